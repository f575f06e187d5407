//! Parallel light.

use std::f64::consts::PI;

use brood_mesh::UnitFrame;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::kind::{At, Kind, SingleSample};
use super::strength::{FromDirection, Group, Strength};
use crate::assets::LightAssets;
use crate::field::FieldError;
use crate::sampler::placement::LightPlacement;
use crate::sampler::sample::LightSample;

/// Parallel light, like the sun. At most one of `irradiance_w_m2` and `illuminance_lx`; by default
/// the irradiance is pi.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct DirectionalLight {
    /// Direction of travel, of any length. Default: from the default position of a point light.
    pub direction: Option<[f64; 3]>,
    /// Irradiance or illuminance at normal incidence.
    #[serde(flatten, with = "FromDirection")]
    #[schema(schema_with = FromDirection::schema)]
    pub strength: Option<Strength>,
}

impl DirectionalLight {
    /// Returns the unit direction towards the light in the unit frame, turned as in
    /// [`crate::LightSampler::all`].
    #[must_use]
    pub fn towards(&self, light_deg: f64, frame: &UnitFrame) -> DVec3 {
        self.towards_in(&LightPlacement::new(light_deg, frame))
    }

    fn towards_in(&self, placement: &LightPlacement<'_>) -> DVec3 {
        match self.direction {
            Some(direction) => -placement.direction(direction),
            None => placement.default_direction(),
        }
    }
}

impl Kind for DirectionalLight {
    type Source = DirectionalSource;

    fn check(&self, at: &At<'_>) -> Result<(), FieldError> {
        at.direction(self.direction, "direction")?;
        at.strength(self.strength, FromDirection::QUANTITIES)
    }

    fn source(&self, placement: &LightPlacement<'_>, _: &LightAssets) -> Option<DirectionalSource> {
        let irradiance = self.strength.map_or([PI; 3], |strength| strength.radiometric());
        Some(DirectionalSource { towards: self.towards_in(placement), irradiance })
    }
}

/// Parallel light in the unit frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DirectionalSource {
    /// Unit direction towards the light.
    towards: DVec3,
    irradiance: [f64; 3],
}

impl SingleSample for DirectionalSource {
    fn at(&self, _: DVec3) -> Option<LightSample> {
        let Self { towards, irradiance } = *self;
        Some(LightSample { towards, irradiance, distance: f64::INFINITY, fading: false })
    }

    fn reference_irradiance(&self, _: DVec3) -> Option<[f64; 3]> {
        Some(self.irradiance)
    }
}
