//! Searches: claims and reports.
//!
//! Searches have their own queue and workers, so that pictures never wait behind them.

mod publish;
#[cfg(test)]
mod tests;

use std::time::Duration;

use brood_protocol::{
    Directive, FoundMaterial, GenerationLine, JobId, MeasuredMaterial, SearchGrant, SearchReport,
    SearchState, SearchTicket, SearchUpdate, WireError, decode,
};
use brood_storage::{ClaimedSearch, SearchEnd, SearchStep, StorageError, StoredSearch};

use super::Dispatch;
use super::kind::{JobKind, Jobs, LeaseOf};
use super::lease::{lease_ms, shortened, stale};
use super::queue::PendingGrant;
use crate::breeding;
use crate::clock::now_ms;
use crate::limit;
use crate::problem::ApiError;
use crate::state::{App, AppState};

pub use publish::search_json;

/// Most generations per report.
const REPORT_LINES: usize = 100_000;

/// Kind of searches.
pub enum Search {}

impl JobKind for Search {
    const NAME: &'static str = "search";
    type Ticket = SearchTicket;
    type Payload = ();
    type Grant = SearchGrant;

    fn jobs(dispatch: &Dispatch) -> &Jobs<Self> {
        &dispatch.searches
    }

    fn job(lease: &LeaseOf<Self>) -> JobId {
        lease.ticket.job
    }

    async fn any_queued(app: &AppState) -> Result<bool, StorageError> {
        app.store.any_search_queued().await
    }

    async fn claim(app: &App, worker: &str) -> Result<Option<PendingGrant<Self>>, ApiError> {
        while let Some(claimed) = app.store.claim_search(worker, now_ms()).await? {
            let ticket = SearchTicket { job: claimed.id, epoch: claimed.epoch };
            app.dispatch.searches.leases.grant(ticket, worker, ());
            match grant(ticket, claimed) {
                Ok(grant) => {
                    let pending = PendingGrant::new(app.clone(), ticket, grant);
                    let search = app.store.search(ticket.job).await?;
                    app.publish_state(&search);
                    return Ok(Some(pending));
                }
                Err(error) => {
                    let reason = format!("cannot decode the start genomes: {error}");
                    app.fail_claimed(&ticket, reason).await?;
                }
            }
        }
        Ok(None)
    }

    async fn on_returned(app: &AppState, lease: LeaseOf<Self>, worker_died: bool) {
        let SearchTicket { job, epoch } = lease.ticket;
        match app.store.release_search(job, epoch, worker_died, now_ms()).await {
            Ok(search) => {
                if search.state == SearchState::Failed {
                    tracing::error!(%job, "a search has failed: too many workers died while running it");
                }
                app.publish_state(&search);
                app.dispatch.searches.notify.notify_one();
            }
            // Paused or cancelled meanwhile.
            Err(StorageError::Conflict { .. } | StorageError::NotFound) => {}
            Err(error) => tracing::error!(%job, %error, "cannot requeue a search"),
        }
    }
}

impl AppState {
    /// Marks a search that no worker can run as failed, and ends its lease.
    async fn fail_claimed(&self, ticket: &SearchTicket, reason: String) -> Result<(), ApiError> {
        let search = self.store.search(ticket.job).await?;
        // Paused or cancelled meanwhile if the epoch differs.
        if search.epoch == ticket.epoch {
            self.fail_search(&search, reason).await?;
        }
        self.dispatch.searches.leases.end(ticket);
        Ok(())
    }

    /// Stores a worker's report and returns its directive.
    ///
    /// # Errors
    /// 409 if the lease is not valid any more, 422 if the report is invalid.
    pub async fn report_search(self: &App, report: SearchReport) -> Result<Directive, ApiError> {
        let SearchReport { ticket, update } = report;
        let held = self.renew_lease::<Search>(&ticket)?.age;
        let search = self.store.search(ticket.job).await?;
        if search.epoch != ticket.epoch || search.state != SearchState::Running {
            self.dispatch.searches.leases.end(&ticket);
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
                SearchUpdate::Failed(reason) => app.fail_search(&search, shortened(&reason)).await,
            }
        });
        let directive = taken.await.map_err(|error| ApiError::internal(error.to_string()))??;
        if directive == Directive::Stop {
            self.dispatch.searches.leases.end(&ticket);
            self.dispatch.searches.notify.notify_one();
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
                breeding::record(self, search, (vec![best], generation), with).await?
            }
            None => None,
        };
        let search = match born {
            Some(_) => self.store.search(search.id).await?,
            None => self.store.step_search(step).await?,
        };
        self.publish_progress(&search);
        if let Some(generation) = &born {
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
        let found = (front, search.generation);
        let Some(generation) = breeding::record(self, search, found, with).await? else {
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

/// Returns the grant of a claimed search.
fn grant(ticket: SearchTicket, claimed: ClaimedSearch) -> Result<SearchGrant, WireError> {
    let options = claimed.options;
    let start = decode(&claimed.start)?;
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
