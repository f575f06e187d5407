//! Render jobs: claims, direct grants, results.

use std::sync::Arc;
use std::time::Duration;

use brood_protocol::{
    JobId, JobTimes, LeaseGrant, LeaseId, LeaseResults, LeaseTicket, PictureFormat, PictureKey,
    Queue, RenderItem, RenderJob, RenderOutcome, RenderedPicture, WireError, decode,
};
use brood_scene::PixelArea;
use brood_storage::{FIRST_EPOCH, JobState, StorageError};
use bytes::Bytes;

use super::history::FinishedJob;
use super::kind::{JobKind, Jobs, Lane, LeaseOf, PendingGrant};
use super::lease::{lease_ms, renew_lease, shortened, stale};
use super::pictures::PictureService;
use super::queue::WaitingWorker;
use super::table::Renewed;
use crate::clock::now_ms;
use crate::picture::{Failure, check, decode as decode_picture};
use crate::problem::{ApiError, quote};
use crate::processors::run_blocking;

/// Worker that waits for a render job.
pub type WaitingRenderer = WaitingWorker<PendingGrant<PictureService>>;

/// Render job during its lease.
pub struct LeasedRender {
    job: JobId,
    queue: Queue,
    work: RenderJob,
    /// Time that the job waited in the queue.
    queued: Duration,
}

impl JobKind for PictureService {
    const NAME: &'static str = "render";
    type Ticket = LeaseTicket;
    type Payload = LeasedRender;
    type Grant = LeaseGrant;
    type Queue = Queue;

    fn jobs(&self) -> &Jobs<Self> {
        &self.jobs
    }

    fn job(lease: &LeaseOf<Self>) -> JobId {
        lease.payload.job
    }

    fn lane(&self, queue: Queue) -> &Lane<Self> {
        match queue {
            Queue::Interactive => &self.interactive,
            Queue::Batch => &self.batch,
        }
    }

    async fn any_queued(&self, queue: Queue) -> Result<bool, StorageError> {
        self.store.any_queued(queue).await
    }

    async fn claim(
        self: &Arc<Self>,
        worker: &str,
        queue: Queue,
    ) -> Result<Option<PendingGrant<Self>>, ApiError> {
        while let Some(job) = self.store.claim(worker, queue).await? {
            self.turns.claimed(queue, job.turn);
            let mut work: RenderJob = match decode(&job.payload) {
                Ok(work) => work,
                Err(WireError::Version) => {
                    // Its pictures are rendered when they are requested again.
                    tracing::info!(job = %job.id, "a job queued by another version is dropped");
                    self.store.complete(job.id, job.epoch).await?;
                    continue;
                }
                Err(error) => {
                    tracing::error!(job = %job.id, %error, "cannot decode a stored job");
                    self.store.fail(job.id, job.epoch, &error.to_string()).await?;
                    continue;
                }
            };
            let before = work.items.len();
            work.items = self.without_cached(work.items).await?;
            self.metrics.skipped.increment((before - work.items.len()) as u64);
            work.items.retain(|item| !self.cache.end_if_abandoned(&[item.key]));
            if work.items.is_empty() {
                self.store.complete(job.id, job.epoch).await?;
                self.metrics.abandoned.increment(1);
                continue;
            }
            let waited_ms = u64::try_from(now_ms() - job.created_ms).unwrap_or(0);
            let queued = Duration::from_millis(waited_ms);
            let job = (job.id, queue, job.epoch);
            return Ok(Some(self.grant(job, worker, work, queued)));
        }
        Ok(None)
    }

    async fn on_returned(&self, lease: LeaseOf<Self>, worker_died: bool) {
        let job = lease.payload.job;
        match self.store.release(job, lease.ticket.epoch, worker_died).await {
            Ok(JobState::Dead) => {
                let reason = "worker_lost: three workers died while rendering it";
                tracing::error!(%job, reason, "a job has failed permanently");
                self.cache.fail(keys(&lease), &Failure::Render(reason.into()));
            }
            Ok(_) => self.lane(lease.payload.queue).notify.notify_one(),
            Err(error) => {
                tracing::error!(%job, %error, "cannot requeue a job");
                self.cache.fail(keys(&lease), &Failure::Internal);
            }
        }
    }
}

impl PictureService {
    /// Grants a job that is being written as leased directly to a waiting worker.
    pub fn grant_directly(
        self: &Arc<Self>,
        job: JobId,
        work: RenderJob,
        waiting: WaitingRenderer,
    ) -> LeaseTicket {
        let job = (job, Queue::Interactive, FIRST_EPOCH);
        let pending = self.grant(job, &waiting.worker, work, Duration::ZERO);
        let ticket = pending.ticket();
        // If the worker has disconnected, dropping the grant returns the lease.
        drop(waiting.sender.send(pending));
        ticket
    }

    /// Grants the lease of a claimed job.
    fn grant(
        self: &Arc<Self>,
        (job, queue, epoch): (JobId, Queue, u64),
        worker: &str,
        work: RenderJob,
        queued: Duration,
    ) -> PendingGrant<Self> {
        let ticket = LeaseTicket { lease: LeaseId::fresh(), epoch };
        let payload = LeasedRender { job, queue, work: work.clone(), queued };
        self.jobs.leases.grant(ticket, worker, payload);
        let ttl_ms = lease_ms(self.jobs.leases.ttl);
        PendingGrant::new(self, ticket, LeaseGrant { ticket, job, ttl_ms, work })
    }

    /// Renews a lease. Ends it and its job if no client waits for any of its pictures: the worker
    /// then stops rendering.
    ///
    /// # Errors
    /// 409 if the lease is not valid any more.
    pub async fn renew(&self, ticket: &LeaseTicket) -> Result<Renewed, ApiError> {
        let renewed = renew_lease(self, ticket)?;
        let keys = self.jobs.leases.read(ticket, |lease| keys(lease).collect::<Vec<_>>());
        if keys.is_some_and(|keys| self.cache.end_if_abandoned(&keys))
            && let Some(lease) = self.jobs.leases.end(ticket)
        {
            let job = lease.payload.job;
            tracing::debug!(%job, "no client waits for a job any more");
            self.store.complete(job, ticket.epoch).await?;
            self.metrics.abandoned.increment(1);
            return Err(ApiError::stale_lease("no client waits for the pictures any more"));
        }
        Ok(renewed)
    }

    /// Returns the items that must be rendered. Cached pictures, made by another job or before a
    /// restart, are completed here: a request may be waiting for them.
    async fn without_cached(
        self: &Arc<Self>,
        items: Vec<RenderItem>,
    ) -> Result<Vec<RenderItem>, ApiError> {
        if !items.iter().any(|item| self.cache.has(item.key)) {
            return Ok(items);
        }
        let own = self.clone();
        run_blocking(move || {
            let mut items = items;
            items.retain(|item| !own.cache.complete_if_cached(item.key));
            items
        })
        .await
    }

    /// Accepts the results of a lease. Pictures of workers that are not the server's own are
    /// decoded; if one is invalid, the job is queued again.
    ///
    /// # Errors
    /// 409 if the lease is not valid any more, 422 if the results are not the requested pictures.
    pub async fn results(
        self: &Arc<Self>,
        results: LeaseResults,
        is_own: bool,
    ) -> Result<(), ApiError> {
        let lease = self.jobs.leases.end(&results.ticket).ok_or_else(stale)?;
        let job = lease.payload.job;
        let (pictures, work) = match results.outcome {
            RenderOutcome::Pictures(pictures, work) => (pictures, work),
            RenderOutcome::Failed(reason) => {
                let reason = shortened(&reason);
                tracing::warn!(%job, worker = %lease.worker, reason, "a job failed");
                return self.fail_job(&lease, &reason).await;
            }
            RenderOutcome::Missing(reason) => {
                let failure = Failure::Missing(shortened(&reason).into());
                self.cache.fail(keys(&lease), &failure);
                return Ok(self.store.complete(job, lease.ticket.epoch).await?);
            }
        };
        let checked = match check_all(&lease.payload.work, &pictures) {
            Ok(()) if !is_own => {
                let work = lease.payload.work.clone();
                let decode = move || decode_all(&work, &pictures).map(|()| pictures);
                run_blocking(decode).await?
            }
            checked => checked.map(|()| pictures),
        };
        let pictures = match checked {
            Ok(pictures) => pictures,
            Err(reason) => {
                tracing::error!(%job, worker = %lease.worker, reason, "results are refused");
                if is_own {
                    self.fail_job(&lease, "the worker sent invalid pictures").await?;
                } else {
                    // Another worker may do better.
                    self.on_returned(lease, true).await;
                }
                return Err(ApiError::refused(reason));
            }
        };
        let leased = lease.granted.elapsed();
        self.metrics.render_seconds.record(leased.as_secs_f64());
        self.metrics.rendered.increment(pictures.len() as u64);
        self.metrics.work(&work);
        let times = JobTimes { queued_us: micros(lease.payload.queued), leased_us: micros(leased) };
        self.history.note(job, FinishedJob { work, times });
        for picture in pictures {
            self.ready(picture.key, Bytes::from(picture.bytes), true);
        }
        // The pictures are already cached, so the answer does not wait for the removal of the
        // queue's row.
        let own = self.clone();
        self.jobs.tasks.spawn(async move {
            if let Err(error) = own.store.complete(job, lease.ticket.epoch).await {
                tracing::warn!(%job, %error, "cannot remove a finished job from the queue");
            }
        });
        Ok(())
    }

    /// Marks a job as failed.
    async fn fail_job(
        &self,
        lease: &LeaseOf<PictureService>,
        reason: &str,
    ) -> Result<(), ApiError> {
        self.cache.fail(keys(lease), &Failure::Render(reason.into()));
        Ok(self.store.fail(lease.payload.job, lease.ticket.epoch, reason).await?)
    }
}

fn keys(lease: &LeaseOf<PictureService>) -> impl Iterator<Item = PictureKey> {
    lease.payload.work.items.iter().map(|item| item.key)
}

fn micros(time: Duration) -> u64 {
    u64::try_from(time.as_micros()).unwrap_or(u64::MAX)
}

/// Checks that results are exactly the requested pictures.
fn check_all(work: &RenderJob, pictures: &[RenderedPicture]) -> Result<(), String> {
    let mut expected: Vec<_> = work.items.iter().map(|item| item.key).collect();
    let mut given: Vec<_> = pictures.iter().map(|picture| picture.key).collect();
    expected.sort_unstable();
    expected.dedup();
    given.sort_unstable();
    if expected != given {
        return Err("the results must be exactly the pictures of the job".to_owned());
    }
    each(work, pictures, check)
}

/// Checks that pictures can be decoded.
fn decode_all(work: &RenderJob, pictures: &[RenderedPicture]) -> Result<(), String> {
    each(work, pictures, decode_picture)
}

/// Check of the bytes of a picture against its format and size.
type PictureCheck = fn(&[u8], PictureFormat, (u32, u32)) -> Result<(), String>;

/// Applies a check to each picture.
fn each(work: &RenderJob, pictures: &[RenderedPicture], check: PictureCheck) -> Result<(), String> {
    let whole = PixelArea::whole(work.frame.size_px);
    let area = work.frame.area.unwrap_or(whole);
    pictures.iter().try_for_each(|picture| {
        check(&picture.bytes, work.frame.format, (area.width, area.height))
            .map_err(|reason| format!("picture {}: {reason}", quote(&picture.key.to_string())))
    })
}

#[cfg(test)]
mod tests {
    use brood_protocol::{Backend, Frame, MeshSource, PackedProgram, Subject, encode};
    use brood_scene::Scene;
    use brood_storage::NewJob;

    use super::*;
    use crate::config::ServerConfig;
    use crate::server::Server;

    fn picture(key: u8, side: u32) -> RenderedPicture {
        let bytes = brood_eval::encode_png(side, side, &vec![0; (side * side * 4) as usize]);
        let key = PictureKey([key; 32]);
        RenderedPicture { key, bytes, exposure_ev: 0.0, samples: 1, operations: 1 }
    }

    fn job(items: Vec<RenderItem>) -> RenderJob {
        let options = (PictureFormat::Png, Backend::Auto);
        let frame = Frame::new(&Scene::default(), MeshSource::Builtin, 16, 1, options);
        RenderJob::new(frame, items)
    }

    fn item(key: u8) -> RenderItem {
        let packed = PackedProgram { words: Vec::new(), operations_written: 0 };
        RenderItem { key: PictureKey([key; 32]), subject: Subject::Program(packed) }
    }

    #[tokio::test]
    async fn job_is_queued_again_after_invalid_pictures_of_a_foreign_worker() {
        let dir = tempfile::tempdir().unwrap();
        let config = ServerConfig::new("127.0.0.1:0".parse().unwrap(), dir.path().to_owned());
        let app = Server::bind(config).await.unwrap().app();
        let queued = NewJob {
            id: JobId::fresh(),
            queue: Queue::Interactive,
            turn: 0,
            leased_to: None,
            payload: encode(&job(vec![item(1)])),
            created_ms: 1,
        };
        app.store.enqueue(queued, 9).await.unwrap();
        for (is_own, is_queued) in [(false, true), (true, false)] {
            let claimed = app.pictures.claim("far", Queue::Interactive).await.unwrap();
            let ticket = claimed.expect("the job is queued").take().ticket;
            let outcome = RenderOutcome::Pictures(Vec::new(), Default::default());
            let refused = app.pictures.results(LeaseResults { ticket, outcome }, is_own).await;
            assert_eq!(refused.unwrap_err().status(), 422);
            assert_eq!(app.store.any_queued(Queue::Interactive).await.unwrap(), is_queued);
        }
    }

    #[test]
    fn results_are_refused_unless_they_are_the_pictures_asked_for() {
        let work = job(vec![item(2), item(1), item(1)]);
        check_all(&work, &[picture(1, 16), picture(2, 16)]).unwrap();
        assert!(check_all(&work, &[picture(1, 16)]).is_err());
        assert!(check_all(&work, &[picture(1, 16), picture(3, 16)]).is_err());
        assert!(check_all(&work, &[picture(1, 16), picture(2, 17)]).is_err());
    }
}
