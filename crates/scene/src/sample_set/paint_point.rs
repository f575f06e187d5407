//! Values that painted materials read at a point, and their columns.

use brood_brdf::{Input, LightInput, Lighting};
use glam::DVec3;

use super::seen_point::{Footprint, SeenPoint};

/// Quantities of one light, in the order of [`LightInput::ALL`].
type LightValues = [f32; LightInput::ALL.len()];

/// Values that painted materials read at a surface point.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PaintPoint {
    /// n.e, depth, and the lengths of their gradients.
    pub own: [f32; 4],
    pub lights: [LightValues; Input::LIGHTS],
    /// Direction to the first light, in the local frame.
    pub wi: DVec3,
    /// Change of the texture position over the point's part of a pixel.
    pub footprint: Footprint,
    /// Where the point is.
    pub seen: SeenPoint,
}

/// Inputs of [`PaintPoint::own`].
const OWN: [Input; 4] =
    [Input::NormalDotEye, Input::Depth, Input::NormalDotEyeStep, Input::DepthStep];

/// Columns of the inputs of painted materials.
pub(super) fn columns(
    points: &[PaintPoint],
    lighting: Lighting,
) -> impl Iterator<Item = (Input, Vec<f32>)> {
    let own = OWN.into_iter().enumerate();
    let own = own.map(|(place, input)| (input, points.iter().map(|p| p.own[place]).collect()));
    let lights = (0..lighting.lights).flat_map(move |light| {
        LightInput::ALL.into_iter().map(move |quantity| {
            let value = |point: &PaintPoint| point.lights[light][quantity as usize];
            (Input::of_light(light, quantity), points.iter().map(value).collect())
        })
    });
    own.chain(lights)
}
