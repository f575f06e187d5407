//! Stored facts as they are answered: ids and thumbnails put together.

use std::sync::Arc;

use brood_program::ProgramHash;
use brood_protocol::{
    Generation, Individual, IndividualDetail, Lineage, LineageId, ListedLineage, PictureFormat,
    PictureKey,
};
use brood_scene::Sampling;
use brood_storage::{StorageError, StoredGeneration, StoredIndividual};
use std::collections::HashMap;

use crate::library::{Framed, View};
use crate::problem::ApiError;
use crate::state::AppState;

/// Where a thumbnail is.
pub fn thumbnail_url(key: PictureKey) -> String {
    format!("/v1/thumbnails/{key}.png")
}

/// Presents individuals with thumbnails in the scenes of their lineages, and gathers the picture keys that this makes.
pub struct Presenter<'a> {
    app: &'a AppState,
    frames: HashMap<LineageId, Arc<Framed>>,
    rows: Vec<Arc<brood_storage::PictureRow>>,
}

impl<'a> Presenter<'a> {
    /// Knows no lineage yet.
    pub fn new(app: &'a AppState) -> Self {
        Self { app, frames: HashMap::new(), rows: Vec::new() }
    }

    /// One individual.
    pub async fn individual(&mut self, stored: StoredIndividual) -> Result<Individual, ApiError> {
        let framed = self.frame(stored.lineage).await?;
        let key = framed.key(ProgramHash::from_bytes(stored.program_hash));
        let gallery = &self.app.gallery;
        if gallery.recipe(key).is_none() {
            let row = Arc::new(framed.row(key, stored.hash));
            gallery.learn(&row);
            self.rows.push(row);
        }
        if !gallery.has(key) {
            gallery.interest(key, stored.lineage, stored.id);
        }
        Ok(individual(stored, key))
    }

    /// One individual with its place in the world.
    pub async fn detail(&mut self, stored: StoredIndividual) -> Result<IndividualDetail, ApiError> {
        let (lineage, generation) = (stored.lineage, stored.generation);
        let individual = self.individual(stored).await?;
        Ok(IndividualDetail { individual, lineage, generation, exposure_ev: None })
    }

    /// Lineages with the pictures that stand for them.
    pub async fn lineages(&mut self, stored: Vec<Lineage>) -> Result<Vec<ListedLineage>, ApiError> {
        let ids: Vec<_> = stored.iter().map(|lineage| lineage.id).collect();
        let mut covers = self.app.store.covers(&ids).await?;
        let mut listed = Vec::with_capacity(stored.len());
        for lineage in stored {
            let cover = match covers.remove(&lineage.id) {
                // Shown in this lineage's scene, wherever it was born.
                Some(one) => {
                    let own = StoredIndividual { lineage: lineage.id, ..one };
                    Some(self.individual(own).await?.thumbnail)
                }
                None => None,
            };
            listed.push(ListedLineage { lineage, cover });
        }
        Ok(listed)
    }

    /// Several, with their places.
    pub async fn details(
        &mut self,
        stored: Vec<StoredIndividual>,
    ) -> Result<Vec<IndividualDetail>, ApiError> {
        let mut details = Vec::with_capacity(stored.len());
        for one in stored {
            details.push(self.detail(one).await?);
        }
        Ok(details)
    }

    /// One generation.
    pub async fn generation(&mut self, stored: StoredGeneration) -> Result<Generation, ApiError> {
        let centre = match stored.centre {
            // The centre is shown in this lineage's scene, wherever it was born.
            Some(centre) => {
                Some(self.individual(StoredIndividual { lineage: stored.lineage, ..centre }).await?)
            }
            None => None,
        };
        let mut individuals = Vec::with_capacity(stored.individuals.len());
        for one in stored.individuals {
            individuals.push(self.individual(one).await?);
        }
        Ok(Generation {
            id: stored.id,
            lineage: stored.lineage,
            index: stored.index,
            seed: stored.seed,
            parents: stored.parents,
            centre,
            mutation: stored.mutation,
            recombination: stored.recombination,
            curation: stored.curation,
            constraints: stored.constraints,
            saturation: stored.saturation,
            energy_limit: stored.energy_limit,
            locks: stored.locks,
            individuals,
            created_ms: stored.created_ms,
        })
    }

    /// Makes the keys that were handed out durable.
    pub async fn finish(self) -> Result<(), ApiError> {
        if self.rows.is_empty() {
            return Ok(());
        }
        let rows = self.rows.iter().map(|row| row.as_ref().clone()).collect();
        match self.app.store.put_pictures(rows).await {
            // Reads go on while nothing can be written: until the next start the keys are known in memory.
            Err(error @ (StorageError::Full | StorageError::Busy | StorageError::Poisoned)) => {
                tracing::warn!(%error, "picture keys could not be stored");
                Ok(())
            }
            other => Ok(other?),
        }
    }

    async fn frame(&mut self, lineage: LineageId) -> Result<Arc<Framed>, ApiError> {
        if let Some(framed) = self.frames.get(&lineage) {
            return Ok(framed.clone());
        }
        let stored = self.app.store.lineage(lineage).await?;
        let framed = self.app.library.frame(thumbnail_view(self.app, &stored)).await?;
        self.frames.insert(lineage, framed.clone());
        Ok(framed)
    }
}

/// An individual whose thumbnail has that key.
pub fn individual(stored: StoredIndividual, key: PictureKey) -> Individual {
    Individual {
        id: stored.id,
        hash: stored.hash,
        slot: stored.slot,
        parents: stored.parents,
        operator: stored.operator,
        live_instructions: stored.live_instructions,
        layers: stored.layers.iter().map(|kind| kind.name().to_owned()).collect(),
        thumbnail: thumbnail_url(key),
        favourite: stored.favourite,
        note: stored.note,
        twin: stored.twin,
        version: stored.version,
    }
}

/// How a lineage's thumbnails are framed.
pub fn thumbnail_view(app: &AppState, lineage: &Lineage) -> View {
    View {
        scene: lineage.scene,
        light_deg: None,
        size_px: lineage.thumbnail_px,
        sampling: Sampling::default(),
        area: None,
        format: PictureFormat::Png,
        backend: app.backend,
    }
}
