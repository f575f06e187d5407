//! Light from all around: a picture of an environment, or the same from everywhere.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::area::aside;
use super::placing::Placing;
use super::{Arrival, Receiver};
use crate::angle::rotation_y_deg;
use crate::sample_set::sequence::Places;
use crate::{AmbientLight, EnvironmentLight, EnvironmentMap, LightAssets};

/// An environment, turned as the scene says.
#[derive(Debug, Clone)]
pub(super) struct EnvironmentSource {
    map: Arc<EnvironmentMap>,
    /// From the picture's directions to the unit frame.
    turn: DMat3,
    scale: [f64; 3],
}

impl EnvironmentSource {
    /// `None` where there is no such picture.
    pub fn new(
        light: &EnvironmentLight,
        placing: &Placing<'_>,
        assets: &LightAssets,
    ) -> Option<Self> {
        let map = assets.environment(&light.image)?.clone();
        let own = rotation_y_deg(light.rotation_deg);
        let turn = DMat3::from_cols(
            placing.direction((own * DVec3::X).to_array()),
            placing.direction((own * DVec3::Y).to_array()),
            placing.direction((own * DVec3::Z).to_array()),
        );
        Some(Self { map, turn, scale: light.scale })
    }

    /// Directions in proportion to luminance.
    pub fn arrivals(&self, (places, samples): (Places, u32), mut put: impl FnMut(u32, Arrival)) {
        let share = 1.0 / f64::from(samples);
        for sample in 0..samples {
            let Some((direction, weight)) = self.map.draw(places.at(sample)) else { continue };
            let towards = (self.turn * direction).normalize();
            let [r, g, b] = self.scale;
            let irradiance = [weight[0] * r * share, weight[1] * g * share, weight[2] * b * share];
            put(sample, Arrival { towards, irradiance, distance: f64::INFINITY, fading: false });
        }
    }

    pub fn usual(&self) -> [f64; 3] {
        let [r, g, b] = self.map.mean();
        [PI * r * self.scale[0], PI * g * self.scale[1], PI * b * self.scale[2]]
    }
}

/// The same radiance from everywhere.
#[derive(Debug, Clone, Copy)]
pub(super) struct AmbientSource {
    radiance: [f64; 3],
}

impl AmbientSource {
    pub fn new(light: &AmbientLight) -> Self {
        Self { radiance: light.strength.map_or([1.0; 3], |strength| strength.radiometric()) }
    }

    /// Directions in proportion to the cosine with the normal: each carries as much light as the others.
    pub fn arrivals(
        &self,
        receiver: &Receiver<'_>,
        (places, samples): (Places, u32),
        mut put: impl FnMut(u32, Arrival),
    ) {
        let share = PI / f64::from(samples);
        for sample in 0..samples {
            let [across, around] = places.at(sample);
            let cos = (1.0 - across).sqrt();
            let local = aside(DVec3::X, DVec3::Y, around) * across.sqrt() + DVec3::Z * cos;
            let towards = receiver.shaded.global(local).normalize();
            let irradiance = self.radiance.map(|channel| channel * share / cos);
            put(sample, Arrival { towards, irradiance, distance: f64::INFINITY, fading: false });
        }
    }

    pub fn usual(&self) -> [f64; 3] {
        self.radiance.map(|channel| PI * channel)
    }
}
