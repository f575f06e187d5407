//! Lights with an area, which throw soft shadows: every place of them shines alike in all directions of its front.

use serde::{Deserialize, Serialize};

use super::strength::{Quantity, Strength};

/// Samples of a light with an area at each place, where nothing is said: see docs/maths/lights.md.
pub const AREA_SAMPLES: u32 = 16;

/// A ball that shines outwards.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SphereLight {
    /// The centre; `None` is where a point light without a position would be.
    pub position: Option<[f64; 3]>,
    /// `None` is half the radius of the mesh.
    pub radius: Option<f64>,
    /// Radiance, luminance or flux; `None` is what gives irradiance pi at the centre of the mesh.
    pub strength: Option<Strength>,
    /// Samples at each place.
    pub samples: u32,
}

/// A disk that shines to one side.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DiskLight {
    /// As of a sphere.
    pub position: Option<[f64; 3]>,
    /// Where it faces, of any length; `None` is towards the centre of the mesh.
    pub axis: Option<[f64; 3]>,
    /// `None` is half the radius of the mesh.
    pub radius: Option<f64>,
    /// Radiance, luminance or flux; `None` is what gives irradiance pi straight ahead at the distance of the centre of the
    /// mesh, if it were small.
    pub strength: Option<Strength>,
    /// Samples at each place.
    pub samples: u32,
}

/// A rectangle that shines to one side.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RectangleLight {
    /// The middle, as of a sphere.
    pub position: Option<[f64; 3]>,
    /// Where it faces, of any length; `None` is towards the centre of the mesh.
    pub axis: Option<[f64; 3]>,
    /// Towards which side its height goes, of any length; `None`, or along the axis, is upwards, or away from the default
    /// camera where the axis goes up or down.
    pub up: Option<[f64; 3]>,
    /// `None` is the radius of the mesh.
    pub width: Option<f64>,
    /// `None` is the radius of the mesh.
    pub height: Option<f64>,
    /// As of a disk.
    pub strength: Option<Strength>,
    /// Samples at each place.
    pub samples: u32,
}

impl SphereLight {
    /// What its strength may be given as.
    pub const QUANTITIES: &[Quantity] = &FROM_AN_AREA;
}

impl DiskLight {
    /// What its strength may be given as.
    pub const QUANTITIES: &[Quantity] = &FROM_AN_AREA;
}

impl RectangleLight {
    /// What its strength may be given as.
    pub const QUANTITIES: &[Quantity] = &FROM_AN_AREA;
}

const FROM_AN_AREA: [Quantity; 4] =
    [Quantity::RadianceWM2Sr, Quantity::LuminanceNit, Quantity::FluxW, Quantity::FluxLm];
