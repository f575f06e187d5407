//! Isotropic point light.

use std::f64::consts::PI;

use brood_mesh::UnitFrame;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::kind::{At, Kind, SingleSample};
use super::strength::{FromPoint, Group, Measure, Strength};
use crate::assets::LightAssets;
use crate::field::FieldError;
use crate::sampler::placement::LightPlacement;
use crate::sampler::sample::LightSample;
use crate::units::isotropic_intensity;

/// Isotropic point light. At most one of `intensity`, `intensity_cd`, `flux_w` and `flux_lm`; by
/// default the irradiance at the centre of the mesh is pi.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PointLight {
    /// World position. Default: right of and above the default camera, four bounding-sphere radii
    /// from the centre of the mesh.
    pub position: Option<[f64; 3]>,
    /// Intensity or flux.
    #[serde(flatten, with = "FromPoint")]
    #[schema(schema_with = FromPoint::schema)]
    pub strength: Option<Strength>,
}

impl PointLight {
    /// Returns the position in the unit frame, turned as in [`crate::LightSampler::all`].
    #[must_use]
    pub fn place(&self, light_deg: f64, frame: &UnitFrame) -> DVec3 {
        LightPlacement::new(light_deg, frame).position(self.position)
    }
}

impl Kind for PointLight {
    type Source = PointSource;

    fn check(&self, at: &At<'_>) -> Result<(), FieldError> {
        at.position(self.position)?;
        at.strength(self.strength, FromPoint::QUANTITIES)
    }

    fn source(&self, placement: &LightPlacement<'_>, _: &LightAssets) -> Option<PointSource> {
        let position = placement.position(self.position);
        Some(PointSource::new(position, self.strength, isotropic_intensity, placement))
    }
}

/// Isotropic point light in the unit frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PointSource {
    pub(super) position: DVec3,
    /// Intensity, scaled so that division by a squared distance in the unit frame gives irradiance.
    intensity: [f64; 3],
}

impl PointSource {
    /// Makes the source at a position in the unit frame. Without a strength, the irradiance at the
    /// distance of the subject's centre is pi.
    pub(super) fn new(
        position: DVec3,
        strength: Option<Strength>,
        from_flux: impl Fn(f64) -> f64,
        placement: &LightPlacement<'_>,
    ) -> Self {
        let Some(strength) = strength else {
            return Self { position, intensity: [PI * placement.squared_to_pivot(position); 3] };
        };
        let channels = strength.radiometric();
        let intensity = match strength.quantity.measure() {
            Measure::Flux => channels.map(from_flux),
            Measure::Intensity | Measure::Irradiance | Measure::Radiance => channels,
        };
        let unit = placement.unit();
        Self { position, intensity: intensity.map(|channel| channel / (unit * unit)) }
    }
}

impl SingleSample for PointSource {
    /// `None` at the light itself.
    fn at(&self, position: DVec3) -> Option<LightSample> {
        let towards = self.position - position;
        let squared = towards.length_squared();
        if squared == 0.0 || !squared.is_finite() {
            return None;
        }
        let irradiance = self.intensity.map(|channel| channel / squared);
        let distance = squared.sqrt();
        Some(LightSample { towards: towards / distance, irradiance, distance, fading: false })
    }

    fn reference_irradiance(&self, pivot: DVec3) -> Option<[f64; 3]> {
        self.at(pivot).map(|sample| sample.irradiance)
    }
}
