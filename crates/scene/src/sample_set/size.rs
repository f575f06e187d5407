//! Size of a whole picture in pixels.

use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

use serde::de::{Error, SeqAccess, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, OneOfBuilder, Type};
use utoipa::openapi::{RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};

/// Size of a whole picture in pixels, both sides at least 1. Pixels are square.
///
/// A square size is written as one number, another one as `[width, height]` in JSON and as
/// `WIDTHxHEIGHT` in text.
///
/// ```
/// use brood_scene::PictureSize;
///
/// let wide: PictureSize = "640x360".parse().unwrap();
/// assert_eq!(wide, PictureSize { width: 640, height: 360 });
/// assert_eq!(PictureSize::from(256).to_string(), "256");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PictureSize {
    /// Number of columns.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
}

/// Error if text or numbers are not a size.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a size is a side in pixels such as 512, or width and height such as 640x360, from 1")]
pub struct PictureSizeError;

impl PictureSize {
    /// Makes a size.
    ///
    /// # Errors
    /// Returns [`PictureSizeError`] if a side is 0.
    pub fn new(width: u32, height: u32) -> Result<Self, PictureSizeError> {
        if width == 0 || height == 0 {
            return Err(PictureSizeError);
        }
        Ok(Self { width, height })
    }

    /// Number of pixels.
    #[must_use]
    pub fn pixels(self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Returns the longer side.
    #[must_use]
    pub fn longer(self) -> u32 {
        self.width.max(self.height)
    }

    /// Checks that a picture of this size has these pixels: columns and rows.
    ///
    /// # Panics
    /// If it lacks one of them.
    pub(crate) fn assert_holds(self, pixels: &[(u32, u32)]) {
        assert!(
            pixels.iter().all(|(x, y)| *x < self.width && *y < self.height),
            "pixels must be within {} x {}",
            self.width,
            self.height
        );
    }

    /// Returns the shorter side.
    #[must_use]
    pub fn shorter(self) -> u32 {
        self.width.min(self.height)
    }

    /// Width divided by height.
    #[must_use]
    pub fn aspect(self) -> f64 {
        f64::from(self.width) / f64::from(self.height)
    }

    fn is_square(self) -> bool {
        self.width == self.height
    }
}

/// Size of a square picture.
impl From<u32> for PictureSize {
    fn from(side: u32) -> Self {
        Self { width: side, height: side }
    }
}

impl fmt::Display for PictureSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_square() {
            return self.width.fmt(f);
        }
        write!(f, "{}x{}", self.width, self.height)
    }
}

impl FromStr for PictureSize {
    type Err = PictureSizeError;

    fn from_str(text: &str) -> Result<Self, PictureSizeError> {
        let side = |text: &str| text.parse().map_err(|_| PictureSizeError);
        let (width, height) = text.split_once('x').unwrap_or((text, text));
        Self::new(side(width)?, side(height)?)
    }
}

/// Outside text formats a size is one number: the side of a square picture, or the width plus the
/// height times 2^32. Variable-length encodings of the first are those of the side alone, so hashes
/// and stored bytes of square pictures do not depend on the height.
impl Serialize for PictureSize {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match (serializer.is_human_readable(), self.is_square()) {
            (true, true) => serializer.serialize_u32(self.width),
            (true, false) => [self.width, self.height].serialize(serializer),
            (false, true) => serializer.serialize_u64(self.width.into()),
            (false, false) => {
                serializer.serialize_u64(u64::from(self.width) | u64::from(self.height) << 32)
            }
        }
    }
}

impl<'de> Deserialize<'de> for PictureSize {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        if deserializer.is_human_readable() {
            return deserializer.deserialize_any(SizeVisitor);
        }
        let number = u64::deserialize(deserializer)?;
        let (width, height) = (number as u32, (number >> 32) as u32);
        let height = if height == 0 { width } else { height };
        Self::new(width, height).map_err(D::Error::custom)
    }
}

struct SizeVisitor;

impl<'de> Visitor<'de> for SizeVisitor {
    type Value = PictureSize;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a side in pixels from 1, or [width, height]")
    }

    fn visit_u64<E: Error>(self, side: u64) -> Result<PictureSize, E> {
        let known = u32::try_from(side).ok().and_then(|side| PictureSize::new(side, side).ok());
        known.ok_or_else(|| E::invalid_value(Unexpected::Unsigned(side), &self))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut sides: A) -> Result<PictureSize, A::Error> {
        let too_short = |count| A::Error::invalid_length(count, &self);
        let width = sides.next_element()?.ok_or_else(|| too_short(0))?;
        let height = sides.next_element()?.ok_or_else(|| too_short(1))?;
        if sides.next_element::<u32>()?.is_some() {
            return Err(A::Error::invalid_length(3, &self));
        }
        PictureSize::new(width, height).map_err(A::Error::custom)
    }
}

impl PartialSchema for PictureSize {
    fn schema() -> RefOr<Schema> {
        let side = || ObjectBuilder::new().schema_type(Type::Integer).minimum(Some(1));
        let pair = ArrayBuilder::new().items(side()).min_items(Some(2)).max_items(Some(2));
        let items = OneOfBuilder::new()
            .description(Some(
                "Size of a picture in pixels: the side of a square one, or width and height.",
            ))
            .item(side())
            .item(pair);
        RefOr::T(Schema::OneOf(items.build()))
    }
}

impl ToSchema for PictureSize {
    fn name() -> Cow<'static, str> {
        Cow::Borrowed("PictureSize")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn size_round_trips_as_number_pair_and_text() {
        for (text, json, (width, height)) in
            [("256", "256", (256, 256)), ("640x360", "[640,360]", (640, 360)), ("1", "1", (1, 1))]
        {
            let size = PictureSize { width, height };
            assert_eq!(text.parse(), Ok(size));
            assert_eq!(size.to_string(), text);
            assert_eq!(serde_json::to_string(&size).unwrap(), json);
            assert_eq!(serde_json::from_str::<PictureSize>(json).unwrap(), size);
            let bytes = postcard::to_stdvec(&size).unwrap();
            assert_eq!(postcard::from_bytes::<PictureSize>(&bytes).unwrap(), size);
        }
        assert_eq!("64x64".parse(), Ok(PictureSize::from(64)));
        assert_eq!(serde_json::from_str::<PictureSize>("[64, 64]").unwrap(), 64.into());
    }

    #[test]
    fn square_sizes_are_encoded_as_their_side_alone() {
        for side in [1u32, 64, 127, 128, 300, 2048, 65_535, u32::MAX] {
            let alone = postcard::to_stdvec(&side).unwrap();
            assert_eq!(postcard::to_stdvec(&PictureSize::from(side)).unwrap(), alone, "{side}");
        }
        let other = |width, height| postcard::to_stdvec(&PictureSize { width, height }).unwrap();
        assert_ne!(other(64, 32), other(32, 64));
    }

    #[test]
    fn text_and_json_that_are_no_size_are_refused() {
        for text in ["", "0", "0x4", "4x0", "x4", "4x", "4x4x4", "-1", "1.5", "4294967296", "4X4"] {
            assert_eq!(text.parse::<PictureSize>(), Err(PictureSizeError), "{text}");
        }
        for json in ["0", "-1", "[1]", "[]", "[1,2,3]", "[0,1]", "1.5", "\"4x4\"", "4294967296"] {
            assert!(serde_json::from_str::<PictureSize>(json).is_err(), "{json}");
        }
        assert!(postcard::from_bytes::<PictureSize>(&[0]).is_err());
    }
}
