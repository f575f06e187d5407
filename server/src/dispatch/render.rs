//! The road of those who want a picture: memory, disk, a flight that is under way already, or a new job.

use std::sync::Arc;
use std::time::Duration;

use brood_program::written_operations;
use brood_protocol::{
    Backend, Frame, JobId, PictureFormat, PictureKey, RenderItem, RenderJob, SceneId, encode,
};
use brood_scene::{PixelArea, Sampling};
use brood_storage::{JobKind, NewJob, PictureRow, Queue, StorageError};
use bytes::Bytes;

use crate::library::{Material, View};
use crate::limit;
use crate::picture::{Boarding, Failure};
use crate::problem::ApiError;
use crate::state::{App, AppState, now_ms};

/// Pictures that come within this time are one job.
const MOMENT: Duration = Duration::from_millis(1);
const RETRY_MOST_S: u64 = 60;
/// Most pictures of one job: a page's brood is one job.
const JOB_PICTURES: u64 = 32;
/// Most primary rays of one job, unless one picture has more. It also keeps a job's results, at most 16 bytes a pixel,
/// far below [`limit::LEASE_BYTES`].
const JOB_RAYS: u64 = 4 << 20;

/// What the pictures of one job have in common.
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
    fn of(row: &PictureRow) -> Self {
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

    /// How many pictures that have a frame in common are one job: at least 1, and few enough that no job keeps a worker
    /// for long.
    pub fn pictures_per_job(frame: &Frame) -> usize {
        per_job(frame.rays())
    }

    fn rays(&self) -> u64 {
        let area = self.area.unwrap_or(PixelArea::whole(self.size_px));
        area.pixels() * u64::from(self.sampling.least())
    }

    fn view(&self) -> View {
        View {
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

/// What a worker is to do for pictures of one frame.
pub fn render_work<'a>(
    frame: &Frame,
    items: impl Iterator<Item = (PictureKey, &'a Material)>,
) -> RenderJob {
    let items = items.map(|(key, material)| RenderItem {
        key,
        words: material.program.to_words(),
        operations_written: written_operations(&material.genome),
    });
    RenderJob { frame: frame.clone(), items: items.collect() }
}

/// A render job that waits for a worker.
pub fn queued_job(queue: Queue, payload: Vec<u8>) -> NewJob {
    NewJob {
        id: JobId::fresh(),
        kind: JobKind::Render,
        queue,
        leased_to: None,
        payload,
        created_ms: now_ms(),
    }
}

/// Rounded up, and bounded: a client that hears of an hour would never come back.
fn whole_seconds(time: Duration) -> u64 {
    u64::try_from(time.as_millis().div_ceil(1000)).unwrap_or(RETRY_MOST_S).clamp(1, RETRY_MOST_S)
}

/// Pictures of so many rays each. Adaptive ones count as one ray a pixel: what edges take is taken once for all of them.
fn per_job(rays: u64) -> usize {
    (JOB_RAYS / rays.max(1)).clamp(1, JOB_PICTURES) as usize
}

impl AppState {
    /// The picture, rendered if need be; waits for it a bounded time.
    pub async fn picture(self: &App, row: &Arc<PictureRow>) -> Result<Bytes, ApiError> {
        let mut waiter = match self.gallery.board(row.key) {
            Boarding::Here(bytes) => {
                self.metrics.served.increment(1);
                return Ok(bytes);
            }
            Boarding::Wait(waiter) => waiter,
            Boarding::Lead(waiter) => {
                let (app, row) = (self.clone(), row.clone());
                // The flight is owned by a task, so that it lands even if this request is given up.
                self.tasks.spawn(async move { app.lead(row).await });
                waiter
            }
        };
        let landing = tokio::select! {
            landing = waiter.wait_for(Option::is_some) => match landing {
                Ok(landing) => landing.clone(),
                Err(_) => None,
            },
            () = tokio::time::sleep(limit::WAIT) => {
                return Err(ApiError::not_yet("ask again in a moment"));
            }
            () = self.stopping.cancelled() => {
                return Err(ApiError::stopping("come back when it runs again"));
            }
        };
        match landing {
            Some(Ok(bytes)) => Ok(bytes),
            Some(Err(Failure::Render(reason))) => Err(ApiError::render_failed(reason.as_ref())),
            Some(Err(Failure::Busy)) => Err(ApiError::busy("too many pictures are waiting")),
            Some(Err(Failure::Internal)) | None => {
                Err(ApiError::internal("a picture's flight ended without a landing"))
            }
        }
    }

    /// When to ask again after a 503: as long as jobs take at present, or as long as the oldest one has waited already,
    /// whichever is longer.
    pub async fn retry_after_s(&self) -> u64 {
        let of_late = self.dispatch.history.wait().unwrap_or_default();
        // Where even this cannot be read, the answer need not wait for it.
        let oldest = self.store.oldest_queued_ms().await.ok().flatten();
        let waited_ms = oldest.map_or(0, |made_ms| u64::try_from(now_ms() - made_ms).unwrap_or(0));
        whole_seconds(of_late.max(Duration::from_millis(waited_ms)))
    }

    async fn lead(self: App, row: Arc<PictureRow>) {
        let key = row.key;
        let disk = self.gallery.disk().clone();
        if disk.contains(key)
            && let Ok(Some(bytes)) = tokio::task::spawn_blocking(move || disk.read(key)).await
        {
            self.metrics.recalled.increment(1);
            self.landed(key, bytes, false);
            return;
        }
        let frame = FrameId::of(&row);
        if self.wanted.add(frame, row) {
            tokio::time::sleep(MOMENT).await;
            let rows = self.wanted.take(&frame);
            for batch in rows.chunks(per_job(frame.rays())) {
                self.enqueue(frame, batch).await;
            }
        }
    }

    async fn enqueue(&self, frame: FrameId, rows: &[Arc<PictureRow>]) {
        let result = async {
            let framed = self.library.frame(frame.view()).await?;
            let mut items = Vec::with_capacity(rows.len());
            for row in rows {
                items.push((row.key, self.library.material(row.genome_hash).await?));
            }
            let items = items.iter().map(|(key, material)| (*key, material.as_ref()));
            let work = render_work(&framed.frame, items);
            let job = queued_job(Queue::Interactive, encode(&work));
            self.store.enqueue(job, limit::QUEUED_JOBS).await.map_err(|error| match error {
                StorageError::QueueFull | StorageError::Busy => Failure::Busy,
                other => {
                    tracing::error!(error = %other, "a render job could not be queued");
                    Failure::Internal
                }
            })?;
            Ok(())
        };
        match result.await {
            Ok(()) => self.dispatch.bell.notify_one(),
            Err(failure) => self.gallery.crash(rows.iter().map(|row| row.key), &failure),
        }
    }

    /// A picture is there: those who wait get it, those who wanted to hear of it are told.
    pub fn landed(&self, key: PictureKey, bytes: Bytes, fresh: bool) {
        if fresh {
            self.gallery.land(key, bytes);
        } else {
            self.gallery.recall(key, bytes);
        }
        let interests = self.gallery.take_interests(key);
        if !interests.is_empty() {
            let url = crate::presenter::thumbnail_url(key);
            for (lineage, individual) in interests {
                self.events.thumbnail(lineage, individual, &url);
            }
        }
    }
}

impl From<ApiError> for Failure {
    fn from(error: ApiError) -> Self {
        tracing::error!(?error, "a render job could not be made");
        Self::Internal
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jobs_are_cut_by_rays_and_pictures() {
        // A page's brood with its parent is one job; the smallest pictures do not make endless ones.
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
    fn clients_come_back_after_whole_seconds_within_bounds() {
        let seconds = |ms| whole_seconds(Duration::from_millis(ms));
        assert_eq!([0, 1, 1000, 1001, 59_001, 3_600_000].map(seconds), [1, 1, 1, 2, 60, 60]);
    }

    #[test]
    fn results_of_a_job_fit_in_a_hand_over() {
        for size_px in limit::PICTURE_MIN_PX..=limit::PICTURE_PX {
            let pixels = per_job(u64::from(size_px).pow(2)) * size_px as usize * size_px as usize;
            assert!(pixels * 16 <= limit::LEASE_BYTES / 4, "{size_px}");
        }
    }
}
