//! Numerical stress: what could go wrong is counted, not assumed away.
//!
//! Random programs of all dialects, half of them with constants up to +-65504, run on directions of which half graze;
//! every level of vector instructions is held against the scalar meaning of the program, and the GPU, where there is
//! one, on a part. Inputs are swapped to see that reciprocity is exact. Pictures in f32 are held against f64.

use std::time::Instant;

use anyhow::{Context, Result, ensure};
use brood_brdf::{DirectionPair, Input};
use brood_eval::conformance::{first_difference, hard_samples, wild_program};
use brood_eval::{CanonicalEvaluator, Evaluator, Level, ReferenceEvaluator, develop, shade};
use brood_genome::{BirthKey, Dialect, Variation};
use brood_program::Program;
use brood_protocol::Backend;
use brood_scene::{BuiltinMesh, Exposure, Mesh, SampleSet, Scene};
use brood_worker::Renderer;
use clap::Args;
use rayon::prelude::*;
use serde::Serialize;

use crate::logging;

/// Programs and samples of one batch.
const PROGRAMS: u64 = 64;
const SAMPLES: usize = 4096;
/// One batch in this many also goes to the GPU.
const GPU_SHARE: u64 = 16;
/// Side of the pictures that are held against f64.
const PICTURE_PX: u32 = 128;

/// Options of `brood bench stress`.
#[derive(Debug, Args)]
pub struct BenchStressArgs {
    /// Program x sample evaluations at each level, rounded up to whole batches
    #[arg(long, value_name = "N", default_value_t = 10_000_000)]
    evaluations: u64,
    /// Direction pairs that are swapped, all inputs each
    #[arg(long, value_name = "N", default_value_t = 1_000_000)]
    pairs: u64,
    /// Random genomes whose pictures are held against f64
    #[arg(long, value_name = "N", default_value_t = 200)]
    pictures: u32,
    /// Seed of the first batch; the others count on from it
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

#[derive(Debug, Default, Serialize)]
struct Report {
    levels: Vec<&'static str>,
    evaluations_per_level: u64,
    not_finite: u64,
    negative: u64,
    differing_from_scalar: u64,
    gpu: String,
    gpu_evaluations: u64,
    gpu_differing: u64,
    swapped_pairs: u64,
    swapped_inputs_differing: u64,
    pictures: u32,
    pictures_off_by_more_than_1_255: u32,
    seconds: f64,
}

/// Runs the command; fails where anything that must be 0 is not.
pub fn run(args: &BenchStressArgs, json: bool) -> Result<()> {
    logging::start_offline();
    let started = Instant::now();
    let mut report = Report {
        levels: Level::available().iter().map(|l| l.name()).collect(),
        ..Report::default()
    };
    let gpu = Renderer::new(Backend::Gpu);
    report.gpu = gpu.report().adapter;
    for batch in 0..args.evaluations.div_ceil(PROGRAMS * SAMPLES as u64) {
        let seed = args.seed.wrapping_add(batch);
        let programs: Vec<Program> = (0..PROGRAMS)
            .into_par_iter()
            .map(|slot| wild_program(seed.wrapping_mul(PROGRAMS).wrapping_add(slot)))
            .collect();
        let set = hard_samples(seed, SAMPLES);
        let on_gpu = gpu.worker_report().gpu && batch % GPU_SHARE == 0;
        report.add(&programs, &set, on_gpu.then_some(&gpu))?;
    }
    report.swap(args);
    report.pictures(args)?;
    report.seconds = started.elapsed().as_secs_f64();
    report.print(json)?;
    let must_be_zero = [
        report.not_finite,
        report.negative,
        report.differing_from_scalar,
        report.gpu_differing,
        report.swapped_inputs_differing,
    ];
    ensure!(must_be_zero == [0; 5], "what must be 0 is not: see the figures above");
    Ok(())
}

impl Report {
    /// One batch at every level.
    fn add(&mut self, programs: &[Program], set: &SampleSet, gpu: Option<&Renderer>) -> Result<()> {
        let batch: Vec<&Program> = programs.iter().collect();
        let of_program = 3 * set.len();
        let mut first = Vec::new();
        for (index, level) in Level::available().into_iter().enumerate() {
            let mut out = Vec::new();
            CanonicalEvaluator::with_level(level).eval(&batch, set, &mut out)?;
            if index > 0 {
                self.differing_from_scalar += differing(&first, &out);
                continue;
            }
            let count = |f: &dyn Fn(&f32) -> bool| out.iter().filter(|v| f(v)).count() as u64;
            self.not_finite += count(&|v| !v.is_finite());
            self.negative += count(&|v| *v < 0.0);
            self.differing_from_scalar += programs
                .par_iter()
                .zip(out.par_chunks(of_program))
                .filter(|(program, f)| first_difference(program, set, f).is_some())
                .count() as u64;
            self.evaluations_per_level += (batch.len() * set.len()) as u64;
            first = out;
        }
        if let Some(gpu) = gpu {
            let out = gpu.reflectance(Backend::Gpu, &batch, set).context("evaluate on the GPU")?;
            self.gpu_differing += differing(&first, &out);
            self.gpu_evaluations += (batch.len() * set.len()) as u64;
        }
        Ok(())
    }

    /// Reciprocity: every input of every pair, both ways round.
    fn swap(&mut self, args: &BenchStressArgs) {
        let sets = args.pairs.div_ceil(SAMPLES as u64);
        self.swapped_pairs = sets * SAMPLES as u64;
        self.swapped_inputs_differing = (0..sets)
            .into_par_iter()
            .map(|index| {
                let set = hard_samples(args.seed.wrapping_add(index), SAMPLES);
                (0..set.len()).map(|sample| asymmetric(set.pair(sample))).sum::<u64>()
            })
            .sum();
    }

    /// Pictures of random genomes, f32 against f64 at one exposure.
    fn pictures(&mut self, args: &BenchStressArgs) -> Result<()> {
        let mesh = Mesh::builtin(BuiltinMesh::Sphere);
        let set = SampleSet::render(&mesh, &Scene::default(), PICTURE_PX, 1);
        let random = Variation::random(Dialect::default());
        self.pictures = args.pictures;
        for slot in 0..args.pictures {
            let key = BirthKey { seed: args.seed, slot, attempt: 0 };
            let program = Program::lower(&random.birth(key));
            let (mut canonical, mut reference) = (Vec::new(), Vec::new());
            CanonicalEvaluator::default().eval(&[&program], &set, &mut canonical)?;
            ReferenceEvaluator.eval(&[&program], &set, &mut reference)?;
            let canonical = develop(&shade(&set, &canonical), Exposure::Auto);
            let exposure = Exposure::Ev(canonical.exposure_ev);
            let reference = develop(&shade(&set, &reference), exposure);
            let off = canonical.rgba.iter().zip(&reference.rgba).any(|(a, b)| a.abs_diff(*b) > 1);
            self.pictures_off_by_more_than_1_255 += u32::from(off);
        }
        Ok(())
    }

    fn print(&self, json: bool) -> Result<()> {
        if json {
            println!("{}", serde_json::to_string_pretty(self)?);
            return Ok(());
        }
        println!("levels                {}", self.levels.join(", "));
        println!("evaluations a level   {}", self.evaluations_per_level);
        println!("not finite            {}", self.not_finite);
        println!("negative              {}", self.negative);
        println!("differing from scalar {}", self.differing_from_scalar);
        println!("GPU                   {}", self.gpu);
        println!("  evaluations         {}", self.gpu_evaluations);
        println!("  differing           {}", self.gpu_differing);
        println!("pairs swapped         {}", self.swapped_pairs);
        println!("  inputs differing    {}", self.swapped_inputs_differing);
        let share = 100.0 * f64::from(self.pictures_off_by_more_than_1_255)
            / f64::from(self.pictures.max(1));
        println!("pictures against f64  {}", self.pictures);
        println!("  off by over 1/255   {} ({share:.1} %)", self.pictures_off_by_more_than_1_255);
        println!("seconds               {:.1}", self.seconds);
        Ok(())
    }
}

/// Values whose bits differ.
fn differing(a: &[f32], b: &[f32]) -> u64 {
    let values = a.iter().zip(b).filter(|(a, b)| a.to_bits() != b.to_bits()).count() as u64;
    values + a.len().abs_diff(b.len()) as u64
}

/// Inputs that change when the directions of a pair are swapped.
fn asymmetric((pair, uv): (DirectionPair, glam::DVec2)) -> u64 {
    let swapped = pair.swapped();
    let differs = |input: &Input| {
        input.evaluate(&pair, uv).to_bits() != input.evaluate(&swapped, uv).to_bits()
    };
    Input::ALL.iter().filter(|input| differs(input)).count() as u64
}
