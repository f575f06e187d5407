//! Area lights: uniform radiance over their front.

use serde::{Deserialize, Serialize};

use super::strength::{Quantity, Strength};

/// Default number of samples of an area light per shading point (docs/maths/lights.md).
pub const AREA_SAMPLES: u32 = 16;

/// Emitting ball.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SphereLight {
    /// Centre; `None` is the default position of a point light.
    pub position: Option<[f64; 3]>,
    /// Radius; `None` is half the radius of the mesh.
    pub radius: Option<f64>,
    /// Radiance, luminance or flux; `None` gives irradiance pi at the centre of the mesh.
    pub strength: Option<Strength>,
    /// Samples per shading point.
    pub samples: u32,
}

/// Disk that emits from its front.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DiskLight {
    /// Centre; `None` is the default position of a point light.
    pub position: Option<[f64; 3]>,
    /// Emission axis, of any length; `None` points at the centre of the mesh.
    pub axis: Option<[f64; 3]>,
    /// Radius; `None` is half the radius of the mesh.
    pub radius: Option<f64>,
    /// Radiance, luminance or flux; `None` gives irradiance pi on the axis at the distance of the
    /// mesh's centre, in the small-source limit.
    pub strength: Option<Strength>,
    /// Samples per shading point.
    pub samples: u32,
}

/// Rectangle that emits from its front.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RectangleLight {
    /// Centre; `None` is the default position of a point light.
    pub position: Option<[f64; 3]>,
    /// Emission axis, of any length; `None` points at the centre of the mesh.
    pub axis: Option<[f64; 3]>,
    /// Direction of the height, of any length. `None`, or a direction along the axis, means up, or
    /// away from the default camera for a vertical axis.
    pub up: Option<[f64; 3]>,
    /// Width; `None` is the radius of the mesh.
    pub width: Option<f64>,
    /// Height; `None` is the radius of the mesh.
    pub height: Option<f64>,
    /// Radiance, luminance or flux; the default is that of a disk.
    pub strength: Option<Strength>,
    /// Samples per shading point.
    pub samples: u32,
}

impl SphereLight {
    /// Quantities allowed for the strength.
    pub const QUANTITIES: &[Quantity] = &FROM_AN_AREA;
}

impl DiskLight {
    /// Quantities allowed for the strength.
    pub const QUANTITIES: &[Quantity] = &FROM_AN_AREA;
}

impl RectangleLight {
    /// Quantities allowed for the strength.
    pub const QUANTITIES: &[Quantity] = &FROM_AN_AREA;
}

const FROM_AN_AREA: [Quantity; 4] =
    [Quantity::RadianceWM2Sr, Quantity::LuminanceNit, Quantity::FluxW, Quantity::FluxLm];
