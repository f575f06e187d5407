//! Leases of searches: claims, heartbeats, reports, and requeueing of expired leases.
//!
//! Searches have their own queue and workers, so that pictures never wait behind them.

mod lease;
mod publish;

use std::time::Duration;

use brood_protocol::{
    Directive, FoundMaterial, GenerationLine, MeasuredMaterial, SearchGrant, SearchReport,
    SearchRequest, SearchState, SearchTicket, SearchUpdate, decode,
};
use brood_storage::{ClaimedSearch, SearchEnd, SearchStep, StorageError, StoredSearch};
use tokio::time::Instant;

use super::lease::{lease_ms, stale};
use crate::clock::now_ms;
use crate::limit;
use crate::problem::ApiError;
use crate::state::{App, AppState};

pub use lease::SearchLeases;
pub use publish::search_json;

/// Longest error text of a worker that is stored.
const REASON_CHARS: usize = 500;
/// Most generations per report.
const REPORT_LINES: usize = 100_000;

impl AppState {
    /// Waits for a search; `None` if there is none in the requested time.
    ///
    /// # Errors
    /// [`ApiError`] if the store fails.
    pub async fn lease_search(
        self: &App,
        request: &SearchRequest,
    ) -> Result<Option<SearchGrant>, ApiError> {
        let wait = limit::LEASE_WAIT.min(Duration::from_millis(request.wait_ms.into()));
        let deadline = Instant::now() + wait;
        loop {
            let notified = self.dispatch.search_notify.notified();
            if self.stopping.is_cancelled() {
                return Ok(None);
            }
            if self.store.any_search_queued().await? {
                let (app, worker) = (self.clone(), request.worker.clone());
                // Runs in a separate task: a claim that was written must become a lease even if the
                // worker disconnects.
                let claim = self.tasks.spawn(async move { app.claim_search(&worker).await });
                let claimed = claim.await.map_err(|error| ApiError::internal(error.to_string()))?;
                if let Some(grant) = claimed? {
                    return Ok(Some(grant));
                }
            }
            tokio::select! {
                () = notified => {}
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
        self.dispatch.search_leases.grant(ticket, worker);
        // Notifications coalesce: wake another waiter, as more searches may be queued.
        self.dispatch.search_notify.notify_one();
        let search = self.store.search(claimed.id).await?;
        self.publish_state(&search);
        Ok(Some(grant(ticket, claimed)?))
    }

    /// Renews the lease of a search.
    ///
    /// # Errors
    /// 409 if the lease is not valid any more.
    pub fn renew_search(&self, ticket: &SearchTicket) -> Result<(), ApiError> {
        self.dispatch.search_leases.renew(ticket).map(drop).ok_or_else(stale)
    }

    /// Returns an unfinished search to its queue.
    ///
    /// # Errors
    /// 409 if the lease is not valid any more.
    pub async fn release_search(self: &App, ticket: &SearchTicket) -> Result<(), ApiError> {
        if !self.dispatch.search_leases.end(ticket) {
            return Err(stale());
        }
        self.requeue_search(ticket, false).await;
        Ok(())
    }

    /// Requeues the search of an ended lease.
    pub(super) async fn requeue_search(&self, ticket: &SearchTicket, worker_died: bool) {
        let SearchTicket { job, epoch } = *ticket;
        match self.store.release_search(job, epoch, worker_died, now_ms()).await {
            Ok(search) => {
                if search.state == SearchState::Failed {
                    tracing::error!(%job, "a search has failed: too many workers died while running it");
                }
                self.publish_state(&search);
                self.dispatch.search_notify.notify_one();
            }
            // Paused or cancelled meanwhile.
            Err(StorageError::Conflict { .. } | StorageError::NotFound) => {}
            Err(error) => tracing::error!(%job, %error, "cannot requeue a search"),
        }
    }

    /// Stores a worker's report and returns its directive.
    ///
    /// # Errors
    /// 409 if the lease is not valid any more, 422 if the report is invalid.
    pub async fn report_search(self: &App, report: SearchReport) -> Result<Directive, ApiError> {
        let SearchReport { ticket, update } = report;
        let held = self.dispatch.search_leases.renew(&ticket).ok_or_else(stale)?;
        let search = self.store.search(ticket.job).await?;
        if search.epoch != ticket.epoch || search.state != SearchState::Running {
            self.dispatch.search_leases.end(&ticket);
            return Err(stale());
        }
        // Runs in a separate task: what was written must be published even if the worker
        // disconnects.
        let app = self.clone();
        let taken = self.tasks.spawn(async move {
            match update {
                SearchUpdate::Generations { lines, checkpoint, best } => {
                    app.take_generations(&search, held, (lines, checkpoint), best).await
                }
                SearchUpdate::Finished { front, seconds } => {
                    app.take_front(&search, front, seconds).await
                }
                SearchUpdate::Failed(reason) => {
                    let reason = reason.chars().take(REASON_CHARS).collect();
                    app.fail_search(&search, reason).await
                }
            }
        });
        let directive = taken.await.map_err(|error| ApiError::internal(error.to_string()))??;
        if directive == Directive::Stop {
            self.dispatch.search_leases.end(&ticket);
            self.dispatch.search_notify.notify_one();
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
            return Err(ApiError::refused(
                "the generations of a report must continue those before, at most 100000 at a time",
            ));
        }
        let Some(last) = lines.last().copied() else {
            return Err(ApiError::refused("a report must have at least one generation"));
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
        self.publish_progress(&search);
        if let Some((generation, _)) = &born {
            self.publish_best(&search, generation);
        }
        if yields {
            self.publish_state(&search);
        }
        Ok(if yields { Directive::Stop } else { Directive::Continue })
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
            let reason = "no result is a genome of the lineage's dialect";
            return self.fail_search(search, reason.to_owned()).await;
        };
        let search = self.store.search(search.id).await?;
        self.publish_best(&search, &generation);
        self.publish_state(&search);
        Ok(Directive::Stop)
    }

    /// Marks a search as failed.
    async fn fail_search(
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
        self.publish_state(&search);
        Ok(Directive::Stop)
    }
}

fn grant(ticket: SearchTicket, claimed: ClaimedSearch) -> Result<SearchGrant, ApiError> {
    let options = claimed.options;
    let start = decode(&claimed.start).map_err(|error| {
        ApiError::internal(format!("cannot decode a search's start genomes: {error}"))
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

/// Returns a step that changes nothing.
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
