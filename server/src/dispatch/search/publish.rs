//! Answers and events of searches.

use brood_protocol::{Generation, SearchAnswer, SearchState};
use brood_storage::StoredSearch;
use serde_json::json;

use super::Searches;

/// Converts a search to its answer.
pub fn search_json(search: StoredSearch) -> SearchAnswer {
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
    /// Publishes a search's state.
    pub fn publish_state(&self, search: &StoredSearch) {
        let data = json!({ "id": search.id, "state": search.state, "reason": search.reason });
        self.events.job(search.id, "state", &data);
        self.publish_to_lineage(search);
    }

    /// Publishes a search's progress.
    pub fn publish_progress(&self, search: &StoredSearch) {
        let data = json!({
            "id": search.id, "progress": progress(search), "generation": search.generation,
            "evaluations": search.evaluations, "seconds": search.seconds,
            "fitted": search.fitted, "held": search.held,
        });
        self.events.job(search.id, "progress", &data);
    }

    /// Publishes a new best result: the first individual of a new generation.
    pub fn publish_best(&self, search: &StoredSearch, born: &Generation) {
        if let (Some(best), Some(first)) = (&search.best, born.individuals.first()) {
            let mut best = best.clone();
            best.thumbnail = Some(first.thumbnail.clone());
            self.events.job(search.id, "best", &json!(best));
        }
        self.publish_to_lineage(search);
    }

    /// Publishes a summary of a search to its lineage.
    fn publish_to_lineage(&self, search: &StoredSearch) {
        let best = search.best.as_ref().map(|best| best.individual);
        let data = json!({
            "id": search.id, "state": search.state, "progress": progress(search), "best": best,
        });
        self.events.job_in(search.lineage, &data);
    }
}
