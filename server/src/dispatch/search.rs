//! Searches: claims and reports.
//!
//! Searches have their own queue and workers, so that pictures never wait behind them.

mod publish;
#[cfg(test)]
mod tests;

use std::sync::Arc;
use std::time::Duration;

use brood_eval::picture_size;
use brood_protocol::{
    CalibratedView, CorrectedScene, Directive, FoundMaterial, Generation, GenerationLine, JobId,
    MaterialSpread, MeasuredMaterial, ReportedSpread, SceneCorrection, SearchGrant, SearchReport,
    SearchState, SearchTicket, SearchUpdate, WireError, decode_stored,
};
use brood_scene::Scene;
use brood_storage::{ClaimedSearch, SearchEnd, SearchStep, StorageError, Store, StoredSearch};
use brood_target::Objective;

use super::kind::{JobKind, Jobs, Lane, LeaseOf, PendingGrant, Returned};
use super::lease::{lease_ms, renew_lease, shortened, stale};
use super::pictures::PictureService;
use crate::breeding::Breeding;
use crate::clock::now_ms;
use crate::event::Events;
use crate::idempotency::Ledger;
use crate::limit;
use crate::metric::Metrics;
use crate::problem::ApiError;
use crate::server_timing::ServerTiming;

pub use publish::search_json;

/// Most generations per report.
const REPORT_LINES: usize = 100_000;
/// Largest side of the pictures of a spread.
const SPREAD_PX: u32 = 512;
/// Largest size of such a picture: twice its pixels, for PNGs that did not compress.
const SPREAD_BYTES: usize = 2 * 4 * 512 * 512;
/// First bytes of a PNG.
const PNG_SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";
/// Largest number of rows of the maps of a spread.
const SPREAD_CELLS: u32 = 90;

/// Serves searches: their leases, reports and events. Also the kind of searches.
pub struct Searches {
    /// Database.
    pub store: Store,
    /// Leases of searches.
    pub jobs: Jobs<Self>,
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
    type Payload = ();
    type Queue = ();
    type Grant = SearchGrant;

    fn jobs(&self) -> &Jobs<Self> {
        &self.jobs
    }

    fn job(lease: &LeaseOf<Self>) -> JobId {
        lease.ticket.job
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
        while let Some(claimed) = self.store.claim_search(worker, now_ms()).await? {
            let ticket = SearchTicket { job: claimed.id, epoch: claimed.epoch };
            self.jobs.leases.grant(ticket, worker, (), limit::LEASE);
            match grant(ticket, claimed) {
                Ok(grant) => {
                    let pending = PendingGrant::new(self, ticket, grant);
                    let search = self.store.search(ticket.job).await?;
                    self.publish_state(&search);
                    return Ok(Some(pending));
                }
                Err(error) => {
                    let reason = format!("cannot decode the start genomes: {error}");
                    self.fail_claimed(&ticket, reason).await?;
                }
            }
        }
        Ok(None)
    }

    async fn on_returned(&self, lease: LeaseOf<Self>, returned: Returned) {
        let SearchTicket { job, epoch } = lease.ticket;
        match self.store.release_search(job, epoch, returned.is_loss(), now_ms()).await {
            Ok(search) => {
                if search.state == SearchState::Failed {
                    tracing::error!(%job, "a search has failed: too many workers died while running it");
                }
                self.publish_state(&search);
                self.lane.notify.notify_one();
            }
            // Paused or cancelled meanwhile.
            Err(StorageError::Conflict { .. } | StorageError::NotFound) => {}
            Err(error) => tracing::error!(%job, %error, "cannot requeue a search"),
        }
    }
}

impl Searches {
    /// Marks a search that no worker can run as failed, and ends its lease.
    async fn fail_claimed(&self, ticket: &SearchTicket, reason: String) -> Result<(), ApiError> {
        let search = self.store.search(ticket.job).await?;
        // Paused or cancelled meanwhile if the epoch differs.
        if search.epoch == ticket.epoch {
            self.fail_search(&search, reason).await?;
        }
        self.jobs.leases.end(ticket);
        Ok(())
    }

    /// Stores a worker's report and returns its directive.
    ///
    /// # Errors
    /// 409 if the lease is not valid any more, 422 if the report is invalid.
    pub async fn report(self: &Arc<Self>, report: SearchReport) -> Result<Directive, ApiError> {
        let SearchReport { ticket, update } = report;
        let held = renew_lease(&**self, &ticket)?.age;
        let search = self.store.search(ticket.job).await?;
        if search.epoch != ticket.epoch || search.state != SearchState::Running {
            self.jobs.leases.end(&ticket);
            return Err(stale());
        }
        // Runs in a separate task: what was written must be published even if the worker
        // disconnects.
        let own = self.clone();
        let taken = self.jobs.tasks.spawn(async move {
            match update {
                SearchUpdate::Generations { lines, checkpoint, best } => {
                    own.take_generations(&search, held, (lines, checkpoint), best).await
                }
                SearchUpdate::Finished { front, seconds } => {
                    own.take_front(&search, front, seconds).await
                }
                SearchUpdate::Failed(reason) => own.fail_search(&search, shortened(&reason)).await,
                SearchUpdate::Calibrated(views) => own.take_scenes(&search, views).await,
                SearchUpdate::Spread(spread) => own.take_spread(&search, &spread).await,
            }
        });
        let directive = taken.await.map_err(|error| ApiError::internal(error.to_string()))??;
        if directive == Directive::Stop {
            self.jobs.leases.end(&ticket);
            self.lane.notify.notify_one();
        }
        Ok(directive)
    }

    /// Stores the corrected scenes of the target's images.
    async fn take_scenes(
        &self,
        search: &StoredSearch,
        views: Vec<CalibratedView>,
    ) -> Result<Directive, ApiError> {
        let target = match self.store.target(search.target).await {
            Ok(target) => target,
            Err(StorageError::NotFound) => return Ok(Directive::Continue),
            Err(error) => return Err(error.into()),
        };
        if target.views.len() != views.len() {
            return Err(ApiError::refused("a report must have a scene for each image"));
        }
        let read = |CalibratedView { scene, corrections }: CalibratedView| {
            if corrections.is_empty() {
                return Ok(None);
            }
            let scene: Scene = serde_json::from_str(&scene)
                .map_err(|error| ApiError::refused(format!("a corrected scene: {error}")))?;
            scene.validate()?;
            let of = |one: &SceneCorrection| [one.value, one.stated_deviation, one.deviation];
            if !corrections.iter().flat_map(of).all(f64::is_finite) {
                return Err(ApiError::refused("corrections must be finite"));
            }
            Ok(Some(CorrectedScene { scene, corrections }))
        };
        let corrected = views.into_iter().map(read).collect::<Result<Vec<_>, ApiError>>()?;
        self.store.correct_target(search.target, corrected).await?;
        Ok(Directive::Continue)
    }

    /// Stores the spread of the materials that match the pictures of the target.
    async fn take_spread(
        &self,
        search: &StoredSearch,
        reported: &ReportedSpread,
    ) -> Result<Directive, ApiError> {
        let spread: MaterialSpread = serde_json::from_str(&reported.spread)
            .map_err(|error| ApiError::refused(format!("a spread: {error}")))?;
        let MaterialSpread { e_log, cells, seen, deviation, next, .. } = &spread;
        let count = u64::from(*cells).pow(2);
        if *cells > SPREAD_CELLS || [seen, deviation].iter().any(|map| map.len() as u64 != count) {
            return Err(ApiError::refused("a spread must have maps of at most 90 x 90 cells"));
        }
        let numbers = seen.iter().chain(deviation).chain([e_log]);
        if !numbers.chain(next.iter().map(|next| &next.e_log)).all(|number| number.is_finite()) {
            return Err(ApiError::refused("a spread must have finite numbers"));
        }
        if let Some(next) = next {
            next.scene.validate()?;
        }
        let pictures = [&reported.darkest, &reported.brightest].map(Vec::as_slice);
        let is_small = |side: u32| (1..=SPREAD_PX).contains(&side);
        for picture in pictures {
            // Only a picture of these sides is sent to a browser.
            let size = picture_size(picture).ok();
            let is_small = size.is_some_and(|(width, height)| is_small(width) && is_small(height));
            if !is_small || !picture.starts_with(PNG_SIGNATURE) || picture.len() > SPREAD_BYTES {
                return Err(ApiError::refused("a spread must have PNGs of at most 512 x 512"));
            }
        }
        self.store.set_search_spread(search.id, &spread, pictures).await?;
        Ok(Directive::Continue)
    }

    async fn take_generations(
        &self,
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
        // A search that has used its budget ends with its next report.
        let budget = search.options.budget;
        let used = budget.used_share(last.generation, last.evaluations, last.seconds);
        let yields =
            held >= limit::SEARCH_SLICE && used < 1.0 && self.store.any_search_queued().await?;
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
        if let Some(generation) = &born {
            self.publish_best(&search, generation);
        }
        if yields {
            self.publish_state(&search);
        }
        Ok(if yields { Directive::Stop } else { Directive::Continue })
    }

    async fn take_front(
        &self,
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
        let Some(generation) = self.record(search, found, with).await? else {
            let reason = "no result is a genome of the lineage's dialect";
            return self.fail_search(search, reason.to_owned()).await;
        };
        let search = self.store.search(search.id).await?;
        self.publish_best(&search, &generation);
        self.publish_state(&search);
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
    let start = decode_stored(&claimed.start)?;
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
