//! Status of the pixels of a picture, and counts by status.

use std::fmt;

use brood_brdf::DirectionPair;
use brood_scene::{ImageLayout, PixelSpan};

/// Number of pixels by status.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct PixelCounts {
    /// All pixels.
    pub pixels: u64,
    /// Pixels used as samples.
    pub used: u64,
    /// Pixels excluded by the mask.
    pub masked: u64,
    /// Pixels without the object.
    pub background: u64,
    /// Pixels at the outline of the object or at an inner edge.
    pub edge: u64,
    /// Pixels at the largest value that the picture can show, and those beside them if noise or
    /// compression has mixed them.
    pub clipped: u64,
    /// Pixels that no light reaches.
    pub unlit: u64,
    /// Pixels at the edge of a shadow.
    pub half_lit: u64,
    /// Pixels lit from several directions: by several lights, a light with an area or an
    /// environment. Models are fitted to them (strategy `analytic`), not other programs.
    pub several_lights: u64,
    /// Pixels with light or eye near the horizon.
    pub grazing: u64,
    /// Pixels that differ from their neighbours by more than noise does: dust, scratches, hot
    /// pixels.
    pub outlier: u64,
}

/// Status of a pixel: used, or why it is not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PixelStatus {
    /// Used as a sample.
    Used,
    /// Excluded by the mask.
    Masked,
    /// Without the object.
    Background,
    /// At the outline of the object or at an inner edge.
    Edge,
    /// At the largest value that the picture can show, or beside such pixels.
    Clipped,
    /// Reached by no light.
    Unlit,
    /// At the edge of a shadow.
    HalfLit,
    /// Lit from several directions; models are fitted to it.
    SeveralLights,
    /// Light or eye near the horizon.
    Grazing,
    /// Different from its neighbours by more than noise, as dust is.
    Outlier,
}

/// Result of reading a covered pixel.
pub(super) enum PixelReading {
    Sample(DirectionPair, [f64; 3]),
    /// A lower bound of f.
    LowerBound(DirectionPair, [f64; 3]),
    /// Lit from several directions, with its status: clipped if only a lower bound of its radiance
    /// is known.
    Several(PixelStatus),
    Unusable(PixelStatus),
}

impl PixelStatus {
    /// True if models are fitted to such pixels.
    #[must_use]
    pub fn is_usable(self) -> bool {
        matches!(self, Self::Used | Self::SeveralLights)
    }
}

/// Samples of each pixel; `None` without any.
pub(super) fn spans(layout: &ImageLayout) -> Vec<Option<PixelSpan>> {
    let mut spans = vec![None; layout.coverage.len()];
    for span in layout.spans() {
        spans[span.pixel as usize] = Some(span);
    }
    spans
}

/// Indices of the pixel and its neighbours up to `reach` rows and columns away, in a picture of
/// that width and height.
pub(super) fn around(
    pixel: usize,
    (width, height): (usize, usize),
    reach: usize,
) -> impl Iterator<Item = usize> {
    let (row, column) = (pixel / width, pixel % width);
    let near = move |at: usize, side: usize| at.saturating_sub(reach)..(at + reach + 1).min(side);
    let columns = near(column, width);
    near(row, height).flat_map(move |row| columns.clone().map(move |column| row * width + column))
}

impl PixelCounts {
    /// Counts pixels by status.
    pub(super) fn of(statuses: &[PixelStatus]) -> Self {
        let mut counts = Self { pixels: statuses.len() as u64, ..Self::default() };
        statuses.iter().for_each(|status| counts.add(*status));
        counts
    }

    /// Number of pixels that models are fitted to.
    #[must_use]
    pub fn usable(&self) -> u64 {
        self.used + self.several_lights
    }

    fn add(&mut self, status: PixelStatus) {
        *match status {
            PixelStatus::Used => &mut self.used,
            PixelStatus::Masked => &mut self.masked,
            PixelStatus::Background => &mut self.background,
            PixelStatus::Edge => &mut self.edge,
            PixelStatus::Clipped => &mut self.clipped,
            PixelStatus::Unlit => &mut self.unlit,
            PixelStatus::HalfLit => &mut self.half_lit,
            PixelStatus::SeveralLights => &mut self.several_lights,
            PixelStatus::Grazing => &mut self.grazing,
            PixelStatus::Outlier => &mut self.outlier,
        } += 1;
    }
}

impl fmt::Display for PixelCounts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "of {} pixels", self.pixels)?;
        let all = [
            (self.masked, "masked"),
            (self.background, "background"),
            (self.edge, "at edges"),
            (self.clipped, "clipped"),
            (self.unlit, "unlit"),
            (self.half_lit, "partly in shadow"),
            (self.several_lights, "lit from several directions"),
            (self.grazing, "at grazing angles"),
            (self.outlier, "outliers"),
        ];
        let mut before = " ";
        for (count, what) in all.into_iter().filter(|(count, _)| *count > 0) {
            write!(f, "{before}{count} are {what}")?;
            before = ", ";
        }
        Ok(())
    }
}

impl PixelCounts {
    /// Sums of two counts.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            pixels: self.pixels + other.pixels,
            used: self.used + other.used,
            masked: self.masked + other.masked,
            background: self.background + other.background,
            edge: self.edge + other.edge,
            clipped: self.clipped + other.clipped,
            unlit: self.unlit + other.unlit,
            half_lit: self.half_lit + other.half_lit,
            several_lights: self.several_lights + other.several_lights,
            grazing: self.grazing + other.grazing,
            outlier: self.outlier + other.outlier,
        }
    }
}
