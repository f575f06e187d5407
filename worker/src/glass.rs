//! Inputs of clear bodies: the colours that mirrored and refracted rays of each sample see.

use brood_brdf::Input;
use brood_genome::Effect;
use brood_program::Program;
use brood_scene::{Raster, SampleSet, WayOut};

use crate::error::RenderError;
use crate::renderer::Renderer;
use crate::shot::Shot;
use crate::sight::{Followed, SeenColor, Sight};

/// Length of a way that sees nothing: nothing passes.
const ENDLESS: f32 = 65504.0;

impl Renderer {
    /// Returns the points with what a clear style sees on them. What it does not read is not
    /// traced.
    pub(crate) fn with_glass(
        &self,
        shot: &Shot<'_>,
        (points, raster): (&SampleSet, Raster),
        style: &Program,
    ) -> Result<SampleSet, RenderError> {
        let lowered = style.painted(points.lighting().expect("the samples are points"));
        let reads_ways = lowered.reads_ways();
        let index = style.glass().and_then(Effect::index_of_refraction);
        let index = index.expect("a clear style has an index");
        // Where nothing enters a thin body, it shows its mirror instead.
        let is_thin = reads_ways && index < 1.0;
        let mirrored = lowered.reads_mirrored() || is_thin;
        let followed = Followed { mirrored, ways: reads_ways, index };
        let sight = self.sight(shot, (points, raster), followed)?;
        let own = match style.is_by_brdf() {
            true => self.seen_along(shot, (shot.view.stage.part(), style), &sight.rays)?,
            false => self.seen_on(&sight.own, style, shot.frame.backend)?,
        };
        Ok(points.with_columns(columns(points.len(), (&sight, is_thin), &own)))
    }
}

/// Returns the columns of the inputs of clear bodies. `own` are the colours of the body itself.
fn columns(
    samples: usize,
    (sight, is_thin): (&Sight, bool),
    own: &[SeenColor],
) -> Vec<(Input, Vec<f32>)> {
    let color = |ray: usize| own[ray].or(sight.colors[ray]);
    let mut columns = Vec::new();
    let mut push = |inputs, length, seen: &[(SeenColor, f32)]| {
        columns.extend(channels(inputs, seen.iter().map(|(color, _)| *color)));
        let lengths = seen.iter().map(|(color, length)| color.map_or(ENDLESS, |_| *length));
        columns.push((length, lengths.collect()));
    };
    let mirrored = |sample: usize| match sight.mirrored.get(sample) {
        Some(length) => (color(sample), *length as f32),
        None => (None, ENDLESS),
    };
    if !sight.mirrored.is_empty() {
        let inputs = [Input::MirroredRed, Input::MirroredGreen, Input::MirroredBlue];
        let seen: Vec<(SeenColor, f32)> = (0..samples).map(mirrored).collect();
        push(inputs, Input::MirroredLength, &seen);
    }
    if sight.ways.is_empty() {
        return columns;
    }
    let inputs = [
        [Input::Way0Red, Input::Way0Green, Input::Way0Blue],
        [Input::Way1Red, Input::Way1Green, Input::Way1Blue],
    ];
    for (at, (inputs, length)) in
        inputs.into_iter().zip([Input::Way0Length, Input::Way1Length]).enumerate()
    {
        let way = |sample: usize| -> (SeenColor, f32) {
            match (sight.ways[sample][at], sight.numbers[sample][at]) {
                (Some(way), Some(ray)) => (color(ray), way.length as f32),
                _ if at == 0 && is_thin => mirrored(sample),
                _ => (None, ENDLESS),
            }
        };
        let ways: Vec<(SeenColor, f32)> = (0..samples).map(way).collect();
        push(inputs, length, &ways);
    }
    let share = |ways: &[Option<WayOut>; 2]| ways[0].map_or(1.0, |way| way.share as f32);
    columns.push((Input::Way0Share, sight.ways.iter().map(share).collect()));
    columns
}

/// Returns the columns of the channels of colours; where nothing is seen they are 0.
fn channels(
    inputs: [Input; 3],
    colors: impl Iterator<Item = SeenColor> + Clone,
) -> [(Input, Vec<f32>); 3] {
    [0, 1, 2].map(|channel| {
        let value = |color: SeenColor| color.map_or(0.0, |color| color[channel]);
        (inputs[channel], colors.clone().map(value).collect())
    })
}

#[cfg(test)]
#[path = "glass_tests.rs"]
mod tests;
