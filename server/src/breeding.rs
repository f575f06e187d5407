//! Breed requests: read the parents, make the children, write one transaction and queue render
//! jobs.

mod adopt;
mod birth;
mod record;

use std::sync::Arc;
use std::sync::atomic::Ordering;

use brood_eval::{diverse_brood, express_brood};
use brood_genome::{Constraints, Dialect, GenomeHash, Locks, Output, Variation};
use brood_program::{BroodRequest, Child, settle_brood};
use brood_protocol::{Breed, Curation, Generation, JobId, Lineage, ParentRef, Seed};
use brood_storage::{StorageError, StoredIndividual};
use rayon::prelude::*;

pub use adopt::OPERATOR as ADOPT;
use birth::Brood;
pub use record::OPERATOR as FIT;

use crate::idempotency::Attempt;
use crate::library::Material;
use crate::limit;
use crate::presenter::thumbnail_view;
use crate::problem::ApiError;
use crate::server_timing::ServerTiming;
use crate::state::{App, AppState};

/// Child with its canonical bytes.
struct Newborn {
    child: Child,
    bytes: Vec<u8>,
}

/// Parent read from the store.
struct Parent {
    hash: GenomeHash,
    individual: Option<StoredIndividual>,
    material: Arc<Material>,
}

/// Inputs of a brood, owned so that they can move to a blocking thread.
struct BreedInputs {
    parents: Vec<Arc<Material>>,
    dialect: Dialect,
    mutation: f32,
    recombination: f32,
    constraints: Constraints,
    output: Option<Output>,
    energy_limit: Option<bool>,
    locks: Option<Locks>,
    count: u32,
    seed: u64,
    curation: Curation,
}

impl BreedInputs {
    fn variation(&self) -> Variation<'_> {
        let variation = match self.parents.as_slice() {
            [] => Variation::random(self.dialect),
            [parent] => Variation::mutate(&parent.genome, self.mutation),
            [first, second, ..] => Variation::crossover(
                &first.genome,
                &second.genome,
                self.recombination,
                self.mutation,
            ),
        };
        variation
            .with_constraints(self.constraints)
            .with_output(self.output)
            .with_limit(self.energy_limit)
            .with_locks(self.locks.as_ref())
    }

    /// Makes the children in parallel. A draw depends on its slot alone, so the result does not
    /// depend on the number of threads.
    fn children(&self) -> Vec<Newborn> {
        let request = BroodRequest {
            variation: self.variation(),
            count: self.count,
            seed: self.seed,
            distinct: self.curation != Curation::Off,
        };
        let children = match self.curation {
            Curation::Diverse => diverse_brood(&request),
            Curation::Off | Curation::Distinct => {
                let slots = (0..self.count).into_par_iter();
                settle_brood(&request, slots.map(|slot| request.draw(slot)).collect())
            }
        };
        let write = |child: Child| Newborn { bytes: child.genome.canonical_bytes(), child };
        express_brood(children).into_iter().map(write).collect()
    }
}

/// Checks the values of a breed request.
fn check(breed: &Breed) -> Result<(), ApiError> {
    let refuse = |pointer: &str, reason: &str| Err(ApiError::refused(reason).at(pointer));
    if !(1..=limit::CHILDREN).contains(&breed.count) {
        let words = format!("`count` must be 1 to {}, got {}", limit::CHILDREN, breed.count);
        return refuse("/count", &words);
    }
    if breed.parents.len() > 2 {
        let words = format!("`parents` must have at most 2 items, got {}", breed.parents.len());
        return refuse("/parents", &words);
    }
    let amounts =
        [("/mutation", Some(breed.mutation)), ("/recombination", Some(breed.recombination))];
    for (pointer, amount) in amounts.into_iter().chain([("/saturation", breed.saturation)]) {
        if let Some(amount) = amount.filter(|amount| !(0.0..=1.0).contains(amount)) {
            let words = format!("`{}` must be between 0 and 1, got {amount}", &pointer[1..]);
            return refuse(pointer, &words);
        }
    }
    if breed.parents.len() == 1 && breed.mutation <= 0.0 {
        return refuse(
            "/mutation",
            "all children of one parent are identical without mutation: raise `mutation`",
        );
    }
    if breed.parents.is_empty() && breed.locks.as_ref().is_some_and(|locks| !locks.is_empty()) {
        return refuse("/locks", "`locks` needs a parent");
    }
    Ok(())
}

impl AppState {
    /// Breeds a generation and starts rendering its pictures.
    ///
    /// Returns the generation and the job that renders its first pictures, if any must be rendered.
    ///
    /// # Errors
    /// [`ApiError`] if the request is invalid, a parent is missing or incompatible, or the store
    /// fails.
    pub async fn breed(
        self: &App,
        lineage: &Lineage,
        breed: Breed,
        attempt: &Attempt,
        timing: &mut ServerTiming,
    ) -> Result<(Generation, Option<JobId>), ApiError> {
        check(&breed)?;
        let framed = self.library.frame(thumbnail_view(self, lineage)).await?;
        let parents = self.parents(lineage, &breed.parents).await?;
        let seed = match breed.seed {
            Some(seed) => seed,
            None => Seed::draw().map_err(|error| ApiError::internal(error.to_string()))?,
        };
        // A random start uses the lineage's defaults and records them, so that it can be repeated
        // after the lineage has changed.
        let default = parents.is_empty().then_some(lineage.saturation);
        let limit = parents.is_empty().then_some(lineage.energy_limit);
        let breed = Breed {
            saturation: breed.saturation.or(default),
            energy_limit: breed.energy_limit.or(limit),
            locks: breed.locks.filter(|locks| !locks.is_empty()),
            ..breed
        };
        let first = parents.first().map(|parent| &parent.material.genome);
        let locked = breed.locks.as_ref().zip(first);
        if let Some(Err(error)) = locked.map(|(locks, first)| locks.validate_for(first)) {
            let pointer = format!("/locks{}", error.pointer());
            return Err(ApiError::refused(error.to_string()).at(pointer));
        }
        let output = breed.saturation.map(Output::saturation).transpose();
        let constraints = breed.constraints.unwrap_or_default();
        let inputs = BreedInputs {
            parents: parents.iter().map(|parent| parent.material.clone()).collect(),
            dialect: lineage.dialect,
            mutation: breed.mutation,
            recombination: breed.recombination,
            constraints: Constraints {
                isotropic: constraints.isotropic,
                homogeneous: constraints.homogeneous,
            },
            output: output
                .map_err(|error| ApiError::refused(error.to_string()).at("/saturation"))?,
            energy_limit: breed.energy_limit,
            locks: breed.locks.clone(),
            count: breed.count,
            seed: seed.0,
            curation: breed.curation,
        };
        let operator = inputs.variation().operator_name();
        if inputs.variation().is_deterministic() {
            let words = "all children would be identical: raise `mutation` or `recombination`";
            return Err(ApiError::refused(words).at("/recombination"));
        }
        timing.end("read");
        let children = self.on_processor(move || inputs.children()).await?;
        self.metrics.brood_seconds.record(timing.end("make").as_secs_f64());
        let brood = Brood { seed, constraints, operator, breed, children, recording: None };
        self.birth(lineage, &framed, &parents, brood, attempt, timing).await
    }

    /// Runs CPU-heavy `work` on a blocking thread, at most one per processor.
    ///
    /// # Errors
    /// 503 if [`limit::WAITING_BROODS`] calls are already waiting.
    pub async fn on_processor<T: Send + 'static>(
        &self,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, ApiError> {
        struct Waiting<'a>(&'a std::sync::atomic::AtomicUsize);
        impl Drop for Waiting<'_> {
            fn drop(&mut self) {
                self.0.fetch_sub(1, Ordering::Relaxed);
            }
        }
        let before = self.waiting.fetch_add(1, Ordering::Relaxed);
        let waiting = Waiting(&self.waiting);
        if before >= limit::WAITING_BROODS {
            return Err(ApiError::busy("all processors are busy"));
        }
        let permit = self.processors.clone().acquire_owned().await;
        let permit = permit.map_err(|error| ApiError::internal(error.to_string()))?;
        drop(waiting);
        let done = tokio::task::spawn_blocking(move || {
            let result = work();
            drop(permit);
            result
        });
        done.await.map_err(|error| ApiError::internal(error.to_string()))
    }

    async fn parents(
        &self,
        lineage: &Lineage,
        parents: &[ParentRef],
    ) -> Result<Vec<Parent>, ApiError> {
        let mut found = Vec::with_capacity(parents.len());
        for (index, parent) in parents.iter().enumerate() {
            let pointer = format!("/parents/{index}");
            let individual = match parent {
                ParentRef::Individual(id) => match self.store.individual(*id).await {
                    Ok(individual) => Some(individual),
                    Err(StorageError::NotFound) => {
                        let words = "there is no individual with this id";
                        return Err(ApiError::not_found(words).at(pointer));
                    }
                    Err(error) => return Err(error.into()),
                },
                ParentRef::Genome(_) => None,
            };
            let hash = match (parent, &individual) {
                (ParentRef::Genome(hash), _) => *hash,
                (_, Some(individual)) => individual.hash,
                (ParentRef::Individual(_), None) => unreachable!("an individual was read above"),
            };
            let material =
                self.library.material(hash).await.map_err(|error| error.at(pointer.clone()))?;
            if !material.genome.dialect().is_compatible(&lineage.dialect) {
                let words = "the parent's opcodes, parametrisation, registers or length are not those of \
                             the lineage's dialect";
                return Err(ApiError::refused(words).at(pointer));
            }
            found.push(Parent { hash, individual, material });
        }
        // In a lineage of models, each parent can be compatible with the lineage but not with the
        // other.
        if let [first, second] = found.as_slice()
            && !first.material.genome.dialect().is_compatible(second.material.genome.dialect())
        {
            let words =
                "the parents' programs have different dialects, so they cannot be recombined";
            return Err(ApiError::refused(words).at("/parents/1"));
        }
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use brood_protocol::IndividualId;

    use super::*;

    fn refused(json: serde_json::Value) -> Option<String> {
        let breed: Breed = serde_json::from_value(json).unwrap();
        let error = check(&breed).err()?;
        assert_eq!(error.status(), 422);
        error.problem().pointer.clone()
    }

    #[test]
    fn breed_is_refused_when_a_value_is_out_of_range() {
        let id = IndividualId::fresh().to_string();
        let hash = "0".repeat(64);
        assert_eq!(refused(serde_json::json!({})), None);
        assert_eq!(refused(serde_json::json!({"count": 0})).unwrap(), "/count");
        assert_eq!(refused(serde_json::json!({"count": 257})).unwrap(), "/count");
        assert_eq!(refused(serde_json::json!({"mutation": 1.5})).unwrap(), "/mutation");
        assert_eq!(refused(serde_json::json!({"recombination": -1})).unwrap(), "/recombination");
        assert_eq!(refused(serde_json::json!({"saturation": 2})).unwrap(), "/saturation");
        assert_eq!(
            refused(serde_json::json!({"parents": [id], "mutation": 0})).unwrap(),
            "/mutation"
        );
        assert_eq!(refused(serde_json::json!({"parents": [id, hash], "mutation": 0})), None);
        assert_eq!(refused(serde_json::json!({"parents": [id, id, id]})).unwrap(), "/parents");
        assert_eq!(refused(serde_json::json!({"locks": {"channels": ["r"]}})).unwrap(), "/locks");
        assert_eq!(refused(serde_json::json!({"locks": {}})), None);
    }
}
