//! Requested pictures, and the render jobs for them.

use std::sync::Arc;

use brood_program::written_operations;
use brood_protocol::{
    Backend, Frame, PackedProgram, PictureFormat, PictureKey, Queue, RenderItem, RenderJob,
    SceneId, Subject,
};
use brood_scene::{PictureSize, PixelArea, Sampling};
use brood_storage::StoredPicture;

use crate::library::{Framing, Material};

/// Most pictures per job; one brood of the page fits.
const JOB_PICTURES: u64 = 32;
/// Most primary rays per job, unless a single picture has more. Keeps jobs short, and the results
/// of a job, at most 16 bytes per pixel, far below [`LEASE_BYTES`](crate::limit::LEASE_BYTES).
const JOB_RAYS: u64 = 2 << 20;

/// Properties shared by all pictures of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct FrameId {
    scene: SceneId,
    light_bits: u64,
    size_px: PictureSize,
    sampling: Sampling,
    area: Option<PixelArea>,
    format: PictureFormat,
    backend: Backend,
}

impl FrameId {
    /// Returns the frame of a stored picture.
    pub fn of(row: &StoredPicture) -> Self {
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

    /// Returns the number of pictures per job: at least 1, and few enough to keep jobs short.
    pub fn per_job(&self) -> usize {
        let area = self.area.unwrap_or(PixelArea::whole(self.size_px));
        per_job(area.pixels() * u64::from(self.sampling.min_rays()))
    }

    /// Returns the framing.
    pub fn view(&self) -> Framing {
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
        Self::Own(RenderJob::new(frame, vec![RenderItem { key, subject }]))
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
    RenderJob::new(frame.clone(), items.collect())
}

/// Returns the queue for pictures that are requested together and trace this many rays: batch if
/// they take longer than an interactive job.
pub fn queue_for(rays: u64) -> Queue {
    if rays > JOB_RAYS { Queue::Batch } else { Queue::Interactive }
}

/// Returns the number of pictures per job for pictures of `rays` rays each. An adaptive picture
/// counts one ray per pixel.
fn per_job(rays: u64) -> usize {
    (JOB_RAYS / rays.max(1)).clamp(1, JOB_PICTURES) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limit;

    #[test]
    fn jobs_are_cut_by_rays_and_pictures() {
        // A brood of the page with its parent is one job; small pictures do not make jobs
        // unbounded.
        let square =
            |size_px: u32, samples: u32| per_job(u64::from(size_px).pow(2) * u64::from(samples));
        assert_eq!(square(256, 1), 32);
        assert_eq!(square(limit::PICTURE_MIN_PX, 1), 32);
        assert_eq!(square(512, 1), 8);
        assert_eq!(square(1024, 1), 2);
        assert_eq!(square(1024, 4), 1);
        assert_eq!(square(limit::PICTURE_PX, limit::SAMPLES), 1);
    }

    #[test]
    fn results_of_a_job_fit_in_one_message() {
        for size_px in limit::PICTURE_MIN_PX..=limit::PICTURE_PX {
            let pixels = per_job(u64::from(size_px).pow(2)) * size_px as usize * size_px as usize;
            assert!(pixels * 16 <= limit::LEASE_BYTES / 4, "{size_px}");
        }
    }
}
