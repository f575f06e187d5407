//! Light from all around: a picture of an environment, or the same from everywhere.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::mixture::{Mixture, by_cosine};
use super::placing::Placing;
use super::{Arrival, Receiver};
use crate::angle::rotation_y_deg;
use crate::sample_set::sequence::Places;
use crate::{AmbientLight, EnvironmentLight, EnvironmentMap, LightAssets};

/// Share of an environment's directions that are drawn by its own light.
const BY_LIGHT: f64 = 0.5;

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

    /// Half of the directions in proportion to luminance, half as materials may reflect; each weighs what all of them weigh
    /// that could have drawn it.
    ///
    /// # Source
    /// Veach and Guibas 1995, *Optimally Combining Sampling Techniques*: the balance heuristic.
    pub fn arrivals(
        &self,
        receiver: &Receiver<'_>,
        (places, samples): (Places, u32),
        mut put: impl FnMut(u32, Arrival),
    ) {
        let shaded = receiver.shaded;
        let mixture = Mixture::new(shaded.wo);
        for sample in 0..samples {
            let [across, down] = places.at(sample);
            let (towards, radiance) = if across < BY_LIGHT {
                let Some(drawn) = self.map.draw([across / BY_LIGHT, down]) else { continue };
                ((self.turn * drawn.0).normalize(), drawn.1)
            } else {
                let local = mixture.draw([(across - BY_LIGHT) / (1.0 - BY_LIGHT), down]);
                let towards = shaded.global(local).normalize();
                (towards, self.map.radiance((self.turn.transpose() * towards).normalize()))
            };
            let by_material = mixture.density(shaded.local(towards));
            let density = BY_LIGHT * self.map.density(radiance) + (1.0 - BY_LIGHT) * by_material;
            let weight = 1.0 / (f64::from(samples) * density);
            let [r, g, b] = self.scale;
            let irradiance =
                [radiance[0] * r * weight, radiance[1] * g * weight, radiance[2] * b * weight];
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

    /// Directions as materials may reflect. Their weights are scaled so that together they give what a place without
    /// obstacles has, pi: matt materials have no noise. Where all are below the horizon, as a single one may be, one stands
    /// for them that is drawn by the cosine.
    pub fn arrivals(
        &self,
        receiver: &Receiver<'_>,
        (places, samples): (Places, u32),
        mut put: impl FnMut(u32, Arrival),
    ) {
        let mixture = Mixture::new(receiver.shaded.wo);
        let mut drawn: Vec<(u32, DVec3, f64)> = (0..samples)
            .map(|sample| (sample, mixture.draw(places.at(sample))))
            .filter(|(_, local)| local.z > 0.0)
            .map(|(sample, local)| (sample, local, 1.0 / mixture.density(local)))
            .collect();
        if drawn.is_empty() {
            drawn.push((0, by_cosine(places.at(0)), 1.0));
        }
        let all: f64 = drawn.iter().map(|(_, local, weight)| local.z * weight).sum();
        for (sample, local, weight) in drawn {
            let towards = receiver.shaded.global(local).normalize();
            let irradiance = self.radiance.map(|channel| channel * (PI * weight / all));
            put(sample, Arrival { towards, irradiance, distance: f64::INFINITY, fading: false });
        }
    }

    pub fn usual(&self) -> [f64; 3] {
        self.radiance.map(|channel| PI * channel)
    }
}
