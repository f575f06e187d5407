//! Lights at a point: what they give falls with the square of the distance.

use serde::{Deserialize, Serialize};

use super::strength::{Quantity, Strength};

/// Shines from a point alike in all directions.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PointLight {
    /// Position in the world; `None` places it to the right of and above the default camera, four radii of the
    /// mesh's bounding sphere from its centre.
    pub position: Option<[f64; 3]>,
    /// Intensity or flux; `None` is what gives irradiance pi at the centre of the mesh.
    pub strength: Option<Strength>,
}

/// Shines from a point into a cone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SpotLight {
    /// As of a point light.
    pub position: Option<[f64; 3]>,
    /// Where it shines, of any length; `None` is towards the centre of the mesh.
    pub axis: Option<[f64; 3]>,
    /// Half angle of the cone in which the intensity is that of the axis, degrees.
    pub hotspot_deg: f64,
    /// Half angle of the cone out of which nothing shines, degrees; between the two the intensity is linear in the cosine.
    pub falloff_deg: f64,
    /// Intensity on the axis, or flux of the whole cone; `None` is what gives irradiance pi at the distance of the centre
    /// of the mesh.
    pub strength: Option<Strength>,
}

/// Shines from a point as an IES file says.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct IesLight {
    /// As of a point light.
    pub position: Option<[f64; 3]>,
    /// Where its straight down points (types A and B: where it is aimed), of any length; `None` is towards the centre of the
    /// mesh.
    pub axis: Option<[f64; 3]>,
    /// Towards which side its 90 degrees of type C, or its upwards of types A and B, are; of any length. `None`, or along
    /// the axis, is upwards, or away from the default camera where the axis goes up or down.
    pub up: Option<[f64; 3]>,
    /// Name of the profile among the assets.
    pub profile: String,
    /// Intensity where it is brightest, or flux of the whole; `None` is what the file says.
    pub strength: Option<Strength>,
}

impl PointLight {
    /// What its strength may be given as.
    pub const QUANTITIES: &[Quantity] = &FROM_A_POINT;
}

impl SpotLight {
    /// What its strength may be given as.
    pub const QUANTITIES: &[Quantity] = &FROM_A_POINT;
}

impl IesLight {
    /// What its strength may be given as.
    pub const QUANTITIES: &[Quantity] = &FROM_A_POINT;
}

impl Default for SpotLight {
    fn default() -> Self {
        Self { position: None, axis: None, hotspot_deg: 10.0, falloff_deg: 15.0, strength: None }
    }
}

const FROM_A_POINT: [Quantity; 4] =
    [Quantity::Intensity, Quantity::IntensityCd, Quantity::FluxW, Quantity::FluxLm];
