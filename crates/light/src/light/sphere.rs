//! Emitting ball.

use std::f64::consts::PI;

use glam::DVec3;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::kind::{At, Draw, Kind, Source};
use super::strength::{FromArea, Group, Strength};
use super::surface::{area_radiance, area_samples};
use crate::assets::LightAssets;
use crate::field::FieldError;
use crate::sampler::mixture::on_unit_circle;
use crate::sampler::placement::LightPlacement;
use crate::sampler::sample::{CentralLight, LightSample, Receiver, brightest};

/// Emitting ball. At most one of `radiance_w_m2_sr`, `luminance_nit`, `flux_w` and `flux_lm`; by
/// default the irradiance at the centre of the mesh is pi.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereLight {
    /// World position of the centre. Default: that of a point light.
    pub position: Option<[f64; 3]>,
    /// Radius. Default: half the radius of the mesh.
    pub radius: Option<f64>,
    /// Radiance, luminance or flux.
    #[serde(flatten, with = "FromArea")]
    #[schema(schema_with = FromArea::schema)]
    pub strength: Option<Strength>,
    /// Samples per shading point.
    #[serde(default = "area_samples")]
    #[schema(minimum = 1, maximum = 1024, default = area_samples)]
    pub samples: u32,
}

impl Kind for SphereLight {
    type Source = SphereSource;

    fn check(&self, at: &At<'_>) -> Result<(), FieldError> {
        at.position(self.position)?;
        at.length(self.radius, "radius")?;
        at.strength(self.strength, FromArea::QUANTITIES)?;
        at.samples(self.samples)
    }

    fn samples(&self) -> u32 {
        self.samples
    }

    fn source(&self, placement: &LightPlacement<'_>, _: &LightAssets) -> Option<SphereSource> {
        let centre = placement.position(self.position);
        let radius = placement.length(self.radius, 0.5);
        let world = radius * placement.unit();
        let radiance = area_radiance(self.strength, 4.0 * PI * world * world, || {
            placement.squared_to_pivot(centre) / (radius * radius)
        });
        Some(SphereSource { centre, radius, radiance })
    }
}

/// Sphere that emits outwards, in the unit frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SphereSource {
    centre: DVec3,
    radius: f64,
    radiance: [f64; 3],
}

impl Source for SphereSource {
    const IS_SOFT: bool = true;

    /// Samples the cone that the sphere subtends uniformly; no samples inside the sphere.
    fn for_each_sample(
        &self,
        receiver: &Receiver,
        draw: &Draw,
        mut put: impl FnMut(u32, LightSample),
    ) {
        let (points, samples) = (draw.points(receiver), draw.samples);
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
    fn unoccluded_irradiance(&self, position: DVec3, n: DVec3) -> f64 {
        let to_centre = self.centre - position;
        let squared = to_centre.length_squared();
        let share = (self.radius * self.radius / squared).min(1.0);
        PI * brightest(self.radiance) * share * (to_centre.dot(n) / squared.sqrt()).max(0.0)
    }

    fn central(&self, position: DVec3, _: Option<DVec3>) -> Option<CentralLight> {
        let to_centre = self.centre - position;
        let squared = to_centre.length_squared();
        let share = self.radius * self.radius / squared;
        let irradiance = self.radiance.map(|channel| PI * channel * share.min(1.0));
        (share.is_finite() && squared.is_finite())
            .then(|| CentralLight { towards: Some(to_centre / squared.sqrt()), irradiance })
    }

    fn reference_irradiance(&self, pivot: DVec3) -> Option<[f64; 3]> {
        let share = (self.radius * self.radius / (self.centre - pivot).length_squared()).min(1.0);
        Some(self.radiance.map(|channel| PI * channel * share))
    }
}
