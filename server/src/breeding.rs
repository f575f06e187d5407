//! A breed request, end to end: parents read, children made, one transaction, one render job.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

use brood_genome::{Constraints, Dialect, GenomeHash, Output, Variation};
use brood_program::{BroodRequest, Child, make_brood};
use brood_protocol::{
    Breed, Curation, DialectConstraints, Generation, GenerationId, IndividualId, Lineage,
    ParentRef, PictureKey, Seed,
};
use brood_storage::{NewGeneration, NewIndividual, NewPicture, StorageError, StoredIndividual};
use http::StatusCode;

use crate::dispatch::render_job;
use crate::idempotency::Attempt;
use crate::library::{Framed, Material};
use crate::limit;
use crate::picture::Failure;
use crate::presenter::{individual, thumbnail_url, thumbnail_view};
use crate::problem::ApiError;
use crate::state::{App, AppState, now_ms};

/// A parent that was found.
struct Parent {
    hash: GenomeHash,
    individual: Option<StoredIndividual>,
    material: Arc<Material>,
}

/// What a brood depends on, owned so that a processor's thread can have it.
struct Making {
    parents: Vec<Arc<Material>>,
    dialect: Dialect,
    mutation: f32,
    recombination: f32,
    constraints: Constraints,
    output: Option<Output>,
    count: u32,
    seed: u64,
    distinct: bool,
}

impl Making {
    fn variation(&self) -> Variation<'_> {
        let variation = match self.parents.as_slice() {
            [] => Variation::random(self.dialect),
            [parent] => Variation::mutate(&parent.genome, self.mutation),
            [first, second, ..] => Variation::recombine(
                &first.genome,
                &second.genome,
                self.recombination,
                self.mutation,
            ),
        };
        variation.with_constraints(self.constraints).with_output(self.output)
    }

    fn children(&self) -> Vec<Child> {
        make_brood(&BroodRequest {
            variation: self.variation(),
            count: self.count,
            seed: self.seed,
            distinct: self.distinct,
        })
    }
}

/// Refuses what is well formed but not to be had.
fn check(breed: &Breed) -> Result<(), ApiError> {
    let refuse = |pointer: &str, reason: &str| Err(ApiError::refused(reason).at(pointer));
    if !(1..=limit::CHILDREN).contains(&breed.count) {
        let words = format!("a brood has 1 to {} children, not {}", limit::CHILDREN, breed.count);
        return refuse("/count", &words);
    }
    if breed.parents.len() > 2 {
        return refuse("/parents", "a brood has two parents at most");
    }
    let amounts =
        [("/mutation", Some(breed.mutation)), ("/recombination", Some(breed.recombination))];
    for (pointer, amount) in amounts.into_iter().chain([("/saturation", breed.saturation)]) {
        if amount.is_some_and(|amount| !(0.0..=1.0).contains(&amount)) {
            return refuse(pointer, "this is an amount from 0 to 1");
        }
    }
    if breed.parents.len() == 1 && breed.mutation <= 0.0 {
        return refuse("/mutation", "without mutation all children of one parent are its twins");
    }
    if breed.curation == Curation::Diverse {
        return refuse("/curation", "diverse is not available yet; use distinct or off");
    }
    if breed.locks.as_ref().is_some_and(|locks| !locks.is_null()) {
        return refuse("/locks", "locks are not available yet");
    }
    Ok(())
}

impl AppState {
    /// Makes a generation and says where it is; its pictures are on their way when this returns.
    pub async fn breed(
        self: &App,
        lineage: &Lineage,
        breed: Breed,
        attempt: &Attempt,
    ) -> Result<Generation, ApiError> {
        check(&breed)?;
        let framed = self.library.frame(thumbnail_view(self, lineage)).await?;
        let parents = self.parents(lineage, &breed.parents).await?;
        let seed = match breed.seed {
            Some(seed) => seed,
            None => Seed(draw_seed()?),
        };
        // A random start takes the lineage's and records it: the lineage's may change, the record replays all the same.
        let default = parents.is_empty().then_some(lineage.saturation);
        let breed = Breed { saturation: breed.saturation.or(default), ..breed };
        let output = breed.saturation.map(Output::saturation).transpose();
        let constraints = breed.constraints.unwrap_or_default();
        let making = Making {
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
            count: breed.count,
            seed: seed.0,
            distinct: breed.curation == Curation::Distinct,
        };
        let operator = making.variation().operator_name();
        let start = Instant::now();
        let children = self.on_processor(move || making.children()).await?;
        self.metrics.brood_seconds.record(start.elapsed().as_secs_f64());
        let brood = Brood { seed, constraints, operator, breed, children };
        self.birth(lineage, &framed, &parents, brood, attempt).await
    }

    /// Runs on a thread for such work, when one is free; refuses when too many wait already.
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
            return Err(ApiError::busy("all processors have enough to do"));
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
                        let words = "there is no individual with that id";
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
                let words = "the parent's opcodes, parametrisation, registers or length are not \
                             those of the lineage's dialect";
                return Err(ApiError::refused(words).at(pointer));
            }
            found.push(Parent { hash, individual, material });
        }
        Ok(found)
    }

    async fn birth(
        self: &App,
        lineage: &Lineage,
        framed: &Arc<Framed>,
        parents: &[Parent],
        brood: Brood,
        attempt: &Attempt,
    ) -> Result<Generation, ApiError> {
        let centre = parents.first().filter(|parent| parent.individual.is_some());
        let (id, created_ms) = (GenerationId::fresh(), now_ms());
        let ids: Vec<_> = brood.children.iter().map(|_| IndividualId::fresh()).collect();
        let mut materials: Vec<(PictureKey, IndividualId, Arc<Material>)> = Vec::new();
        let mut pictures: Vec<NewPicture> = Vec::new();
        let mut individuals: Vec<NewIndividual> = Vec::new();
        if let Some(centre) = centre
            && let Some(individual) = &centre.individual
        {
            let key = framed.key(centre.material.program.hash());
            pictures.push(framed.row(key, centre.hash));
            materials.push((key, individual.id, centre.material.clone()));
        }
        let mut redraws = 0;
        let mut twins = 0;
        for (child, id) in brood.children.into_iter().zip(&ids) {
            let key = framed.key(child.program_hash);
            pictures.push(framed.row(key, child.hash));
            redraws += u64::from(child.attempts - 1);
            twins += u64::from(child.twin);
            individuals.push(NewIndividual {
                id: *id,
                slot: child.slot,
                hash: child.hash,
                genome_text: child.genome.to_string(),
                program_hash: *child.program_hash.as_bytes(),
                operator: brood.operator,
                live_instructions: child.live_instructions,
                attempts: child.attempts,
                twin: child.twin,
            });
            let material = self.library.keep(child.hash, child.genome, child.program);
            materials.push((key, *id, material));
        }
        for row in &pictures {
            self.gallery.learn(&Arc::new(row.clone()));
        }
        let mut answer = Generation {
            id,
            lineage: lineage.id,
            index: 0,
            seed: brood.seed,
            parents: brood.breed.parents.clone(),
            centre: centre.and_then(|parent| {
                let key = framed.key(parent.material.program.hash());
                Some(individual(parent.individual.clone()?, key))
            }),
            mutation: brood.breed.mutation,
            recombination: brood.breed.recombination,
            curation: brood.breed.curation,
            constraints: brood.constraints,
            saturation: brood.breed.saturation,
            individuals: individuals
                .iter()
                .map(|new| {
                    let stored = stored(new, lineage, id, &brood.breed.parents);
                    let program = brood_program::ProgramHash::from_bytes(new.program_hash);
                    individual(stored, framed.key(program))
                })
                .collect(),
            created_ms,
        };

        let departed = self.gallery.depart(materials.iter().map(|(key, ..)| *key));
        self.metrics.skipped.increment((materials.len() - departed.len()) as u64);
        let job = (!departed.is_empty()).then(|| {
            let items = departed.iter().filter_map(|key| {
                let (_, _, material) = materials.iter().find(|(known, ..)| known == key)?;
                Some((*key, material.as_ref()))
            });
            render_job(&framed.frame, items)
        });
        let new = NewGeneration {
            id,
            lineage: lineage.id,
            seed: brood.seed,
            parents: brood.breed.parents,
            centre: answer.centre.as_ref().map(|centre| centre.id),
            mutation: brood.breed.mutation,
            recombination: brood.breed.recombination,
            curation: brood.breed.curation,
            constraints: brood.constraints,
            saturation: brood.breed.saturation,
            created_ms,
            individuals,
            pictures,
            job,
            idempotency: attempt.record(StatusCode::CREATED, &answer),
        };
        // A request that is given up while the transaction runs must not leave its flights hanging.
        let mut flights = Flights { app: self.clone(), keys: departed };
        let born = self.store.create_generation(new).await?;
        flights.keys.clear();
        self.dispatch.bell.notify_one();
        answer.index = born.index;
        self.metrics.breeds.increment(1);
        self.metrics.births.increment(answer.individuals.len() as u64);
        self.metrics.redraws.increment(redraws);
        self.metrics.twins.increment(twins);
        self.events.generation(lineage.id, id);
        for (key, individual, _) in materials {
            // First the wish, then the look: a picture that lands between the two is told of all the same.
            self.gallery.interest(key, lineage.id, individual);
            if self.gallery.has(key) {
                for (lineage, individual) in self.gallery.take_interests(key) {
                    self.events.thumbnail(lineage, individual, &thumbnail_url(key));
                }
            }
        }
        Ok(answer)
    }
}

/// What was made and how it was asked for.
struct Brood {
    seed: Seed,
    constraints: DialectConstraints,
    operator: &'static str,
    breed: Breed,
    children: Vec<Child>,
}

/// Flights that were begun for a transaction; they crash if it does not come to its end.
struct Flights {
    app: App,
    keys: Vec<PictureKey>,
}

impl Drop for Flights {
    fn drop(&mut self) {
        if !self.keys.is_empty() {
            self.app.gallery.crash(self.keys.iter().copied(), &Failure::Busy);
        }
    }
}

fn stored(
    new: &NewIndividual,
    lineage: &Lineage,
    generation: GenerationId,
    parents: &[ParentRef],
) -> StoredIndividual {
    StoredIndividual {
        id: new.id,
        lineage: lineage.id,
        generation,
        hash: new.hash,
        program_hash: new.program_hash,
        slot: new.slot,
        parents: parents.to_vec(),
        operator: new.operator.to_owned(),
        live_instructions: new.live_instructions,
        attempts: new.attempts,
        twin: new.twin,
        favourite: false,
        note: String::new(),
        version: 1,
    }
}

/// A seed that JavaScript can hold.
fn draw_seed() -> Result<u64, ApiError> {
    let mut bytes = [0; 8];
    getrandom::fill(&mut bytes).map_err(|error| ApiError::internal(error.to_string()))?;
    Ok(u64::from_le_bytes(bytes) >> 11)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(json: serde_json::Value) -> Option<String> {
        let breed: Breed = serde_json::from_value(json).unwrap();
        let error = check(&breed).err()?;
        assert_eq!(error.status(), 422);
        error.problem().pointer.clone()
    }

    #[test]
    fn breed_is_refused_when_it_is_not_to_be_had() {
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
        assert_eq!(refused(serde_json::json!({"curation": "diverse"})).unwrap(), "/curation");
        assert_eq!(refused(serde_json::json!({"locks": {}})).unwrap(), "/locks");
    }

    #[test]
    fn drawn_seeds_are_below_2_to_the_53() {
        for _ in 0..100 {
            assert!(draw_seed().unwrap() < 1 << 53);
        }
    }
}
