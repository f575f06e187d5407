//! What is told of a search: to those who listen to it, and where its results are born.

use brood_protocol::{Budget, Generation, SearchAnswer, SearchState};
use brood_storage::StoredSearch;
use serde_json::json;

use crate::state::AppState;

/// A search as it is answered.
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

/// How much of its budget a search has used up.
fn progress(search: &StoredSearch) -> f64 {
    let share = match search.options.budget {
        _ if search.state == SearchState::Succeeded => 1.0,
        Budget::Seconds(seconds) => search.seconds / seconds,
        Budget::Generations(generations) => f64::from(search.generation) / f64::from(generations),
        Budget::Evaluations(evaluations) => search.evaluations as f64 / evaluations as f64,
    };
    share.clamp(0.0, 1.0)
}

impl AppState {
    /// Tells where a search stands.
    pub fn tell_state(&self, search: &StoredSearch) {
        let data = json!({ "id": search.id, "state": search.state, "reason": search.reason });
        self.events.job(search.id, "state", &data);
        self.tell_lineage(search);
    }

    /// Tells how far a search has come.
    pub fn tell_progress(&self, search: &StoredSearch) {
        let data = json!({
            "id": search.id, "progress": progress(search), "generation": search.generation,
            "evaluations": search.evaluations, "seconds": search.seconds,
            "fitted": search.fitted, "held": search.held,
        });
        self.events.job(search.id, "progress", &data);
    }

    /// Tells of a new best, which is the first of a generation that was just born.
    pub fn tell_best(&self, search: &StoredSearch, born: &Generation) {
        if let (Some(best), Some(first)) = (&search.best, born.individuals.first()) {
            let mut best = best.clone();
            best.thumbnail = Some(first.thumbnail.clone());
            self.events.job(search.id, "best", &json!(best));
        }
        self.tell_lineage(search);
    }

    fn tell_lineage(&self, search: &StoredSearch) {
        let best = search.best.as_ref().map(|best| best.individual);
        let data = json!({
            "id": search.id, "state": search.state, "progress": progress(search), "best": best,
        });
        self.events.job_in(search.lineage, &data);
    }
}
