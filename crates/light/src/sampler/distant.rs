//! Distant light from all directions: environment picture and ambient light.

use std::f64::consts::PI;
use std::sync::Arc;

use brood_mesh::angle::rotation_y_deg;
use glam::{DMat3, DVec3};

use super::mixture::{Mixture, by_cosine};
use super::placement::LightPlacement;
use super::sample::{LightSample, Receiver};
use crate::assets::LightAssets;
use crate::environment::EnvironmentMap;
use crate::light::{AmbientLight, EnvironmentLight};
use crate::sequence::SamplePoints;

/// Share of an environment's samples that are drawn in proportion to its luminance.
const BY_LIGHT: f64 = 0.5;

/// Environment picture, rotated as the scene defines.
#[derive(Debug, Clone)]
pub(super) struct EnvironmentSource {
    map: Arc<EnvironmentMap>,
    /// Rotation from the picture's directions to the unit frame.
    rotation: DMat3,
    scale: [f64; 3],
}

impl EnvironmentSource {
    /// Returns `None` if the picture is missing.
    pub fn new(
        light: &EnvironmentLight,
        placement: &LightPlacement<'_>,
        assets: &LightAssets,
    ) -> Option<Self> {
        let map = assets.environment(&light.image)?.clone();
        let own = rotation_y_deg(light.rotation_deg);
        let rotation = DMat3::from_cols(
            placement.direction((own * DVec3::X).to_array()),
            placement.direction((own * DVec3::Y).to_array()),
            placement.direction((own * DVec3::Z).to_array()),
        );
        Some(Self { map, rotation, scale: light.scale })
    }

    /// Multiple importance sampling: half of the directions are drawn in proportion to luminance,
    /// half from the material lobes of [`Mixture`]. Weights use the combined density.
    ///
    /// # Source
    /// Veach and Guibas 1995, *Optimally Combining Sampling Techniques*: the balance heuristic.
    pub fn for_each_sample(
        &self,
        receiver: &Receiver,
        (points, samples): (SamplePoints, u32),
        mut put: impl FnMut(u32, LightSample),
    ) {
        let frame = &receiver.frame;
        let mixture = Mixture::new(receiver.wo);
        for sample in 0..samples {
            let [across, down] = points.at(sample);
            let (towards, radiance) = if across < BY_LIGHT {
                let Some(drawn) = self.map.draw([across / BY_LIGHT, down]) else { continue };
                ((self.rotation * drawn.0).normalize(), drawn.1)
            } else {
                let local = mixture.draw([(across - BY_LIGHT) / (1.0 - BY_LIGHT), down]);
                let towards = frame.global(local).normalize();
                (towards, self.map.radiance((self.rotation.transpose() * towards).normalize()))
            };
            let by_material = mixture.density(frame.local(towards));
            let density = BY_LIGHT * self.map.density(radiance) + (1.0 - BY_LIGHT) * by_material;
            let weight = 1.0 / (f64::from(samples) * density);
            let [r, g, b] = self.scale;
            let irradiance =
                [radiance[0] * r * weight, radiance[1] * g * weight, radiance[2] * b * weight];
            put(
                sample,
                LightSample { towards, irradiance, distance: f64::INFINITY, fading: false },
            );
        }
    }

    pub fn reference_irradiance(&self) -> [f64; 3] {
        let [r, g, b] = self.map.mean();
        [PI * r * self.scale[0], PI * g * self.scale[1], PI * b * self.scale[2]]
    }
}

/// Ambient light: equal radiance from all directions.
#[derive(Debug, Clone, Copy)]
pub(super) struct AmbientSource {
    radiance: [f64; 3],
}

impl AmbientSource {
    pub fn new(light: &AmbientLight) -> Self {
        Self { radiance: light.strength.map_or([1.0; 3], |strength| strength.radiometric()) }
    }

    /// Samples directions from the material lobes of [`Mixture`]. Weights are normalised to the
    /// exact sum of irradiance times cosine, pi times radiance, so diffuse materials have no noise.
    /// If all directions are below the horizon, one cosine-distributed direction replaces them.
    pub fn for_each_sample(
        &self,
        receiver: &Receiver,
        (points, samples): (SamplePoints, u32),
        mut put: impl FnMut(u32, LightSample),
    ) {
        let mixture = Mixture::new(receiver.wo);
        let mut drawn: Vec<(u32, DVec3, f64)> = (0..samples)
            .map(|sample| (sample, mixture.draw(points.at(sample))))
            .filter(|(_, local)| local.z > 0.0)
            .map(|(sample, local)| (sample, local, 1.0 / mixture.density(local)))
            .collect();
        if drawn.is_empty() {
            drawn.push((0, by_cosine(points.at(0)), 1.0));
        }
        let sum: f64 = drawn.iter().map(|(_, local, weight)| local.z * weight).sum();
        for (sample, local, weight) in drawn {
            let towards = receiver.frame.global(local).normalize();
            let irradiance = self.radiance.map(|channel| channel * (PI * weight / sum));
            put(
                sample,
                LightSample { towards, irradiance, distance: f64::INFINITY, fading: false },
            );
        }
    }

    pub fn reference_irradiance(&self) -> [f64; 3] {
        self.radiance.map(|channel| PI * channel)
    }
}
