//! Islands of searches: a search of several as one, what they send each other, and the front of
//! all.

use brood_protocol::{
    Arrival, Directive, GenerationLine, IslandAnswer, MeasuredMaterial, SearchState, WireError,
    decode_stored, encode,
};
use brood_storage::{IslandEnd, StorageError, StoredArrival, StoredSearch};
use serde::{Deserialize, Serialize};

use super::Searches;
use crate::dispatch::lease::{stale, stale_or};
use crate::problem::ApiError;

/// A best material of one island is recorded if its validation error is below this share of that of
/// the best one recorded of any.
const NOTABLE_RATIO: f64 = 0.9;

/// Front of an island that has ended, as it is stored.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct IslandFront {
    /// Materials, the best first.
    pub front: Vec<MeasuredMaterial>,
    /// True if the island has reached the target error.
    pub is_reached: bool,
}

/// Returns what the island before has stored, as it is sent to a worker.
pub(super) fn arrival_of(stored: StoredArrival) -> Result<Arrival, WireError> {
    Ok(match stored {
        StoredArrival::Migrants(genomes) => Arrival::Migrants(decode_stored(&genomes)?),
        StoredArrival::Front(front) => {
            let IslandFront { is_reached, .. } = decode_stored(&front)?;
            Arrival::Ended { is_reached }
        }
    })
}

/// Returns the answers of several islands; none for a single one.
pub(super) fn each(islands: &[StoredSearch]) -> Vec<IslandAnswer> {
    if islands.len() < 2 {
        return Vec::new();
    }
    let one = |own: &StoredSearch| IslandAnswer {
        island: own.island,
        state: if own.is_over { SearchState::Succeeded } else { own.state },
        generation: own.generation,
        evaluations: own.evaluations,
        fitted: own.fitted,
        held: own.held,
        seconds: own.seconds,
    };
    islands.iter().map(one).collect()
}

/// Returns a search as one: the least generation, all evaluations, the longest time, and the best
/// of its islands.
pub fn whole_search(islands: Vec<StoredSearch>) -> StoredSearch {
    let first = islands[0].clone();
    if islands.len() < 2 {
        return first;
    }
    let is_running = islands.iter().any(|own| own.state == SearchState::Running);
    let by = |of: fn(&StoredSearch) -> Option<f64>| {
        let rank = move |own: &StoredSearch| of(own).unwrap_or(f64::INFINITY);
        islands.iter().min_by(|a, b| rank(a).total_cmp(&rank(b))).expect("a search has an island")
    };
    let ahead = by(|own| own.held);
    let recorded = by(|own| own.recorded.filter(|_| own.best.is_some()));
    let populations = islands.iter().map(|own| own.population).collect::<Option<Vec<_>>>();
    StoredSearch {
        state: if is_running { SearchState::Running } else { first.state },
        generation: islands.iter().map(|own| own.generation).min().unwrap_or_default(),
        evaluations: islands.iter().map(|own| own.evaluations).sum(),
        seconds: islands.iter().map(|own| own.seconds).fold(0.0, f64::max),
        fitted: ahead.fitted,
        held: ahead.held,
        population: populations.map(|all| *blake3::hash(&all.concat()).as_bytes()),
        best: match first.state {
            SearchState::Succeeded => first.best.clone(),
            _ => recorded.best.clone(),
        },
        started_ms: islands.iter().filter_map(|own| own.started_ms).min(),
        ..first
    }
}

/// Merges the fronts of islands, each with its best material first. A material stays if it has a
/// smaller error than all that are as short. The best comes first: of the best of the islands that
/// of least error, the first among equals.
fn merged(fronts: Vec<Vec<MeasuredMaterial>>) -> Vec<MeasuredMaterial> {
    let bests = fronts.iter().filter_map(|front| front.first());
    let Some(best) = bests.min_by(|a, b| a.e_log.total_cmp(&b.e_log)).cloned() else {
        return Vec::new();
    };
    let mut all: Vec<MeasuredMaterial> = fronts.into_iter().flatten().collect();
    // Stable: equal ones stay in the order of the islands.
    all.sort_by(|a, b| a.operations.cmp(&b.operations).then(a.e_log.total_cmp(&b.e_log)));
    let mut least = f64::INFINITY;
    all.retain(|one| {
        let is_better = one.e_log < least;
        least = least.min(one.e_log);
        is_better && one.genome != best.genome
    });
    all.reverse();
    all.insert(0, best);
    all
}

impl Searches {
    /// Returns what has come of the island before one, for a generation; `None` if it is not there
    /// yet.
    pub(super) async fn arrival(
        &self,
        island: &StoredSearch,
        generation: u32,
    ) -> Result<Option<Arrival>, ApiError> {
        let stored = self.store.search_arrival(island.id, generation).await?;
        let arrival = stored.map(arrival_of).transpose();
        arrival.map_err(|error| ApiError::internal(format!("decode migrants: {error}")))
    }

    /// Returns the answer to a repeated report, which has kept its lease: `directive`, or what has
    /// come of the island before, if it is one of emigrants after this generation.
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
    ) -> Result<Option<Vec<MeasuredMaterial>>, ApiError> {
        let Some(search) = island.archipelago() else { return Ok(Some(found.front)) };
        let end = IslandEnd {
            id: island.id,
            epoch: island.epoch,
            generation: island.generation,
            seconds,
            front: encode(&found),
        };
        let others = match self.store.end_island(search, end).await.map_err(stale_or)? {
            Ok(ended) => {
                self.publish_state(&ended).await;
                return Ok(None);
            }
            Err(others) => others,
        };
        let mut fronts = vec![(island.island, found.front)];
        for (number, bytes) in others {
            let IslandFront { front, .. } = decode_stored(&bytes).map_err(|error| {
                ApiError::internal(format!("decode the front of island {number}: {error}"))
            })?;
            fronts.push((number, front));
        }
        fronts.sort_by_key(|(number, _)| *number);
        Ok(Some(merged(fronts.into_iter().map(|(_, front)| front).collect())))
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

#[cfg(test)]
mod tests {
    use super::*;

    fn material(operations: u32, e_log: f64) -> MeasuredMaterial {
        MeasuredMaterial {
            genome: format!("{operations} {e_log}").into_bytes(),
            operations,
            numbers: 3,
            e_log,
            e_log_fitted: e_log,
            e_cbrt: e_log,
            relative_l2: e_log,
            divisor: 1.0,
            views: None,
        }
    }

    #[test]
    fn merged_front_has_the_best_first_and_drops_what_a_shorter_one_matches() {
        let first = vec![material(30, 0.2), material(20, 0.3), material(5, 0.9)];
        let second = vec![material(40, 0.1), material(25, 0.25), material(10, 0.3)];
        let all = merged(vec![first, second]);
        let found: Vec<(u32, f64)> = all.iter().map(|one| (one.operations, one.e_log)).collect();
        assert_eq!(found, [(40, 0.1), (30, 0.2), (25, 0.25), (10, 0.3), (5, 0.9)]);
    }
}
