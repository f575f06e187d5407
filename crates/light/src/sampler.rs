//! Sampling of a scene's lights: directions and irradiances at a position, in the unit frame.
//!
//! Independent of meshes and occlusion: the caller rejects samples below the horizon and occluded
//! samples.

pub(crate) mod mixture;
pub(crate) mod placement;
pub(crate) mod sample;
#[cfg(test)]
mod tests;

use brood_mesh::UnitFrame;
use glam::DVec3;

pub use sample::{CentralLight, LightSample, Receiver};

use crate::assets::LightAssets;
use crate::environment::PrefilteredEnvironment;
use crate::light::{Draw, Light, LightSource};
use placement::LightPlacement;
use sample::brightest;

/// Sampler of one light.
#[derive(Debug)]
pub struct LightSampler {
    /// `None` if the light's asset is missing.
    source: Option<LightSource>,
    /// Index of the light's first sample among those of all lights.
    pub first_slot: usize,
    /// Largest number of samples per position.
    pub samples: u32,
    /// False if its light passes through objects.
    pub casts_shadows: bool,
    /// True for environments, whose light may also be prefiltered.
    pub is_environment: bool,
    /// Index of the light in the scene.
    index: usize,
    /// Centre of the subject in the unit frame.
    pivot: DVec3,
}

impl LightSampler {
    /// Makes the samplers of all lights of a scene, turned by `light_deg` about the vertical axis
    /// through the subject's centre. A light whose asset is missing emits nothing.
    ///
    /// # Units
    /// Degrees, from +z towards +x.
    #[must_use]
    pub fn all(
        lights: &[Light],
        light_deg: f64,
        assets: &LightAssets,
        frame: &UnitFrame,
    ) -> Vec<Self> {
        let placement = LightPlacement::new(light_deg, frame);
        let mut first_slot = 0;
        let sampler = |(index, light): (usize, &Light)| {
            let source = light.source(&placement, assets);
            let (samples, casts_shadows) = (light.samples(), light.casts_shadows());
            let pivot = frame.pivot();
            let is_environment = matches!(light, Light::Environment(_));
            let sampler =
                Self { source, first_slot, samples, casts_shadows, is_environment, index, pivot };
            first_slot += sampler.samples as usize;
            sampler
        };
        lights.iter().enumerate().map(sampler).collect()
    }

    /// Calls `put` with the index of each sample and the sample, if its irradiance is not 0.
    pub fn for_each_sample(&self, receiver: &Receiver, mut put: impl FnMut(u32, LightSample)) {
        let Some(source) = &self.source else { return };
        let draw = Draw { light: self.index, samples: self.samples };
        source.for_each_sample(receiver, &draw, |sample, light_sample| {
            if light_sample.irradiance != [0.0; 3] {
                put(sample, light_sample);
            }
        });
    }

    /// Returns an environment as prefiltered radiance; `None` for other lights and for a missing
    /// asset.
    #[must_use]
    pub fn prefiltered(&self) -> Option<PrefilteredEnvironment> {
        self.source.as_ref()?.prefiltered()
    }

    /// True for extended lights: their samples differ between positions, and their shadows are
    /// soft.
    #[must_use]
    pub fn is_soft(&self) -> bool {
        self.source.as_ref().is_some_and(LightSource::is_soft)
    }

    /// Returns the mean direction to an environment, for [`LightSampler::central`].
    #[must_use]
    pub fn mean_direction(&self) -> Option<DVec3> {
        self.source.as_ref()?.mean_direction()
    }

    /// Returns the light at a position as if all of it came from its middle; `None` if it does not
    /// reach the position. `mean` is that of [`LightSampler::mean_direction`].
    #[must_use]
    pub fn central(&self, position: DVec3, mean: Option<DVec3>) -> Option<CentralLight> {
        self.source.as_ref()?.central(position, mean)
    }

    /// Returns the approximate irradiance of an extended light without occlusion, in the brightest
    /// channel; 0 for other lights. Varies smoothly with position, unlike samples.
    #[must_use]
    pub fn unoccluded_irradiance(&self, position: DVec3, n: DVec3) -> f64 {
        let source = self.source.as_ref();
        let irradiance = source.map_or(0.0, |source| source.unoccluded_irradiance(position, n));
        if irradiance.is_finite() { irradiance } else { 0.0 }
    }

    /// Returns the approximate maximum of the irradiance at the subject's centre, in the brightest
    /// channel. Differences of shading are relative to it.
    #[must_use]
    pub fn reference_irradiance(&self) -> f64 {
        let source = self.source.as_ref();
        source.and_then(|source| source.reference_irradiance(self.pivot)).map_or(0.0, brightest)
    }
}
