//! Control images of effects: images by texture position in place of colours and numbers.

use brood_brdf::Input;

use super::EffectKind;
use crate::ImageHash;

/// Largest number of different images of a genome.
pub const IMAGES_MAX: usize = Input::IMAGES.len();

/// A place of an effect that an image can take, by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImagePlace {
    /// Name in text and JSON.
    pub name: &'static str,
    /// Short description of what the image does there.
    pub about: &'static str,
}

/// An image in a place of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectImage {
    /// Name of the place.
    pub place: &'static str,
    /// The image.
    pub image: ImageHash,
    /// Share of the image, in [0, 1]; the rest is what the place is without it.
    pub share: f64,
}

/// Place of the darkest colour of a palette.
const DARK: &str = "dark";
/// Place of the brightest colour of a palette.
const BRIGHT: &str = "bright";
/// Place of the colour of an overlay.
const IMAGE: &str = "image";
/// Place of the brightness that changes a number.
pub(crate) const MAP: &str = "map";

const PALETTE_PLACES: [ImagePlace; 2] = [
    ImagePlace { name: DARK, about: "in place of the darkest colour" },
    ImagePlace { name: BRIGHT, about: "in place of the brightest colour" },
];
const SCALE: ImagePlace = ImagePlace { name: MAP, about: "its brightness scales the effect" };

const LIGHT: &[ImagePlace] = &[
    PALETTE_PLACES[0],
    PALETTE_PLACES[1],
    ImagePlace { name: MAP, about: "its brightness shifts the amount of light, by brush" },
];
const OVERLAY: &[ImagePlace] = &[
    ImagePlace {
        name: IMAGE,
        about: "in place of the colour; its transparent parts show what is below",
    },
    SCALE,
];
const GLASS: &[ImagePlace] = &[SCALE];

impl EffectKind {
    /// Places that images can take, in the order of canonical bytes. New ones are only appended.
    #[must_use]
    pub fn image_places(self) -> &'static [ImagePlace] {
        match self {
            Self::Light => LIGHT,
            Self::Silhouette | Self::Highlight | Self::Distance => OVERLAY,
            Self::Glass => GLASS,
        }
    }

    /// Returns a place by its name.
    pub(crate) fn image_place(self, name: &str) -> Option<&'static str> {
        self.image_places().iter().find(|place| place.name == name).map(|place| place.name)
    }
}

/// True if a place belongs to the palette of a light effect.
pub(crate) fn is_of_palette(place: &str) -> bool {
    PALETTE_PLACES.iter().any(|own| own.name == place)
}
