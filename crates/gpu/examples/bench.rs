//! Benchmark of the GPU evaluator on the available adapter: exactness by guard, layouts, pipelines
//! of single programs, cached inputs, fused errors, tiles, and the CPU for comparison. Prints a
//! Markdown report. On a software adapter all workloads are much smaller, and the figures do not
//! represent hardware.
//!
//! `cargo run -p brood-gpu --example bench [-- part of the adapter's name]`

use std::error::Error;
use std::time::{Duration, Instant};

use brood_eval::{
    CanonicalEvaluator, Evaluator, FitnessEvaluator, FitnessPopulation, FitnessTarget, Loss,
    conformance,
};
use brood_genome::{BirthKey, Dialect, Variation};
use brood_gpu::{
    BatchTiming, Contraction, GpuEvaluator, GpuOptions, GpuPopulation, Guard, InterpreterLayout,
    OwnPipelinePolicy,
};
use brood_program::Program;
use brood_scene::SampleSet;

type Outcome<T> = Result<T, Box<dyn Error>>;

/// Each figure is the least of this many repeats, or of those within `LIMIT`.
const REPEATS: usize = 15;
const LIMIT: Duration = Duration::from_millis(1500);

/// Size of the workloads.
#[derive(Clone, Copy)]
struct Scale {
    /// Samples of a set in measurements that do not vary sizes.
    samples: usize,
    /// Programs of a brood.
    brood: u32,
    /// Programs of a population.
    population: u32,
    /// Sides of pictures.
    sizes_px: [usize; 2],
}

impl Scale {
    const HARDWARE: Self =
        Self { samples: 1 << 16, brood: 20, population: 2000, sizes_px: [128, 256] };
    const SOFTWARE: Self = Self { samples: 1 << 13, brood: 10, population: 40, sizes_px: [64, 96] };
}

fn main() -> Outcome<()> {
    let options = GpuOptions { adapter: std::env::args().nth(1), ..GpuOptions::default() };
    let started = Instant::now();
    let gpu = GpuEvaluator::new(&options)?;
    let opened_ms = ms(started.elapsed().as_secs_f64());
    let report = gpu.adapter();
    println!("# {} ({}, {})\n", report.name, report.backend, report.driver);
    println!("- software: {}; bit-exact: {}", report.is_software, report.exact);
    println!("- subnormal results become zero: {}", report.flushes_subnormals);
    println!("- timestamps: {}", report.has_timestamps);
    println!("- opened, probed and timed in {opened_ms:.0} ms");
    println!("- in use: {}, {}", report.guard.name(), report.shape.name());
    for (shape, guard, seconds) in &report.timed {
        println!("- timed at start: {}, {}: {:.3} ms", shape.name(), guard.name(), ms(*seconds));
    }
    let scale = if report.is_software { Scale::SOFTWARE } else { Scale::HARDWARE };
    guards(&options, scale)?;
    layouts(&options, scale)?;
    processor(&gpu, scale)?;
    own_pipelines(&options, scale)?;
    kept_inputs(&gpu, scale)?;
    fitness(&gpu, scale)?;
    tiles(&gpu, scale)?;
    Ok(())
}

/// Measures exactness and cost of each guard.
fn guards(options: &GpuOptions, scale: Scale) -> Outcome<()> {
    let Scale { samples, brood: count, .. } = scale;
    println!("\n## Guards against contraction: {count} programs, {samples} samples\n");
    println!("| guard | bit-exact | device ms | ratio | probe |\n|---|---|---|---|---|");
    let (programs, set) = (brood(count), conformance::hard_samples(1, samples));
    let mut plain_s = None;
    for guard in Guard::ALL {
        let options = GpuOptions { contraction: Contraction::Only(guard), ..options.clone() };
        let gpu = match GpuEvaluator::new(&options) {
            Ok(gpu) => gpu,
            Err(error) => {
                println!("| {} | | | | {error} |", guard.name());
                continue;
            }
        };
        let (timing, _) = best(&gpu, &programs, &set)?;
        let ratio = timing.device_s / *plain_s.get_or_insert(timing.device_s);
        let report = gpu.adapter();
        let detail = &report.guards[0].detail;
        let device_ms = ms(timing.device_s);
        println!(
            "| {} | {} | {device_ms:.3} | {ratio:.3} | {detail} |",
            guard.name(),
            report.exact
        );
    }
    Ok(())
}

/// Measures the cost of each layout of the interpreter.
fn layouts(options: &GpuOptions, scale: Scale) -> Outcome<()> {
    let Scale { samples, brood: count, .. } = scale;
    println!("\n## Layouts of the interpreter: {count} programs, {samples} samples\n");
    println!("| layout | bit-exact | device ms | open ms |\n|---|---|---|---|");
    let (programs, set) = (brood(count), conformance::hard_samples(1, samples));
    for shape in InterpreterLayout::ALL {
        let started = Instant::now();
        let options = GpuOptions { shape: Some(shape), ..options.clone() };
        let gpu = GpuEvaluator::new(&options)?;
        let open_ms = ms(started.elapsed().as_secs_f64());
        let (timing, _) = best(&gpu, &programs, &set)?;
        let (exact, device_ms) = (gpu.adapter().exact, ms(timing.device_s));
        println!("| {} | {exact} | {device_ms:.3} | {open_ms:.0} |", shape.name());
    }
    Ok(())
}

/// Compares with the CPU, over sizes.
fn processor(gpu: &GpuEvaluator, scale: Scale) -> Outcome<()> {
    println!("\n## Against the processor (all threads; results back in memory)\n");
    println!("| programs | samples | CPU ms | GPU wall ms | GPU device ms | CPU / GPU wall |");
    println!("|---|---|---|---|---|---|");
    let cpu = CanonicalEvaluator::default();
    let [small, large] = scale.sizes_px;
    let workloads = [(1, small), (1, large), (scale.brood, small), (scale.brood, large)];
    for (count, size_px) in workloads {
        let programs = brood(count);
        let set = conformance::hard_samples(2, size_px * size_px);
        let (timing, wall_s) = best(gpu, &programs, &set)?;
        let cpu_s = best_wall(&cpu, &programs, &set)?;
        println!(
            "| {count} | {} | {:.3} | {:.3} | {:.3} | {:.2} |",
            set.len(),
            ms(cpu_s),
            ms(wall_s),
            ms(timing.device_s),
            cpu_s / wall_s
        );
    }
    Ok(())
}

/// Compares the interpreter with straight-line code, and counts the evaluations after which the
/// latter pays off.
fn own_pipelines(options: &GpuOptions, scale: Scale) -> Outcome<()> {
    println!("\n## A pipeline of a program's own\n");
    println!("| steps | samples | interpreted ms | own ms | made in ms | pays after |");
    println!("|---|---|---|---|---|---|");
    let never = GpuOptions { own_pipelines: OwnPipelinePolicy::Never, ..options.clone() };
    let always = GpuOptions { own_pipelines: OwnPipelinePolicy::Always, ..options.clone() };
    let (never, always) = (GpuEvaluator::new(&never)?, GpuEvaluator::new(&always)?);
    let [small, large] = scale.sizes_px;
    for (slot, size_px) in [(1, small), (2, small), (3, large), (4, large)] {
        let programs = [child(slot)];
        let set = conformance::hard_samples(3, size_px * size_px);
        let (interpreted, _) = best(&never, &programs, &set)?;
        // Warms up first, so that one-time costs do not count as those of the pipeline.
        best(&always, &[child(100), child(101)], &set)?;
        let batch = [&programs[0]];
        let mut out = Vec::new();
        let started = Instant::now();
        always.eval(&batch, &set, &mut out)?;
        let made_s = started.elapsed().as_secs_f64() - interpreted.device_s;
        let (own, _) = best(&always, &programs, &set)?;
        if !own.own_pipeline {
            println!("| {} | {} | | refused | | |", programs[0].operations(), set.len());
            continue;
        }
        let saved_s = interpreted.device_s - own.device_s;
        let pays = if saved_s > 0.0 {
            format!("{:.0} evaluations", made_s / saved_s)
        } else {
            "never".to_owned()
        };
        println!(
            "| {} | {} | {:.3} | {:.3} | {:.1} | {pays} |",
            programs[0].operations(),
            set.len(),
            ms(interpreted.device_s),
            ms(own.device_s),
            ms(made_s)
        );
    }
    Ok(())
}

/// Compares batches over the same set with batches over a new set each.
fn kept_inputs(gpu: &GpuEvaluator, scale: Scale) -> Outcome<()> {
    println!("\n## Inputs kept on the device: 1 program\n");
    println!("| samples | new set, wall ms | bytes sent | same set, wall ms | bytes sent |");
    println!("|---|---|---|---|---|");
    let programs = brood(1);
    let batch: Vec<&Program> = programs.iter().collect();
    for size_px in scale.sizes_px {
        let (mut new_s, mut sent) = (f64::INFINITY, 0);
        let mut out = Vec::new();
        let mut set = conformance::hard_samples(4, size_px * size_px);
        for seed in 0..5 {
            set = conformance::hard_samples(seed, size_px * size_px);
            // Computes the inputs, which happens at first use and is not measured here.
            CanonicalEvaluator::default().eval(&batch, &set, &mut out)?;
            let started = Instant::now();
            sent = gpu.eval_timed(&batch, &set, &mut out)?.uploaded_bytes;
            new_s = new_s.min(started.elapsed().as_secs_f64());
        }
        let (timing, same_s) = best(gpu, &programs, &set)?;
        println!(
            "| {} | {:.3} | {sent} | {:.3} | {} |",
            set.len(),
            ms(new_s),
            ms(same_s),
            timing.uploaded_bytes
        );
    }
    Ok(())
}

/// Compares sums of errors on the device with reflectances read back, and measures early ends at a
/// bound that one program in ten stays within.
fn fitness(gpu: &GpuEvaluator, scale: Scale) -> Outcome<()> {
    let programs = brood(scale.population);
    let batch: Vec<&Program> = programs.iter().collect();
    let set = conformance::hard_samples(6, 4096);
    println!("\n## Errors of {} programs, {} samples\n", programs.len(), set.len());
    println!("| way | wall ms | device ms | bytes read | programs a second |");
    println!("|---|---|---|---|---|");
    let row = |value: f32| vec![value; set.len()];
    let (values, weights) = (row(0.4), row(1.0));
    let target = FitnessTarget::new(&set, [&values; 3], [&weights; 3], Loss::Logarithmic, 1)?;
    let mut sums = gpu.sums(&batch, &target)?;
    sums.sort_by(f64::total_cmp);
    let print = |way: &str, wall_s: f64, timing: BatchTiming| {
        println!(
            "| {way} | {:.3} | {:.3} | {} | {:.0} |",
            ms(wall_s),
            ms(timing.device_s),
            timing.read_bytes,
            batch.len() as f64 / wall_s
        );
    };
    let (timing, wall_s) = best(gpu, &programs, &set)?;
    print("reflectances read back, no errors yet", wall_s, timing);
    let all: Vec<usize> = (0..batch.len()).collect();
    let bounds =
        [("errors summed", f64::INFINITY), ("ending at the best tenth", sums[sums.len() / 10])];
    for (way, bound) in bounds {
        let (mut least_s, mut least) = (f64::INFINITY, BatchTiming::default());
        for _ in 0..5 {
            let mut population = GpuPopulation::new(gpu, &batch, &target);
            let started = Instant::now();
            population.extend(&all, 0..target.blocks(), bound)?;
            let wall_s = started.elapsed().as_secs_f64();
            if wall_s < least_s {
                (least_s, least) = (wall_s, population.timing());
            }
        }
        print(way, least_s, least);
    }
    let started = Instant::now();
    CanonicalEvaluator::default().sums(&batch, &target)?;
    let wall_s = started.elapsed().as_secs_f64();
    let rate = batch.len() as f64 / wall_s;
    println!("| the CPU, all threads, errors summed | {:.3} | | | {rate:.0} |", ms(wall_s));
    Ok(())
}

/// Measures the length of submissions when the work does not fit one.
fn tiles(gpu: &GpuEvaluator, scale: Scale) -> Outcome<()> {
    let programs = brood(scale.population / 5);
    let set = conformance::hard_samples(5, 4 * scale.samples);
    println!("\n## Submissions: {} programs, {} samples\n", programs.len(), set.len());
    println!("| batch | submissions | longest ms | device ms | by timestamps |");
    println!("|---|---|---|---|---|");
    let batch: Vec<&Program> = programs.iter().collect();
    let mut out = Vec::new();
    for number in 1..=3 {
        let timing = gpu.eval_timed(&batch, &set, &mut out)?;
        let (longest_ms, device_ms) = (ms(timing.longest_s), ms(timing.device_s));
        let BatchTiming { submissions, has_timestamps, .. } = timing;
        println!(
            "| {number} | {submissions} | {longest_ms:.1} | {device_ms:.1} | {has_timestamps} |"
        );
    }
    Ok(())
}

fn brood(count: u32) -> Vec<Program> {
    (0..count).map(child).collect()
}

fn child(slot: u32) -> Program {
    let random = Variation::random(Dialect::default());
    Program::lower(&random.birth(BirthKey { seed: 23, slot, attempt: 0 }))
}

/// Returns the least device time, with the cost of that batch, and the least wall time; the first
/// batches are not counted.
fn best(gpu: &GpuEvaluator, programs: &[Program], set: &SampleSet) -> Outcome<(BatchTiming, f64)> {
    let batch: Vec<&Program> = programs.iter().collect();
    let mut out = Vec::new();
    let begun = Instant::now();
    for _ in 0..3 {
        gpu.eval(&batch, set, &mut out)?;
        if begun.elapsed() > LIMIT {
            break;
        }
    }
    let mut least = BatchTiming { device_s: f64::INFINITY, ..BatchTiming::default() };
    let mut wall_s = f64::INFINITY;
    let begun = Instant::now();
    for _ in 0..REPEATS {
        if wall_s.is_finite() && begun.elapsed() > LIMIT {
            break;
        }
        let started = Instant::now();
        let timing = gpu.eval_timed(&batch, set, &mut out)?;
        wall_s = wall_s.min(started.elapsed().as_secs_f64());
        if timing.device_s < least.device_s {
            least = timing;
        }
    }
    Ok((least, wall_s))
}

fn best_wall(cpu: &CanonicalEvaluator, programs: &[Program], set: &SampleSet) -> Outcome<f64> {
    let batch: Vec<&Program> = programs.iter().collect();
    let mut out = Vec::new();
    cpu.eval(&batch, set, &mut out)?;
    let mut wall_s = f64::INFINITY;
    let begun = Instant::now();
    for _ in 0..REPEATS {
        if wall_s.is_finite() && begun.elapsed() > LIMIT {
            break;
        }
        let started = Instant::now();
        cpu.eval(&batch, set, &mut out)?;
        wall_s = wall_s.min(started.elapsed().as_secs_f64());
    }
    Ok(wall_s)
}

fn ms(seconds: f64) -> f64 {
    1e3 * seconds
}
