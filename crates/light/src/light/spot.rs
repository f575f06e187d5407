//! Point light restricted to a cone.

use brood_mesh::angle::sin_cos_deg;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::kind::{At, Kind, SingleSample};
use super::point::PointSource;
use super::strength::{FromPoint, Group, Strength};
use crate::assets::LightAssets;
use crate::field::FieldError;
use crate::sampler::placement::LightPlacement;
use crate::sampler::sample::LightSample;
use crate::units::spot_intensity;

/// Smallest outer cone; below, the solid angle loses digits.
const FALLOFF_MIN_DEG: f64 = 0.1;

/// Point light restricted to a cone. At most one of `intensity`, `intensity_cd`, `flux_w` and
/// `flux_lm`; by default the irradiance on the axis at the distance of the mesh's centre is pi.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SpotLight {
    /// World position. Default: that of a point light.
    pub position: Option<[f64; 3]>,
    /// Axis of the cone, of any length. Default: towards the centre of the mesh.
    pub axis: Option<[f64; 3]>,
    /// Half angle of the cone of full intensity, degrees.
    #[serde(default = "hotspot_deg")]
    #[schema(default = hotspot_deg)]
    pub hotspot_deg: f64,
    /// Half angle of the outer cone, degrees. Between both the intensity is linear in the cosine.
    #[serde(default = "falloff_deg")]
    #[schema(default = falloff_deg)]
    pub falloff_deg: f64,
    /// Intensity on the axis, or flux of the whole cone.
    #[serde(flatten, with = "FromPoint")]
    #[schema(schema_with = FromPoint::schema)]
    pub strength: Option<Strength>,
}

fn hotspot_deg() -> f64 {
    10.0
}

fn falloff_deg() -> f64 {
    15.0
}

impl Default for SpotLight {
    fn default() -> Self {
        Self {
            position: None,
            axis: None,
            hotspot_deg: hotspot_deg(),
            falloff_deg: falloff_deg(),
            strength: None,
        }
    }
}

impl Kind for SpotLight {
    type Source = SpotSource;

    fn check(&self, at: &At<'_>) -> Result<(), FieldError> {
        at.position(self.position)?;
        at.direction(self.axis, "axis")?;
        let falloff = (FALLOFF_MIN_DEG..=180.0).contains(&self.falloff_deg);
        at.require(falloff, "falloff_deg", "must be from 0.1 to 180 degrees")?;
        let hotspot = self.hotspot_deg >= 0.0 && self.hotspot_deg <= self.falloff_deg;
        at.require(hotspot, "hotspot_deg", "must be from 0 to the fall-off's angle")?;
        at.strength(self.strength, FromPoint::QUANTITIES)
    }

    fn source(&self, placement: &LightPlacement<'_>, _: &LightAssets) -> Option<SpotSource> {
        let cos_hotspot = sin_cos_deg(self.hotspot_deg).1;
        let cos_falloff = sin_cos_deg(self.falloff_deg).1;
        let position = placement.position(self.position);
        let from_flux = |flux| spot_intensity(flux, cos_hotspot, cos_falloff);
        let point = PointSource::new(position, self.strength, from_flux, placement);
        let axis = placement.axis(self.axis, position);
        Some(SpotSource { point, axis, cos_hotspot, cos_falloff })
    }
}

/// Spot light in the unit frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SpotSource {
    point: PointSource,
    axis: DVec3,
    cos_hotspot: f64,
    cos_falloff: f64,
}

impl SingleSample for SpotSource {
    /// `None` outside the cone.
    fn at(&self, position: DVec3) -> Option<LightSample> {
        let sample = self.point.at(position)?;
        let cos = -sample.towards.dot(self.axis);
        if cos >= self.cos_hotspot {
            return Some(sample);
        }
        if cos > self.cos_falloff {
            let share = (cos - self.cos_falloff) / (self.cos_hotspot - self.cos_falloff);
            let irradiance = sample.irradiance.map(|channel| channel * share);
            return Some(LightSample { irradiance, fading: true, ..sample });
        }
        None
    }

    /// As if the subject's centre were on the axis.
    fn reference_irradiance(&self, pivot: DVec3) -> Option<[f64; 3]> {
        self.point.reference_irradiance(pivot)
    }
}
