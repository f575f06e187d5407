//! The lights of a scene.
//!
//! Owns what each kind is described by, and its JSON form. What a light gives to a place is the sample set's business.

mod area;
mod distant;
mod json;
mod point;
mod strength;
mod validate;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

pub use area::{AREA_SAMPLES, DiskLight, RectangleLight, SphereLight};
pub use distant::{AmbientLight, DirectionalLight, ENVIRONMENT_SAMPLES, EnvironmentLight};
pub use point::{IesLight, PointLight, SpotLight};
pub(crate) use strength::Measure;
pub use strength::{Quantity, Strength};

/// A light. In JSON an object with a `kind`; a length of 1 of the world is a metre.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
// The derived form is that of formats without field names; JSON has its own.
#[serde(remote = "Self")]
pub enum Light {
    /// Shines from a point alike in all directions.
    Point(PointLight),
    /// Shines along one direction everywhere.
    Directional(DirectionalLight),
    /// Shines from a point into a cone.
    Spot(SpotLight),
    /// Shines from a point as a photometric profile says.
    Ies(IesLight),
    /// A ball that shines outwards.
    Sphere(SphereLight),
    /// A disk that shines to one side.
    Disk(DiskLight),
    /// A rectangle that shines to one side.
    Rectangle(RectangleLight),
    /// A picture of all that is around.
    Environment(EnvironmentLight),
    /// The same radiance from everywhere.
    Ambient(AmbientLight),
}

impl Light {
    /// A point light at a position, of irradiance pi at the centre of the mesh.
    #[must_use]
    pub fn point_at(position: [f64; 3]) -> Self {
        Self::Point(PointLight { position: Some(position), strength: None })
    }

    /// Samples that it makes at each place at most.
    #[must_use]
    pub fn samples(&self) -> u32 {
        match self {
            Self::Point(_) | Self::Directional(_) | Self::Spot(_) | Self::Ies(_) => 1,
            Self::Sphere(light) => light.samples,
            Self::Disk(light) => light.samples,
            Self::Rectangle(light) => light.samples,
            Self::Environment(light) => light.samples,
            Self::Ambient(light) => light.samples,
        }
    }

    /// Its kind in JSON.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Point(_) => "point",
            Self::Directional(_) => "directional",
            Self::Spot(_) => "spot",
            Self::Ies(_) => "ies",
            Self::Sphere(_) => "sphere",
            Self::Disk(_) => "disk",
            Self::Rectangle(_) => "rectangle",
            Self::Environment(_) => "environment",
            Self::Ambient(_) => "ambient",
        }
    }
}

impl Default for Light {
    fn default() -> Self {
        Self::Point(PointLight::default())
    }
}

impl Serialize for Light {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if serializer.is_human_readable() {
            return json::write(self, serializer);
        }
        Self::serialize(self, serializer)
    }
}

impl<'de> Deserialize<'de> for Light {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        if deserializer.is_human_readable() {
            return json::read(deserializer);
        }
        Self::deserialize(deserializer)
    }
}
