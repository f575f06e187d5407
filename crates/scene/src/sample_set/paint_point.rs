//! Values that painted materials read at a point, buffers of them, and their columns.

use std::ops::Range;

use brood_brdf::{Input, LightInput, Lighting};
use glam::DVec3;
use rayon::prelude::*;

use super::seen_point::{Footprint, SeenPoint};

/// Quantities of one light, in the order of [`LightInput::ALL`].
type LightValues = [f32; LightInput::ALL.len()];

/// Values that painted materials read at a surface point.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PaintPoint {
    /// n.e, depth, and the lengths of their gradients.
    pub own: [f32; 4],
    pub lights: [LightValues; Input::LIGHTS],
    /// Number of lights of the scene.
    pub light_count: usize,
    /// Direction to the first light, in the local frame.
    pub wi: DVec3,
    /// Change of the texture position over the point's part of a pixel.
    pub footprint: Footprint,
    /// Where the point is.
    pub seen: SeenPoint,
    /// True if buffers keep `seen`.
    pub keeps_seen: bool,
}

/// Buffer of points as painted materials read them, as a structure of arrays.
#[derive(Debug, Default)]
pub(super) struct PaintBuffer {
    pub own: Vec<[f32; 4]>,
    /// All lights of a point, point after point.
    lights: Vec<LightValues>,
    pub footprints: Vec<Footprint>,
    /// Empty if they are not kept.
    pub seen: Vec<SeenPoint>,
}

/// Inputs of [`PaintPoint::own`].
const OWN: [Input; 4] =
    [Input::NormalDotEye, Input::Depth, Input::NormalDotEyeStep, Input::DepthStep];

impl PaintBuffer {
    pub fn push(&mut self, point: &PaintPoint) {
        self.own.push(point.own);
        self.lights.extend_from_slice(&point.lights[..point.light_count]);
        self.footprints.push(point.footprint);
        if point.keeps_seen {
            self.seen.push(point.seen);
        }
    }

    pub fn extend(&mut self, other: &Self, range: Range<usize>) {
        let lights = other.lights_per_point();
        self.own.extend_from_slice(&other.own[range.clone()]);
        self.lights.extend_from_slice(&other.lights[range.start * lights..range.end * lights]);
        self.footprints.extend_from_slice(&other.footprints[range.clone()]);
        if !other.seen.is_empty() {
            self.seen.extend_from_slice(&other.seen[range]);
        }
    }

    pub fn append(&mut self, other: &mut Self) {
        self.own.append(&mut other.own);
        self.lights.append(&mut other.lights);
        self.footprints.append(&mut other.footprints);
        self.seen.append(&mut other.seen);
    }

    pub fn is_empty(&self) -> bool {
        self.own.is_empty()
    }

    fn lights_per_point(&self) -> usize {
        self.lights.len() / self.own.len().max(1)
    }

    /// Returns the columns of the inputs of painted materials.
    pub fn columns(&self, lighting: Lighting) -> Vec<(Input, Vec<f32>)> {
        let own = OWN.into_par_iter().enumerate();
        let own =
            own.map(|(place, input)| (input, self.own.iter().map(|own| own[place]).collect()));
        let quantities = LightInput::ALL.len();
        let lights = (0..lighting.lights * quantities).into_par_iter().map(|at| {
            let (light, quantity) = (at / quantities, LightInput::ALL[at % quantities]);
            let of_light = self.lights.iter().skip(light).step_by(lighting.lights);
            let values = of_light.map(|values| values[quantity as usize]).collect();
            (Input::of_light(light, quantity), values)
        });
        own.chain(lights).collect()
    }
}
