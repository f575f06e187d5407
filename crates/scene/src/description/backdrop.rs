//! Backdrop of pictures: what the object does not cover.

use brood_light::FieldError;
use brood_light::field::require;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Default blur of environments in degrees.
const BLUR_DEG: f64 = 12.0;
/// Largest blur in degrees.
const BLUR_DEG_MAX: f64 = 90.0;
/// Longest name of an image, in bytes: on the command line, a path.
const IMAGE_BYTES_MAX: usize = 1024;

/// Backdrop behind the object; without one, pictures are transparent there. Linear pictures stay
/// transparent: their radiance is that of the object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(
    tag = "kind",
    rename_all = "kebab-case",
    deny_unknown_fields,
    expecting = "an object with the field `kind`"
)]
pub enum Backdrop {
    /// The environments of the scene, blurred, in the picture's exposure.
    Environment {
        /// Width of the blur, degrees.
        #[serde(default = "blur_deg")]
        #[schema(minimum = 0, maximum = 90, default = blur_deg)]
        blur_deg: f64,
    },
    /// A colour of the display.
    Color {
        /// sRGB, red, green and blue, each within [0, 1].
        color: [f64; 3],
    },
    /// An uploaded image, in the middle and just large enough to cover the picture.
    Image {
        /// Hash of the image.
        image: String,
    },
}

fn blur_deg() -> f64 {
    BLUR_DEG
}

impl Backdrop {
    pub(super) fn validate(&self, has_environment: bool) -> Result<(), FieldError> {
        match self {
            Self::Environment { blur_deg } => {
                let in_range = (0.0..=BLUR_DEG_MAX).contains(blur_deg);
                require(in_range, "/backdrop/blur_deg", "must be between 0 and 90 degrees")?;
                let reason = "\"environment\" needs a light of the kind \"environment\"";
                require(has_environment, "/backdrop/kind", reason)
            }
            Self::Color { color } => {
                let in_range = color.iter().all(|channel| (0.0..=1.0).contains(channel));
                require(in_range, "/backdrop/color", "must be three numbers between 0 and 1")
            }
            Self::Image { image } => check_image(image, "/backdrop"),
        }
    }
}

/// Checks the length of the name of an image in the object at `pointer`.
pub(super) fn check_image(image: &str, pointer: &str) -> Result<(), FieldError> {
    let in_range = (1..=IMAGE_BYTES_MAX).contains(&image.len());
    require(in_range, &format!("{pointer}/image"), "must be the id of an image")
}
