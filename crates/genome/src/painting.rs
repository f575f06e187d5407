//! Painting palettes: the colours of a picture by regions, for painted children.
//!
//! A palette is read from the pixels of a picture ([`PaintingPalette::of_picture`]) or from JSON,
//! so that a brood can be repeated without the picture. The module does not decode files.

mod cells;
mod partition;
mod region;

use serde::{Deserialize, Serialize};

use crate::effect::hex;
use crate::oklab::Oklab;
pub use region::{PaintingRegion, REGIONS_MAX};

/// Colours of a picture: a list of regions.
///
/// # Invariants
/// There are 1 to 6 regions, each with a share above 0 and at most 1. The middle colour of a region
/// is at least as light as its dark one, and the bright colour as the middle one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(try_from = "Unchecked")]
pub struct PaintingPalette {
    /// 1 to 6 regions; the largest first if they were read from a picture.
    regions: Vec<PaintingRegion>,
}

/// JSON form, before it is checked.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Unchecked {
    regions: Vec<PaintingRegion>,
}

/// Error of a painting palette.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PaintingError {
    /// No pixel has a colour.
    #[error("the picture has no pixels that are not transparent")]
    Transparent,
    /// Too few or too many regions.
    #[error("a painting palette must have 1 to {REGIONS_MAX} regions, got {0}")]
    Regions(usize),
    /// A share is not within (0, 1].
    #[error("`share` of region {0} must be above 0 and at most 1, got {1}")]
    Share(usize, f64),
    /// The colours of a region are in another order.
    #[error("`dark`, `middle` and `bright` of region {0} must ascend in lightness, got {1}")]
    Order(usize, String),
}

impl PaintingPalette {
    /// Creates a palette.
    ///
    /// # Errors
    /// Returns [`PaintingError`] for the first region that breaks the invariants.
    pub fn new(regions: Vec<PaintingRegion>) -> Result<Self, PaintingError> {
        if !(1..=REGIONS_MAX).contains(&regions.len()) {
            return Err(PaintingError::Regions(regions.len()));
        }
        for (at, region) in regions.iter().enumerate() {
            if !(region.share > 0.0 && region.share <= 1.0) {
                return Err(PaintingError::Share(at, region.share));
            }
            let lightness = region.colors().map(|codes| Oklab::of_codes(codes).lightness);
            if !lightness.is_sorted() {
                return Err(PaintingError::Order(
                    at,
                    region.colors().map(|one| hex(&one)).join(" "),
                ));
            }
        }
        Ok(Self { regions })
    }

    /// Reads the palette of a picture. The same pixels give the same palette on every machine, and
    /// a picture and its enlargement nearly the same one: pictures of more than 256 pixels a side
    /// are averaged to that size first.
    ///
    /// # Shapes
    /// `rgba`: red, green, blue and alpha of each pixel, row by row, 4 `width` `height` values.
    ///
    /// # Units
    /// 8-bit sRGB codes of a display; alpha is straight, 255 is opaque.
    ///
    /// # Domain
    /// Pixels count by their alpha; transparent ones are ignored. Pictures with few colours have
    /// fewer regions, a grey one or one of one colour has one.
    ///
    /// # Errors
    /// Returns [`PaintingError::Transparent`] if the picture has no pixels, or none with a colour.
    ///
    /// # Panics
    /// If `rgba` has another length.
    ///
    /// # Source
    /// The darkest and brightest colours of regions: the thesis of docs/maths/painted.md, section
    /// 5.2. Regions: docs/maths/painted.md.
    pub fn of_picture(width: u32, height: u32, rgba: &[u8]) -> Result<Self, PaintingError> {
        let cells = cells::of(width, height, rgba);
        if cells.is_empty() {
            return Err(PaintingError::Transparent);
        }
        Self::new(partition::regions(&cells))
    }

    /// Regions of the palette.
    #[must_use]
    pub fn regions(&self) -> &[PaintingRegion] {
        &self.regions
    }
}

impl TryFrom<Unchecked> for PaintingPalette {
    type Error = PaintingError;

    fn try_from(unchecked: Unchecked) -> Result<Self, PaintingError> {
        Self::new(unchecked.regions)
    }
}

#[cfg(test)]
mod tests;
