//! Lights with an area, sampled anew at each place.

use std::f64::consts::PI;

use glam::DVec3;

use super::placing::Placing;
use super::{Arrival, Receiver, brightest};
use crate::sample_set::sequence::Places;
use crate::units::lambertian_radiance;
use crate::{DiskLight, Measure, RectangleLight, SphereLight, Strength};

/// A ball.
#[derive(Debug, Clone, Copy)]
pub(super) struct SphereSource {
    centre: DVec3,
    radius: f64,
    radiance: [f64; 3],
}

/// A flat surface with a front.
#[derive(Debug, Clone, Copy)]
pub(super) struct FlatSource {
    centre: DVec3,
    /// Half its sides, or its radius along two directions; and the direction of its front.
    axes: [DVec3; 3],
    round: bool,
    radiance: [f64; 3],
    /// In the unit frame.
    area: f64,
}

impl SphereSource {
    pub fn new(light: &SphereLight, placing: &Placing<'_>) -> Self {
        let centre = placing.position(light.position);
        let radius = placing.length(light.radius, 0.5);
        let world = radius * placing.unit();
        let radiance = radiance(light.strength, 4.0 * PI * world * world, || {
            centre.length_squared() / (radius * radius)
        });
        Self { centre, radius, radiance }
    }

    /// Directions spread evenly over the cone in which the ball is seen; none from within it.
    pub fn arrivals(
        &self,
        receiver: &Receiver<'_>,
        (places, samples): (Places, u32),
        mut put: impl FnMut(u32, Arrival),
    ) {
        let to_centre = self.centre - receiver.place;
        let squared = to_centre.length_squared();
        let sine_squared = self.radius * self.radius / squared;
        if sine_squared >= 1.0 || !squared.is_finite() {
            return;
        }
        let distance = squared.sqrt();
        let axis = to_centre / distance;
        if axis.dot(receiver.shaded.n) <= -sine_squared.sqrt() {
            // All of it is below the horizon.
            return;
        }
        // 1 minus the cosine of the cone's half angle, also where that is tiny.
        let height = sine_squared / (1.0 + (1.0 - sine_squared).sqrt());
        let share = 2.0 * PI * height / f64::from(samples);
        let irradiance = self.radiance.map(|channel| channel * share);
        let (x, y) = axis.any_orthonormal_pair();
        for sample in 0..samples {
            let [across, around] = places.at(sample);
            let down = across * height;
            let sine = (down * (2.0 - down)).sqrt();
            let aside = aside(x, y, around) * sine;
            let towards = (axis * (1.0 - down) + aside).normalize();
            let half_chord = (self.radius * self.radius - squared * sine * sine).max(0.0).sqrt();
            let distance = distance * (1.0 - down) - half_chord;
            put(sample, Arrival { towards, irradiance, distance, fading: false });
        }
    }

    /// What all of it gives to a surface if none of it is below the horizon or hidden.
    pub fn outline(&self, place: DVec3, n: DVec3) -> f64 {
        let to_centre = self.centre - place;
        let squared = to_centre.length_squared();
        let share = (self.radius * self.radius / squared).min(1.0);
        PI * brightest(self.radiance) * share * (to_centre.dot(n) / squared.sqrt()).max(0.0)
    }

    pub fn usual(&self) -> [f64; 3] {
        let share = (self.radius * self.radius / self.centre.length_squared()).min(1.0);
        self.radiance.map(|channel| PI * channel * share)
    }
}

impl FlatSource {
    pub fn disk(light: &DiskLight, placing: &Placing<'_>) -> Self {
        let centre = placing.position(light.position);
        let axes = placing.axes(placing.axis(light.axis, centre), None);
        let radius = placing.length(light.radius, 0.5);
        Self::new(true, centre, axes, [radius; 2], (light.strength, placing))
    }

    pub fn rectangle(light: &RectangleLight, placing: &Placing<'_>) -> Self {
        let centre = placing.position(light.position);
        let axes = placing.axes(placing.axis(light.axis, centre), light.up);
        let sides = [light.width, light.height].map(|side| 0.5 * placing.length(side, 1.0));
        Self::new(false, centre, axes, sides, (light.strength, placing))
    }

    fn new(
        round: bool,
        centre: DVec3,
        [x, y, z]: [DVec3; 3],
        [width, height]: [f64; 2],
        (strength, placing): (Option<Strength>, &Placing<'_>),
    ) -> Self {
        let area = if round { PI } else { 4.0 } * width * height;
        let unit = placing.unit();
        let radiance =
            radiance(strength, area * unit * unit, || PI * centre.length_squared() / area);
        Self { centre, axes: [x * width, y * height, z], round, radiance, area }
    }

    /// Places spread evenly over the surface; none from behind it.
    pub fn arrivals(
        &self,
        receiver: &Receiver<'_>,
        (places, samples): (Places, u32),
        mut put: impl FnMut(u32, Arrival),
    ) {
        let [x, y, z] = self.axes;
        let to_centre = self.centre - receiver.place;
        let n = receiver.shaded.n;
        let highest = to_centre.dot(n) + x.dot(n).abs() + y.dot(n).abs();
        if to_centre.dot(z) >= 0.0 || highest <= 0.0 {
            return;
        }
        let share = self.area / f64::from(samples);
        for sample in 0..samples {
            let [across, down] = places.at(sample);
            let offset = if self.round {
                aside(x, y, down) * across.sqrt()
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
            put(sample, Arrival { towards, irradiance, distance, fading: false });
        }
    }

    /// What it would give to a surface if it were all in its middle.
    pub fn outline(&self, place: DVec3, n: DVec3) -> f64 {
        let to_centre = self.centre - place;
        let squared = to_centre.length_squared();
        let cosines = to_centre.dot(n).max(0.0) * (-to_centre.dot(self.axes[2])).max(0.0);
        brightest(self.radiance) * self.area * cosines / (squared * squared)
    }

    pub fn usual(&self) -> [f64; 3] {
        let squared = self.centre.length_squared().max(self.area);
        self.radiance.map(|channel| channel * self.area / squared)
    }
}

/// A direction around an axis, by its share of a turn.
pub(super) fn aside(x: DVec3, y: DVec3, turn: f64) -> DVec3 {
    let angle = 2.0 * PI * turn;
    x * libm::cos(angle) + y * libm::sin(angle)
}

/// Radiance of a surface of that area in the world; without a strength what is usual.
fn radiance(strength: Option<Strength>, area: f64, usual: impl FnOnce() -> f64) -> [f64; 3] {
    let Some(strength) = strength else { return [usual(); 3] };
    let channels = strength.radiometric();
    match strength.quantity.measure() {
        Measure::Flux => channels.map(|flux| lambertian_radiance(flux, area)),
        Measure::Intensity | Measure::Irradiance | Measure::Radiance => channels,
    }
}
