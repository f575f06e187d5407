//! Reports of islands: programs that migrate, best materials, and the end of the last island.

use brood_protocol::{
    Arrival, Directive, GenerationLine, MeasuredMaterial, NOTABLE_RATIO, decode_stored, encode,
};
use brood_storage::{IslandEnd, IslandEnded, StorageError, StoredSearch};

use super::Searches;
use super::islands::{IslandFront, WholeFront, arrival_of, merged};
use crate::dispatch::lease::{stale, stale_or};
use crate::problem::ApiError;

impl Searches {
    /// Returns the programs of the previous island of a generation, or its end; `None` if neither
    /// is stored yet.
    pub(super) async fn arrival(
        &self,
        island: &StoredSearch,
        generation: u32,
    ) -> Result<Option<Arrival>, ApiError> {
        let stored = self.store.search_arrival(island.id, generation).await?;
        let arrival = stored.map(arrival_of).transpose();
        arrival.map_err(|error| ApiError::internal(format!("decode migrants: {error}")))
    }

    /// Returns the answer to a repeated report that has kept its lease: the arrival from the
    /// previous island if the report had emigrants of generation `migration`, else `directive`.
    pub(super) async fn repeated(
        &self,
        island: &StoredSearch,
        directive: Directive,
        migration: Option<u32>,
    ) -> Result<Directive, ApiError> {
        let Some(generation) = migration.filter(|_| directive == Directive::Continue) else {
            return Ok(directive);
        };
        let arrival = self.arrival(island, generation).await?;
        // An island whose predecessor has sent nothing has lost its lease.
        arrival.map(Directive::Take).ok_or_else(stale)
    }

    /// Returns the best material of an island's report, unless another island has recorded one
    /// that is nearly as good.
    pub(super) async fn notable(
        &self,
        island: &StoredSearch,
        best: Option<MeasuredMaterial>,
        last: Option<GenerationLine>,
    ) -> Result<Option<MeasuredMaterial>, ApiError> {
        let (Some(search), Some(last)) = (island.archipelago(), last) else { return Ok(best) };
        if best.is_none() {
            return Ok(None);
        }
        let islands = self.store.islands(search).await.map_err(stale_or)?;
        let recorded = islands.iter().filter_map(|own| own.recorded).fold(f64::INFINITY, f64::min);
        Ok(best.filter(|_| last.held < NOTABLE_RATIO * recorded))
    }

    /// Returns the front of a search when its last island ends. The front of another island is
    /// stored, and `None` is returned.
    pub(super) async fn whole_front(
        &self,
        island: &StoredSearch,
        found: IslandFront,
        seconds: f64,
    ) -> Result<Option<WholeFront>, ApiError> {
        let IslandFront { front, generation, .. } = &found;
        let Some(search) = island.archipelago() else {
            return Ok(Some(WholeFront { front: found.front, generation: found.generation }));
        };
        let end = IslandEnd {
            id: island.id,
            epoch: island.epoch,
            generation: *generation,
            seconds,
            front: encode(&found),
        };
        let others = match self.store.end_island(search, end).await.map_err(stale_or)? {
            IslandEnded::Stored(ended) => {
                self.publish_state(&ended).await;
                return Ok(None);
            }
            IslandEnded::Last(others) => others,
        };
        let mut generation = *generation;
        let mut fronts = vec![(island.island, front.clone())];
        for (number, bytes) in others {
            let other: IslandFront = decode_stored(&bytes).map_err(|error| {
                ApiError::internal(format!("decode the front of island {number}: {error}"))
            })?;
            generation = generation.max(other.generation);
            fronts.push((number, other.front));
        }
        fronts.sort_by_key(|(number, _)| *number);
        let front = merged(fronts.into_iter().map(|(_, front)| front).collect());
        Ok(Some(WholeFront { front, generation }))
    }

    /// Returns a search by its islands.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if it does not exist.
    pub async fn islands(&self, first: StoredSearch) -> Result<Vec<StoredSearch>, StorageError> {
        match first.archipelago() {
            Some(search) => self.store.islands(search).await,
            None => Ok(vec![first]),
        }
    }
}
