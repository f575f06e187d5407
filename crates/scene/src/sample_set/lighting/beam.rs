//! Lights at a point: alike in all directions, or in a cone.

use std::f64::consts::PI;

use glam::DVec3;

use super::Arrival;
use super::placing::Placing;
use crate::angle::sin_cos_deg;
use crate::units::{isotropic_intensity, spot_intensity};
use crate::{Measure, PointLight, SpotLight, Strength};

/// Alike in all directions.
#[derive(Debug, Clone, Copy)]
pub(super) struct PointSource {
    position: DVec3,
    /// Over the square of a distance in the unit frame: irradiance.
    intensity: [f64; 3],
}

impl PointSource {
    pub fn new(light: &PointLight, placing: &Placing<'_>) -> Self {
        let position = placing.position(light.position);
        let intensity = intensity(light.strength, isotropic_intensity, position, placing);
        Self { position, intensity }
    }

    /// `None` at the light itself.
    pub fn at(&self, place: DVec3) -> Option<Arrival> {
        let towards = self.position - place;
        let squared = towards.length_squared();
        if squared == 0.0 || !squared.is_finite() {
            return None;
        }
        let irradiance = self.intensity.map(|channel| channel / squared);
        let distance = squared.sqrt();
        Some(Arrival { towards: towards / distance, irradiance, distance, fading: false })
    }
}

/// In a cone: 1 within the hotspot, linear in the cosine down to 0 at the fall-off.
#[derive(Debug, Clone, Copy)]
pub(super) struct SpotSource {
    point: PointSource,
    axis: DVec3,
    cos_hotspot: f64,
    cos_falloff: f64,
}

impl SpotSource {
    pub fn new(light: &SpotLight, placing: &Placing<'_>) -> Self {
        let cos_hotspot = sin_cos_deg(light.hotspot_deg).1;
        let cos_falloff = sin_cos_deg(light.falloff_deg).1;
        let position = placing.position(light.position);
        let of_flux = |flux| spot_intensity(flux, cos_hotspot, cos_falloff);
        let intensity = intensity(light.strength, of_flux, position, placing);
        let axis = placing.axis(light.axis, position);
        Self { point: PointSource { position, intensity }, axis, cos_hotspot, cos_falloff }
    }

    /// `None` out of the cone.
    pub fn at(&self, place: DVec3) -> Option<Arrival> {
        let arrival = self.point.at(place)?;
        let cos = -arrival.towards.dot(self.axis);
        if cos >= self.cos_hotspot {
            return Some(arrival);
        }
        if cos > self.cos_falloff {
            let share = (cos - self.cos_falloff) / (self.cos_hotspot - self.cos_falloff);
            let irradiance = arrival.irradiance.map(|channel| channel * share);
            return Some(Arrival { irradiance, fading: true, ..arrival });
        }
        None
    }

    /// As if the centre of the mesh were on the axis.
    pub fn usual(&self) -> Option<[f64; 3]> {
        self.point.at(DVec3::ZERO).map(|arrival| arrival.irradiance)
    }
}

/// Intensity over squared lengths of the unit frame; without a strength what gives irradiance pi at the distance of its
/// origin.
fn intensity(
    strength: Option<Strength>,
    of_flux: impl Fn(f64) -> f64,
    position: DVec3,
    placing: &Placing<'_>,
) -> [f64; 3] {
    let unit = placing.unit();
    let Some(strength) = strength else { return [PI * position.length_squared(); 3] };
    let channels = strength.radiometric();
    let intensity = match strength.quantity.measure() {
        Measure::Flux => channels.map(of_flux),
        Measure::Intensity | Measure::Irradiance | Measure::Radiance => channels,
    };
    intensity.map(|channel| channel / (unit * unit))
}
