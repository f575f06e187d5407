//! Searches for a genome that matches measured values of f.

use std::time::Instant;

use brood_brdf::MeasuredSamples;
use brood_genome::ModelKind;
use brood_search::{Found, Options, Progress, Search, TimeBudget};
use brood_target::{MeasuredTarget, Objective, Strategy, TargetFile, TargetKind};
use glam::DVec3;
use pyo3::prelude::*;

use crate::error::value_error;
use crate::material::NativeMaterial;
use crate::rows::{PairRows, Rows, longest};
use crate::threads::Threads;

/// Material to match.
#[pyclass(frozen, module = "brood_brdf._native")]
pub(crate) struct NativeTarget {
    target: MeasuredTarget,
    skipped: usize,
}

#[pymethods]
impl NativeTarget {
    /// Makes a target of f at pairs of directions.
    #[staticmethod]
    fn of_samples(py: Python<'_>, wi: Rows<'_>, wo: Rows<'_>, f: Rows<'_>) -> PyResult<Self> {
        let rows = PairRows { wi: wi.numbers()?, wo: wo.numbers()?, uv: None };
        let f = f.numbers()?;
        py.detach(|| {
            let row = |index| Ok((rows.pair(index)?, DVec3::from(f.row::<3>(index))));
            let count = longest([rows.count(), f.rows::<3>()].into_iter());
            let rows = (0..count).map(row).collect::<PyResult<Vec<_>>>()?;
            let samples = MeasuredSamples::new(rows).map_err(value_error)?;
            let target = MeasuredTarget::of_samples(&samples).map_err(value_error)?;
            Ok(Self { target, skipped: samples.skipped() })
        })
    }

    /// Reads a file; its extension selects the format.
    #[staticmethod]
    fn of_file(py: Python<'_>, extension: &str, bytes: &[u8]) -> PyResult<Self> {
        let kind = TargetKind::of_extension(extension).ok_or_else(|| {
            value_error(format!(
                "a target is a MERL .binary, an RGL .bsdf, samples as .csv, a goniometer's .brdf, \
                 or an image slice as .exr, got .{extension}"
            ))
        })?;
        let file = py.detach(|| TargetFile::read(kind, bytes)).map_err(value_error)?;
        Ok(Self { target: file.target, skipped: file.skipped })
    }

    /// Numbers of samples to fit, held out, and skipped because they are below the surface.
    #[getter]
    fn counts(&self) -> (usize, usize, usize) {
        (self.target.fitted.len(), self.target.held.len(), self.skipped)
    }
}

/// Options of a search, as a dictionary.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct FitOptions {
    strategy: String,
    objective: Option<String>,
    seed: u64,
    mirrored: bool,
    models: Vec<String>,
    generations: Option<u32>,
    seconds: Option<f64>,
    threads: Option<usize>,
}

/// A found material: its genome, then operations, parameters, errors on the fitted samples, then
/// E_log, E_cbrt and relative L2 on the held-out ones, and the divisor of the energy limit.
type FoundRow = (NativeMaterial, usize, usize, [f64; 4], f64);

/// Generation, evaluations, and E_log on training and validation samples.
type ProgressRow = (u32, u64, f64, f64);

/// Searches until the budget is spent; returns the front, the index of the best, and the last
/// progress. Calls `progress` after each generation, and stops when Python has a signal.
#[pyfunction]
#[pyo3(signature = (target, start, options, progress))]
pub(crate) fn fit(
    py: Python<'_>,
    target: &Bound<'_, NativeTarget>,
    start: Vec<Bound<'_, NativeMaterial>>,
    options: FitOptions,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Vec<FoundRow>, usize, ProgressRow)> {
    let target = &target.get().target;
    let strategy: Strategy = options.strategy.parse().map_err(value_error)?;
    let kinds: Vec<ModelKind> = options
        .models
        .iter()
        .map(|name| name.parse().map_err(value_error))
        .collect::<PyResult<_>>()?;
    if !kinds.is_empty() && strategy != Strategy::Analytic {
        return Err(value_error("`models` needs the strategy `analytic`"));
    }
    for material in &start {
        if material.get().genome().is_painted() {
            return Err(value_error("`start`: a painted material is not a BRDF"));
        }
    }
    let start = start.iter().map(|material| material.get().genome().clone()).collect();
    let asked: Option<Objective> =
        options.objective.as_deref().map(str::parse).transpose().map_err(value_error)?;
    let objective = strategy.objective(asked).map_err(value_error)?;
    let (seed, is_mirrored) = (options.seed, options.mirrored);
    let given = Options { strategy, seed, is_mirrored, start, objective };
    let on_generation = |done: &Progress| {
        Python::attach(|py| {
            py.check_signals()?;
            match &progress {
                Some(progress) => progress.call1(py, (row(done),)).map(drop),
                None => Ok(()),
            }
        })
    };
    let threads = Threads::of(options.threads)?;
    py.detach(|| {
        let search = threads.install(|| match kinds.is_empty() {
            true => Search::new(&target.fitted, &given),
            false => Search::with_kinds(&target.fitted, &given, kinds),
        });
        let search = search.reporting(&target.held);
        let (outcome, done) = spend((search, &threads), &options, on_generation)?;
        let found = threads.install(|| Found::all(&outcome.front, target)).map_err(value_error)?;
        let best = Found::best(&found, &outcome);
        Ok((found.into_iter().map(found_row).collect(), best, row(&done)))
    })
}

/// Runs generations until the budget is spent, then finishes the search. `on_generation` is called
/// on the thread of the caller, because Python handles signals on its main thread only.
fn spend(
    (mut search, threads): (Search, &Threads),
    options: &FitOptions,
    on_generation: impl Fn(&Progress) -> PyResult<()>,
) -> PyResult<(brood_search::Outcome, Progress)> {
    let begun = Instant::now();
    let spent = || begun.elapsed().as_secs_f64();
    let most = options.generations.unwrap_or(u32::MAX);
    let mut pace = options.seconds.map(TimeBudget::new);
    loop {
        let (before, times) = (spent(), search.next_step_cost());
        let progress = threads.install(|| search.step());
        let now = spent();
        on_generation(&progress)?;
        let is_late = pace.as_mut().is_some_and(|pace| {
            pace.took(now - before, times);
            pace.is_over(now, &search)
        });
        if is_late || progress.generation >= most {
            let search = &mut search;
            let pace = &mut pace;
            let outcome = threads.install(move || {
                search.finish_while(|| pace.as_mut().is_none_or(|pace| pace.has_time(spent())))
            });
            let outcome = outcome.ok_or_else(|| value_error("the search found nothing"))?;
            return Ok((outcome, progress));
        }
    }
}

fn row(progress: &Progress) -> ProgressRow {
    (progress.generation, progress.evaluations, progress.fitted, progress.held)
}

fn found_row(found: Found) -> FoundRow {
    let errors = [found.fitted, found.e_log, found.e_cbrt, found.relative_l2];
    let (operations, parameters) = (found.operations, found.parameters);
    (NativeMaterial::new(found.genome), operations, parameters, errors, found.divisor)
}
