//! Normal map of an object.

use brood_light::FieldError;
use brood_light::field::require;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::backdrop::check_image;

/// Largest strength, either way.
const STRENGTH_MAX: f64 = 4.0;
/// Largest number of repetitions.
const REPEAT_MAX: f64 = 1000.0;

/// Normal map: an image whose colours turn the shading normals of an object. Red points along
/// growing u, green along growing v, and blue out of the surface; code 127.5 is 0.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub struct NormalMap {
    /// Hash of an uploaded image.
    pub image: String,
    /// Factor of the slopes, within [-4, 4]; a negative one turns bumps into dents.
    #[serde(default = "one")]
    #[schema(minimum = -4, maximum = 4, default = one)]
    pub strength: f64,
    /// Number of times that the image repeats along u and v, above 0 and at most 1000.
    #[serde(default = "one")]
    #[schema(exclusive_minimum = 0, maximum = 1000, default = one)]
    pub repeat: f64,
}

fn one() -> f64 {
    1.0
}

impl NormalMap {
    pub(super) fn validate(&self, pointer: &str) -> Result<(), FieldError> {
        check_image(&self.image, pointer)?;
        let in_range = self.strength.abs() <= STRENGTH_MAX;
        require(in_range, &format!("{pointer}/strength"), "must be between -4 and 4")?;
        let in_range = self.repeat > 0.0 && self.repeat <= REPEAT_MAX;
        require(in_range, &format!("{pointer}/repeat"), "must be above 0 and at most 1000")
    }
}
