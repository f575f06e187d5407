//! Punctual lights: point and spot.

use std::f64::consts::PI;

use brood_mesh::angle::sin_cos_deg;
use glam::DVec3;

use super::placement::LightPlacement;
use super::sample::LightSample;
use crate::light::{Measure, PointLight, SpotLight, Strength};
use crate::units::{isotropic_intensity, spot_intensity};

/// Isotropic point light.
#[derive(Debug, Clone, Copy)]
pub(super) struct PointSource {
    position: DVec3,
    /// Intensity, scaled so that division by a squared distance in the unit frame gives irradiance.
    intensity: [f64; 3],
}

impl PointSource {
    pub fn new(light: &PointLight, placement: &LightPlacement<'_>) -> Self {
        let position = placement.position(light.position);
        let intensity = intensity(light.strength, isotropic_intensity, position, placement);
        Self { position, intensity }
    }

    /// Returns the sample at a position; `None` at the light itself.
    pub fn at(&self, position: DVec3) -> Option<LightSample> {
        let towards = self.position - position;
        let squared = towards.length_squared();
        if squared == 0.0 || !squared.is_finite() {
            return None;
        }
        let irradiance = self.intensity.map(|channel| channel / squared);
        let distance = squared.sqrt();
        Some(LightSample { towards: towards / distance, irradiance, distance, fading: false })
    }
}

/// Spot light: factor 1 within the hotspot, linear in the cosine down to 0 at the fall-off.
#[derive(Debug, Clone, Copy)]
pub(super) struct SpotSource {
    point: PointSource,
    axis: DVec3,
    cos_hotspot: f64,
    cos_falloff: f64,
}

impl SpotSource {
    pub fn new(light: &SpotLight, placement: &LightPlacement<'_>) -> Self {
        let cos_hotspot = sin_cos_deg(light.hotspot_deg).1;
        let cos_falloff = sin_cos_deg(light.falloff_deg).1;
        let position = placement.position(light.position);
        let from_flux = |flux| spot_intensity(flux, cos_hotspot, cos_falloff);
        let intensity = intensity(light.strength, from_flux, position, placement);
        let axis = placement.axis(light.axis, position);
        Self { point: PointSource { position, intensity }, axis, cos_hotspot, cos_falloff }
    }

    /// Returns the sample at a position; `None` outside the cone.
    pub fn at(&self, position: DVec3) -> Option<LightSample> {
        let light_sample = self.point.at(position)?;
        let cos = -light_sample.towards.dot(self.axis);
        if cos >= self.cos_hotspot {
            return Some(light_sample);
        }
        if cos > self.cos_falloff {
            let share = (cos - self.cos_falloff) / (self.cos_hotspot - self.cos_falloff);
            let irradiance = light_sample.irradiance.map(|channel| channel * share);
            return Some(LightSample { irradiance, fading: true, ..light_sample });
        }
        None
    }

    /// Returns the irradiance at the centre of the mesh, as if it were on the axis.
    pub fn reference_irradiance(&self) -> Option<[f64; 3]> {
        self.point.at(DVec3::ZERO).map(|light_sample| light_sample.irradiance)
    }
}

/// Returns intensity for distances in the unit frame. Without a strength, the irradiance at the
/// distance of the unit frame's origin is pi.
fn intensity(
    strength: Option<Strength>,
    from_flux: impl Fn(f64) -> f64,
    position: DVec3,
    placement: &LightPlacement<'_>,
) -> [f64; 3] {
    let unit = placement.unit();
    let Some(strength) = strength else { return [PI * position.length_squared(); 3] };
    let channels = strength.radiometric();
    let intensity = match strength.quantity.measure() {
        Measure::Flux => channels.map(from_flux),
        Measure::Intensity | Measure::Irradiance | Measure::Radiance => channels,
    };
    intensity.map(|channel| channel / (unit * unit))
}
