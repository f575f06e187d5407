//! Leases of render jobs: claims, heartbeats, results, and requeueing of expired leases.

use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;

use brood_protocol::{
    JobId, JobTimes, LeaseGrant, LeaseRequest, LeaseResults, LeaseTicket, PictureKey, RenderItem,
    RenderJob, RenderOutcome, RenderedPicture, decode,
};
use brood_scene::PixelArea;
use brood_storage::FIRST_EPOCH;
use tokio::time::Instant;

use super::{FinishedJob, Lease, PendingGrant, WaitingWorker};
use crate::clock::now_ms;
use crate::limit;
use crate::picture::{Failure, check};
use crate::problem::{ApiError, quote};
use crate::state::{App, AppState};

/// Longest error text of a worker that is stored.
const REASON_CHARS: usize = 500;

impl AppState {
    /// Waits for a render job; `None` if there is none in the requested time.
    ///
    /// # Errors
    /// [`ApiError`] if the store fails.
    pub async fn lease(self: &App, request: &LeaseRequest) -> Result<Option<LeaseGrant>, ApiError> {
        self.dispatch.worker_seen(&request.worker, &request.report);
        let wait = limit::LEASE_WAIT.min(Duration::from_millis(request.wait_ms.into()));
        let deadline = Instant::now() + wait;
        loop {
            let notified = self.dispatch.job_notify.notified();
            if self.stopping.is_cancelled() {
                return Ok(None);
            }
            if self.store.any_queued().await? {
                let (app, worker) = (self.clone(), request.worker.clone());
                // Runs in a separate task: a claim that was written must become a lease even if the
                // worker disconnects.
                let claim = self.tasks.spawn(async move { app.claim(&worker).await });
                let claimed = claim.await.map_err(|error| ApiError::internal(error.to_string()))?;
                if let Some(pending) = claimed? {
                    return Ok(Some(pending.take()));
                }
            }
            let mut receiver = self.dispatch.join(&request.worker);
            tokio::select! {
                biased;
                pending = &mut receiver => if let Ok(pending) = pending {
                    return Ok(Some(pending.take()));
                },
                () = notified => {}
                () = tokio::time::sleep_until(deadline) => {}
                () = self.stopping.cancelled() => {}
            }
            // A job may have arrived while another branch ended the wait.
            receiver.close();
            if let Ok(pending) = receiver.try_recv() {
                return Ok(Some(pending.take()));
            }
            if Instant::now() >= deadline {
                return Ok(None);
            }
        }
    }

    /// Grants a job that is being written as leased directly to a waiting worker.
    pub fn grant_directly(
        self: &App,
        job: JobId,
        work: RenderJob,
        waiting: WaitingWorker,
    ) -> LeaseTicket {
        let work = Arc::new(work);
        let (ttl_ms, worker) = (lease_ms(), &waiting.worker);
        let lease = (job, FIRST_EPOCH);
        let ticket = self.dispatch.table.grant(lease, worker, work.clone(), Duration::ZERO);
        let grant = LeaseGrant { ticket, job, ttl_ms, work: Arc::unwrap_or_clone(work) };
        // If the worker has disconnected, dropping the grant returns the lease.
        drop(waiting.sender.send(PendingGrant::new(self.clone(), grant)));
        ticket
    }

    async fn claim(self: &App, worker: &str) -> Result<Option<PendingGrant>, ApiError> {
        while let Some(job) = self.store.claim(worker).await? {
            let mut work: RenderJob = match decode(&job.payload) {
                Ok(work) => work,
                Err(error) => {
                    tracing::error!(job = %job.id, %error, "cannot decode a stored job");
                    self.store.fail(job.id, job.epoch, &error.to_string()).await?;
                    continue;
                }
            };
            let before = work.items.len();
            work.items = self.without_cached(work.items).await?;
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
            // Notifications coalesce: wake another waiter, as more jobs may be queued.
            self.dispatch.job_notify.notify_one();
            let grant = LeaseGrant { ticket, job: job.id, ttl_ms: lease_ms(), work };
            return Ok(Some(PendingGrant::new(self.clone(), grant)));
        }
        Ok(None)
    }

    /// Returns the items that must be rendered. Cached pictures, made by another job or before a
    /// restart, are completed here: a request may be waiting for them.
    async fn without_cached(
        self: &App,
        items: Vec<RenderItem>,
    ) -> Result<Vec<RenderItem>, ApiError> {
        if !items.iter().any(|item| self.picture_cache.has(item.key)) {
            return Ok(items);
        }
        let app = self.clone();
        let reading = tokio::task::spawn_blocking(move || {
            let mut items = items;
            items.retain(|item| !app.picture_cache.complete_if_cached(item.key));
            items
        });
        reading.await.map_err(|error| ApiError::internal(error.to_string()))
    }

    /// Accepts the results of a lease.
    ///
    /// # Errors
    /// 409 if the lease is not valid any more, 422 if the results are not the requested pictures.
    pub async fn results(self: &App, results: LeaseResults) -> Result<(), ApiError> {
        let lease = self.dispatch.table.end(&results.ticket).ok_or_else(stale)?;
        let (pictures, work) = match results.outcome {
            RenderOutcome::Pictures(pictures, work) => (pictures, work),
            RenderOutcome::Failed(reason) => {
                let reason: String = reason.chars().take(REASON_CHARS).collect();
                tracing::warn!(job = %lease.job, worker = %lease.worker, reason, "a job failed");
                return self.fail_job(&lease, &reason).await;
            }
        };
        if let Err(reason) = check_all(&lease.work, &pictures) {
            tracing::error!(job = %lease.job, worker = %lease.worker, reason, "results are refused");
            self.fail_job(&lease, "the worker sent invalid pictures").await?;
            return Err(ApiError::refused(reason));
        }
        let leased = lease.granted.elapsed();
        self.metrics.render_seconds.record(leased.as_secs_f64());
        self.metrics.rendered.increment(pictures.len() as u64);
        self.metrics.work(&work);
        let times = JobTimes { queued_us: micros(lease.queued), leased_us: micros(leased) };
        self.dispatch.history.note(lease.job, FinishedJob { work, times });
        for picture in pictures {
            self.picture_ready(picture.key, Bytes::from(picture.bytes), true);
        }
        // The pictures are already cached, so the answer does not wait for the removal of the
        // queue's row.
        let app = self.clone();
        self.tasks.spawn(async move {
            if let Err(error) = app.store.complete(lease.job, lease.epoch).await {
                tracing::warn!(job = %lease.job, %error, "cannot remove a finished job from the queue");
            }
        });
        Ok(())
    }

    /// Renews a lease.
    ///
    /// # Errors
    /// 409 if the lease is not valid any more.
    pub fn heartbeat(&self, ticket: &LeaseTicket) -> Result<(), ApiError> {
        let worker = self.dispatch.table.renew(ticket).ok_or_else(stale)?;
        self.dispatch.worker_seen_again(&worker);
        Ok(())
    }

    /// Returns an unfinished job to the queue.
    ///
    /// # Errors
    /// 409 if the lease is not valid any more.
    pub async fn release(&self, ticket: &LeaseTicket) -> Result<(), ApiError> {
        let lease = self.dispatch.table.end(ticket).ok_or_else(stale)?;
        self.requeue_job(&lease, false).await;
        Ok(())
    }

    /// Requeues the jobs of expired leases.
    pub async fn expire_leases(&self) {
        for lease in self.dispatch.table.expire() {
            tracing::warn!(job = %lease.job, worker = %lease.worker, "a lease has expired");
            self.requeue_job(&lease, true).await;
        }
        for ticket in self.dispatch.search_leases.expire() {
            tracing::warn!(job = %ticket.job, "the lease of a search has expired");
            self.requeue_search(&ticket, true).await;
        }
    }

    /// Requeues the jobs of a dead worker at once, before its leases expire.
    pub async fn requeue_jobs_of(&self, worker: &str) {
        for lease in self.dispatch.table.end_those_of(worker) {
            tracing::warn!(job = %lease.job, worker, "a worker died while rendering a job");
            self.requeue_job(&lease, true).await;
        }
        for ticket in self.dispatch.search_leases.end_those_of(worker) {
            tracing::warn!(job = %ticket.job, worker, "a worker died while running a search");
            self.requeue_search(&ticket, true).await;
        }
    }

    /// Requeues the jobs of all leases.
    pub async fn release_all(&self) {
        for lease in self.dispatch.table.end_all() {
            self.requeue_job(&lease, false).await;
        }
        for ticket in self.dispatch.search_leases.end_all() {
            self.requeue_search(&ticket, false).await;
        }
    }

    /// Requeues the job of an ended lease.
    pub async fn requeue_job(&self, lease: &Lease, worker_died: bool) {
        match self.store.release(lease.job, lease.epoch, worker_died).await {
            Ok(brood_storage::JobState::Dead) => {
                let reason = "worker_lost: three workers died while rendering it";
                tracing::error!(job = %lease.job, reason, "a job has failed permanently");
                self.picture_cache.fail(keys(lease), &Failure::Render(reason.into()));
            }
            Ok(_) => self.dispatch.job_notify.notify_one(),
            Err(error) => {
                tracing::error!(job = %lease.job, %error, "cannot requeue a job");
                self.picture_cache.fail(keys(lease), &Failure::Internal);
            }
        }
    }

    /// Marks a job as failed.
    async fn fail_job(&self, lease: &Lease, reason: &str) -> Result<(), ApiError> {
        self.picture_cache.fail(keys(lease), &Failure::Render(reason.into()));
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
    ApiError::stale_lease("the lease has expired, or another worker finished the job")
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
