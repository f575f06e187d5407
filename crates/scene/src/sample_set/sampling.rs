//! Number of rays per pixel, and the part of a picture to sample.

use std::fmt;
use std::str::FromStr;

use serde::de::{Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::size::PictureSize;

/// Number of rays per pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, PartialOrd, Ord)]
pub enum Sampling {
    /// One ray through the centre, and more in pixels with a silhouette, a terminator, a shadow
    /// edge, a crease or strongly curved shading.
    #[default]
    Adaptive,
    /// The same number of rays in every pixel. [`Sampling::fixed`] and all input make it a power of
    /// two; code may use other numbers. An even number gets one more ray, so that rays are
    /// symmetric about the pixel's centre and include it.
    Fixed(u16),
}

/// Error if text or a number is not a sampling.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("samples must be \"adaptive\" or a number from 1 to 32768")]
pub struct SamplingError;

impl Sampling {
    /// Largest fixed number of rays per pixel.
    pub const FIXED_MAX: u32 = 1 << 15;

    /// Makes a fixed sampling: `samples` rounded up to a power of two.
    ///
    /// The error falls from each power of two to the next. It does not from each number to the
    /// next, because the evenness of the lattice depends on the number (docs/maths/film.md).
    ///
    /// # Errors
    /// Returns [`SamplingError`] if `samples` is not in 1..=[`Sampling::FIXED_MAX`].
    pub fn fixed(samples: u32) -> Result<Self, SamplingError> {
        let known = (1..=Self::FIXED_MAX).contains(&samples).then(|| samples.next_power_of_two());
        let fixed = known.and_then(|samples| u16::try_from(samples).ok()).map(Self::Fixed);
        fixed.ok_or(SamplingError)
    }

    /// Returns the smallest number of rays that a pixel can have.
    #[must_use]
    pub fn min_rays(self) -> u32 {
        match self {
            Self::Adaptive => 1,
            Self::Fixed(samples) => u32::from(samples),
        }
    }
}

/// Fixed sampling from a literal, for tests and benchmarks.
///
/// # Panics
/// If the number is not in 1..=[`Sampling::FIXED_MAX`]. Outside input must use [`Sampling::fixed`].
impl From<u32> for Sampling {
    fn from(samples: u32) -> Self {
        Self::fixed(samples)
            .unwrap_or_else(|_| panic!("samples per pixel must be in 1..=32768, got {samples}"))
    }
}

impl fmt::Display for Sampling {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Adaptive => f.write_str("adaptive"),
            Self::Fixed(samples) => samples.fmt(f),
        }
    }
}

impl FromStr for Sampling {
    type Err = SamplingError;

    fn from_str(text: &str) -> Result<Self, SamplingError> {
        match text {
            "adaptive" => Ok(Self::Adaptive),
            _ => text.parse().map_err(|_| SamplingError).and_then(Self::fixed),
        }
    }
}

impl Serialize for Sampling {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match (serializer.is_human_readable(), self) {
            (true, Self::Adaptive) => serializer.serialize_str("adaptive"),
            (true, Self::Fixed(samples)) => serializer.serialize_u16(*samples),
            (false, Self::Adaptive) => serializer.serialize_u16(0),
            (false, Self::Fixed(samples)) => serializer.serialize_u16(*samples),
        }
    }
}

impl<'de> Deserialize<'de> for Sampling {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        if deserializer.is_human_readable() {
            return deserializer.deserialize_any(SamplingVisitor);
        }
        Ok(match u16::deserialize(deserializer)? {
            0 => Self::Adaptive,
            samples => Self::fixed(samples.into()).map_err(serde::de::Error::custom)?,
        })
    }
}

struct SamplingVisitor;

impl Visitor<'_> for SamplingVisitor {
    type Value = Sampling;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("\"adaptive\" or a number from 1 to 32768")
    }

    fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Sampling, E> {
        text.parse().map_err(|_| E::invalid_value(Unexpected::Other("another word"), &self))
    }

    fn visit_u64<E: serde::de::Error>(self, samples: u64) -> Result<Sampling, E> {
        let fixed = u32::try_from(samples).map_err(|_| SamplingError).and_then(Sampling::fixed);
        fixed.map_err(E::custom)
    }
}

/// Rectangle of pixels of a picture; row 0 is the top.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PixelArea {
    /// First column.
    pub x: u32,
    /// First row.
    pub y: u32,
    /// Number of columns.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
}

/// Pixels of a picture to sample, and their sampling.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Raster {
    /// Size of the whole picture.
    pub size_px: PictureSize,
    /// Number of rays per pixel.
    pub sampling: Sampling,
    /// Part of the picture to sample.
    pub area: PixelArea,
}

/// Error if text is not a pixel area.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("an area must be four whole numbers `x,y,width,height`, with width and height above 0")]
pub struct PixelAreaError;

impl PixelArea {
    /// Returns the area of a whole picture.
    #[must_use]
    pub fn whole(size_px: impl Into<PictureSize>) -> Self {
        let PictureSize { width, height } = size_px.into();
        Self { x: 0, y: 0, width, height }
    }

    /// True if the area is not empty and lies within a picture of that size.
    #[must_use]
    pub fn is_within(&self, size_px: impl Into<PictureSize>) -> bool {
        let size_px = size_px.into();
        let fits = |start: u32, length: u32, side: u32| {
            length > 0 && start.checked_add(length).is_some_and(|end| end <= side)
        };
        fits(self.x, self.width, size_px.width) && fits(self.y, self.height, size_px.height)
    }

    /// Returns the area with a border of one pixel, clipped to the picture.
    #[must_use]
    pub fn with_border(&self, size_px: impl Into<PictureSize>) -> Self {
        let size_px = size_px.into();
        let grow = |start: u32, length: u32, side: u32| {
            let from = start.saturating_sub(1);
            (from, (start + length + 1).min(side) - from)
        };
        let (x, width) = grow(self.x, self.width, size_px.width);
        let (y, height) = grow(self.y, self.height, size_px.height);
        Self { x, y, width, height }
    }

    /// Number of pixels.
    #[must_use]
    pub fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }
}

impl fmt::Display for PixelArea {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{},{},{}", self.x, self.y, self.width, self.height)
    }
}

impl FromStr for PixelArea {
    type Err = PixelAreaError;

    fn from_str(text: &str) -> Result<Self, PixelAreaError> {
        let numbers: Result<Vec<u32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
        match numbers.as_deref() {
            Ok(&[x, y, width, height]) if width > 0 && height > 0 => {
                Ok(Self { x, y, width, height })
            }
            _ => Err(PixelAreaError),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sampling_round_trips_as_word_or_number_in_every_format() {
        for (text, sampling) in [
            ("\"adaptive\"", Some(Sampling::Adaptive)),
            ("4", Some(Sampling::Fixed(4))),
            ("32768", Some(Sampling::Fixed(32768))),
            ("0", None),
            ("32769", None),
            ("65536", None),
            ("-1", None),
            ("1.5", None),
            ("\"many\"", None),
        ] {
            assert_eq!(serde_json::from_str(text).ok(), sampling, "{text}");
            assert_eq!(text.trim_matches('"').parse().ok(), sampling, "{text}");
            let Some(sampling) = sampling else { continue };
            assert_eq!(serde_json::to_string(&sampling).unwrap(), text);
            let bytes = postcard::to_stdvec(&sampling).unwrap();
            assert_eq!(postcard::from_bytes::<Sampling>(&bytes).unwrap(), sampling);
        }
    }

    #[test]
    fn numbers_are_rounded_up_to_a_power_of_two() {
        for (number, power) in
            [(1, 1), (2, 2), (3, 4), (5, 8), (20, 32), (1023, 1024), (1024, 1024)]
        {
            assert_eq!(Sampling::fixed(number), Ok(Sampling::Fixed(power)), "{number}");
            let text = number.to_string();
            assert_eq!(serde_json::from_str::<Sampling>(&text).ok(), Some(Sampling::Fixed(power)));
            assert_eq!(text.parse(), Ok(Sampling::Fixed(power)), "{number}");
        }
    }

    #[test]
    fn area_parses_four_numbers_and_checks_picture_bounds() {
        let area: PixelArea = "3, 0,5,8".parse().unwrap();
        assert_eq!(area.to_string(), "3,0,5,8");
        assert!(area.is_within(8) && !area.is_within(7));
        assert_eq!(area.with_border(8), PixelArea { x: 2, y: 0, width: 6, height: 8 });
        let wide = PictureSize { width: 9, height: 8 };
        let high = PictureSize { width: 8, height: 9 };
        assert!(area.is_within(wide) && area.is_within(high));
        assert!(!area.is_within(PictureSize { width: 7, height: 9 }));
        assert!(!area.is_within(PictureSize { width: 9, height: 7 }));
        assert_eq!(area.with_border(wide), PixelArea { x: 2, y: 0, width: 7, height: 8 });
        assert_eq!(area.with_border(high), PixelArea { x: 2, y: 0, width: 6, height: 9 });
        assert_eq!(PixelArea::whole(wide).to_string(), "0,0,9,8");
        for text in ["", "1,2,3", "1,2,3,4,5", "1,2,0,4", "-1,2,3,4", "1,2,3,x", "1,2,3,4294967296"]
        {
            assert!(text.parse::<PixelArea>().is_err(), "{text}");
        }
        let far = PixelArea { x: u32::MAX, y: 0, width: 2, height: 1 };
        assert!(!far.is_within(2048));
    }
}
