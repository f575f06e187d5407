//! Area lights: sphere, disk and rectangle.

use std::f64::consts::PI;

use glam::DVec3;

use super::placement::LightPlacement;
use super::sample::{LightSample, Receiver, brightest};
use crate::light::{DiskLight, Measure, RectangleLight, SphereLight, Strength};
use crate::sequence::SamplePoints;
use crate::units::lambertian_radiance;

/// Sphere that emits outwards.
#[derive(Debug, Clone, Copy)]
pub(super) struct SphereSource {
    centre: DVec3,
    radius: f64,
    radiance: [f64; 3],
}

/// Disk or rectangle that emits from its front.
#[derive(Debug, Clone, Copy)]
pub(super) struct FlatSource {
    centre: DVec3,
    /// Two half sides, or two radii at right angles, and the unit normal of the front.
    axes: [DVec3; 3],
    round: bool,
    radiance: [f64; 3],
    /// Area in the unit frame.
    area: f64,
}

impl SphereSource {
    pub fn new(light: &SphereLight, placement: &LightPlacement<'_>) -> Self {
        let centre = placement.position(light.position);
        let radius = placement.length(light.radius, 0.5);
        let world = radius * placement.unit();
        let radiance = radiance(light.strength, 4.0 * PI * world * world, || {
            centre.length_squared() / (radius * radius)
        });
        Self { centre, radius, radiance }
    }

    /// Samples the cone that the sphere subtends uniformly; no samples inside the sphere.
    pub fn for_each_sample(
        &self,
        receiver: &Receiver,
        (points, samples): (SamplePoints, u32),
        mut put: impl FnMut(u32, LightSample),
    ) {
        let to_centre = self.centre - receiver.position;
        let squared = to_centre.length_squared();
        let sine_squared = self.radius * self.radius / squared;
        if sine_squared >= 1.0 || !squared.is_finite() {
            return;
        }
        let distance = squared.sqrt();
        let axis = to_centre / distance;
        if axis.dot(receiver.frame.n()) <= -sine_squared.sqrt() {
            // Wholly below the horizon.
            return;
        }
        // 1 minus the cosine of the cone's half angle, without cancellation for small angles.
        let height = sine_squared / (1.0 + (1.0 - sine_squared).sqrt());
        let share = 2.0 * PI * height / f64::from(samples);
        let irradiance = self.radiance.map(|channel| channel * share);
        let (x, y) = axis.any_orthonormal_pair();
        for sample in 0..samples {
            let [across, around] = points.at(sample);
            let down = across * height;
            let sine = (down * (2.0 - down)).sqrt();
            let offset = on_unit_circle(x, y, around) * sine;
            let towards = (axis * (1.0 - down) + offset).normalize();
            let half_chord = (self.radius * self.radius - squared * sine * sine).max(0.0).sqrt();
            let distance = distance * (1.0 - down) - half_chord;
            put(sample, LightSample { towards, irradiance, distance, fading: false });
        }
    }

    /// Returns the irradiance of the whole sphere if no part is below the horizon.
    pub fn unoccluded_irradiance(&self, position: DVec3, n: DVec3) -> f64 {
        let to_centre = self.centre - position;
        let squared = to_centre.length_squared();
        let share = (self.radius * self.radius / squared).min(1.0);
        PI * brightest(self.radiance) * share * (to_centre.dot(n) / squared.sqrt()).max(0.0)
    }

    pub fn reference_irradiance(&self) -> [f64; 3] {
        let share = (self.radius * self.radius / self.centre.length_squared()).min(1.0);
        self.radiance.map(|channel| PI * channel * share)
    }
}

impl FlatSource {
    pub fn disk(light: &DiskLight, placement: &LightPlacement<'_>) -> Self {
        let centre = placement.position(light.position);
        let axes = placement.axes(placement.axis(light.axis, centre), None);
        let radius = placement.length(light.radius, 0.5);
        Self::new(true, centre, axes, [radius; 2], (light.strength, placement))
    }

    pub fn rectangle(light: &RectangleLight, placement: &LightPlacement<'_>) -> Self {
        let centre = placement.position(light.position);
        let axes = placement.axes(placement.axis(light.axis, centre), light.up);
        let sides = [light.width, light.height].map(|side| 0.5 * placement.length(side, 1.0));
        Self::new(false, centre, axes, sides, (light.strength, placement))
    }

    fn new(
        round: bool,
        centre: DVec3,
        [x, y, z]: [DVec3; 3],
        [width, height]: [f64; 2],
        (strength, placement): (Option<Strength>, &LightPlacement<'_>),
    ) -> Self {
        let area = if round { PI } else { 4.0 } * width * height;
        let unit = placement.unit();
        let radiance =
            radiance(strength, area * unit * unit, || PI * centre.length_squared() / area);
        Self { centre, axes: [x * width, y * height, z], round, radiance, area }
    }

    /// Samples the surface uniformly; no samples behind it.
    pub fn for_each_sample(
        &self,
        receiver: &Receiver,
        (points, samples): (SamplePoints, u32),
        mut put: impl FnMut(u32, LightSample),
    ) {
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
    pub fn unoccluded_irradiance(&self, position: DVec3, n: DVec3) -> f64 {
        let to_centre = self.centre - position;
        let squared = to_centre.length_squared();
        let cosines = to_centre.dot(n).max(0.0) * (-to_centre.dot(self.axes[2])).max(0.0);
        brightest(self.radiance) * self.area * cosines / (squared * squared)
    }

    pub fn reference_irradiance(&self) -> [f64; 3] {
        let squared = self.centre.length_squared().max(self.area);
        self.radiance.map(|channel| channel * self.area / squared)
    }
}

/// Returns the point of the unit circle spanned by `x` and `y` at a fraction of a turn.
pub(super) fn on_unit_circle(x: DVec3, y: DVec3, turn: f64) -> DVec3 {
    let angle = 2.0 * PI * turn;
    x * libm::cos(angle) + y * libm::sin(angle)
}

/// Returns the radiance of a surface of `area` in the world; `default` if there is no strength.
fn radiance(strength: Option<Strength>, area: f64, default: impl FnOnce() -> f64) -> [f64; 3] {
    let Some(strength) = strength else { return [default(); 3] };
    let channels = strength.radiometric();
    match strength.quantity.measure() {
        Measure::Flux => channels.map(|flux| lambertian_radiance(flux, area)),
        Measure::Intensity | Measure::Irradiance | Measure::Radiance => channels,
    }
}
