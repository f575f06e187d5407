//! Render jobs: hand-out, claims, results.

use std::sync::Arc;
use std::time::Duration;

use brood_protocol::{
    JobId, JobTimes, LeaseGrant, LeaseId, LeaseRenewal, LeaseResults, LeaseTicket, PictureFormat,
    PictureKey, Queue, RenderItem, RenderJob, RenderOutcome, RenderedPicture,
};
use brood_scene::PixelArea;
use brood_storage::{EndedLease, LostLeases, StorageError};
use bytes::Bytes;

use super::history::FinishedJob;
use super::kind::{JobKind, Jobs, Lane, PendingGrant};
use super::lease::{lease_ms, shortened, stale};
use super::pictures::PictureService;
use super::render_queue::{QueueFull, QueuedJob, Returned};
use super::table::{LeasedRender, RenderLease, Renewed};
use crate::client::Client;
use crate::limit;
use crate::picture::{Failure, check, decode as decode_picture};
use crate::problem::{ApiError, quote};
use crate::processors::run_blocking;

impl JobKind for PictureService {
    const NAME: &'static str = "render";
    type Ticket = LeaseTicket;
    type Grant = LeaseGrant;
    type Queue = Queue;

    fn jobs(&self) -> &Jobs {
        &self.jobs
    }

    fn lane(&self, queue: Queue) -> &Lane<Self> {
        match queue {
            Queue::Interactive => &self.interactive,
            Queue::Batch => &self.batch,
        }
    }

    async fn any_queued(&self, queue: Queue) -> Result<bool, StorageError> {
        Ok(!self.queue.is_empty(queue))
    }

    async fn claim(
        self: &Arc<Self>,
        worker: &str,
        queue: Queue,
    ) -> Result<Option<PendingGrant<Self>>, ApiError> {
        while let Some(mut job) = self.queue.take(queue) {
            let queued_items = job.work.items.len();
            let wanted: Vec<_> = keys(&job).collect();
            match self.without_cached(std::mem::take(&mut job.work.items)).await {
                Ok(items) => job.work.items = items,
                Err(error) => {
                    self.queue.fail(&job, "its pictures could not be read");
                    self.cache.fail(wanted, &Failure::Internal);
                    return Err(error);
                }
            }
            self.metrics.skipped.increment((queued_items - job.work.items.len()) as u64);
            job.work.items.retain(|item| !self.cache.end_if_abandoned(&[item.key]));
            if job.work.items.is_empty() {
                self.queue.forget(job.id);
                self.metrics.abandoned.increment(1);
                continue;
            }
            let queued = job.age();
            return Ok(Some(self.grant(job, worker, queued)));
        }
        Ok(None)
    }

    async fn give_back(&self, ticket: &LeaseTicket) -> Result<(), ApiError> {
        let lease = self.leases.end(ticket).ok_or_else(stale)?;
        self.put_back(lease, Returned::Released);
        Ok(())
    }

    async fn end_lost(&self, lost: LostLeases) -> Result<Vec<EndedLease>, ApiError> {
        let (leases, returned) = match lost {
            LostLeases::Expired => (self.leases.end_expired(), Returned::Expired),
            LostLeases::OfWorker(worker) => (self.leases.end_those_of(&worker), Returned::Died),
            LostLeases::OfStopped(worker) => {
                (self.leases.end_those_of(&worker), Returned::Released)
            }
            LostLeases::OfProcess => (self.leases.end_all(), Returned::Released),
        };
        let mut ended = Vec::with_capacity(leases.len());
        for lease in leases {
            let (id, epoch) = (lease.payload.job.id, lease.ticket.epoch);
            ended.push(EndedLease { id, epoch, worker: lease.worker.clone() });
            self.put_back(lease, returned);
        }
        Ok(ended)
    }
}

impl PictureService {
    /// Hands a job to a waiting worker, or queues it. Returns its id.
    ///
    /// # Errors
    /// [`QueueFull`] if no worker waits and the queue takes no more jobs.
    pub fn hand_out(
        self: &Arc<Self>,
        work: RenderJob,
        queue: Queue,
        client: Client,
    ) -> Result<JobId, QueueFull> {
        let lane = self.lane(queue);
        if let Some(waiting) = lane.waiting.next() {
            let job = self.queue.take_new(work, queue, client);
            let id = job.id;
            let pending = self.grant(job, &waiting.worker, Duration::ZERO);
            // If the worker has disconnected, dropping the grant returns the lease.
            drop(waiting.sender.send(pending));
            return Ok(id);
        }
        let id = self.queue.push(work, queue, client)?;
        lane.notify.notify_one();
        Ok(id)
    }

    /// Returns the job of a lease that has ended to its queue.
    fn put_back(&self, lease: RenderLease, returned: Returned) {
        let queue = lease.payload.job.queue;
        match self.queue.put_back(lease.payload.job, returned) {
            None => self.lane(queue).notify.notify_one(),
            Some(dead) => {
                let reason = "worker_lost: its workers died or were cut off while rendering it";
                tracing::error!(job = %dead.id, reason, "a job has failed permanently");
                self.metrics.dead.increment(1);
                self.cache.fail(keys(&dead), &Failure::Render(reason.into()));
            }
        }
    }

    /// Grants the lease of a job.
    fn grant(
        self: &Arc<Self>,
        job: QueuedJob,
        worker: &str,
        queued: Duration,
    ) -> PendingGrant<Self> {
        let ticket = LeaseTicket { lease: LeaseId::fresh(), epoch: job.epoch };
        let (id, work) = (job.id, job.work.clone());
        let ttl = match job.queue {
            Queue::Interactive => limit::INTERACTIVE_LEASE,
            Queue::Batch => limit::BATCH_LEASE,
        };
        self.leases.grant(ticket, worker, LeasedRender { job, queued }, ttl);
        let ttl_ms = lease_ms(ttl);
        PendingGrant::new(self, ticket, LeaseGrant { ticket, job: id, ttl_ms, work })
    }

    /// Renews a lease and stores the progress of its job. If no client waits for any of the
    /// pictures, lease and job end, and the worker stops rendering.
    ///
    /// # Errors
    /// 409 if the lease is not valid any more.
    pub fn renew(&self, renewal: &LeaseRenewal) -> Result<Renewed, ApiError> {
        let LeaseRenewal { ticket, progress } = renewal;
        let renewed = self.leases.renew(ticket).ok_or_else(stale)?;
        let read = |lease: &RenderLease| keys(&lease.payload.job).collect::<Vec<_>>();
        let Some(keys) = self.leases.read(ticket, read) else { return Ok(renewed) };
        self.cache.note_progress(&keys, *progress);
        if self.cache.end_if_abandoned(&keys)
            && let Some(lease) = self.leases.end(ticket)
        {
            let job = lease.payload.job.id;
            tracing::debug!(%job, "no client waits for a job any more");
            self.queue.forget(job);
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
        let lease = self.leases.end(&results.ticket).ok_or_else(stale)?;
        let job = lease.payload.job.id;
        let (pictures, work) = match results.outcome {
            RenderOutcome::Pictures(pictures, work) => (pictures, work),
            RenderOutcome::Failed(reason) => {
                let reason = shortened(&reason);
                tracing::warn!(%job, worker = %lease.worker, reason, "a job failed");
                self.fail_job(&lease, &reason);
                return Ok(());
            }
            RenderOutcome::Missing(reason) => {
                let failure = Failure::Missing(shortened(&reason).into());
                self.cache.fail(keys(&lease.payload.job), &failure);
                self.queue.forget(job);
                return Ok(());
            }
        };
        let checked = match check_all(&lease.payload.job.work, &pictures) {
            Ok(()) if !is_own => {
                let work = lease.payload.job.work.clone();
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
                    self.fail_job(&lease, "the worker sent invalid pictures");
                } else {
                    // Another worker may do better.
                    self.put_back(lease, Returned::Died);
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
        self.queue.forget(job);
        Ok(())
    }

    /// Marks a job as failed.
    fn fail_job(&self, lease: &RenderLease, reason: &str) {
        self.cache.fail(keys(&lease.payload.job), &Failure::Render(reason.into()));
        self.queue.fail(&lease.payload.job, reason);
    }
}

fn keys(job: &QueuedJob) -> impl Iterator<Item = PictureKey> {
    job.work.items.iter().map(|item| item.key)
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
    use brood_protocol::{Backend, Frame, MeshSource, PackedProgram, Subject};
    use brood_scene::Scene;

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
        let (work, client) = (job(vec![item(1)]), Client::current());
        app.pictures.hand_out(work, Queue::Interactive, client).unwrap();
        for (is_own, is_queued) in [(false, true), (true, false)] {
            let claimed = app.pictures.claim("far", Queue::Interactive).await.unwrap();
            let ticket = claimed.expect("the job is queued").take().ticket;
            let outcome = RenderOutcome::Pictures(Vec::new(), Default::default());
            let refused = app.pictures.results(LeaseResults { ticket, outcome }, is_own).await;
            assert_eq!(refused.unwrap_err().status(), 422);
            assert_eq!(!app.pictures.queue.is_empty(Queue::Interactive), is_queued);
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
