//! Breeding: makes broods from breed requests, adoptions and search results. A brood is then stored
//! and its pictures are requested ([`Brood::deliver`]).

mod adopt;
mod birth;
mod record;

use std::sync::Arc;

use brood_eval::{diverse_brood, express_child, steered_brood};
use brood_genome::{Dialect, Genome, Start, Variation};
use brood_program::{BroodRequest, Child, settle_brood};
use brood_protocol::{
    Adopt, Backend, Breed, BreedOptions, Curation, IndividualId, Lineage, ParentRef, Queue, Seed,
};
use brood_storage::{SearchStep, StorageError, Store, StoredIndividual};
use metrics::Histogram;
use rayon::prelude::*;

pub use adopt::OPERATOR as ADOPT;
pub use record::OPERATOR as FIT;

use crate::deferred::AnswerProgress;
use crate::library::{Framed, Framing, Library, Material};
use crate::limit;
use crate::problem::ApiError;
use crate::processors::Processors;
use crate::server_timing::ServerTiming;

/// Number of children above which a brood is made at low priority.
const LARGE_BROOD: u32 = 32;

/// Maker of broods: reads the parents and draws the children. Stores nothing.
pub struct Breeding {
    /// Database, for parents.
    pub store: Store,
    /// Caches of materials and frames.
    pub library: Arc<Library>,
    /// Permits for drawing children.
    pub processors: Processors,
    /// Backend that renders thumbnails.
    pub backend: Backend,
    /// Metric of the time to make a brood.
    pub seconds: Histogram,
}

/// Brood that is ready to be stored.
pub struct Brood {
    framed: Arc<Framed>,
    seed: Seed,
    parents: Vec<ParentRef>,
    /// First parent, if it is an individual.
    centre: Option<(StoredIndividual, Arc<Material>)>,
    operator: &'static str,
    options: BreedOptions,
    children: Vec<Newborn>,
    /// Search step to write in the same transaction.
    step: Option<SearchStep>,
}

/// Child with its id and canonical bytes.
struct Newborn {
    id: IndividualId,
    child: Child,
    bytes: Vec<u8>,
}

impl From<Child> for Newborn {
    fn from(child: Child) -> Self {
        Self { id: IndividualId::fresh(), bytes: child.genome.canonical_bytes(), child }
    }
}

/// Parent read from the store.
struct Parent {
    individual: Option<StoredIndividual>,
    material: Arc<Material>,
}

impl Parent {
    fn centre(self) -> Option<(StoredIndividual, Arc<Material>)> {
        Some((self.individual?, self.material))
    }
}

/// Inputs of a brood, owned so that they can move to a blocking thread.
struct BreedInputs {
    parents: Vec<Arc<Material>>,
    start: Start,
    dialect: Dialect,
    options: BreedOptions,
    count: u32,
    seed: Seed,
}

impl BreedInputs {
    fn variation(&self) -> Variation<'_> {
        let parents: Vec<&Genome> = self.parents.iter().map(|parent| &parent.genome).collect();
        self.options.variation((self.start, self.dialect), &parents)
    }

    /// Makes the children in parallel. A draw depends on its slot alone, so the result does not
    /// depend on the number of threads.
    fn children(&self, progress: Option<&AnswerProgress>) -> Vec<Newborn> {
        let request = BroodRequest {
            variation: self.variation(),
            count: self.count,
            seed: self.seed.0,
            distinct: self.options.curation != Curation::Off,
        };
        let steer = &self.options.steer;
        let is_diverse = self.options.curation == Curation::Diverse;
        let children = match self.options.curation {
            _ if !steer.is_empty() => steered_brood(&request, steer, is_diverse),
            Curation::Diverse => diverse_brood(&request),
            Curation::Off | Curation::Distinct => {
                let slots = (0..self.count).into_par_iter();
                settle_brood(&request, slots.map(|slot| request.draw(slot)).collect())
            }
        };
        let step = |parts| {
            if let Some(progress) = progress {
                progress.step(parts);
            }
        };
        step(children.len());
        let express = |child| {
            let child = express_child(child);
            step(1);
            child
        };
        let children: Vec<Child> = children.into_par_iter().map(express).collect();
        // One after another, so that ids follow the slots.
        children.into_iter().map(Newborn::from).collect()
    }
}

/// Checks the values of a breed request.
fn check(count: u32, parents: &[ParentRef], options: &BreedOptions) -> Result<(), ApiError> {
    let refuse = |pointer: &str, reason: &str| Err(ApiError::refused(reason).at(pointer));
    if !(1..=limit::CHILDREN).contains(&count) {
        let words = format!("`count` must be 1 to {}, got {count}", limit::CHILDREN);
        return refuse("/count", &words);
    }
    if parents.len() > 2 {
        let words = format!("`parents` must have at most 2 items, got {}", parents.len());
        return refuse("/parents", &words);
    }
    if let Err(error) = options.check_amounts() {
        return refuse(&format!("/{}", error.field), &error.to_string());
    }
    if parents.len() == 1 && options.mutation <= 0.0 && options.painting.is_none() {
        return refuse(
            "/mutation",
            "all children of one parent are identical without mutation: raise `mutation`",
        );
    }
    if parents.is_empty() && options.locks.is_some() {
        return refuse("/locks", "`locks` needs a parent");
    }
    Ok(())
}

/// Request that makes a brood.
pub enum Origin {
    /// Children of up to two parents.
    Breed(Box<Breed>),
    /// Existing genomes and presets.
    Adopt(Adopt),
}

impl Breeding {
    /// Makes the brood of a request.
    ///
    /// # Errors
    /// [`ApiError`] if the request is invalid, a parent or genome is missing or incompatible, or
    /// the server is busy.
    pub async fn make(
        &self,
        lineage: &Lineage,
        origin: Origin,
        timing: &mut ServerTiming,
    ) -> Result<Brood, ApiError> {
        match origin {
            Origin::Breed(breed) => self.breed(lineage, *breed, timing).await,
            Origin::Adopt(adopt) => self.adopt(lineage, adopt, timing).await,
        }
    }

    async fn breed(
        &self,
        lineage: &Lineage,
        breed: Breed,
        timing: &mut ServerTiming,
    ) -> Result<Brood, ApiError> {
        let (count, seed, refs) = (breed.count, breed.seed, breed.parents.clone());
        let mut options = BreedOptions::from(breed);
        check(count, &refs, &options)?;
        let framed = self.library.frame(Framing::thumbnail(self.backend, lineage)).await?;
        let parents = self.parents(lineage, &refs).await?;
        let seed = match seed {
            Some(seed) => seed,
            None => Seed::draw().map_err(|error| ApiError::internal(error.to_string()))?,
        };
        match (parents.first(), &options.locks) {
            // A random start uses the lineage's defaults and records them, so that it can be
            // repeated after the lineage has changed.
            (None, _) if lineage.start == Start::Painted => {}
            (None, _) => {
                options.saturation.get_or_insert(lineage.saturation);
                options.energy_limit.get_or_insert(lineage.energy_limit);
            }
            (Some(first), Some(locks)) => {
                locks.validate_for(&first.material.genome).map_err(|error| {
                    let pointer = format!("/locks{}", error.pointer());
                    ApiError::refused(error.to_string()).at(pointer)
                })?;
            }
            (Some(_), None) => {}
        }
        let genomes: Vec<&Genome> = parents.iter().map(|parent| &parent.material.genome).collect();
        options.check_painted(&genomes, lineage.start == Start::Painted)?;
        options.check_steer(&genomes).map_err(|error| {
            ApiError::refused(error.to_string()).at(format!("/{}", error.field()))
        })?;
        let inputs = BreedInputs {
            parents: parents.iter().map(|parent| parent.material.clone()).collect(),
            start: lineage.start,
            dialect: lineage.dialect,
            options: options.clone(),
            count,
            seed,
        };
        let operator = inputs.variation().operator_name();
        if inputs.variation().is_deterministic() {
            let words = "all children would be identical: raise `mutation`";
            return Err(match inputs.variation().has_share() {
                true => {
                    ApiError::refused(format!("{words} or `recombination`")).at("/recombination")
                }
                false => ApiError::refused(words).at("/mutation"),
            });
        }
        timing.end("read");
        // Large broods do not keep others waiting.
        let progress = AnswerProgress::current();
        let is_long = count > LARGE_BROOD || progress.is_some();
        let queue = if is_long { Queue::Batch } else { Queue::Interactive };
        // A child is drawn, then expressed.
        AnswerProgress::expect(2 * count as usize);
        let make = move || inputs.children(progress.as_deref());
        let children = self.processors.run_from(queue, make).await?;
        self.seconds.record(timing.end("make").as_secs_f64());
        let centre = parents.into_iter().next().and_then(Parent::centre);
        Ok(Brood { framed, seed, parents: refs, centre, operator, options, children, step: None })
    }

    /// Reads an individual that a request names at `pointer`.
    async fn individual(
        &self,
        id: IndividualId,
        pointer: &str,
    ) -> Result<StoredIndividual, ApiError> {
        match self.store.individual(id).await {
            Err(StorageError::NotFound) => {
                Err(ApiError::not_found("there is no individual with this id").at(pointer))
            }
            read => Ok(read?),
        }
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
                ParentRef::Individual(id) => Some(self.individual(*id, &pointer).await?),
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
            found.push(Parent { individual, material });
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
        let (count, parents) = (breed.count, breed.parents.clone());
        let error = check(count, &parents, &breed.into()).err()?;
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
        let region = serde_json::json!({"dark": "#000000", "middle": "#808080", "bright": "#ffffff", "share": 1});
        let recoloured =
            serde_json::json!({"parents": [id], "mutation": 0, "painting": {"regions": [region]}});
        assert_eq!(refused(recoloured), None);
        assert_eq!(refused(serde_json::json!({"parents": [id, id, id]})).unwrap(), "/parents");
        assert_eq!(refused(serde_json::json!({"locks": {"channels": ["r"]}})).unwrap(), "/locks");
        assert_eq!(refused(serde_json::json!({"locks": {}})), None);
    }
}
