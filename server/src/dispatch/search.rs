//! The road of those who search: claims, heartbeats, reports, and what becomes of searches that nobody keeps.
//!
//! Searches have a queue and workers of their own: no picture waits behind them.

mod hold;
mod tell;

use std::time::Duration;

use brood_protocol::{
    Directive, FoundMaterial, GenerationLine, MeasuredMaterial, SearchGrant, SearchNews,
    SearchReport, SearchRequest, SearchState, SearchTicket, decode,
};
use brood_storage::{ClaimedSearch, SearchEnd, SearchStep, StorageError, StoredSearch};
use tokio::time::Instant;

use super::lease::{lease_ms, stale};
use crate::limit;
use crate::problem::ApiError;
use crate::state::{App, AppState, now_ms};

pub use hold::Holds;
pub use tell::search_json;

/// Longest reason that is kept.
const REASON_CHARS: usize = 500;
/// Most generations of one report.
const REPORT_LINES: usize = 100_000;

impl AppState {
    /// Waits for a search; `None` where there was none in the time asked for.
    pub async fn lease_search(
        self: &App,
        request: &SearchRequest,
    ) -> Result<Option<SearchGrant>, ApiError> {
        let wait = limit::LEASE_WAIT.min(Duration::from_millis(request.wait_ms.into()));
        let deadline = Instant::now() + wait;
        loop {
            let rung = self.dispatch.search_bell.notified();
            if self.stopping.is_cancelled() {
                return Ok(None);
            }
            if self.store.any_search_queued().await? {
                let (app, worker) = (self.clone(), request.worker.clone());
                // In a task of its own: a claim that was written must become a lease even if the worker has gone.
                let claim = self.tasks.spawn(async move { app.claim_search(&worker).await });
                let claimed = claim.await.map_err(|error| ApiError::internal(error.to_string()))?;
                if let Some(grant) = claimed? {
                    return Ok(Some(grant));
                }
            }
            tokio::select! {
                () = rung => {}
                () = tokio::time::sleep_until(deadline) => return Ok(None),
                () = self.stopping.cancelled() => return Ok(None),
            }
        }
    }

    async fn claim_search(self: &App, worker: &str) -> Result<Option<SearchGrant>, ApiError> {
        let Some(claimed) = self.store.claim_search(worker, now_ms()).await? else {
            return Ok(None);
        };
        let ticket = SearchTicket { job: claimed.id, epoch: claimed.epoch };
        self.dispatch.holds.grant(ticket, worker);
        // More may be queued than bells were heard: whoever waits besides looks again.
        self.dispatch.search_bell.notify_one();
        let search = self.store.search(claimed.id).await?;
        self.tell_state(&search);
        Ok(Some(grant(ticket, claimed)?))
    }

    /// Keeps the lease of a search.
    pub fn keep_search(&self, ticket: &SearchTicket) -> Result<(), ApiError> {
        self.dispatch.holds.renew(ticket).map(drop).ok_or_else(stale)
    }

    /// Takes a search back that a worker cannot go on with now.
    pub async fn release_search(self: &App, ticket: &SearchTicket) -> Result<(), ApiError> {
        if !self.dispatch.holds.end(ticket) {
            return Err(stale());
        }
        self.put_search_back(ticket, false).await;
        Ok(())
    }

    /// Puts a search whose lease has ended back into its queue.
    pub(super) async fn put_search_back(&self, ticket: &SearchTicket, worker_died: bool) {
        let SearchTicket { job, epoch } = *ticket;
        match self.store.release_search(job, epoch, worker_died, now_ms()).await {
            Ok(search) => {
                if search.state == SearchState::Failed {
                    tracing::error!(%job, "a search is given up: workers died over it");
                }
                self.tell_state(&search);
                self.dispatch.search_bell.notify_one();
            }
            // Somebody paused or cancelled it meanwhile.
            Err(StorageError::Conflict { .. } | StorageError::NotFound) => {}
            Err(error) => tracing::error!(%job, %error, "a search could not be put back"),
        }
    }

    /// Takes down what a worker tells; it counts only while the lease is held.
    pub async fn report_search(self: &App, report: SearchReport) -> Result<Directive, ApiError> {
        let SearchReport { ticket, news } = report;
        let held = self.dispatch.holds.renew(&ticket).ok_or_else(stale)?;
        let search = self.store.search(ticket.job).await?;
        if search.epoch != ticket.epoch || search.state != SearchState::Running {
            self.dispatch.holds.end(&ticket);
            return Err(stale());
        }
        // In a task of its own: what was written must be told even if the worker has gone meanwhile.
        let app = self.clone();
        let taken = self.tasks.spawn(async move {
            match news {
                SearchNews::Generations { lines, checkpoint, best } => {
                    app.take_generations(&search, held, (lines, checkpoint), best).await
                }
                SearchNews::Finished { front, seconds } => {
                    app.take_front(&search, front, seconds).await
                }
                SearchNews::Failed(reason) => {
                    let reason = reason.chars().take(REASON_CHARS).collect();
                    app.give_search_up(&search, reason).await
                }
            }
        });
        let directive = taken.await.map_err(|error| ApiError::internal(error.to_string()))??;
        if directive == Directive::Leave {
            self.dispatch.holds.end(&ticket);
            self.dispatch.search_bell.notify_one();
        }
        Ok(directive)
    }

    async fn take_generations(
        self: &App,
        search: &StoredSearch,
        held: Duration,
        (lines, checkpoint): (Vec<GenerationLine>, Vec<u8>),
        best: Option<MeasuredMaterial>,
    ) -> Result<Directive, ApiError> {
        let follows = lines.iter().map(|line| line.generation);
        if lines.len() > REPORT_LINES || !follows.eq((search.generation + 1..).take(lines.len())) {
            return Err(ApiError::refused("these generations do not follow the ones before"));
        }
        let Some(last) = lines.last().copied() else {
            return Err(ApiError::refused("there is no generation"));
        };
        let yields = held >= limit::SEARCH_SLICE && self.store.any_search_queued().await?;
        self.metrics.search_generations.increment(lines.len() as u64);
        let hash = *blake3::hash(&checkpoint).as_bytes();
        let step = SearchStep {
            lines,
            checkpoint: Some((checkpoint, hash)),
            seconds: last.seconds,
            yields,
            ..step(search)
        };
        let born = match best {
            Some(best) => {
                let generation = last.generation;
                let plain = step.clone();
                let with =
                    move |mut found: Vec<FoundMaterial>| SearchStep { best: found.pop(), ..plain };
                self.record(search, (vec![best], generation), with).await?
            }
            None => None,
        };
        let search = match born {
            Some(_) => self.store.search(search.id).await?,
            None => self.store.step_search(step).await?,
        };
        self.tell_progress(&search);
        if let Some((generation, _)) = &born {
            self.tell_best(&search, generation);
        }
        if yields {
            self.tell_state(&search);
        }
        Ok(if yields { Directive::Leave } else { Directive::GoOn })
    }

    async fn take_front(
        self: &App,
        search: &StoredSearch,
        front: Vec<MeasuredMaterial>,
        seconds: f64,
    ) -> Result<Directive, ApiError> {
        let plain = SearchStep { seconds, ..step(search) };
        let with = |front: Vec<FoundMaterial>| SearchStep {
            best: front.first().cloned(),
            end: Some(SearchEnd {
                state: SearchState::Succeeded,
                reason: None,
                front,
                ended_ms: now_ms(),
            }),
            ..plain
        };
        let Some((generation, _)) = self.record(search, (front, search.generation), with).await?
        else {
            let reason = "nothing that was found is a genome of the lineage's dialect";
            return self.give_search_up(search, reason.to_owned()).await;
        };
        let search = self.store.search(search.id).await?;
        self.tell_best(&search, &generation);
        self.tell_state(&search);
        Ok(Directive::Leave)
    }

    async fn give_search_up(
        &self,
        search: &StoredSearch,
        reason: String,
    ) -> Result<Directive, ApiError> {
        tracing::warn!(job = %search.id, reason, "a search failed");
        let end = SearchEnd {
            state: SearchState::Failed,
            reason: Some(reason),
            front: search.best.clone().into_iter().collect(),
            ended_ms: now_ms(),
        };
        let search = self.store.step_search(SearchStep { end: Some(end), ..step(search) }).await?;
        self.tell_state(&search);
        Ok(Directive::Leave)
    }
}

fn grant(ticket: SearchTicket, claimed: ClaimedSearch) -> Result<SearchGrant, ApiError> {
    let options = claimed.options;
    let start = decode(&claimed.start).map_err(|error| {
        ApiError::internal(format!("what a search starts from cannot be read: {error}"))
    })?;
    Ok(SearchGrant {
        ticket,
        ttl_ms: lease_ms(),
        target_kind: claimed.target_kind,
        target_hash: claimed.target_hash,
        strategy: options.strategy,
        seed: options.seed.0,
        is_mirrored: options.mirrored,
        start,
        threads: options.threads,
        budget: options.budget,
        target_error: options.target_error,
        checkpoint: claimed.checkpoint,
        seconds: claimed.seconds,
        recorded: claimed.recorded,
    })
}

/// A step that changes nothing yet.
fn step(search: &StoredSearch) -> SearchStep {
    SearchStep {
        id: search.id,
        epoch: search.epoch,
        lines: Vec::new(),
        checkpoint: None,
        best: None,
        best_before: search.best.as_ref().map(|best| best.hash),
        seconds: search.seconds,
        yields: false,
        end: None,
    }
}
