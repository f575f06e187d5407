//! `brood bench stress`: numerical stress test that counts non-finite values, differing bits and
//! errors.
//!
//! Random programs of all dialects, with constants up to the ends of the range, run on directions
//! half of which are grazing, polar, mirrored or equal. Every instruction set level is compared
//! with a scalar evaluator, the scalar evaluator with the definition of the steps on a part, and
//! the GPU, if there is one, with the scalar evaluator on a part. Inputs are swapped to check that
//! reciprocity is exact. Invalid meshes are rendered. Pictures in f32 are compared with f64. Random
//! painted materials are checked against their properties.

mod batch;
mod counts;
mod mesh;
mod picture;
mod program;
mod scalar;
mod style;

use std::time::Instant;

use anyhow::{Result, ensure};
use brood_brdf::{DirectionPair, Input};
use brood_eval::Level;
use brood_eval::conformance::hard_samples;
use brood_protocol::Backend;
use brood_worker::Renderer;
use clap::Args;
use rayon::prelude::*;
use serde::Serialize;

use self::batch::{Batches, SAMPLES};
use self::mesh::Meshes;
use self::picture::PictureDifferences;
use self::style::Styles;
use super::record::CommonArgs;
use crate::output;

/// Options of `brood bench stress`.
#[derive(Debug, Args)]
pub struct BenchStressArgs {
    /// Number of program x sample evaluations at each level, rounded up to whole batches
    #[arg(long, value_name = "N", default_value_t = 10_000_000)]
    evaluations: u64,
    /// Number of direction pairs to swap, with all inputs of each
    #[arg(long, value_name = "N", default_value_t = 1_000_000)]
    pairs: u64,
    /// Number of random genomes whose pictures are compared with f64
    #[arg(long, value_name = "N", default_value_t = 200)]
    pictures: u32,
    /// Number of invalid meshes to render
    #[arg(long, value_name = "N", default_value_t = 64)]
    meshes: u32,
    /// Number of random painted materials, rounded up to whole batches; 64 random points each
    #[arg(long, value_name = "N", default_value_t = 20_000)]
    styles: u64,
    #[command(flatten)]
    common: CommonArgs,
}

/// Results of all parts of the test.
#[derive(Debug, Serialize)]
struct Report {
    levels: Vec<&'static str>,
    #[serde(flatten)]
    batches: Batches,
    gpu: String,
    swapped_pairs: u64,
    swapped_inputs_differing: u64,
    #[serde(flatten)]
    meshes: Meshes,
    #[serde(flatten)]
    pictures: PictureDifferences,
    #[serde(flatten)]
    styles: Styles,
    /// Time spent on [`Report::batches`].
    evaluation_seconds: f64,
    seconds: f64,
}

/// Runs the command; returns an error if a count that must be 0 is not.
pub fn run(args: &BenchStressArgs, json: bool) -> Result<()> {
    let folder = args.common.start()?;
    let started = Instant::now();
    let gpu = Renderer::new(Backend::Gpu);
    let batches = batch::run(args.common.seed, args.evaluations, &gpu)?;
    let evaluation_seconds = started.elapsed().as_secs_f64();
    let (swapped_pairs, swapped_inputs_differing) = swap(args);
    let report = Report {
        levels: Level::available().iter().map(|l| l.name()).collect(),
        batches,
        gpu: gpu.report().adapter,
        swapped_pairs,
        swapped_inputs_differing,
        meshes: mesh::run(args.common.seed, args.meshes)?,
        pictures: picture::run(args.common.seed, args.pictures)?,
        styles: style::run(args.common.seed, args.styles)?,
        evaluation_seconds,
        seconds: started.elapsed().as_secs_f64(),
    };
    folder.add_json("stress", &report)?;
    folder.write("stress.csv", &report.pictures.table().csv())?;
    folder.write("stress.svg", &report.pictures.chart().svg())?;
    report.print(json)?;
    let must_be_zero: u64 = report.zeros().iter().map(|(_, count)| count).sum();
    ensure!(
        must_be_zero == 0,
        "{must_be_zero} values or programs broke a rule; the last fifteen counts above must be 0"
    );
    Ok(())
}

/// Checks reciprocity: swaps every pair and compares all inputs. Returns the numbers of pairs and
/// of differing inputs.
fn swap(args: &BenchStressArgs) -> (u64, u64) {
    let sets = args.pairs.div_ceil(SAMPLES as u64);
    let bar = output::bar(sets, "swapping");
    let differing = (0..sets)
        .into_par_iter()
        .map(|index| {
            let set = hard_samples(args.common.seed.wrapping_add(index), SAMPLES);
            bar.inc(1);
            (0..set.len()).map(|sample| asymmetric(set.pair(sample))).sum::<u64>()
        })
        .sum();
    bar.finish_and_clear();
    (sets * SAMPLES as u64, differing)
}

/// Number of inputs that change when the directions of a pair are swapped.
fn asymmetric((pair, uv): (DirectionPair, glam::DVec2)) -> u64 {
    let swapped = pair.swapped();
    let differs = |input: &Input| {
        input.evaluate(&pair, uv).to_bits() != input.evaluate(&swapped, uv).to_bits()
    };
    Input::symmetric().filter(differs).count() as u64
}

impl Report {
    /// Counts that must be 0, by name.
    fn zeros(&self) -> [(&'static str, u64); 15] {
        let styles = &self.styles;
        [
            ("not finite", self.batches.not_finite),
            ("negative", self.batches.negative),
            ("differing from scalar", self.batches.differing_from_scalar),
            ("scalar against the definition", self.batches.scalar_differing),
            ("differing on the GPU", self.batches.gpu_differing),
            ("inputs differing when swapped", self.swapped_inputs_differing),
            ("broken meshes: samples not finite", self.meshes.mesh_samples_not_finite),
            ("broken meshes: samples out of bounds", self.meshes.mesh_samples_out_of_bounds),
            ("styles: wrong weights", styles.weights_wrong),
            ("styles: differing hull weights", styles.hull_weights_differing),
            ("styles: colours out of the box", styles.colors_outside),
            ("styles: colours not finite", styles.colors_not_finite),
            ("styles: differing between levels", styles.colors_differing),
            ("styles: against the definition", styles.styles_differing_from_definition),
            ("styles: jumps at the terminator", styles.terminator_differing),
        ]
    }

    fn print(&self, json: bool) -> Result<()> {
        if json {
            return output::print(&(serde_json::to_string_pretty(self)? + "\n"));
        }
        let Self { batches, meshes, pictures, .. } = self;
        let mut lines = vec![
            ("levels", self.levels.join(", ")),
            ("evaluations per level", batches.evaluations_per_level.to_string()),
            ("  with constants to 65504", batches.evaluations_with_large_constants.to_string()),
            ("  a direction grazing", batches.grazing.to_string()),
            ("  a direction at the pole", batches.at_the_pole.to_string()),
            ("  antipodal in azimuth", batches.antipodal.to_string()),
            ("  wi = wo", batches.equal.to_string()),
            ("scalar checked", batches.scalar_checked.to_string()),
            ("GPU", self.gpu.clone()),
            ("  evaluations", batches.gpu_evaluations.to_string()),
            ("  both subnormal, differing", batches.gpu_subnormal_differing.to_string()),
            ("pairs swapped", self.swapped_pairs.to_string()),
            ("broken meshes", meshes.meshes.to_string()),
            ("  rejected as invalid", meshes.meshes_refused.to_string()),
            ("  sample sets", meshes.mesh_sets.to_string()),
            ("  samples", meshes.mesh_samples.to_string()),
            ("pictures against f64", pictures.pictures.to_string()),
            ("  off by over 1/255", pictures.share()),
            ("styles", self.styles.styles.to_string()),
            ("  evaluations per level", self.styles.style_evaluations.to_string()),
            ("  sums of weights", self.styles.weight_sums.to_string()),
            ("seconds", format!("{:.1}", self.seconds)),
            ("  spent on evaluations", format!("{:.1}", self.evaluation_seconds)),
        ];
        lines.extend(self.zeros().map(|(name, count)| (name, count.to_string())));
        let line = |(name, value): &(&str, String)| format!("{name:<36} {value}\n");
        output::print(&lines.iter().map(line).collect::<String>())
    }
}
