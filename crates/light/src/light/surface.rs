//! Parts shared by lights with an area: flat sources, and radiance from a strength.

use std::f64::consts::PI;

use glam::DVec3;

use super::kind::{Draw, Source};
use super::strength::{Measure, Strength};
use crate::sampler::mixture::on_unit_circle;
use crate::sampler::placement::LightPlacement;
use crate::sampler::sample::{CentralLight, LightSample, Receiver, brightest};
use crate::units::lambertian_radiance;

/// Default number of samples of an area light per shading point (docs/maths/lights.md).
pub const AREA_SAMPLES: u32 = 16;

pub(super) fn area_samples() -> u32 {
    AREA_SAMPLES
}

/// Disk or rectangle that emits from its front, in the unit frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FlatSource {
    centre: DVec3,
    /// Two half sides, or two radii at right angles, and the unit normal of the front.
    axes: [DVec3; 3],
    round: bool,
    radiance: [f64; 3],
    /// Area in the unit frame.
    area: f64,
}

impl FlatSource {
    pub(super) fn new(
        round: bool,
        centre: DVec3,
        [x, y, z]: [DVec3; 3],
        [width, height]: [f64; 2],
        (strength, placement): (Option<Strength>, &LightPlacement<'_>),
    ) -> Self {
        let area = if round { PI } else { 4.0 } * width * height;
        let unit = placement.unit();
        let radiance = area_radiance(strength, area * unit * unit, || {
            PI * placement.squared_to_pivot(centre) / area
        });
        Self { centre, axes: [x * width, y * height, z], round, radiance, area }
    }
}

impl Source for FlatSource {
    const IS_SOFT: bool = true;

    /// Samples the surface uniformly; no samples behind it.
    fn for_each_sample(
        &self,
        receiver: &Receiver,
        draw: &Draw,
        mut put: impl FnMut(u32, LightSample),
    ) {
        let (points, samples) = (draw.points(receiver), draw.samples);
        let [x, y, z] = self.axes;
        let to_centre = self.centre - receiver.position;
        let n = receiver.frame.n();
        let highest = to_centre.dot(n) + x.dot(n).abs() + y.dot(n).abs();
        if to_centre.dot(z) >= 0.0 || highest <= 0.0 {
            return;
        }
        let share = self.area / f64::from(samples);
        for sample in 0..samples {
            let [across, down] = points.at(sample);
            let offset = if self.round {
                on_unit_circle(x, y, down) * across.sqrt()
            } else {
                x * (2.0 * across - 1.0) + y * (2.0 * down - 1.0)
            };
            let towards = to_centre + offset;
            let squared = towards.length_squared();
            if squared == 0.0 || !squared.is_finite() {
                continue;
            }
            let distance = squared.sqrt();
            let towards = towards / distance;
            let weight = share * -towards.dot(z) / squared;
            let irradiance = self.radiance.map(|channel| channel * weight);
            put(sample, LightSample { towards, irradiance, distance, fading: false });
        }
    }

    /// Returns the irradiance if all of the light were at its centre.
    fn unoccluded_irradiance(&self, position: DVec3, n: DVec3) -> f64 {
        let to_centre = self.centre - position;
        let squared = to_centre.length_squared();
        let cosines = to_centre.dot(n).max(0.0) * (-to_centre.dot(self.axes[2])).max(0.0);
        brightest(self.radiance) * self.area * cosines / (squared * squared)
    }

    fn central(&self, position: DVec3, _: Option<DVec3>) -> Option<CentralLight> {
        let to_centre = self.centre - position;
        let squared = to_centre.length_squared();
        if squared == 0.0 || !squared.is_finite() {
            return None;
        }
        let towards = to_centre / squared.sqrt();
        let cosine = (-towards.dot(self.axes[2])).max(0.0);
        let share = (self.area * cosine / squared).min(PI);
        let irradiance = self.radiance.map(|channel| channel * share);
        Some(CentralLight { towards: Some(towards), irradiance })
    }

    fn reference_irradiance(&self, pivot: DVec3) -> Option<[f64; 3]> {
        let squared = (self.centre - pivot).length_squared().max(self.area);
        Some(self.radiance.map(|channel| channel * self.area / squared))
    }
}

/// Returns the radiance of a surface of `area` in the world; `default` if there is no strength.
pub(super) fn area_radiance(
    strength: Option<Strength>,
    area: f64,
    default: impl FnOnce() -> f64,
) -> [f64; 3] {
    let Some(strength) = strength else { return [default(); 3] };
    let channels = strength.radiometric();
    match strength.quantity.measure() {
        Measure::Flux => channels.map(|flux| lambertian_radiance(flux, area)),
        Measure::Intensity | Measure::Irradiance | Measure::Radiance => channels,
    }
}
