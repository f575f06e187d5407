//! The way back from samples to the pixels of an image, and the counts of what was skipped.

use std::sync::Arc;

use super::{PixelArea, Sampling};

/// Where the samples of an image belong.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageLayout {
    /// Columns.
    pub width: u32,
    /// Rows; row 0 is the top.
    pub height: u32,
    /// Side of the whole square picture.
    pub size_px: u32,
    /// The part of it that this is.
    pub area: PixelArea,
    /// How it was sampled.
    pub sampling: Sampling,
    /// A pixel's radiance is this times the sum over its samples.
    pub scale: f32,
    /// Pixels that have samples, in ascending order; their samples follow one another without gaps.
    pub runs: Vec<PixelRun>,
    /// Share of each pixel in which the mesh is seen, lit or not.
    pub coverage: Arc<[f32]>,
}

/// Pixels that follow one another and have equally many samples of each kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PixelRun {
    /// The first pixel: row times width plus column.
    pub pixel: u32,
    /// Number of pixels.
    pub pixels: u32,
    /// First sample of the first pixel.
    pub start: u32,
    /// Samples of each pixel.
    pub samples: u32,
    /// How many of them, from the first on, belong to the ray through the pixel's centre: one per light that reaches its
    /// hit, several of lights that have extent. Automatic exposure looks at nothing else; none where that ray misses or meets shadow.
    pub centre: u32,
    /// Which is the first that counts for radiance: 0, or `centre` where the others stand for the whole pixel.
    pub counted: u32,
}

/// The samples of one pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PixelSpan {
    /// Row times width plus column.
    pub pixel: u32,
    /// First sample.
    pub start: u32,
    /// End of the samples of the ray through its centre.
    pub centre_end: u32,
    /// First sample that counts for radiance.
    pub counted: u32,
    /// End of its samples.
    pub end: u32,
}

/// What a set was made of, so that skipping is counted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SampleCounts {
    /// Rays traced.
    pub rays: u64,
    /// Rays that hit the mesh (in sets of pairs: pairs).
    pub covered: u64,
    /// Samples kept: pairs of a hit and a sample of a light that reaches it, groups of similar ones counted once.
    pub lit: u64,
    /// Samples of lights that were never made, because nothing arrives: the light is behind the surface, the surface is out
    /// of its cone, or it has no power.
    pub skipped: u64,
    /// Samples of lights that were not made because something is in the way.
    pub shadowed: u64,
}

impl SampleCounts {
    pub(super) fn add_unlit(&mut self, (skipped, shadowed): (u64, u64)) {
        self.skipped += skipped;
        self.shadowed += shadowed;
    }
}

impl ImageLayout {
    /// The pixels that have samples, one by one.
    pub fn spans(&self) -> impl Iterator<Item = PixelSpan> + '_ {
        self.runs.iter().flat_map(|run| run.spans())
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.runs.as_slice()) + size_of_val(&*self.coverage)
    }
}

impl PixelRun {
    /// Its pixels, one by one.
    pub fn spans(self) -> impl Iterator<Item = PixelSpan> {
        (0..self.pixels).map(move |k| {
            let start = self.start + k * self.samples;
            PixelSpan {
                pixel: self.pixel + k,
                start,
                centre_end: start + self.centre,
                counted: start + self.counted,
                end: start + self.samples,
            }
        })
    }

    /// End of its samples.
    pub(super) fn end(&self) -> u32 {
        self.start + self.pixels * self.samples
    }

    /// Takes the next pixel in, if it is the neighbour and alike.
    pub(super) fn extend(&mut self, next: &Self) -> bool {
        let alike =
            (self.samples, self.centre, self.counted) == (next.samples, next.centre, next.counted);
        let joins = alike && self.pixel + self.pixels == next.pixel;
        if joins {
            self.pixels += next.pixels;
        }
        joins
    }
}
