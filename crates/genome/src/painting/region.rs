//! Regions of a picture with their colours.

use serde::{Deserialize, Serialize};

/// Largest number of regions of a painting palette.
pub const REGIONS_MAX: usize = 6;

/// A region of a picture: places of similar hue and saturation, also if they are apart.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct PaintingRegion {
    /// Mean colour of the darkest tenth of the region, as `#2b1e46`.
    #[cfg_attr(feature = "schema", schema(value_type = String))]
    #[serde(with = "color_text")]
    pub dark: [u8; 3],
    /// Mean colour of the tenth of middle lightness.
    #[cfg_attr(feature = "schema", schema(value_type = String))]
    #[serde(with = "color_text")]
    pub middle: [u8; 3],
    /// Mean colour of the brightest tenth.
    #[cfg_attr(feature = "schema", schema(value_type = String))]
    #[serde(with = "color_text")]
    pub bright: [u8; 3],
    /// Share of the area of the picture, above 0 and at most 1.
    pub share: f64,
}

impl PaintingRegion {
    /// The dark, the middle and the bright colour, as 8-bit codes of a display.
    #[must_use]
    pub fn colors(&self) -> [[u8; 3]; 3] {
        [self.dark, self.middle, self.bright]
    }
}

/// Colours in JSON: `"#2b1e46"`.
mod color_text {
    use brood_brdf::display_codes;
    use serde::{Deserialize, Deserializer, Serializer, de};

    use crate::effect::hex;

    pub(super) fn serialize<S: Serializer>(
        color: &[u8; 3],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&hex(color))
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<[u8; 3], D::Error> {
        let text = String::deserialize(deserializer)?;
        display_codes(&text).ok_or_else(|| {
            de::Error::custom(format!("a colour must be like #2b1e46, got {text:?}"))
        })
    }
}
