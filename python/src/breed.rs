//! Broods: children of none, one or two parents.

use brood_eval::{diverse_brood, express_brood, steered_brood};
use brood_genome::{Genome, Start, Variation};
use brood_program::{BroodRequest, make_brood};
use brood_protocol::{BreedOptions, Curation};
use pyo3::prelude::*;

use crate::error::value_error;
use crate::material::NativeMaterial;
use crate::threads;

/// Largest number of children.
const MOST: u32 = 256;

/// Breeds a brood. `options` is the JSON of [`BreedOptions`].
#[pyfunction]
#[pyo3(signature = (parents, count, seed, start, options, threads))]
pub(crate) fn breed(
    py: Python<'_>,
    parents: Vec<Bound<'_, NativeMaterial>>,
    count: u32,
    seed: u64,
    start: Option<&str>,
    options: &str,
    threads: Option<usize>,
) -> PyResult<Vec<NativeMaterial>> {
    let options: BreedOptions = serde_json::from_str(options).map_err(value_error)?;
    if !(1..=MOST).contains(&count) {
        return Err(value_error(format!("`count` must be 1 to {MOST}, got {count}")));
    }
    let start = match start {
        None => Start::default(),
        Some(name) => Start::from_name(name).ok_or_else(|| {
            let known = Start::ALL.map(Start::name).join(", ");
            value_error(format!("`start` must be one of {known}, got {name}"))
        })?,
    };
    let parents: Vec<&Genome> = parents.iter().map(|parent| parent.get().genome()).collect();
    let variation = variation(&options, start, &parents)?;
    let distinct = options.curation != Curation::Off;
    let request = BroodRequest { variation, count, seed, distinct };
    let is_diverse = options.curation == Curation::Diverse;
    let children = threads::run(py, threads, || {
        express_brood(match options.curation {
            _ if !options.steer.is_empty() => steered_brood(&request, &options.steer, is_diverse),
            Curation::Diverse => diverse_brood(&request),
            Curation::Off | Curation::Distinct => make_brood(&request),
        })
    })?;
    let material =
        |child: brood_program::Child| NativeMaterial::expressed(child.genome, child.program);
    Ok(children.into_iter().map(material).collect())
}

/// Returns the variation that the options describe; an error if they contradict each other or do
/// not fit the parents.
fn variation<'a>(
    options: &'a BreedOptions,
    start: Start,
    parents: &[&'a Genome],
) -> PyResult<Variation<'a>> {
    options.check_amounts().map_err(value_error)?;
    match *parents {
        [] if options.locks.is_some() => return Err(value_error("`locks` needs a parent")),
        [_] if options.mutation <= 0.0 && options.painting.is_none() => {
            return Err(value_error(
                "`mutation` must be above 0 with one parent: at 0 every child is a copy",
            ));
        }
        [first, second] if !first.dialect().is_compatible(second.dialect()) => {
            return Err(value_error(
                "the parents have different dialects; only parents of one dialect can be crossed",
            ));
        }
        [] | [_] | [_, _] => {}
        _ => return Err(value_error(format!("at most 2 parents, got {}", parents.len()))),
    }
    if let (Some(locks), Some(first)) = (&options.locks, parents.first()) {
        locks.validate_for(first).map_err(value_error)?;
    }
    options.check_steer(parents).map_err(value_error)?;
    options.check_painted(parents, start == Start::Painted).map_err(value_error)?;
    let variation = options.variation((start, start.dialect()), parents);
    if variation.is_deterministic() {
        return Err(value_error("these amounts give only copies of the parents; raise `mutation`"));
    }
    Ok(variation)
}
