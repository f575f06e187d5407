//! Picture requests: answered from memory, from disk, by a render already in flight, or by a new
//! job.

use std::sync::Arc;
use std::time::Duration;

use brood_program::written_operations;
use brood_protocol::{
    Backend, Frame, JobId, PackedProgram, PictureFormat, PictureKey, RenderItem, RenderJob,
    SceneId, Subject, encode,
};
use brood_scene::{PixelArea, Sampling};
use brood_storage::{NewJob, Queue, StorageError, StoredPicture};
use bytes::Bytes;

use crate::clock::now_ms;
use crate::library::{Framing, Material};
use crate::limit;
use crate::picture::{Failure, Lookup};
use crate::problem::ApiError;
use crate::state::{App, AppState};

/// Requests within this time share a job.
const BATCH_WINDOW: Duration = Duration::from_millis(1);
/// Largest `Retry-After` in seconds.
const RETRY_MOST_S: u64 = 60;
/// Most pictures per job; one brood of the page fits.
const JOB_PICTURES: u64 = 32;
/// Most primary rays per job, unless a single picture has more. Keeps the results of a job, at most
/// 16 bytes per pixel, far below [`limit::LEASE_BYTES`].
const JOB_RAYS: u64 = 4 << 20;

/// Properties shared by all pictures of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct FrameId {
    scene: SceneId,
    light_bits: u64,
    size_px: u32,
    sampling: Sampling,
    area: Option<PixelArea>,
    format: PictureFormat,
    backend: Backend,
}

impl FrameId {
    fn of(row: &StoredPicture) -> Self {
        Self {
            scene: row.scene,
            light_bits: row.light_deg.to_bits(),
            size_px: row.size_px,
            sampling: row.sampling,
            area: row.area,
            format: row.format,
            backend: row.backend,
        }
    }

    /// Returns the number of pictures per job for a frame: at least 1, and few enough to keep jobs
    /// short.
    pub fn pictures_per_job(frame: &Frame) -> usize {
        per_job(frame.rays())
    }

    fn rays(&self) -> u64 {
        let area = self.area.unwrap_or(PixelArea::whole(self.size_px));
        area.pixels() * u64::from(self.sampling.min_rays())
    }

    fn view(&self) -> Framing {
        Framing {
            scene: self.scene,
            light_deg: Some(f64::from_bits(self.light_bits)),
            size_px: self.size_px,
            sampling: self.sampling,
            area: self.area,
            format: self.format,
            backend: self.backend,
        }
    }
}

/// Requested picture.
pub enum PictureRequest {
    /// Picture of a program with a stored row. Those of one frame share a job.
    Stored(Arc<StoredPicture>),
    /// Picture with a job of its own. It needs no row: the URL determines its key.
    Own(RenderJob),
}

impl PictureRequest {
    /// Requests the picture of a subject in a frame, as a job of its own.
    pub fn own(frame: Frame, subject: &Subject<Arc<Material>>) -> Self {
        let hashes = subject.map(|material| material.program.hash());
        let key = PictureKey::of(&hashes, &frame.identity());
        let subject = subject.map(|material| packed(material));
        Self::Own(RenderJob { frame, items: vec![RenderItem { key, subject }] })
    }

    /// Key of the picture.
    pub fn key(&self) -> PictureKey {
        match self {
            Self::Stored(row) => row.key,
            Self::Own(work) => work.items[0].key,
        }
    }
}

impl From<&Arc<StoredPicture>> for PictureRequest {
    fn from(row: &Arc<StoredPicture>) -> Self {
        Self::Stored(row.clone())
    }
}

fn packed(material: &Material) -> PackedProgram {
    PackedProgram {
        words: material.program.to_words(),
        operations_written: written_operations(&material.genome),
    }
}

/// Returns the render job for pictures of one frame.
pub fn render_work<'a>(
    frame: &Frame,
    items: impl Iterator<Item = (PictureKey, &'a Material)>,
) -> RenderJob {
    let items = items
        .map(|(key, material)| RenderItem { key, subject: Subject::Program(packed(material)) });
    RenderJob { frame: frame.clone(), items: items.collect() }
}

/// Returns a queued render job.
pub fn queued_job(queue: Queue, payload: Vec<u8>) -> NewJob {
    NewJob { id: JobId::fresh(), queue, leased_to: None, payload, created_ms: now_ms() }
}

/// Rounds up to whole seconds, at most [`RETRY_MOST_S`].
fn whole_seconds(time: Duration) -> u64 {
    u64::try_from(time.as_millis().div_ceil(1000)).unwrap_or(RETRY_MOST_S).clamp(1, RETRY_MOST_S)
}

/// Returns the number of pictures per job for pictures of `rays` rays each. An adaptive picture
/// counts one ray per pixel.
fn per_job(rays: u64) -> usize {
    (JOB_RAYS / rays.max(1)).clamp(1, JOB_PICTURES) as usize
}

impl AppState {
    /// Returns a picture, rendered if necessary; waits at most [`limit::WAIT`].
    ///
    /// # Errors
    /// 503 if the server is busy, stopping or too slow; 500 if rendering fails.
    pub async fn picture(
        self: &App,
        request: impl Into<PictureRequest>,
    ) -> Result<Bytes, ApiError> {
        let request = request.into();
        let mut waiter = match self.picture_cache.subscribe(request.key()) {
            Lookup::Cached(bytes) => {
                self.metrics.served.increment(1);
                return Ok(bytes);
            }
            Lookup::InFlight(waiter) => waiter,
            Lookup::Leader(waiter) => {
                let app = self.clone();
                // Runs in a separate task, so that the picture completes even if the client
                // disconnects.
                self.tasks.spawn(async move { app.fetch_or_enqueue(request).await });
                waiter
            }
        };
        let outcome = tokio::select! {
            outcome = waiter.wait_for(Option::is_some) => match outcome {
                Ok(outcome) => outcome.clone(),
                Err(_) => None,
            },
            () = tokio::time::sleep(limit::WAIT) => {
                return Err(ApiError::not_yet("retry in a moment"));
            }
            () = self.stopping.cancelled() => {
                return Err(ApiError::stopping("retry after the restart"));
            }
        };
        match outcome {
            Some(Ok(bytes)) => Ok(bytes),
            Some(Err(Failure::Missing(reason))) => Err(ApiError::not_found(reason.as_ref())),
            Some(Err(Failure::Render(reason))) => Err(ApiError::render_failed(reason.as_ref())),
            Some(Err(Failure::Busy)) => Err(ApiError::busy("too many pictures are queued")),
            Some(Err(Failure::Internal)) | None => {
                Err(ApiError::internal("a picture request ended without a result"))
            }
        }
    }

    /// Returns the `Retry-After` of a 503 in seconds: the recent mean duration of jobs or the age
    /// of the oldest queued job, whichever is longer.
    pub async fn retry_after_s(&self) -> u64 {
        let of_late = self.dispatch.history.wait().unwrap_or_default();
        // The age is optional: an error of the store must not hide the 503.
        let oldest = self.store.oldest_queued_ms().await.ok().flatten();
        let waited_ms = oldest.map_or(0, |made_ms| u64::try_from(now_ms() - made_ms).unwrap_or(0));
        whole_seconds(of_late.max(Duration::from_millis(waited_ms)))
    }

    async fn fetch_or_enqueue(self: App, request: PictureRequest) {
        let key = request.key();
        let disk = self.picture_cache.disk().clone();
        if disk.contains(key)
            && let Ok(Some(bytes)) = tokio::task::spawn_blocking(move || disk.read(key)).await
        {
            self.metrics.recalled.increment(1);
            self.picture_ready(key, bytes, false);
            return;
        }
        let row = match request {
            PictureRequest::Stored(row) => row,
            PictureRequest::Own(work) => return self.enqueue(async { Ok(work) }, [key]).await,
        };
        let frame = FrameId::of(&row);
        if self.render_batches.add(frame, row) {
            tokio::time::sleep(BATCH_WINDOW).await;
            let rows = self.render_batches.take(&frame);
            for batch in rows.chunks(per_job(frame.rays())) {
                let work = self.work_of(frame, batch);
                self.enqueue(work, batch.iter().map(|row| row.key)).await;
            }
        }
    }

    /// Returns the render job for stored pictures of one frame.
    async fn work_of(
        &self,
        frame: FrameId,
        rows: &[Arc<StoredPicture>],
    ) -> Result<RenderJob, ApiError> {
        let framed = self.library.frame(frame.view()).await?;
        let mut items = Vec::with_capacity(rows.len());
        for row in rows {
            items.push((row.key, self.library.material(row.genome_hash).await?));
        }
        let items = items.iter().map(|(key, material)| (*key, material.as_ref()));
        Ok(render_work(&framed.frame, items))
    }

    /// Queues a job; if it cannot be queued, fails the pictures with these keys.
    async fn enqueue(
        &self,
        work: impl Future<Output = Result<RenderJob, ApiError>>,
        keys: impl IntoIterator<Item = PictureKey>,
    ) {
        let result = async {
            let job = queued_job(Queue::Interactive, encode(&work.await?));
            self.store.enqueue(job, limit::QUEUED_JOBS).await.map_err(|error| match error {
                StorageError::QueueFull | StorageError::Busy => Failure::Busy,
                other => {
                    tracing::error!(error = %other, "cannot queue a render job");
                    Failure::Internal
                }
            })?;
            Ok(())
        };
        match result.await {
            Ok(()) => self.dispatch.renders.notify.notify_one(),
            Err(failure) => self.picture_cache.fail(keys, &failure),
        }
    }

    /// Completes a picture: answers the waiting requests and publishes its thumbnail.
    pub fn picture_ready(&self, key: PictureKey, bytes: Bytes, fresh: bool) {
        if fresh {
            self.picture_cache.complete(key, bytes);
        } else {
            self.picture_cache.complete_from_disk(key, bytes);
        }
        let listeners = self.picture_cache.take_listeners(key);
        if !listeners.is_empty() {
            let url = crate::presenter::thumbnail_url(key);
            for (lineage, individual) in listeners {
                self.events.thumbnail(lineage, individual, &url);
            }
        }
    }
}

impl From<ApiError> for Failure {
    fn from(error: ApiError) -> Self {
        tracing::error!(?error, "cannot prepare a render job");
        Self::Internal
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jobs_are_cut_by_rays_and_pictures() {
        // A brood of the page with its parent is one job; small pictures do not make jobs
        // unbounded.
        let square =
            |size_px: u32, samples: u32| per_job(u64::from(size_px).pow(2) * u64::from(samples));
        assert_eq!(square(256, 1), 32);
        assert_eq!(square(limit::PICTURE_MIN_PX, 1), 32);
        assert_eq!(square(512, 1), 16);
        assert_eq!(square(1024, 1), 4);
        assert_eq!(square(1024, 4), 1);
        assert_eq!(square(limit::PICTURE_PX, limit::SAMPLES), 1);
    }

    #[test]
    fn retry_after_is_whole_seconds_within_bounds() {
        let seconds = |ms| whole_seconds(Duration::from_millis(ms));
        assert_eq!([0, 1, 1000, 1001, 59_001, 3_600_000].map(seconds), [1, 1, 1, 2, 60, 60]);
    }

    #[test]
    fn results_of_a_job_fit_in_one_message() {
        for size_px in limit::PICTURE_MIN_PX..=limit::PICTURE_PX {
            let pixels = per_job(u64::from(size_px).pow(2)) * size_px as usize * size_px as usize;
            assert!(pixels * 16 <= limit::LEASE_BYTES / 4, "{size_px}");
        }
    }
}
