//! Mapping from samples to the pixels of an image, and counts of rays and samples.

use std::sync::Arc;

use super::sampling::{PixelArea, Sampling};
use super::size::PictureSize;

/// Mapping from the samples of a set to the pixels of its image.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageLayout {
    /// Number of columns.
    pub width: u32,
    /// Number of rows; row 0 is the top.
    pub height: u32,
    /// Size of the whole picture.
    pub size_px: PictureSize,
    /// Part of the whole picture that this image is.
    pub area: PixelArea,
    /// Sampling of the image.
    pub sampling: Sampling,
    /// Factor from the sum over a pixel's samples to its radiance.
    pub scale: f32,
    /// Pixels that have samples, in ascending order. Their samples are contiguous.
    pub runs: Vec<PixelRun>,
    /// Fraction of each pixel that the mesh covers, lit or not.
    pub coverage: Arc<[f32]>,
}

/// Consecutive pixels with equal sample counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PixelRun {
    /// Index of the first pixel: row times width plus column.
    pub pixel: u32,
    /// Number of pixels.
    pub pixels: u32,
    /// Index of the first sample of the first pixel.
    pub start: u32,
    /// Number of samples per pixel.
    pub samples: u32,
    /// Number of leading samples that belong to the ray through the pixel's centre: one per light
    /// that reaches its hit, several per extended light. 0 if that ray misses or hits an unlit
    /// point. Automatic exposure reads only these samples.
    pub centre: u32,
    /// Offset of the first sample that is summed for radiance: 0, or `centre` if the samples after
    /// the centre's represent the whole pixel.
    pub radiance_start: u32,
}

/// Samples of one pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PixelSpan {
    /// Index of the pixel: row times width plus column.
    pub pixel: u32,
    /// Index of the first sample.
    pub start: u32,
    /// End of the samples of the ray through the pixel's centre.
    pub centre_end: u32,
    /// Index of the first sample that is summed for radiance.
    pub radiance_start: u32,
    /// End of the pixel's samples.
    pub end: u32,
}

/// Counts of the rays and samples from which a set was made.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SampleCounts {
    /// Number of rays traced.
    pub rays: u64,
    /// Number of rays that hit the mesh; in sets of pairs, the number of pairs.
    pub covered: u64,
    /// Number of samples stored: combinations of a hit and a light sample that reaches it. A group
    /// of similar combinations is one sample.
    pub lit: u64,
    /// Number of light samples not stored because no light arrives: the light is behind the
    /// surface, the surface is outside the light's cone, or the light has no power.
    pub skipped: u64,
    /// Number of light samples not stored because they are occluded.
    pub shadowed: u64,
}

impl SampleCounts {
    pub(super) fn add_unlit(&mut self, (skipped, shadowed): (u64, u64)) {
        self.skipped += skipped;
        self.shadowed += shadowed;
    }
}

impl ImageLayout {
    /// Iterates over the pixels that have samples.
    pub fn spans(&self) -> impl Iterator<Item = PixelSpan> + '_ {
        self.runs.iter().flat_map(|run| run.spans())
    }

    /// Returns true for each pixel that only the ray through its centre sampled.
    #[must_use]
    pub fn lone_rays(&self) -> Vec<bool> {
        let mut lone = vec![false; self.coverage.len()];
        for run in self.runs.iter().filter(|run| run.centre > 0 && run.samples == run.centre) {
            lone[run.pixel as usize..][..run.pixels as usize].fill(true);
        }
        lone
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.runs.as_slice()) + size_of_val(&*self.coverage)
    }
}

impl PixelRun {
    /// Iterates over the pixels of the run.
    pub fn spans(self) -> impl Iterator<Item = PixelSpan> {
        (0..self.pixels).map(move |k| {
            let start = self.start + k * self.samples;
            PixelSpan {
                pixel: self.pixel + k,
                start,
                centre_end: start + self.centre,
                radiance_start: start + self.radiance_start,
                end: start + self.samples,
            }
        })
    }

    /// End of the run's samples.
    pub(super) fn end(&self) -> u32 {
        self.start + self.pixels * self.samples
    }

    /// Appends `next` and returns true if it is the following pixel with equal sample counts.
    pub(super) fn extend(&mut self, next: &Self) -> bool {
        let same_counts = (self.samples, self.centre, self.radiance_start)
            == (next.samples, next.centre, next.radiance_start);
        let joins = same_counts && self.pixel + self.pixels == next.pixel;
        if joins {
            self.pixels += next.pixels;
        }
        joins
    }
}
