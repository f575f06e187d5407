//! Stress test of painted materials: random styles on random points in up to eight lights, and on
//! points of invalid meshes. Weights of palettes are found by probes: the light effect with one
//! white colour among black ones.

use anyhow::Result;
use brood_brdf::{Input, LightInput, Lighting};
use brood_eval::conformance::{
    color_bounds, first_difference, lit_points, weight_probes, wild_style,
};
use brood_eval::{CanonicalEvaluator, Evaluator, Level};
use brood_genome::Genome;
use brood_program::Program;
use brood_scene::SampleSet;
use rayon::prelude::*;
use serde::Serialize;

use super::counts::counts;
use super::mesh::points;
use crate::output;

/// Number of styles of a batch.
const STYLES: u64 = 32;
/// Number of random points of a batch.
const POINTS: usize = 64;
/// Largest error of the sum of a palette's weights.
const WEIGHT_ERROR: f32 = 2.4e-7;
/// Rounding of colours beyond the box of the control colours.
const BOX_ERROR: f32 = 4e-7;

/// Lights of the random points, batch after batch.
const LIGHTINGS: [Lighting; 4] = [
    Lighting { lights: 1, has_shadows: true },
    Lighting { lights: 2, has_shadows: false },
    Lighting { lights: 3, has_shadows: true },
    Lighting { lights: 8, has_shadows: true },
];

counts! {
    /// Counts over all styles.
    #[derive(Debug, Clone, Copy, Default, Serialize)]
    pub struct Styles {
        pub styles: u64,
        /// Styles times points, random and of meshes, at each level.
        pub style_evaluations: u64,
        /// Sums of weights: of each channel of each style at each point.
        pub weight_sums: u64,
        /// Sums further than 2.4e-7 from 1, and negative weights.
        pub weights_wrong: u64,
        /// Weights that differ between channels although the style is a `hull`.
        pub hull_weights_differing: u64,
        /// Values outside of the box of the control colours.
        pub colors_outside: u64,
        pub colors_not_finite: u64,
        /// Values of any level whose bits differ from those of another level.
        pub colors_differing: u64,
        /// Styles that differ from the definition of the steps, of one in 32.
        pub styles_differing_from_definition: u64,
        /// Values that depend on visibility where no light reaches the point: a jump of shadows at
        /// the terminator.
        pub terminator_differing: u64,
    }
}

/// Runs random styles, rounded up to whole batches.
pub fn run(seed: u64, styles: u64) -> Result<Styles> {
    let batches = styles.div_ceil(STYLES);
    let bar = output::bar(batches, "styles");
    let one = |index: u64| {
        let found = batch(seed, index);
        bar.inc(1);
        found
    };
    let found =
        (0..batches).into_par_iter().map(one).try_reduce(Styles::default, |a, b| Ok(a.plus(b)));
    bar.finish_and_clear();
    found
}

fn batch(seed: u64, index: u64) -> Result<Styles> {
    let first = seed.wrapping_add(index).wrapping_mul(STYLES);
    let genomes: Vec<Genome> = (0..STYLES).map(|k| wild_style(first.wrapping_add(k))).collect();
    let lighting = LIGHTINGS[index as usize % LIGHTINGS.len()];
    let random = lit_points(first, POINTS, lighting);
    let mut found = Styles { styles: STYLES, ..Styles::default() };
    found.colors(&genomes, &random)?;
    if let Some(points) = points(seed, index) {
        found.colors(&genomes, &points)?;
    }
    let unreached = unreached(first, lighting);
    for genome in &genomes {
        found.weights(genome, &random)?;
        found.terminator(genome, &unreached)?;
    }
    Ok(found)
}

/// Points that no light reaches, with random visibility and with none occluded.
fn unreached(seed: u64, lighting: Lighting) -> [SampleSet; 2] {
    [false, true].map(|is_visible| {
        let set = lit_points(seed, POINTS, lighting);
        let columns = (0..lighting.lights).flat_map(|light| {
            let cosine = Input::of_light(light, LightInput::Cos);
            let below = set.input(cosine).iter().map(|cosine| -cosine.abs()).collect();
            let visibility = Input::of_light(light, LightInput::Visibility);
            let visible = match is_visible {
                true => vec![1.0; POINTS],
                false => set.input(visibility).to_vec(),
            };
            [(cosine, below), (visibility, visible)]
        });
        let columns: Vec<_> = columns.collect();
        set.with_lights(lighting, columns)
    })
}

fn evaluate(level: Level, styles: &[Program], set: &SampleSet) -> Result<Vec<f32>> {
    let batch: Vec<&Program> = styles.iter().collect();
    let mut colors = Vec::new();
    CanonicalEvaluator::with_level(level).eval(&batch, set, &mut colors)?;
    Ok(colors)
}

fn count(values: impl Iterator<Item = bool>) -> u64 {
    values.filter(|is_wrong| *is_wrong).count() as u64
}

fn differing(a: &[f32], b: &[f32]) -> u64 {
    count(a.iter().zip(b).map(|(a, b)| a.to_bits() != b.to_bits()))
}

impl Styles {
    /// Evaluates styles at every level.
    fn colors(&mut self, genomes: &[Genome], set: &SampleSet) -> Result<()> {
        let styles: Vec<Program> = genomes.iter().map(Program::lower).collect();
        self.style_evaluations += STYLES * set.len() as u64;
        let mut first: Option<Vec<f32>> = None;
        for level in Level::available() {
            let colors = evaluate(level, &styles, set)?;
            match &first {
                Some(first) => self.colors_differing += differing(first, &colors),
                None => first = Some(colors),
            }
        }
        let colors = first.unwrap_or_default();
        self.colors_not_finite += count(colors.iter().map(|value| !value.is_finite()));
        let of_style = colors.chunks_exact(3 * set.len().max(1));
        for (genome, colors) in genomes.iter().zip(of_style) {
            let bounds = color_bounds(genome);
            for ((low, high), values) in bounds.iter().zip(colors.chunks_exact(set.len())) {
                let inside = (low - BOX_ERROR).max(0.0)..=(high + BOX_ERROR).min(1.0);
                self.colors_outside += count(values.iter().map(|value| !inside.contains(value)));
            }
        }
        let lighting = set.lighting().unwrap_or(LIGHTINGS[0]);
        let own = &colors[..(3 * set.len()).min(colors.len())];
        let differs = first_difference(&styles[0].painted(lighting), set, own).is_some();
        self.styles_differing_from_definition += u64::from(differs);
        Ok(())
    }

    /// Checks the weights of a palette.
    fn weights(&mut self, genome: &Genome, set: &SampleSet) -> Result<()> {
        let probes = weight_probes(genome);
        let weights = evaluate(Level::best(), &probes, set)?;
        let values = 3 * set.len();
        let is_wrong = (0..values).map(|at| {
            let of_value = weights.iter().skip(at).step_by(values);
            let sum: f32 = of_value.clone().sum();
            let error = (sum - 1.0).abs();
            // Written so that NaN counts as wrong.
            !(error <= WEIGHT_ERROR && of_value.clone().all(|weight| *weight >= 0.0))
        });
        self.weights_wrong += count(is_wrong);
        self.weight_sums += values as u64;
        if genome.effects()[0].word("property") == "hull" {
            for weights in weights.chunks_exact(values) {
                let (red, others) = weights.split_at(set.len());
                let (green, blue) = others.split_at(set.len());
                self.hull_weights_differing += differing(red, green) + differing(red, blue);
            }
        }
        Ok(())
    }

    /// Compares the light effect at points that no light reaches.
    fn terminator(&mut self, genome: &Genome, [shadowed, visible]: &[SampleSet; 2]) -> Result<()> {
        let probes = weight_probes(genome);
        let of_set = |set| evaluate(Level::best(), &probes[..1], set);
        self.terminator_differing += differing(&of_set(shadowed)?, &of_set(visible)?);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_find_nothing_wrong() {
        let found = run(11, 10 * STYLES).unwrap();
        assert_eq!(found.weight_sums, 10 * STYLES * 3 * POINTS as u64);
        assert!(found.style_evaluations > 2 * found.weight_sums / 3, "points of meshes: {found:?}");
        let wrong = [
            found.weights_wrong,
            found.hull_weights_differing,
            found.colors_outside,
            found.colors_not_finite,
            found.colors_differing,
            found.styles_differing_from_definition,
            found.terminator_differing,
        ];
        assert_eq!(wrong, [0; 7], "{found:?}");
    }
}
