//! Steering of broods: draws are chosen by features that are measured on small pictures.
//!
//! This module owns the features and the thresholds; the words belong to the genome crate. The
//! pictures are of a sphere under the default light, equal for all lineages, so that a brood is a
//! function of its request alone.

use std::sync::OnceLock;

use brood_brdf::Input;
use brood_genome::{Genome, ModelKind, Steer};
use brood_light::units::luminance;
use brood_mesh::{BuiltinMesh, Mesh};
use brood_program::{BroodRequest, Child, DrawScorer, Program, settle_scored};
use brood_scene::{SampleSet, Sampling, Scene};
use glam::DVec2;
use rayon::prelude::*;

use crate::preview::Preview;
use crate::{CanonicalEvaluator, Evaluator};

/// Side of the measured picture: highlights a few degrees wide cover a pixel.
const SIZE_PX: u32 = 40;
/// Shift of the texture between the two places that are compared for the pattern.
const SHIFT: DVec2 = DVec2::new(0.37, 0.61);
/// Largest multiple of the median luminance with which a pixel counts for the colour, so that the
/// colour is that of the body even where highlights are bright.
const BRIGHT: f64 = 2.0;
/// Relative luminance at which colours are compared.
const LUMINANCE: f64 = 0.3;
/// Direction of orange in the plane of a* and b*: 60 degrees.
const WARM: [f64; 2] = [0.5, 0.866_025_403_784_438_6];

/// Distance in a* and b* below which a colour is the same.
const SAME_COLOUR: f64 = 5.0;
/// Distance at which a kept colour, or pattern, counts for nothing, in multiples of the same.
const OTHER: f64 = 8.0;
/// Change that a direction asks for: warmth in a* and b*, gloss in powers of two, pattern as a
/// share.
const WARMER: f64 = 6.0;
const GLOSSIER: f64 = 0.2;
const PATTERNED: f64 = 0.04;
/// Difference of patterns below which a pattern is the same.
const SAME_PATTERN: f64 = 0.03;
/// Change of the gloss that `only-gloss` asks for, in either direction.
const OTHER_GLOSS: f64 = 0.05;

/// Samples of the measured picture, and the same samples elsewhere on the texture.
struct Samples {
    here: SampleSet,
    elsewhere: SampleSet,
}

fn samples() -> &'static Samples {
    static SAMPLES: OnceLock<Samples> = OnceLock::new();
    SAMPLES.get().unwrap_or_else(|| {
        // Not inside `get_or_init`, as for previews.
        let mesh = Mesh::builtin(BuiltinMesh::Sphere);
        let here = SampleSet::render(&mesh, &Scene::default(), SIZE_PX, Sampling::Fixed(1));
        let (pairs, uvs): (Vec<_>, Vec<_>) = (0..here.len()).map(|at| here.pair(at)).unzip();
        let uvs: Vec<DVec2> = uvs.into_iter().map(|uv| (uv + SHIFT).fract_gl()).collect();
        let elsewhere = SampleSet::from_pairs(&pairs, &uvs);
        SAMPLES.get_or_init(|| Samples { here, elsewhere })
    })
}

/// Features of a material by which broods are steered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Appearance {
    /// a* and b* of the body's colour at a fixed luminance.
    pub colour: [f64; 2],
    /// log2 of the mean square of the reflected light over the square of its mean: 0 if all of the
    /// object is equally bright, larger for narrower and stronger highlights.
    pub gloss: f64,
    /// Share of the reflected light that changes between two places of the texture, all directions
    /// being equal: 0 for homogeneous materials, at most 1.
    pub pattern: f64,
}

impl Appearance {
    /// Measures the appearance of a program.
    ///
    /// # Error
    /// Highlights narrower than 3 degrees can fall between two pixels and then lower the gloss.
    #[must_use]
    pub fn of(program: &Program) -> Self {
        let Samples { here, elsewhere } = samples();
        let light = reflected(program, here, here);
        let luminances: Vec<f64> = light.iter().map(|rgb| luminance(*rgb)).collect();
        let count = luminances.len().max(1) as f64;
        let mean = luminances.iter().sum::<f64>() / count;
        let square = luminances.iter().map(|y| y * y).sum::<f64>() / count;
        let gloss = if mean > 0.0 { libm::log2(square / (mean * mean)) } else { 0.0 };
        let inputs = program.inputs();
        let is_textured = inputs.contains(Input::U) || inputs.contains(Input::V);
        let pattern =
            if is_textured { pattern(&light, &reflected(program, elsewhere, here)) } else { 0.0 };
        Self { colour: body_colour(&light, &luminances), gloss, pattern }
    }

    /// Degree, from 0 to 1, to which this appearance follows a word, compared with the parent's.
    #[must_use]
    pub fn follows(&self, word: Steer, parent: &Self) -> f64 {
        // 1 from the wanted change on, half without a change.
        let towards = |change: f64, wanted: f64| (0.5 + 0.5 * change / wanted).clamp(0.0, 1.0);
        // 1 up to `same`, 0 from `OTHER` times that on.
        let kept = |change: f64, same: f64| {
            (1.0 - (change.abs() / same - 1.0) / (OTHER - 1.0)).clamp(0.0, 1.0)
        };
        let [a, b] = [0, 1].map(|at| self.colour[at] - parent.colour[at]);
        let colour = || kept((a * a + b * b).sqrt(), SAME_COLOUR);
        let warmth = a * WARM[0] + b * WARM[1];
        let gloss = self.gloss - parent.gloss;
        let pattern = self.pattern - parent.pattern;
        match word {
            Steer::KeepColour => colour(),
            Steer::OnlyGloss => {
                let changed = (gloss.abs() / OTHER_GLOSS).min(1.0);
                colour().min(kept(pattern, SAME_PATTERN)).min(changed)
            }
            Steer::Warmer => towards(warmth, WARMER),
            Steer::Cooler => towards(-warmth, WARMER),
            Steer::Rougher => towards(-gloss, GLOSSIER),
            Steer::Glossier => towards(gloss, GLOSSIER),
            Steer::MorePattern => towards(pattern, PATTERNED),
            Steer::LessPattern => towards(-pattern, PATTERNED.min(parent.pattern)),
        }
    }
}

/// Reflected light of each sample of `set` under the irradiance of `lit`.
fn reflected(program: &Program, set: &SampleSet, lit: &SampleSet) -> Vec<[f64; 3]> {
    let mut f = Vec::new();
    CanonicalEvaluator::default()
        .eval(&[program], set, &mut f)
        .expect("memory for a few thousand samples");
    let (count, irradiance) = (set.len(), lit.irradiance());
    let channel = |at: usize, channel: usize| {
        let light = f64::from(f[channel * count + at]) * f64::from(irradiance[channel][at]);
        if light.is_finite() { light.max(0.0) } else { 0.0 }
    };
    (0..count).map(|at| [0, 1, 2].map(|c| channel(at, c))).collect()
}

/// Share of the light that differs.
fn pattern(here: &[[f64; 3]], elsewhere: &[[f64; 3]]) -> f64 {
    let (mut apart, mut sum) = (0.0, 0.0);
    for (a, b) in here.as_flattened().iter().zip(elsewhere.as_flattened()) {
        apart += (a - b).abs();
        sum += a + b;
    }
    if sum > 0.0 { apart / sum } else { 0.0 }
}

/// a* and b* of the mean colour, in which bright pixels count no more than [`BRIGHT`] medians; 0
/// for black.
fn body_colour(light: &[[f64; 3]], luminances: &[f64]) -> [f64; 2] {
    let mut sorted: Vec<f64> = luminances.iter().copied().filter(|y| *y > 0.0).collect();
    sorted.sort_by(f64::total_cmp);
    let Some(median) = sorted.get(sorted.len() / 2) else { return [0.0; 2] };
    let mut sum = [0.0; 3];
    for (rgb, y) in light.iter().zip(luminances) {
        let weight = if *y > BRIGHT * median { BRIGHT * median / y } else { 1.0 };
        for (sum, channel) in sum.iter_mut().zip(rgb) {
            *sum += weight * channel;
        }
    }
    let factor = LUMINANCE / luminance(sum);
    lab(sum.map(|channel| factor * channel))
}

/// a* and b* of linear RGB with the primaries of BT.709 and the white point D65.
fn lab([r, g, b]: [f64; 3]) -> [f64; 2] {
    let x = (0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505;
    let y = luminance([r, g, b]);
    let z = (0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089;
    // The linear part near 0 of CIELAB.
    let curve = |t: f64| if t > 0.008_856 { libm::cbrt(t) } else { 7.787 * t + 16.0 / 116.0 };
    [500.0 * (curve(x) - curve(y)), 200.0 * (curve(y) - curve(z))]
}

/// Scores draws by the words of a steer, then by their previews.
struct SteerScorer<'a> {
    words: &'a [Steer],
    /// True if draws that resemble parents or siblings are drawn again.
    is_diverse: bool,
    /// True if draws are slow to measure, so that at most `MAX_REDRAWS` are made again.
    is_slow: bool,
}

/// True if new parameters of a model of the genome take milliseconds to prepare.
fn is_slow(genome: &Genome) -> bool {
    genome.layers().iter().any(|model| model.kind() == ModelKind::RoughPlastic)
}

impl DrawScorer for SteerScorer<'_> {
    type Features = (Preview, Appearance);

    const BATCH: u32 = 8;

    fn features_of_all(&self, programs: &[&Program]) -> Vec<Self::Features> {
        programs.par_iter().map(|program| self.features(program)).collect()
    }

    fn features(&self, program: &Program) -> Self::Features {
        (Preview::of(program), Appearance::of(program))
    }

    /// Returns a lower score for draws that do not follow all words, by the degree to which they
    /// do, and a still lower one for black draws.
    fn score(&self, (look, own): &Self::Features, taken: &[Self::Features]) -> f32 {
        // The parents are each listed as they are, then under the brood's constraints and colours.
        let (_, parent) = &taken[1];
        let follows = self.words.iter().map(|word| own.follows(*word, parent));
        let least = follows.fold(1.0, f64::min);
        if look.is_black() {
            return least as f32 - 2.0;
        }
        // Scores below 0 allow `MAX_UNWANTED_REDRAWS`.
        let (none, all) = if self.is_slow { (0.0, 0.5) } else { (-1.0, 0.0) };
        if least < 1.0 {
            return none + (all - none) * least as f32;
        }
        if !self.is_diverse {
            return 1.0;
        }
        all + (1.0 - all) * look.newness(taken.iter().map(|(look, _)| look))
    }
}

/// Breeds the children of a request so that each follows the words, compared with the first parent,
/// as far as the redraws allow; a pure function of its arguments. With `is_diverse`, children that
/// follow them also differ from each other and the parents.
///
/// # Panics
/// If the variation has no parent.
#[must_use]
pub fn steered_brood(request: &BroodRequest<'_>, words: &[Steer], is_diverse: bool) -> Vec<Child> {
    let mut parents = request.variation.parents();
    let is_slow = parents.any(is_slow);
    assert!(request.variation.parents().next().is_some(), "steering compares with a parent");
    let scorer = SteerScorer { words, is_diverse, is_slow };
    let first = |slot| {
        let draw = request.draw(slot);
        let features = scorer.features(draw.program());
        (draw, features)
    };
    settle_scored(request, (0..request.count).into_par_iter().map(first).collect(), &scorer)
}

#[cfg(test)]
#[path = "steering_tests.rs"]
mod tests;
