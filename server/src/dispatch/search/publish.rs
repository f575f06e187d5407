//! Answers and events of searches.

use brood_protocol::{Generation, SearchAnswer, SearchState};
use brood_storage::StoredSearch;
use serde_json::json;

use super::Searches;
use super::islands::{each, whole_search};

/// Converts a search, given by its islands, to its answer.
pub fn search_json(islands: Vec<StoredSearch>) -> SearchAnswer {
    let each_island = each(&islands);
    let search = whole_search(islands);
    let progress = progress(&search);
    let population = search.population.map(|hash| blake3::Hash::from_bytes(hash).to_hex());
    SearchAnswer {
        id: search.id,
        kind: "fit".to_owned(),
        state: search.state,
        reason: search.reason,
        target: search.target,
        lineage: search.lineage,
        options: search.options,
        progress,
        generation: search.generation,
        evaluations: search.evaluations,
        fitted: search.fitted,
        held: search.held,
        best: search.best,
        seconds: search.seconds,
        each_island,
        population: population.map(|hash| hash.to_string()),
        created_ms: search.created_ms,
        started_ms: search.started_ms,
        ended_ms: search.ended_ms,
    }
}

/// Returns the used share of a search's budget, 0 to 1.
fn progress(search: &StoredSearch) -> f64 {
    if search.state == SearchState::Succeeded {
        return 1.0;
    }
    search.options.budget.used_share(search.generation, search.evaluations, search.seconds)
}

impl Searches {
    /// Publishes the state of the search of an island.
    pub async fn publish_state(&self, island: &StoredSearch) {
        let search = self.whole(island).await;
        let data = json!({ "id": search.id, "state": search.state, "reason": search.reason });
        self.events.job(search.id, "state", &data);
        self.publish_to_lineage(&search);
    }

    /// Publishes the progress of the search of an island.
    pub async fn publish_progress(&self, island: &StoredSearch) {
        let search = self.whole(island).await;
        let data = json!({
            "id": search.id, "progress": progress(&search), "generation": search.generation,
            "evaluations": search.evaluations, "seconds": search.seconds,
            "fitted": search.fitted, "held": search.held,
        });
        self.events.job(search.id, "progress", &data);
    }

    /// Publishes a new best result of an island: the first individual of a new generation.
    pub async fn publish_best(&self, island: &StoredSearch, born: &Generation) {
        if let (Some(best), Some(first)) = (&island.best, born.individuals.first()) {
            let mut best = best.clone();
            best.thumbnail = Some(first.thumbnail.clone());
            self.events.job(island.search_id(), "best", &json!(best));
        }
        self.publish_to_lineage(&self.whole(island).await);
    }

    /// Publishes a summary of a search to its lineage.
    fn publish_to_lineage(&self, search: &StoredSearch) {
        let best = search.best.as_ref().map(|best| best.individual);
        let data = json!({
            "id": search.id, "state": search.state, "progress": progress(search), "best": best,
        });
        self.events.job_in(search.lineage, &data);
    }

    /// Returns the search of an island; the island itself if the others cannot be read.
    pub(super) async fn whole(&self, island: &StoredSearch) -> StoredSearch {
        let Some(search) = island.archipelago() else { return island.clone() };
        match self.store.islands(search).await {
            Ok(islands) => whole_search(islands),
            Err(error) => {
                tracing::debug!(job = %search, %error, "cannot read the islands of a search");
                StoredSearch { id: search, ..island.clone() }
            }
        }
    }
}
