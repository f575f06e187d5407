//! The lights of a scene in the unit frame of the mesh, and what arrives from them at a place.
//!
//! Owns the way from a light's description to directions and irradiances. Knows neither meshes nor what lies in between:
//! whether a light is behind the surface or behind an obstacle is the caller's to find out.

mod area;
mod beam;
mod distant;
mod mixture;
mod photometric;
mod placing;
#[cfg(test)]
mod tests;

use std::f64::consts::PI;

use glam::DVec3;

use self::area::{FlatSource, SphereSource};
use self::beam::{PointSource, SpotSource};
use self::distant::{AmbientSource, EnvironmentSource};
use self::photometric::IesSource;
use self::placing::Placing;
use super::frame::ShadedPoint;
use super::sequence::Places;
use super::view::UnitFrame;
use crate::{Light, LightAssets, Scene};

/// What arrives at a place by one sample of a light.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arrival {
    /// Unit direction to where it comes from.
    pub towards: DVec3,
    /// Irradiance at normal incidence, this sample's share of it.
    pub irradiance: [f64; 3],
    /// How far away that is, in the unit frame; infinite for distant lights.
    pub distance: f64,
    /// Whether it is on its way to nothing: there is no edge where it ends.
    pub fading: bool,
}

/// Who asks a light.
#[derive(Debug, Clone, Copy)]
pub(super) struct Receiver<'a> {
    /// In the unit frame.
    pub place: DVec3,
    /// The surface there.
    pub shaded: &'a ShadedPoint,
    /// What samples are drawn by.
    pub seed: u64,
}

/// A light, ready to be asked.
#[derive(Debug)]
pub(super) struct Lamp {
    source: Source,
    /// Number of its first sample among those of all lights.
    pub first_slot: usize,
    /// Samples that it makes at each place at most.
    pub samples: u32,
    /// Which light of the scene it is.
    number: usize,
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
    /// Gives nothing: what it refers to is not there.
    Dark,
}

impl Lamp {
    /// All lights of a scene, at the scene's position on the light circle.
    pub fn all(scene: &Scene, assets: &LightAssets, frame: &UnitFrame) -> Vec<Self> {
        let placing = Placing::new(scene, frame);
        let mut first_slot = 0;
        let lamp = |(number, light): (usize, &Light)| {
            let source = Source::new(light, &placing, assets);
            let lamp = Self { source, first_slot, samples: light.samples(), number };
            first_slot += lamp.samples as usize;
            lamp
        };
        scene.lights.iter().enumerate().map(lamp).collect()
    }

    /// Calls back with each sample from which anything arrives, and its number.
    pub fn arrivals(&self, receiver: &Receiver<'_>, mut put: impl FnMut(u32, Arrival)) {
        let place = receiver.place;
        let draw = || (Places::new(receiver.seed, self.number), self.samples);
        let mut lit = |sample, arrival: Arrival| {
            if arrival.irradiance != [0.0; 3] {
                put(sample, arrival);
            }
        };
        let arrival = match &self.source {
            Source::Point(point) => point.at(place),
            Source::Spot(spot) => spot.at(place),
            Source::Directional(towards, irradiance) => Some(Arrival {
                towards: *towards,
                irradiance: *irradiance,
                distance: f64::INFINITY,
                fading: false,
            }),
            Source::Ies(ies) => ies.at(place),
            Source::Sphere(sphere) => return sphere.arrivals(receiver, draw(), lit),
            Source::Flat(flat) => return flat.arrivals(receiver, draw(), lit),
            Source::Environment(environment) => return environment.arrivals(receiver, draw(), lit),
            Source::Ambient(ambient) => return ambient.arrivals(receiver, draw(), lit),
            Source::Dark => None,
        };
        if let Some(arrival) = arrival {
            lit(0, arrival);
        }
    }

    /// Whether it comes from many directions at once, so that samples of it differ from place to place and its shadows are
    /// soft.
    pub fn is_soft(&self) -> bool {
        match &self.source {
            Source::Point(_) | Source::Spot(_) | Source::Directional(..) | Source::Ies(_) => false,
            Source::Sphere(_) | Source::Flat(_) | Source::Environment(_) | Source::Ambient(_) => {
                true
            }
            Source::Dark => false,
        }
    }

    /// About what a soft light gives to a surface, over the channels: smooth, where samples are not, and without shadows.
    pub fn outline(&self, place: DVec3, n: DVec3) -> f64 {
        let outline = match &self.source {
            Source::Sphere(sphere) => sphere.outline(place, n),
            Source::Flat(flat) => flat.outline(place, n),
            Source::Point(_) | Source::Spot(_) | Source::Directional(..) | Source::Ies(_) => 0.0,
            Source::Environment(_) | Source::Ambient(_) | Source::Dark => 0.0,
        };
        if outline.is_finite() { outline } else { 0.0 }
    }

    /// About the most that it gives to a place at the centre of the mesh, over the channels: what is bright is measured by
    /// it.
    pub fn usual(&self) -> f64 {
        let irradiance = match &self.source {
            Source::Point(point) => point.at(DVec3::ZERO).map(|arrival| arrival.irradiance),
            Source::Spot(spot) => spot.usual(),
            Source::Directional(_, irradiance) => Some(*irradiance),
            Source::Ies(ies) => ies.usual(),
            Source::Sphere(sphere) => Some(sphere.usual()),
            Source::Flat(flat) => Some(flat.usual()),
            Source::Environment(environment) => Some(environment.usual()),
            Source::Ambient(ambient) => Some(ambient.usual()),
            Source::Dark => None,
        };
        irradiance.map_or(0.0, brightest)
    }
}

fn brightest([r, g, b]: [f64; 3]) -> f64 {
    r.max(g).max(b)
}

impl Source {
    fn new(light: &Light, placing: &Placing<'_>, assets: &LightAssets) -> Self {
        match light {
            Light::Point(light) => Self::Point(PointSource::new(light, placing)),
            Light::Spot(light) => Self::Spot(SpotSource::new(light, placing)),
            Light::Ies(light) => {
                IesSource::new(light, placing, assets).map_or(Self::Dark, Self::Ies)
            }
            Light::Sphere(light) => Self::Sphere(SphereSource::new(light, placing)),
            Light::Disk(light) => Self::Flat(FlatSource::disk(light, placing)),
            Light::Rectangle(light) => Self::Flat(FlatSource::rectangle(light, placing)),
            Light::Environment(light) => {
                let source = EnvironmentSource::new(light, placing, assets);
                source.map_or(Self::Dark, Self::Environment)
            }
            Light::Ambient(light) => Self::Ambient(AmbientSource::new(light)),
            Light::Directional(light) => {
                let towards = match light.direction {
                    Some(direction) => -placing.direction(direction),
                    None => placing.position(None).normalize(),
                };
                let irradiance = light.strength.map_or([PI; 3], |strength| strength.radiometric());
                Self::Directional(towards, irradiance)
            }
        }
    }
}
