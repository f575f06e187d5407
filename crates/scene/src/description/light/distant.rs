//! Lights that are so far away that every place gets the same from them.

use serde::{Deserialize, Serialize};

use super::strength::{Quantity, Strength};

/// Shines along one direction everywhere, as the sun does.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct DirectionalLight {
    /// Where the light goes, of any length; `None` is from where a point light without a position would be.
    pub direction: Option<[f64; 3]>,
    /// Irradiance or illuminance at normal incidence; `None` is irradiance pi.
    pub strength: Option<Strength>,
}

impl DirectionalLight {
    /// What its strength may be given as.
    pub const QUANTITIES: &[Quantity] = &[Quantity::IrradianceWM2, Quantity::IlluminanceLx];
}

/// Samples of an environment, or of ambient light, at each place, where nothing is said: see docs/maths/lights.md.
pub const ENVIRONMENT_SAMPLES: u32 = 64;

/// A picture of all that is around, infinitely far away.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EnvironmentLight {
    /// Name of the picture among the assets: equirectangular, its upper edge straight up, its middle towards -z, +x a
    /// quarter to the right of it.
    pub image: String,
    /// Rotation about the vertical axis, from +z towards +x, degrees.
    pub rotation_deg: f64,
    /// For red, green and blue: from the picture's numbers to radiance in W/(m2 sr).
    pub scale: [f64; 3],
    /// Samples at each place.
    pub samples: u32,
}

/// The same radiance from everywhere: what a surface shows is its own directional albedo, seen from where the eye is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AmbientLight {
    /// Radiance or luminance; `None` is radiance 1, whose irradiance is pi.
    pub strength: Option<Strength>,
    /// Samples at each place.
    pub samples: u32,
}

impl AmbientLight {
    /// What its strength may be given as.
    pub const QUANTITIES: &[Quantity] = &[Quantity::RadianceWM2Sr, Quantity::LuminanceNit];
}
