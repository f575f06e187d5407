//! Lights of a scene: parameters of each kind and their JSON form. The sample set samples them.

mod area;
mod distant;
mod json;
mod point;
#[cfg(feature = "schema")]
mod schema;
mod strength;
#[cfg(test)]
mod tests;
mod validate;

use serde::{Deserialize, Serialize};

pub use area::{AREA_SAMPLES, DiskLight, RectangleLight, SphereLight};
pub use distant::{AmbientLight, DirectionalLight, ENVIRONMENT_SAMPLES, EnvironmentLight};
pub use point::{IesLight, PointLight, SpotLight};
pub(crate) use strength::Measure;
pub use strength::{Quantity, Strength};

/// Light of a scene. In JSON an object with a `kind`. World units are metres.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
// The derived form serves formats without field names; JSON has its own form.
#[serde(remote = "Self")]
pub enum Light {
    /// Isotropic point light.
    Point(PointLight),
    /// Parallel light.
    Directional(DirectionalLight),
    /// Point light restricted to a cone.
    Spot(SpotLight),
    /// Point light with a photometric profile.
    Ies(IesLight),
    /// Emitting ball.
    Sphere(SphereLight),
    /// Disk that emits from its front.
    Disk(DiskLight),
    /// Rectangle that emits from its front.
    Rectangle(RectangleLight),
    /// Equirectangular environment.
    Environment(EnvironmentLight),
    /// Uniform radiance from every direction.
    Ambient(AmbientLight),
}

impl Light {
    /// Returns a point light at a position with irradiance pi at the centre of the mesh.
    #[must_use]
    pub fn point_at(position: [f64; 3]) -> Self {
        Self::Point(PointLight { position: Some(position), strength: None })
    }

    /// Returns the largest number of samples at one shading point.
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

    /// Returns the kind in JSON.
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
