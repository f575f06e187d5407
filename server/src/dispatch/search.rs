//! Searches: claims and reports.
//!
//! Searches have their own queue and workers, so that pictures never wait behind them.

mod islands;
mod migration;
mod publish;
mod spread;
#[cfg(test)]
mod tests;

use std::sync::Arc;
use std::time::Duration;

use brood_protocol::{
    Directive, FoundMaterial, Generation, GenerationLine, MeasuredMaterial, SearchGrant,
    SearchReport, SearchState, SearchTicket, SearchUpdate, WireError, decode_stored, encode,
};
use brood_storage::{
    ClaimedSearch, EndedLease, LostLeases, SearchEnd, SearchStep, StorageError, Store, StoredSearch,
};
use brood_target::Objective;
use http::StatusCode;

use self::islands::{IslandFront, WholeFront};
use super::kind::{JobKind, Jobs, Lane, PendingGrant};
use super::lease::{lease_ms, shortened, stale, stale_or};
use super::pictures::PictureService;
use crate::breeding::Breeding;
use crate::clock::now_ms;
use crate::event::Events;
use crate::idempotency::Ledger;
use crate::limit;
use crate::metric::Metrics;
use crate::problem::ApiError;
use crate::server_timing::ServerTiming;

pub use islands::whole_search;
pub use publish::search_json;

/// Most generations per report.
const REPORT_LINES: usize = 100_000;

/// Generations that a worker reports.
#[derive(Debug, Clone)]
struct Generations {
    lines: Vec<GenerationLine>,
    checkpoint: Option<Vec<u8>>,
    emigrants: Option<Vec<Vec<u8>>>,
}

/// Serves searches: their leases, reports and events. Also the kind of searches.
pub struct Searches {
    /// Database.
    pub store: Store,
    /// Tasks of searches.
    pub jobs: Jobs,
    /// Waiting workers.
    pub lane: Lane<Self>,
    /// Maker of the broods of found materials.
    pub breeding: Arc<Breeding>,
    /// Pictures of found materials.
    pub pictures: Arc<PictureService>,
    /// Idempotency keys of running requests.
    pub ledger: Ledger,
    /// Event streams.
    pub events: Arc<Events>,
    /// Metrics.
    pub metrics: Arc<Metrics>,
}

impl JobKind for Searches {
    const NAME: &'static str = "search";
    type Ticket = SearchTicket;
    type Queue = ();
    type Grant = SearchGrant;

    fn jobs(&self) -> &Jobs {
        &self.jobs
    }

    fn lane(&self, (): ()) -> &Lane<Self> {
        &self.lane
    }

    async fn any_queued(&self, (): ()) -> Result<bool, StorageError> {
        self.store.any_search_queued().await
    }

    async fn claim(
        self: &Arc<Self>,
        worker: &str,
        (): (),
    ) -> Result<Option<PendingGrant<Self>>, ApiError> {
        while let Some(claimed) = self.store.claim_search(worker, limit::LEASE, now_ms()).await? {
            let ticket = SearchTicket { job: claimed.id, epoch: claimed.epoch };
            if let Some(object) = &claimed.lost_checkpoint {
                let reason =
                    format!("the checkpoint {object} in the object store is missing or damaged");
                self.fail_claimed(&ticket, reason).await?;
                continue;
            }
            match grant(ticket, claimed) {
                Ok(grant) => {
                    let pending = PendingGrant::new(self, ticket, grant);
                    let search = self.store.search(ticket.job).await?;
                    self.publish_state(&search).await;
                    return Ok(Some(pending));
                }
                Err(error) => {
                    let reason = format!(
                        "cannot decode the start genomes, or what another island sent: {error}"
                    );
                    self.fail_claimed(&ticket, reason).await?;
                }
            }
        }
        Ok(None)
    }

    async fn give_back(&self, ticket: &SearchTicket) -> Result<(), ApiError> {
        let SearchTicket { job, epoch } = *ticket;
        let released = self.store.release_search(job, epoch, false, now_ms()).await;
        self.requeued(&released.map_err(stale_or)?).await;
        Ok(())
    }

    async fn end_lost(&self, lost: LostLeases) -> Result<Vec<EndedLease>, ApiError> {
        let ended = self.store.end_search_leases(lost, now_ms()).await?;
        let mut leases = Vec::new();
        for (lease, search) in ended {
            self.requeued(&search).await;
            leases.push(lease);
        }
        Ok(leases)
    }
}

impl Searches {
    /// Publishes a search that was returned to its queue, or has failed instead.
    async fn requeued(&self, search: &StoredSearch) {
        if search.state == SearchState::Failed {
            let job = search.search_id();
            tracing::error!(%job, "a search has failed: too many workers died while running it");
        }
        self.publish_state(search).await;
        self.wake();
    }

    /// Wakes a worker that waits, since a job is queued.
    pub fn wake(&self) {
        self.lane.notify.notify_one();
        self.events.peers().tell_search();
    }

    /// Renews a lease. Accepts that of a search that was just paused: the next report of its worker
    /// saves the search.
    ///
    /// # Errors
    /// 409 if the lease is not valid any more.
    pub async fn renew(&self, ticket: &SearchTicket) -> Result<(), ApiError> {
        let renewed = self.store.renew_search(ticket.job, ticket.epoch, limit::LEASE).await;
        match renewed {
            Err(StorageError::Conflict { .. })
                if is_paused(&self.store.search(ticket.job).await.map_err(stale_or)?, ticket) =>
            {
                Ok(())
            }
            renewed => renewed.map_err(stale_or),
        }
    }

    /// Marks a search that no worker can run as failed, and ends its lease.
    async fn fail_claimed(&self, ticket: &SearchTicket, reason: String) -> Result<(), ApiError> {
        let search = self.store.search(ticket.job).await?;
        // Paused or cancelled meanwhile if the epoch differs.
        if search.epoch == ticket.epoch {
            self.fail_search(&search, reason).await?;
        }
        Ok(())
    }

    /// Stores a worker's report and returns its directive. A search that was paused since its last
    /// report takes further generations and a checkpoint.
    ///
    /// # Errors
    /// 409 if the lease is not valid any more, 422 if the report is invalid.
    pub async fn report(self: &Arc<Self>, report: SearchReport) -> Result<Directive, ApiError> {
        let SearchReport { ticket, held_ms, update } = report;
        let held = Duration::from_millis(held_ms);
        let search = self.store.search(ticket.job).await.map_err(stale_or)?;
        let is_step = matches!(update, SearchUpdate::Generations { .. });
        let is_leased = search.epoch == ticket.epoch && search.state == SearchState::Running;
        if !(is_leased || is_step && is_paused(&search, &ticket)) {
            return Err(stale());
        }
        // Runs in a separate task: what was written must be published even if the worker
        // disconnects.
        let own = self.clone();
        let taken = self.jobs.tasks.spawn(async move {
            match update {
                SearchUpdate::Generations { lines, checkpoint, best, emigrants } => {
                    let done = Generations { lines, checkpoint, emigrants };
                    let taken =
                        own.take_generations(&search, held, done.clone(), best.clone()).await;
                    if !taken.as_ref().is_err_and(|error| error.status() == StatusCode::CONFLICT) {
                        return taken;
                    }
                    let now = own.store.search(ticket.job).await.map_err(stale_or)?;
                    if !is_paused(&now, &ticket) {
                        return taken;
                    }
                    own.take_generations(&now, held, done, best).await
                }
                SearchUpdate::Finished { front, seconds, is_reached } => {
                    let generation = search.generation;
                    let found = IslandFront { front, generation, is_reached };
                    own.take_front(&search, found, seconds).await
                }
                SearchUpdate::Failed(reason) => own.fail_search(&search, shortened(&reason)).await,
                SearchUpdate::Calibrated(views) => own.take_scenes(&search, views).await,
                SearchUpdate::Spread(spread) => own.take_spread(&search, &spread).await,
            }
        });
        let directive = taken.await.map_err(|error| ApiError::internal(error.to_string()))??;
        match directive {
            Directive::Stop => self.wake(),
            // Other reports renew the lease with the step that they store.
            Directive::Continue if !is_step => self.renew(&ticket).await?,
            Directive::Continue | Directive::Take(_) | Directive::Yield => {}
        }
        Ok(directive)
    }

    async fn take_generations(
        &self,
        search: &StoredSearch,
        held: Duration,
        Generations { lines, checkpoint, emigrants }: Generations,
        best: Option<MeasuredMaterial>,
    ) -> Result<Directive, ApiError> {
        let last = lines.last().copied();
        let migrates = emigrants.is_some();
        let (is_paused, is_saved) = (search.state == SearchState::Paused, checkpoint.is_some());
        // Of a paused search only the missing checkpoint is wanted.
        let directive = match (is_paused, is_saved) {
            (true, true) => Directive::Stop,
            (true, false) => Directive::Yield,
            (false, _) => Directive::Continue,
        };
        // The answer to a report was lost, and the worker repeats it.
        if let Some(last) = last.filter(|last| last.generation <= search.generation) {
            return self.repeated(search, directive, migrates.then_some(last.generation)).await;
        }
        let follows = lines.iter().map(|line| line.generation);
        if lines.len() > REPORT_LINES || !follows.eq((search.generation + 1..).take(lines.len())) {
            return Err(ApiError::refused(
                "the generations of a report must continue those before, at most 100000 at a time",
            ));
        }
        if lines.is_empty() && !is_saved {
            return Err(ApiError::refused("a report must have a generation or a checkpoint"));
        }
        if best.is_some() && (lines.is_empty() || !is_saved) {
            return Err(ApiError::refused(
                "a report with a material must have its generation and a checkpoint",
            ));
        }
        if migrates && (lines.is_empty() || !is_saved || search.archipelago().is_none()) {
            return Err(ApiError::refused(
                "a report with emigrants must be one of an island, with a generation and a checkpoint",
            ));
        }
        let best = self.notable(search, best, last).await?;
        let seconds = last.map_or(search.seconds, |line| line.seconds);
        let (generation, evaluations) = last
            .map_or((search.generation, search.evaluations), |line| {
                (line.generation, line.evaluations)
            });
        // A search that has used its budget ends with its next report.
        let budget = search.options.budget.of_island(search.options.islands);
        let used = budget.used_share(generation, evaluations, seconds);
        let is_due = !is_paused
            && held >= limit::SEARCH_SLICE
            && used < 1.0
            && self.store.any_search_queued().await?;
        let arrival = match emigrants {
            Some(_) => self.arrival(search, generation).await?,
            None => None,
        };
        let waits = migrates && !is_paused && arrival.is_none();
        let yields = is_due && is_saved || waits;
        self.metrics.search_generations.increment(lines.len() as u64);
        let checkpoint = checkpoint.map(|bytes| {
            let hash = *blake3::hash(&bytes).as_bytes();
            (bytes, hash)
        });
        let emigrants = emigrants.map(|genomes| encode(&genomes));
        let step = SearchStep { lines, checkpoint, emigrants, seconds, yields, ..step(search) };
        let (search, born) = match self.store_step(search, step, best, generation).await {
            Ok(stored) => stored,
            // The same report was on its way twice.
            Err(error) if error.status() == StatusCode::CONFLICT => {
                let now = self.store.search(search.id).await.map_err(stale_or)?;
                let is_stored = now.epoch == search.epoch && now.generation >= generation;
                if !is_stored || last.is_none() {
                    return Err(error);
                }
                return self.repeated(&now, directive, migrates.then_some(generation)).await;
            }
            Err(error) => return Err(error),
        };
        self.publish_progress(&search).await;
        if let Some(generation) = &born {
            self.publish_best(&search, generation).await;
        }
        if yields {
            self.publish_state(&search).await;
        }
        if migrates {
            // The next island may wait for the migrants.
            self.wake();
        }
        Ok(match (yields, arrival, is_due) {
            (true, ..) => Directive::Stop,
            (false, Some(arrival), _) if !is_paused => Directive::Take(arrival),
            (false, _, true) => Directive::Yield,
            (false, _, false) => directive,
        })
    }

    /// Stores a step, with its best material as a generation of the lineage if it fits the dialect.
    /// Returns the search after the step and that generation.
    async fn store_step(
        &self,
        search: &StoredSearch,
        step: SearchStep,
        best: Option<MeasuredMaterial>,
        generation: u32,
    ) -> Result<(StoredSearch, Option<Generation>), ApiError> {
        if let Some(best) = best {
            let plain = step.clone();
            let with =
                move |mut found: Vec<FoundMaterial>| SearchStep { best: found.pop(), ..plain };
            let born = self.record(search, (vec![best], generation), with).await?;
            if born.is_some() {
                return Ok((self.store.search(search.id).await?, born));
            }
        }
        Ok((self.store.step_search(step).await.map_err(stale_or)?, None))
    }

    async fn take_front(
        &self,
        search: &StoredSearch,
        found: IslandFront,
        seconds: f64,
    ) -> Result<Directive, ApiError> {
        let Some(WholeFront { front, generation }) =
            self.whole_front(search, found, seconds).await?
        else {
            return Ok(Directive::Stop);
        };
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
        let whole = StoredSearch { best: self.whole(search).await.best, ..search.clone() };
        let found = (front, generation);
        let Some(generation) = self.record(&whole, found, with).await? else {
            let reason = "no result is a genome of the lineage's dialect";
            return self.fail_search(search, reason.to_owned()).await;
        };
        let search = self.store.search(search.id).await?;
        self.publish_best(&search, &generation).await;
        self.publish_state(&search).await;
        Ok(Directive::Stop)
    }

    /// Stores found materials as a generation of the search's lineage, with a step of the search;
    /// `None`, without the step, if none of them fits the lineage's dialect.
    async fn record(
        &self,
        search: &StoredSearch,
        found: (Vec<MeasuredMaterial>, u32),
        step: impl FnOnce(Vec<FoundMaterial>) -> SearchStep + Send,
    ) -> Result<Option<Generation>, ApiError> {
        let lineage = self.store.lineage(search.lineage).await?;
        let Some(brood) = self.breeding.record(search, &lineage, found, step).await? else {
            return Ok(None);
        };
        let (attempt, mut timing) = (self.ledger.unkeyed(), ServerTiming::begin());
        let delivered = brood.deliver(&self.pictures, &lineage, &attempt, &mut timing).await?;
        Ok(Some(delivered.0))
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
            front: self.whole(search).await.best.into_iter().collect(),
            ended_ms: now_ms(),
        };
        let search = self.store.step_search(SearchStep { end: Some(end), ..step(search) }).await?;
        self.publish_state(&search).await;
        Ok(Directive::Stop)
    }
}

/// Returns the grant of a claimed search.
fn grant(ticket: SearchTicket, claimed: ClaimedSearch) -> Result<SearchGrant, WireError> {
    let options = claimed.options;
    let start = decode_stored(&claimed.start)?;
    let arrival = claimed.arrival.map(islands::arrival_of).transpose()?;
    // Searches of earlier versions have none.
    let objective = options.objective.unwrap_or_else(|| Objective::default().name().to_owned());
    Ok(SearchGrant {
        ticket,
        ttl_ms: lease_ms(limit::LEASE),
        target_kind: claimed.target_kind,
        target_hash: claimed.target_hash,
        strategy: options.strategy,
        objective,
        seed: options.seed.0,
        islands: options.islands,
        island: claimed.island,
        arrival,
        is_mirrored: options.mirrored,
        start,
        threads: options.threads,
        budget: options.budget.of_island(options.islands),
        target_error: options.target_error,
        checkpoint: claimed.checkpoint,
        seconds: claimed.seconds,
        recorded: claimed.recorded,
    })
}

/// True if a search was paused while the worker of a ticket had leased it, and was not changed
/// since.
fn is_paused(search: &StoredSearch, ticket: &SearchTicket) -> bool {
    search.state == SearchState::Paused && search.epoch == ticket.epoch + 1
}

/// Returns a step that changes nothing.
fn step(search: &StoredSearch) -> SearchStep {
    SearchStep {
        id: search.id,
        epoch: search.epoch,
        is_paused: search.state == SearchState::Paused,
        from: search.generation,
        lines: Vec::new(),
        checkpoint: None,
        archipelago: search.archipelago(),
        emigrants: None,
        best: None,
        best_before: search.best.as_ref().map(|best| best.hash),
        seconds: search.seconds,
        yields: false,
        ttl: limit::LEASE,
        end: None,
    }
}
