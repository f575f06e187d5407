//! Uncertainties of the scene of a photograph, within which a search may correct it.

use brood_light::FieldError;
use brood_light::field::require;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Largest standard deviation of an angle in degrees, and of a ratio.
const MOST_DEG: f64 = 15.0;
const MOST: f64 = 0.5;

/// Standard deviations of what is stated about a picture: light, camera and brightness. What has no
/// standard deviation is exact.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Refine {
    /// Direction of each light from the centre of the mesh, in degrees, at most 15.
    #[serde(skip_serializing_if = "is_zero")]
    pub light_deg: f64,
    /// Distance of each light from the centre of the mesh, as a share, at most 0.5.
    #[serde(skip_serializing_if = "is_zero")]
    pub light_distance: f64,
    /// Direction of the camera from the centre of the mesh, and its aim and roll, in degrees, at
    /// most 15.
    #[serde(skip_serializing_if = "is_zero")]
    pub camera_deg: f64,
    /// Distance of the camera from the centre of the mesh, as a share, at most 0.5.
    #[serde(skip_serializing_if = "is_zero")]
    pub camera_distance: f64,
    /// Field of view, as a share, at most 0.5.
    #[serde(skip_serializing_if = "is_zero")]
    pub fov: f64,
    /// Brightness of the pictures, as a share, at most 0.5. The same for all pictures of a target.
    #[serde(skip_serializing_if = "is_zero")]
    pub gain: f64,
    /// Brightness of red, green and blue against each other, as a share, at most 0.5. The same for
    /// all pictures of a target.
    #[serde(skip_serializing_if = "is_zero")]
    pub white_balance: f64,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl Refine {
    /// True if everything is exact.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        *self == Self::default()
    }

    /// Checks every field.
    ///
    /// # Errors
    /// Returns the first field out of its range.
    pub fn validate(&self) -> Result<(), FieldError> {
        for (angle_deg, pointer) in
            [(self.light_deg, "/light_deg"), (self.camera_deg, "/camera_deg")]
        {
            let holds = (0.0..=MOST_DEG).contains(&angle_deg);
            require(holds, pointer, "must be from 0 to 15 degrees")?;
        }
        let shares = [
            (self.light_distance, "/light_distance"),
            (self.camera_distance, "/camera_distance"),
            (self.fov, "/fov"),
            (self.gain, "/gain"),
            (self.white_balance, "/white_balance"),
        ];
        for (share, pointer) in shares {
            require((0.0..=MOST).contains(&share), pointer, "must be from 0 to 0.5")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refine_is_checked_and_leaves_out_what_is_exact() {
        let read = |json| serde_json::from_str::<Refine>(json).unwrap();
        let refine = read(r#"{"light_deg": 2, "fov": 0.01}"#);
        assert_eq!(serde_json::to_string(&refine).unwrap(), r#"{"light_deg":2.0,"fov":0.01}"#);
        assert!(refine.validate().is_ok() && !refine.is_exact());
        assert!(read("{}").is_exact());
        for (json, pointer) in
            [(r#"{"light_deg": 16}"#, "/light_deg"), (r#"{"gain": -0.1}"#, "/gain")]
        {
            assert_eq!(read(json).validate().unwrap_err().pointer, pointer);
        }
        assert!(serde_json::from_str::<Refine>(r#"{"light": 2}"#).is_err());
    }
}
