//! A search of several islands as one: its answer, and the front of all.

use brood_protocol::{
    Arrival, IslandAnswer, MeasuredMaterial, SearchState, WireError, decode_stored,
};
use brood_storage::{StoredArrival, StoredSearch};
use serde::{Deserialize, Serialize};

/// Front of an island that has ended, as it is stored.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct IslandFront {
    /// Materials, the best first.
    pub front: Vec<MeasuredMaterial>,
    /// Number of generations of the island.
    pub generation: u32,
    /// True if the island has reached the target error.
    pub is_reached: bool,
}

/// Front of a search.
#[derive(Debug)]
pub(super) struct WholeFront {
    /// Materials, the best first.
    pub front: Vec<MeasuredMaterial>,
    /// Largest number of generations of an island.
    pub generation: u32,
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
        state: if own.is_over && !own.state.is_final() {
            SearchState::Succeeded
        } else {
            own.state
        },
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
    // All, once the search has ended.
    let going_on = islands.iter().filter(|own| !own.is_over);
    let populations = islands.iter().map(|own| own.population).collect::<Option<Vec<_>>>();
    StoredSearch {
        state: if is_running { SearchState::Running } else { first.state },
        generation: going_on.map(|own| own.generation).min().unwrap_or(first.generation),
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
/// smaller error than all others of at most its number of operations. The material of least error
/// comes first; of equal ones, that of the first island.
pub(super) fn merged(fronts: Vec<Vec<MeasuredMaterial>>) -> Vec<MeasuredMaterial> {
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
