//! The road of workers: claims, heartbeats, results, and what becomes of leases that nobody keeps.

use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;

use brood_protocol::{
    JobId, JobTimes, LeaseGrant, LeaseRequest, LeaseResults, LeaseTicket, Outcome, PictureKey,
    RenderItem, RenderJob, RenderedPicture, decode,
};
use brood_scene::PixelArea;
use brood_storage::FIRST_EPOCH;
use tokio::time::Instant;

use super::{Finished, Handed, Lease, Waiting};
use crate::limit;
use crate::picture::{Failure, check};
use crate::problem::{ApiError, quote};
use crate::state::{App, AppState, now_ms};

/// Longest reason that is kept.
const REASON_CHARS: usize = 500;

impl AppState {
    /// Waits for a job; `None` where there was none in the time asked for.
    pub async fn lease(self: &App, request: &LeaseRequest) -> Result<Option<LeaseGrant>, ApiError> {
        self.dispatch.heard(&request.worker, &request.report);
        let wait = limit::LEASE_WAIT.min(Duration::from_millis(request.wait_ms.into()));
        let deadline = Instant::now() + wait;
        loop {
            let rung = self.dispatch.bell.notified();
            if self.stopping.is_cancelled() {
                return Ok(None);
            }
            if self.store.any_queued().await? {
                let (app, worker) = (self.clone(), request.worker.clone());
                // In a task of its own: a claim that was written must become a lease even if the worker has gone.
                let claim = self.tasks.spawn(async move { app.claim(&worker).await });
                let claimed = claim.await.map_err(|error| ApiError::internal(error.to_string()))?;
                if let Some(handed) = claimed? {
                    return Ok(Some(handed.take()));
                }
            }
            let mut place = self.dispatch.join(&request.worker);
            tokio::select! {
                biased;
                handed = &mut place => if let Ok(handed) = handed {
                    return Ok(Some(handed.take()));
                },
                () = rung => {}
                () = tokio::time::sleep_until(deadline) => {}
                () = self.stopping.cancelled() => {}
            }
            // A job may have been put there while something else ended the wait.
            place.close();
            if let Ok(handed) = place.try_recv() {
                return Ok(Some(handed.take()));
            }
            if Instant::now() >= deadline {
                return Ok(None);
            }
        }
    }

    /// Puts a job that is being written as leased into the hands of the worker that it is leased to.
    pub fn hand_out(self: &App, job: JobId, work: RenderJob, waiting: Waiting) -> LeaseTicket {
        let work = Arc::new(work);
        let (ttl_ms, worker) = (lease_ms(), &waiting.worker);
        let lease = (job, FIRST_EPOCH);
        let ticket = self.dispatch.table.grant(lease, worker, work.clone(), Duration::ZERO);
        let grant = LeaseGrant { ticket, job, ttl_ms, work: Arc::unwrap_or_clone(work) };
        // Where the worker has left, the lease is given back by being dropped.
        drop(waiting.place.send(Handed::new(self.clone(), grant)));
        ticket
    }

    async fn claim(self: &App, worker: &str) -> Result<Option<Handed>, ApiError> {
        while let Some(job) = self.store.claim(worker).await? {
            let mut work: RenderJob = match decode(&job.payload) {
                Ok(work) => work,
                Err(error) => {
                    tracing::error!(job = %job.id, %error, "a stored job cannot be read");
                    self.store.fail(job.id, job.epoch, &error.to_string()).await?;
                    continue;
                }
            };
            let before = work.items.len();
            work.items = self.without_those_there(work.items).await?;
            self.metrics.skipped.increment((before - work.items.len()) as u64);
            if work.items.is_empty() {
                self.store.complete(job.id, job.epoch).await?;
                continue;
            }
            let waited_ms = u64::try_from(now_ms() - job.created_ms).unwrap_or(0);
            let work = Arc::new(work);
            let lease = (job.id, job.epoch);
            let queued = Duration::from_millis(waited_ms);
            let ticket = self.dispatch.table.grant(lease, worker, work.clone(), queued);
            let work = Arc::unwrap_or_clone(work);
            // More may be queued than bells were heard: whoever waits besides looks again.
            self.dispatch.bell.notify_one();
            let grant = LeaseGrant { ticket, job: job.id, ttl_ms: lease_ms(), work };
            return Ok(Some(Handed::new(self.clone(), grant)));
        }
        Ok(None)
    }

    /// The items that still have to be rendered. What is there, made meanwhile by another job or before the last
    /// restart, lands here: somebody may be waiting for it.
    async fn without_those_there(
        self: &App,
        items: Vec<RenderItem>,
    ) -> Result<Vec<RenderItem>, ApiError> {
        if !items.iter().any(|item| self.gallery.has(item.key)) {
            return Ok(items);
        }
        let app = self.clone();
        let reading = tokio::task::spawn_blocking(move || {
            let mut items = items;
            items.retain(|item| !app.gallery.land_if_there(item.key));
            items
        });
        reading.await.map_err(|error| ApiError::internal(error.to_string()))
    }

    /// Takes results; they count only while the lease is held.
    pub async fn results(self: &App, results: LeaseResults) -> Result<(), ApiError> {
        let lease = self.dispatch.table.end(&results.ticket).ok_or_else(stale)?;
        let (pictures, work) = match results.outcome {
            Outcome::Pictures(pictures, work) => (pictures, work),
            Outcome::Failed(reason) => {
                let reason: String = reason.chars().take(REASON_CHARS).collect();
                tracing::warn!(job = %lease.job, worker = %lease.worker, reason, "a job failed");
                return self.give_up(&lease, &reason).await;
            }
        };
        if let Err(reason) = check_all(&lease.work, &pictures) {
            tracing::error!(job = %lease.job, worker = %lease.worker, reason, "results are refused");
            self.give_up(&lease, "the worker sent something else than the pictures").await?;
            return Err(ApiError::refused(reason));
        }
        let leased = lease.granted.elapsed();
        self.metrics.render_seconds.record(leased.as_secs_f64());
        self.metrics.rendered.increment(pictures.len() as u64);
        self.metrics.work(&work);
        let times = JobTimes { queued_us: micros(lease.queued), leased_us: micros(leased) };
        self.dispatch.history.note(lease.job, Finished { work, times });
        for picture in pictures {
            self.landed(picture.key, Bytes::from(picture.bytes), true);
        }
        // The pictures are derived: nobody has to wait until the queue's row is gone.
        let app = self.clone();
        self.tasks.spawn(async move {
            if let Err(error) = app.store.complete(lease.job, lease.epoch).await {
                tracing::warn!(job = %lease.job, %error, "a finished job could not be taken off the queue");
            }
        });
        Ok(())
    }

    /// Keeps a lease.
    pub fn heartbeat(&self, ticket: &LeaseTicket) -> Result<(), ApiError> {
        let worker = self.dispatch.table.renew(ticket).ok_or_else(stale)?;
        self.dispatch.heard_again(&worker);
        Ok(())
    }

    /// Takes a job back undone.
    pub async fn release(&self, ticket: &LeaseTicket) -> Result<(), ApiError> {
        let lease = self.dispatch.table.end(ticket).ok_or_else(stale)?;
        self.put_back(&lease, false).await;
        Ok(())
    }

    /// Puts the jobs of leases that nobody has kept back into the queue.
    pub async fn expire_leases(&self) {
        for lease in self.dispatch.table.expire() {
            tracing::warn!(job = %lease.job, worker = %lease.worker, "a lease has lapsed");
            self.put_back(&lease, true).await;
        }
        for ticket in self.dispatch.holds.expire() {
            tracing::warn!(job = %ticket.job, "the lease of a search has lapsed");
            self.put_search_back(&ticket, true).await;
        }
    }

    /// Puts the jobs of a worker that is known to be dead back into the queue, without waiting for its leases to lapse.
    pub async fn bury(&self, worker: &str) {
        for lease in self.dispatch.table.end_those_of(worker) {
            tracing::warn!(job = %lease.job, worker, "a worker died over a job");
            self.put_back(&lease, true).await;
        }
        for ticket in self.dispatch.holds.end_those_of(worker) {
            tracing::warn!(job = %ticket.job, worker, "a worker died over a search");
            self.put_search_back(&ticket, true).await;
        }
    }

    /// Puts all jobs that are out back into the queue.
    pub async fn release_all(&self) {
        for lease in self.dispatch.table.end_all() {
            self.put_back(&lease, false).await;
        }
        for ticket in self.dispatch.holds.end_all() {
            self.put_search_back(&ticket, false).await;
        }
    }

    /// Puts the job of a lease that has ended back into the queue.
    pub async fn put_back(&self, lease: &Lease, worker_died: bool) {
        match self.store.release(lease.job, lease.epoch, worker_died).await {
            Ok(brood_storage::JobState::Dead) => {
                let reason = "worker_lost: three workers died over it";
                tracing::error!(job = %lease.job, reason, "a job is dead");
                self.gallery.crash(keys(lease), &Failure::Render(reason.into()));
            }
            Ok(_) => self.dispatch.bell.notify_one(),
            Err(error) => {
                tracing::error!(job = %lease.job, %error, "a job could not be put back");
                self.gallery.crash(keys(lease), &Failure::Internal);
            }
        }
    }

    async fn give_up(&self, lease: &Lease, reason: &str) -> Result<(), ApiError> {
        self.gallery.crash(keys(lease), &Failure::Render(reason.into()));
        Ok(self.store.fail(lease.job, lease.epoch, reason).await?)
    }
}

fn keys(lease: &Lease) -> impl Iterator<Item = PictureKey> {
    lease.work.items.iter().map(|item| item.key)
}

pub(super) fn lease_ms() -> u32 {
    u32::try_from(limit::LEASE.as_millis()).expect("a lease is seconds long")
}

fn micros(time: Duration) -> u64 {
    u64::try_from(time.as_micros()).unwrap_or(u64::MAX)
}

pub(super) fn stale() -> ApiError {
    ApiError::stale_lease("the lease has lapsed, or its job was done by another worker")
}

/// Refuses results that are not exactly the pictures asked for.
fn check_all(work: &RenderJob, pictures: &[RenderedPicture]) -> Result<(), String> {
    let mut expected: Vec<_> = work.items.iter().map(|item| item.key).collect();
    let mut given: Vec<_> = pictures.iter().map(|picture| picture.key).collect();
    expected.sort_unstable();
    expected.dedup();
    given.sort_unstable();
    if expected != given {
        return Err("these are not the pictures of the job".to_owned());
    }
    let whole = PixelArea::whole(work.frame.size_px);
    let area = work.frame.area.unwrap_or(whole);
    for picture in pictures {
        check(&picture.bytes, work.frame.format, (area.width, area.height))
            .map_err(|reason| format!("picture {}: {reason}", quote(&picture.key.to_string())))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use brood_protocol::{Backend, Frame, MeshSource, PictureFormat, RenderItem};
    use brood_scene::Scene;

    use super::*;

    fn picture(key: u8, side: u32) -> RenderedPicture {
        let bytes = brood_eval::encode_png(side, side, &vec![0; (side * side * 4) as usize]);
        let key = PictureKey([key; 32]);
        RenderedPicture { key, bytes, exposure_ev: 0.0, samples: 1, operations: 1 }
    }

    #[test]
    fn results_are_refused_unless_they_are_the_pictures_asked_for() {
        let options = (PictureFormat::Png, Backend::Auto);
        let frame = Frame::new(&Scene::default(), MeshSource::Builtin, 16, 1, options);
        let item = |key| RenderItem {
            key: PictureKey([key; 32]),
            words: Vec::new(),
            operations_written: 0,
        };
        let work = RenderJob { frame, items: vec![item(2), item(1), item(1)] };
        check_all(&work, &[picture(1, 16), picture(2, 16)]).unwrap();
        assert!(check_all(&work, &[picture(1, 16)]).is_err());
        assert!(check_all(&work, &[picture(1, 16), picture(3, 16)]).is_err());
        assert!(check_all(&work, &[picture(1, 16), picture(2, 17)]).is_err());
    }
}
