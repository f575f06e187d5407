//! The way back from samples to the pixels of an image, and the counts of what was skipped.

/// Where the samples of an image belong.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ImageLayout {
    /// Columns.
    pub width: u32,
    /// Rows; row 0 is the top.
    pub height: u32,
    /// Subsamples of a pixel, covered or not.
    pub samples_per_pixel: u32,
    /// Pixels that have samples, in ascending order; their samples follow one another without gaps.
    pub spans: Vec<PixelSpan>,
    /// Per pixel: subsamples in which the mesh is seen, lit or not.
    pub covered: Vec<u16>,
}

/// The samples of one pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PixelSpan {
    /// Row times width plus column.
    pub pixel: u32,
    /// First sample.
    pub start: u32,
    /// End of the samples of its first lit subsample, which has one per light that reaches it.
    pub first_end: u32,
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
    /// Samples kept: pairs of a hit and a light that is in front of its surface.
    pub lit: u64,
}

impl ImageLayout {
    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.spans.as_slice()) + size_of_val(self.covered.as_slice())
    }
}
