//! Stores the results of a search as individuals of its lineage, in the same transaction as the
//! search step that found them.

use brood_genome::{Dialect, Genome};
use brood_protocol::{BreedOptions, FoundMaterial, Lineage, MeasuredMaterial, ParentRef};
use brood_storage::{SearchStep, StoredSearch};

use super::adopt::{fitted, newborns};
use super::{Breeding, Brood, Newborn, Parent};
use crate::library::Framing;
use crate::limit;
use crate::problem::ApiError;

/// Operator of an individual found by a search.
pub const OPERATOR: &str = "fit";

impl Breeding {
    /// Makes a brood of the found materials, in order, to be stored with a step of the search.
    ///
    /// Returns `None` if none of the materials fits the lineage's dialect.
    ///
    /// # Errors
    /// [`ApiError`] if the store fails or the server is busy.
    pub async fn record(
        &self,
        search: &StoredSearch,
        lineage: &Lineage,
        (found, generation): (Vec<MeasuredMaterial>, u32),
        step: impl FnOnce(Vec<FoundMaterial>) -> SearchStep + Send,
    ) -> Result<Option<Brood>, ApiError> {
        let Some((brood, kept)) = self.collect(search, lineage, found).await? else {
            return Ok(None);
        };
        let found = kept.iter().zip(&brood.children);
        let found = found.map(|(measured, newborn)| present(measured, newborn, generation));
        let step = step(found.collect());
        Ok(Some(Brood { step: Some(step), ..brood }))
    }

    /// Makes a brood of the found materials that fit the lineage's dialect; `None` if none does.
    async fn collect(
        &self,
        search: &StoredSearch,
        lineage: &Lineage,
        found: Vec<MeasuredMaterial>,
    ) -> Result<Option<(Brood, Vec<MeasuredMaterial>)>, ApiError> {
        let framed = self.library.frame(Framing::thumbnail(self.backend, lineage)).await?;
        let parent = self.parent_of(search, lineage).await?;
        let (dialect, id) = (lineage.dialect, search.id);
        let made = self.processors.run(move || {
            let (kept, genomes): (Vec<_>, Vec<_>) = found
                .into_iter()
                .take(limit::CHILDREN as usize)
                .filter_map(|one| {
                    let genome = read(&one, &dialect);
                    genome
                        .inspect_err(|reason| {
                            tracing::warn!(job = %id, reason, "a search result does not fit its lineage");
                        })
                        .ok()
                        .map(|genome| (one, genome))
                })
                .unzip();
            (kept, newborns(genomes))
        });
        let (kept, children): (Vec<MeasuredMaterial>, Vec<Newborn>) = made.await?;
        if children.is_empty() {
            return Ok(None);
        }
        let centre = parent.and_then(Parent::centre);
        let brood = Brood {
            framed,
            seed: search.options.seed,
            parents: centre.iter().map(|(one, _)| ParentRef::Individual(one.id)).collect(),
            centre,
            operator: OPERATOR,
            options: BreedOptions::default(),
            children,
            step: None,
        };
        Ok(Some((brood, kept)))
    }

    /// Returns the previous best, or else the first start individual, if it still exists and is
    /// compatible with the lineage.
    async fn parent_of(
        &self,
        search: &StoredSearch,
        lineage: &Lineage,
    ) -> Result<Option<Parent>, ApiError> {
        let best = search.best.as_ref().map(|best| best.individual);
        let Some(id) = best.or(search.options.start.first().copied()) else { return Ok(None) };
        let found = self.parents(lineage, &[ParentRef::Individual(id)]).await;
        Ok(found.ok().and_then(|mut found| found.pop()))
    }
}

/// Reads a found genome and pads it to the lineage's length.
fn read(found: &MeasuredMaterial, dialect: &Dialect) -> Result<Genome, String> {
    let errors = [found.e_log, found.e_log_fitted, found.e_cbrt, found.relative_l2, found.divisor];
    let views = found.views.iter().flatten();
    let of_views = views.flat_map(|view| [view.rmse, view.flip, view.gain]);
    if !errors.into_iter().chain(of_views).all(f64::is_finite) {
        return Err("an error value is not finite".to_owned());
    }
    let genome = Genome::from_canonical_bytes(&found.genome).map_err(|error| error.to_string())?;
    fitted(genome, dialect, String::new()).map_err(|error| format!("{error:?}"))
}

fn present(found: &MeasuredMaterial, newborn: &Newborn, generation: u32) -> FoundMaterial {
    FoundMaterial {
        individual: newborn.id,
        hash: newborn.child.hash,
        e_log: found.e_log,
        e_log_fitted: found.e_log_fitted,
        e_cbrt: found.e_cbrt,
        relative_l2: found.relative_l2,
        operations: found.operations,
        numbers: found.numbers,
        divisor: found.divisor,
        generation,
        views: found.views.clone(),
        thumbnail: None,
    }
}
