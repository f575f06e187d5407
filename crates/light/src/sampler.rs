//! Sampling of a scene's lights: directions and irradiances at a position, in the unit frame.
//!
//! Independent of meshes and occlusion: the caller rejects samples below the horizon and occluded
//! samples.

mod area;
mod distant;
mod ies;
mod mixture;
mod placement;
mod punctual;
mod sample;
#[cfg(test)]
mod tests;

use std::f64::consts::PI;

use brood_mesh::UnitFrame;
use glam::DVec3;

pub use sample::{LightSample, Receiver};

use crate::assets::LightAssets;
use crate::light::Light;
use crate::sequence::SamplePoints;
use area::{FlatSource, SphereSource};
use distant::{AmbientSource, EnvironmentSource};
use ies::IesSource;
use placement::LightPlacement;
use punctual::{PointSource, SpotSource};
use sample::brightest;

/// Sampler of one light.
#[derive(Debug)]
pub struct LightSampler {
    source: Source,
    /// Index of the light's first sample among those of all lights.
    pub first_slot: usize,
    /// Largest number of samples per position.
    pub samples: u32,
    /// Index of the light in the scene.
    index: usize,
}

#[derive(Debug)]
enum Source {
    Point(PointSource),
    Spot(SpotSource),
    /// Direction to the light, and irradiance.
    Directional(DVec3, [f64; 3]),
    Ies(IesSource),
    Sphere(SphereSource),
    Flat(FlatSource),
    Environment(EnvironmentSource),
    Ambient(AmbientSource),
    /// Light whose asset is missing.
    Dark,
}

impl LightSampler {
    /// Makes the samplers of all lights of a scene, turned by `light_deg` about the vertical axis
    /// through the centre of the mesh. A light whose asset is missing emits nothing.
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
            let source = Source::new(light, &placement, assets);
            let sampler = Self { source, first_slot, samples: light.samples(), index };
            first_slot += sampler.samples as usize;
            sampler
        };
        lights.iter().enumerate().map(sampler).collect()
    }

    /// Calls `put` with the index of each sample and the sample, if its irradiance is not 0.
    pub fn for_each_sample(&self, receiver: &Receiver, mut put: impl FnMut(u32, LightSample)) {
        let position = receiver.position;
        let draw = || (SamplePoints::new(receiver.seed, self.index), self.samples);
        let mut lit = |sample, light_sample: LightSample| {
            if light_sample.irradiance != [0.0; 3] {
                put(sample, light_sample);
            }
        };
        let light_sample = match &self.source {
            Source::Point(point) => point.at(position),
            Source::Spot(spot) => spot.at(position),
            Source::Directional(towards, irradiance) => Some(LightSample {
                towards: *towards,
                irradiance: *irradiance,
                distance: f64::INFINITY,
                fading: false,
            }),
            Source::Ies(ies) => ies.at(position),
            Source::Sphere(sphere) => return sphere.for_each_sample(receiver, draw(), lit),
            Source::Flat(flat) => return flat.for_each_sample(receiver, draw(), lit),
            Source::Environment(environment) => {
                return environment.for_each_sample(receiver, draw(), lit);
            }
            Source::Ambient(ambient) => return ambient.for_each_sample(receiver, draw(), lit),
            Source::Dark => None,
        };
        if let Some(light_sample) = light_sample {
            lit(0, light_sample);
        }
    }

    /// True for extended lights: their samples differ between positions, and their shadows are
    /// soft.
    #[must_use]
    pub fn is_soft(&self) -> bool {
        match &self.source {
            Source::Point(_) | Source::Spot(_) | Source::Directional(..) | Source::Ies(_) => false,
            Source::Sphere(_) | Source::Flat(_) | Source::Environment(_) | Source::Ambient(_) => {
                true
            }
            Source::Dark => false,
        }
    }

    /// Returns the approximate irradiance of an extended light without occlusion, in the brightest
    /// channel; 0 for other lights. Varies smoothly with position, unlike samples.
    #[must_use]
    pub fn unoccluded_irradiance(&self, position: DVec3, n: DVec3) -> f64 {
        let irradiance = match &self.source {
            Source::Sphere(sphere) => sphere.unoccluded_irradiance(position, n),
            Source::Flat(flat) => flat.unoccluded_irradiance(position, n),
            Source::Point(_) | Source::Spot(_) | Source::Directional(..) | Source::Ies(_) => 0.0,
            Source::Environment(_) | Source::Ambient(_) | Source::Dark => 0.0,
        };
        if irradiance.is_finite() { irradiance } else { 0.0 }
    }

    /// Returns the approximate maximum of the irradiance at the centre of the mesh, in the
    /// brightest channel. Differences of shading are relative to it.
    #[must_use]
    pub fn reference_irradiance(&self) -> f64 {
        let irradiance = match &self.source {
            Source::Point(point) => {
                point.at(DVec3::ZERO).map(|light_sample| light_sample.irradiance)
            }
            Source::Spot(spot) => spot.reference_irradiance(),
            Source::Directional(_, irradiance) => Some(*irradiance),
            Source::Ies(ies) => ies.reference_irradiance(),
            Source::Sphere(sphere) => Some(sphere.reference_irradiance()),
            Source::Flat(flat) => Some(flat.reference_irradiance()),
            Source::Environment(environment) => Some(environment.reference_irradiance()),
            Source::Ambient(ambient) => Some(ambient.reference_irradiance()),
            Source::Dark => None,
        };
        irradiance.map_or(0.0, brightest)
    }
}

impl Source {
    fn new(light: &Light, placement: &LightPlacement<'_>, assets: &LightAssets) -> Self {
        match light {
            Light::Point(light) => Self::Point(PointSource::new(light, placement)),
            Light::Spot(light) => Self::Spot(SpotSource::new(light, placement)),
            Light::Ies(light) => {
                IesSource::new(light, placement, assets).map_or(Self::Dark, Self::Ies)
            }
            Light::Sphere(light) => Self::Sphere(SphereSource::new(light, placement)),
            Light::Disk(light) => Self::Flat(FlatSource::disk(light, placement)),
            Light::Rectangle(light) => Self::Flat(FlatSource::rectangle(light, placement)),
            Light::Environment(light) => {
                let source = EnvironmentSource::new(light, placement, assets);
                source.map_or(Self::Dark, Self::Environment)
            }
            Light::Ambient(light) => Self::Ambient(AmbientSource::new(light)),
            Light::Directional(light) => {
                let towards = match light.direction {
                    Some(direction) => -placement.direction(direction),
                    None => placement.position(None).normalize(),
                };
                let irradiance = light.strength.map_or([PI; 3], |strength| strength.radiometric());
                Self::Directional(towards, irradiance)
            }
        }
    }
}
