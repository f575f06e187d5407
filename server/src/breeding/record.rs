//! Stores the results of a search as individuals of its lineage, in the same transaction as the
//! search step that found them.

use brood_genome::{Dialect, Genome};
use brood_protocol::{
    BreedOptions, FoundMaterial, Generation, IndividualId, Lineage, MeasuredMaterial, ParentRef,
};
use brood_storage::{SearchStep, StoredSearch};

use super::adopt::{fitted, newborns};
use super::birth::{Brood, Recording};
use super::{Newborn, Parent};
use crate::limit;
use crate::presenter::thumbnail_view;
use crate::problem::ApiError;
use crate::server_timing::ServerTiming;
use crate::state::{App, AppState};

/// Operator of an individual found by a search.
pub const OPERATOR: &str = "fit";

impl AppState {
    /// Makes a generation of the found materials, in order, and writes the search step with it.
    ///
    /// Returns `None`, and writes no step, if none of the materials fits the lineage's dialect.
    ///
    /// # Errors
    /// [`ApiError`] if the store fails or the server is busy.
    pub async fn record(
        self: &App,
        search: &StoredSearch,
        (found, generation): (Vec<MeasuredMaterial>, u32),
        step: impl FnOnce(Vec<FoundMaterial>) -> SearchStep + Send,
    ) -> Result<Option<(Generation, Vec<FoundMaterial>)>, ApiError> {
        let lineage = self.store.lineage(search.lineage).await?;
        let framed = self.library.frame(thumbnail_view(self, &lineage)).await?;
        let parent = self.parent_of(search, &lineage).await?;
        let (dialect, id) = (lineage.dialect, search.id);
        let made = self.on_processor(move || {
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
        let ids: Vec<_> = children.iter().map(|_| IndividualId::fresh()).collect();
        let materials = kept.iter().zip(&children).zip(&ids);
        let materials: Vec<_> = materials
            .map(|((measured, newborn), id)| present(measured, newborn, *id, generation))
            .collect();
        let step = step(materials.clone());
        let individuals = parent.iter().filter_map(|parent| parent.individual.as_ref());
        let brood = Brood {
            seed: search.options.seed,
            parents: individuals.map(|one| ParentRef::Individual(one.id)).collect(),
            operator: OPERATOR,
            options: BreedOptions::default(),
            children,
            recording: Some(Recording { ids, step }),
        };
        let (attempt, mut timing) = (self.ledger.unkeyed(), ServerTiming::begin());
        let parents: Vec<Parent> = parent.into_iter().collect();
        let (generation, _) =
            self.birth(&lineage, &framed, &parents, brood, &attempt, &mut timing).await?;
        Ok(Some((generation, materials)))
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

fn present(
    found: &MeasuredMaterial,
    newborn: &Newborn,
    individual: IndividualId,
    generation: u32,
) -> FoundMaterial {
    FoundMaterial {
        individual,
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
