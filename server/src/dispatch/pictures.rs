//! Picture requests: answered from memory, from disk, by a render already in flight, or by a new
//! job.

use std::sync::Arc;
use std::time::Duration;

use brood_protocol::{LeaseTicket, PictureKey, Queue, RenderJob};
use brood_storage::{Store, StoredPicture};
use bytes::Bytes;
use http::StatusCode;

use super::history::History;
use super::kind::{Jobs, Lane};
use super::render_queue::{QueueFull, RenderQueue};
use super::request::{FrameId, PictureRequest, queue_for, render_work};
use super::table::{LeaseTable, LeasedRender};
use crate::client::Client;
use crate::deferred::{AnswerProgress, longest_wait};
use crate::event::Events;
use crate::library::Library;
use crate::metric::Metrics;
use crate::picture::{Coalescer, Failure, Lookup, PictureCache, thumbnail_url};
use crate::problem::ApiError;

/// Requests within this time share a job.
const BATCH_WINDOW: Duration = Duration::from_millis(1);
/// Largest `Retry-After` in seconds.
const RETRY_MOST_S: u64 = 60;
/// Time for which a picture is wanted after its client was asked to come again.
const KEPT_WANTED: Duration = Duration::from_secs(2 * RETRY_MOST_S);

/// Serves pictures: from the cache, by a render in flight, or by a new render job. Also the kind of
/// render jobs.
pub struct PictureService {
    /// Database: picture rows.
    pub store: Store,
    /// Caches of materials and frames.
    pub library: Arc<Library>,
    /// Pictures in memory and on disk, and renders in flight.
    pub cache: PictureCache,
    /// Requested pictures, collected by frame for a short time before they become render jobs.
    pub batches: Coalescer<FrameId, Arc<StoredPicture>>,
    /// Tasks of render jobs.
    pub jobs: Jobs,
    /// Leases of render jobs.
    pub leases: LeaseTable<LeaseTicket, LeasedRender>,
    /// Workers that wait for interactive jobs.
    pub interactive: Lane<Self>,
    /// Workers that wait for batch jobs.
    pub batch: Lane<Self>,
    /// Render jobs that wait for a worker.
    pub queue: RenderQueue,
    /// Recently finished render jobs.
    pub history: History,
    /// Event streams, which get the URLs of new thumbnails.
    pub events: Arc<Events>,
    /// Metrics.
    pub metrics: Arc<Metrics>,
}

impl PictureService {
    /// Returns a picture, rendered if necessary; waits at most [`longest_wait`].
    ///
    /// # Errors
    /// As [`PictureService::get_from`].
    pub async fn get(
        self: &Arc<Self>,
        request: impl Into<PictureRequest>,
    ) -> Result<Bytes, ApiError> {
        self.get_from(Queue::Interactive, request).await
    }

    /// As [`PictureService::get`]; renders it by a job of this queue. Pictures of deferred
    /// answers, and pictures too large for an interactive job, are always rendered by a batch job.
    ///
    /// # Errors
    /// 422 if the material cannot be drawn in the scene; 503 if the server is busy, stopping or too
    /// slow; 500 if rendering fails.
    pub async fn get_from(
        self: &Arc<Self>,
        queue: Queue,
        request: impl Into<PictureRequest>,
    ) -> Result<Bytes, ApiError> {
        let request = request.into();
        let key = request.key();
        let part = AnswerProgress::current().map(|progress| progress.begin(key));
        let queue = if part.is_some() { Queue::Batch } else { queue };
        let mut waiter = match self.cache.subscribe(key, queue) {
            Lookup::Cached(bytes) => {
                self.metrics.served.increment(1);
                return Ok(bytes);
            }
            Lookup::Missing(reason) => return Err(ApiError::not_found(reason.as_ref())),
            Lookup::InFlight(waiter) => {
                if queue == Queue::Interactive {
                    self.move_to_interactive(&[key], Client::current());
                }
                waiter
            }
            Lookup::Leader(waiter) => {
                let (own, asked) = (self.clone(), (queue, Client::current()));
                // Runs in a separate task, so that a picture that has become a job is not lost if
                // the client disconnects. The job ends unrendered if no other client waits for it
                // when a worker claims it.
                self.jobs.tasks.spawn(async move { own.fetch_or_enqueue(request, asked).await });
                waiter
            }
        };
        let outcome = tokio::select! {
            outcome = waiter.wait_for(Option::is_some) => match outcome {
                Ok(outcome) => outcome.clone(),
                Err(_) => None,
            },
            () = tokio::time::sleep(longest_wait()) => {
                self.cache.keep_wanted(key, KEPT_WANTED);
                return Err(ApiError::not_yet("retry in a moment"));
            }
            () = self.jobs.stopping.cancelled() => {
                return Err(ApiError::stopping("retry after the restart"));
            }
        };
        match outcome {
            Some(Ok(bytes)) => Ok(bytes),
            Some(Err(Failure::Refused(reason))) => Err(ApiError::refused(reason.as_ref())),
            Some(Err(Failure::Missing(reason))) => Err(ApiError::not_found(reason.as_ref())),
            Some(Err(Failure::Render(reason))) => Err(ApiError::render_failed(reason.as_ref())),
            Some(Err(Failure::Busy)) => Err(ApiError::busy("too many pictures are queued")),
            Some(Err(Failure::Unavailable(reason))) => Err(ApiError::busy(reason.as_ref())),
            Some(Err(Failure::Internal)) | None => {
                Err(ApiError::internal("a picture request ended without a result"))
            }
        }
    }

    /// Returns the `Retry-After` of a 503 in seconds: the larger of the recent mean duration of
    /// jobs and the age of the oldest interactive job.
    pub fn retry_after_s(&self) -> u64 {
        let of_late = self.history.wait().unwrap_or_default();
        whole_seconds(of_late.max(self.queue.oldest(Queue::Interactive).unwrap_or_default()))
    }

    async fn fetch_or_enqueue(self: Arc<Self>, request: PictureRequest, asked: (Queue, Client)) {
        let key = request.key();
        let disk = self.cache.disk().clone();
        if disk.contains(key)
            && let Ok(Some(bytes)) = tokio::task::spawn_blocking(move || disk.read(key)).await
        {
            self.metrics.recalled.increment(1);
            self.ready(key, bytes, false);
            return;
        }
        let row = match request {
            PictureRequest::Stored(row) => row,
            PictureRequest::Own(work) => {
                return self.enqueue(async { Ok(work) }, [key], asked).await;
            }
        };
        let frame = FrameId::of(&row);
        if self.batches.add(frame, row) {
            tokio::time::sleep(BATCH_WINDOW).await;
            let rows = self.batches.take(&frame);
            for batch in rows.chunks(frame.per_job()) {
                let work = self.work_of(frame, batch);
                self.enqueue(work, batch.iter().map(|row| row.key), asked).await;
            }
        }
    }

    /// Returns the render job for stored pictures of one frame. Fails the pictures of materials
    /// that cannot be drawn in it, and leaves them out.
    async fn work_of(
        &self,
        frame: FrameId,
        rows: &[Arc<StoredPicture>],
    ) -> Result<RenderJob, ApiError> {
        let framed = self.library.frame(frame.view()).await?;
        let mut items = Vec::with_capacity(rows.len());
        for row in rows {
            let material = self.library.material(row.genome_hash).await?;
            match framed.refusal(&material.program) {
                Some(words) => self.cache.fail([row.key], &Failure::Refused(words.into())),
                None => items.push((row.key, material)),
            }
        }
        let items = items.iter().map(|(key, material)| (*key, material.as_ref()));
        Ok(render_work(&framed.frame, items))
    }

    /// Moves the waiting batch job of one of these pictures to the interactive queue, if it is
    /// small enough for that queue.
    fn move_to_interactive(&self, keys: &[PictureKey], client: Client) {
        if keys.iter().any(|key| self.queue.move_to_interactive(*key, client)) {
            self.interactive.notify.notify_one();
        }
    }

    /// Queues a job unless it is empty; if it cannot be queued, fails the pictures with these keys.
    async fn enqueue(
        self: &Arc<Self>,
        work: impl Future<Output = Result<RenderJob, ApiError>>,
        keys: impl IntoIterator<Item = PictureKey>,
        (queue, client): (Queue, Client),
    ) {
        let keys: Vec<PictureKey> = keys.into_iter().collect();
        let result = async {
            let work = work.await?;
            if !work.items.is_empty() {
                let is_urgent = || self.cache.any_urgent(&keys);
                let asked = if is_urgent() { Queue::Interactive } else { queue };
                let queue = asked.max(queue_for(work.rays()));
                self.hand_out(work, queue, client)?;
                // A client may have asked for one of the pictures meanwhile.
                if asked == Queue::Batch && is_urgent() {
                    self.move_to_interactive(&keys, client);
                }
            }
            Ok(())
        };
        if let Err::<(), Failure>(failure) = result.await {
            self.cache.fail(keys, &failure);
        }
    }

    /// Completes a picture: answers the waiting requests and publishes its thumbnail.
    pub fn ready(&self, key: PictureKey, bytes: Bytes, fresh: bool) {
        if fresh {
            self.cache.complete(key, bytes);
        } else {
            self.cache.complete_from_disk(key, bytes);
        }
        let listeners = self.cache.take_listeners(key);
        if !listeners.is_empty() {
            let url = thumbnail_url(key);
            for (lineage, individual) in listeners {
                self.events.thumbnail(lineage, individual, &url);
            }
        }
    }
}

impl From<ApiError> for Failure {
    fn from(error: ApiError) -> Self {
        if error.status() == StatusCode::SERVICE_UNAVAILABLE {
            tracing::debug!(?error, "cannot prepare a render job now");
            return Self::Unavailable(error.problem().detail.as_str().into());
        }
        tracing::error!(?error, "cannot prepare a render job");
        Self::Internal
    }
}

impl From<QueueFull> for Failure {
    fn from(_: QueueFull) -> Self {
        Self::Busy
    }
}

/// Rounds up to whole seconds, at most [`RETRY_MOST_S`].
fn whole_seconds(time: Duration) -> u64 {
    u64::try_from(time.as_millis().div_ceil(1000)).unwrap_or(RETRY_MOST_S).clamp(1, RETRY_MOST_S)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn retry_after_is_whole_seconds_within_bounds() {
        let seconds = |ms| whole_seconds(Duration::from_millis(ms));
        assert_eq!([0, 1, 1000, 1001, 59_001, 3_600_000].map(seconds), [1, 1, 1, 2, 60, 60]);
    }
}
