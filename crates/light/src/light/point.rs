//! Lights at a point, with inverse-square fall-off.

use serde::{Deserialize, Serialize};

use super::strength::{Quantity, Strength};

/// Isotropic point light.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PointLight {
    /// World position; `None` is right of and above the default camera, four bounding-sphere radii
    /// from the centre of the mesh.
    pub position: Option<[f64; 3]>,
    /// Intensity or flux; `None` gives irradiance pi at the centre of the mesh.
    pub strength: Option<Strength>,
}

/// Point light restricted to a cone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SpotLight {
    /// World position; the default is that of a point light.
    pub position: Option<[f64; 3]>,
    /// Axis of the cone, of any length; `None` points at the centre of the mesh.
    pub axis: Option<[f64; 3]>,
    /// Half angle of the cone of full intensity, degrees.
    pub hotspot_deg: f64,
    /// Half angle of the outer cone, degrees. Between both the intensity is linear in the cosine.
    pub falloff_deg: f64,
    /// Intensity on the axis, or flux of the whole cone; `None` gives irradiance pi at the distance
    /// of the mesh's centre.
    pub strength: Option<Strength>,
}

/// Point light with the distribution of an IES file.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct IesLight {
    /// World position; the default is that of a point light.
    pub position: Option<[f64; 3]>,
    /// Direction of the profile's nadir (types A and B: of its aim), of any length; `None` points
    /// at the centre of the mesh.
    pub axis: Option<[f64; 3]>,
    /// Direction of the profile's 90 degrees (type C) or up (types A and B), of any length. `None`,
    /// or a direction along the axis, means up, or away from the default camera for a vertical
    /// axis.
    pub up: Option<[f64; 3]>,
    /// Name of the profile among the assets.
    pub profile: String,
    /// Peak intensity, or flux; `None` uses the file's values.
    pub strength: Option<Strength>,
}

impl PointLight {
    /// Quantities allowed for the strength.
    pub const QUANTITIES: &[Quantity] = &FROM_A_POINT;
}

impl SpotLight {
    /// Quantities allowed for the strength.
    pub const QUANTITIES: &[Quantity] = &FROM_A_POINT;
}

impl IesLight {
    /// Quantities allowed for the strength.
    pub const QUANTITIES: &[Quantity] = &FROM_A_POINT;
}

impl Default for SpotLight {
    fn default() -> Self {
        Self { position: None, axis: None, hotspot_deg: 10.0, falloff_deg: 15.0, strength: None }
    }
}

const FROM_A_POINT: [Quantity; 4] =
    [Quantity::Intensity, Quantity::IntensityCd, Quantity::FluxW, Quantity::FluxLm];
