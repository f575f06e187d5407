//! Converts stored rows to answers: adds thumbnail URLs and registers their picture keys.

use std::sync::Arc;

use brood_program::ProgramHash;
use brood_protocol::{
    Generation, GenerationId, GenerationOutline, Individual, IndividualDetail, Lineage, LineageId,
    ListedLineage,
};
use brood_storage::{StorageError, StoredGeneration, StoredIndividual, StoredOutline};
use std::collections::HashMap;

use crate::answer::individual;
use crate::library::{Framed, Framing};
use crate::problem::ApiError;
use crate::state::AppState;

/// Converts individuals with thumbnails in the scenes of their lineages, and collects the new
/// picture rows.
pub struct Presenter<'a> {
    app: &'a AppState,
    frames: HashMap<LineageId, Arc<Framed>>,
    rows: Vec<Arc<brood_storage::StoredPicture>>,
}

impl<'a> Presenter<'a> {
    /// Creates a presenter without cached frames.
    pub fn new(app: &'a AppState) -> Self {
        Self { app, frames: HashMap::new(), rows: Vec::new() }
    }

    /// Converts an individual.
    ///
    /// # Errors
    /// [`ApiError`] if its lineage or scene cannot be read.
    pub async fn individual(&mut self, stored: StoredIndividual) -> Result<Individual, ApiError> {
        let framed = self.frame(stored.lineage).await?;
        let key = framed.key(ProgramHash::from_bytes(stored.program_hash));
        let picture_cache = &self.app.pictures.cache;
        if picture_cache.row(key).is_none() {
            let row = Arc::new(framed.row(key, stored.hash));
            picture_cache.insert_row(&row);
            self.rows.push(row);
        }
        if !picture_cache.has(key) {
            picture_cache.add_listener(key, stored.lineage, stored.id);
        }
        Ok(individual(stored, key))
    }

    /// Converts an individual with its lineage and generation.
    ///
    /// # Errors
    /// As for [`Self::individual`].
    pub async fn detail(&mut self, stored: StoredIndividual) -> Result<IndividualDetail, ApiError> {
        let (lineage, generation) = (stored.lineage, stored.generation);
        let indices = self.app.store.generation_indices(&[generation]).await?;
        let individual = self.individual(stored).await?;
        Ok(detail(individual, lineage, generation, &indices))
    }

    /// Converts lineages with their cover pictures.
    ///
    /// # Errors
    /// [`ApiError`] if the store fails.
    pub async fn lineages(&mut self, stored: Vec<Lineage>) -> Result<Vec<ListedLineage>, ApiError> {
        let ids: Vec<_> = stored.iter().map(|lineage| lineage.id).collect();
        let mut covers = self.app.store.covers(&ids).await?;
        let mut listed = Vec::with_capacity(stored.len());
        for lineage in stored {
            let cover = match covers.remove(&lineage.id) {
                // Shown in this lineage's scene, even if it belongs to another lineage.
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

    /// Converts several individuals with their lineages and generations.
    ///
    /// # Errors
    /// As for [`Self::individual`].
    pub async fn details(
        &mut self,
        stored: Vec<StoredIndividual>,
    ) -> Result<Vec<IndividualDetail>, ApiError> {
        let generations: Vec<_> = stored.iter().map(|one| one.generation).collect();
        let indices = self.app.store.generation_indices(&generations).await?;
        let mut details = Vec::with_capacity(stored.len());
        for one in stored {
            let (lineage, generation) = (one.lineage, one.generation);
            details.push(detail(self.individual(one).await?, lineage, generation, &indices));
        }
        Ok(details)
    }

    /// Converts a generation.
    ///
    /// # Errors
    /// As for [`Self::individual`].
    pub async fn generation(&mut self, stored: StoredGeneration) -> Result<Generation, ApiError> {
        let centre = self.centre(stored.lineage, stored.centre).await?;
        let individuals = self.individuals(stored.individuals).await?;
        Ok(Generation {
            id: stored.id,
            lineage: stored.lineage,
            index: stored.index,
            seed: stored.seed,
            parents: stored.parents,
            centre,
            options: stored.options,
            individuals,
            created_ms: stored.created_ms,
        })
    }

    /// Converts the outline of a generation of this lineage.
    ///
    /// # Errors
    /// As for [`Self::individual`].
    pub async fn outline(
        &mut self,
        lineage: LineageId,
        stored: StoredOutline,
    ) -> Result<GenerationOutline, ApiError> {
        let StoredOutline { id, index, from, centre, individuals } = stored;
        let centre = self.centre(lineage, centre).await?;
        Ok(GenerationOutline {
            id,
            index,
            from,
            centre,
            individuals: self.individuals(individuals).await?,
        })
    }

    /// Converts a centre. It is shown in this lineage's scene, even if it belongs to another
    /// lineage.
    async fn centre(
        &mut self,
        lineage: LineageId,
        stored: Option<StoredIndividual>,
    ) -> Result<Option<Individual>, ApiError> {
        match stored {
            Some(centre) => {
                Ok(Some(self.individual(StoredIndividual { lineage, ..centre }).await?))
            }
            None => Ok(None),
        }
    }

    async fn individuals(
        &mut self,
        stored: Vec<StoredIndividual>,
    ) -> Result<Vec<Individual>, ApiError> {
        let mut individuals = Vec::with_capacity(stored.len());
        for one in stored {
            individuals.push(self.individual(one).await?);
        }
        Ok(individuals)
    }

    /// Stores the new picture rows, so that their keys stay valid across restarts.
    ///
    /// # Errors
    /// [`ApiError`] if the store fails for another reason than a full or busy disk.
    pub async fn finish(self) -> Result<(), ApiError> {
        if self.rows.is_empty() {
            return Ok(());
        }
        let rows = self.rows.iter().map(|row| row.as_ref().clone()).collect();
        match self.app.store.put_pictures(rows).await {
            // Reads must work while writes fail: the keys stay in memory until the next start.
            Err(
                error @ (StorageError::Full
                | StorageError::Busy
                | StorageError::Poisoned
                | StorageError::Gone
                | StorageError::Unreachable(_)),
            ) => {
                tracing::warn!(%error, "cannot store picture keys");
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
        let framed = self.app.library.frame(Framing::thumbnail(self.app.backend, &stored)).await?;
        self.frames.insert(lineage, framed.clone());
        Ok(framed)
    }
}

/// Adds the place of an individual. An index is missing only if the generation was purged since.
fn detail(
    individual: Individual,
    lineage: LineageId,
    generation: GenerationId,
    indices: &HashMap<GenerationId, u64>,
) -> IndividualDetail {
    let generation_index = indices.get(&generation).copied().unwrap_or_default();
    IndividualDetail { individual, lineage, generation, generation_index, exposure_ev: None }
}
