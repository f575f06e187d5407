//! Lights at infinity, equal at every point of the scene.

use serde::{Deserialize, Serialize};

use super::strength::{Quantity, Strength};

/// Parallel light, like the sun.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct DirectionalLight {
    /// Direction of travel, of any length; `None` comes from the default position of a point light.
    pub direction: Option<[f64; 3]>,
    /// Irradiance or illuminance at normal incidence; `None` is irradiance pi.
    pub strength: Option<Strength>,
}

impl DirectionalLight {
    /// Quantities allowed for the strength.
    pub const QUANTITIES: &[Quantity] = &[Quantity::IrradianceWM2, Quantity::IlluminanceLx];
}

/// Default number of samples of environments and ambient light per shading point
/// (docs/maths/lights.md).
pub const ENVIRONMENT_SAMPLES: u32 = 64;

/// Equirectangular environment at infinity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EnvironmentLight {
    /// Name of the picture among the assets: equirectangular, upper edge +y, middle -z, +x a
    /// quarter of the width to the right of the middle.
    pub image: String,
    /// Rotation about the vertical axis, from +z towards +x, degrees.
    pub rotation_deg: f64,
    /// Factor from pixel values to radiance in W/(m2 sr), for red, green and blue.
    pub scale: [f64; 3],
    /// Samples per shading point.
    pub samples: u32,
}

/// Uniform radiance from every direction. A surface shows its directional albedo towards the eye.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AmbientLight {
    /// Radiance or luminance; `None` is radiance 1, whose irradiance is pi.
    pub strength: Option<Strength>,
    /// Samples per shading point.
    pub samples: u32,
}

impl AmbientLight {
    /// Quantities allowed for the strength.
    pub const QUANTITIES: &[Quantity] = &[Quantity::RadianceWM2Sr, Quantity::LuminanceNit];
}
