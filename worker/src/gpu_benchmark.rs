//! Benchmark of CPU against GPU at the start of a worker. It measures one small picture and one
//! brood, and derives the smallest batch for which the GPU is worth the transfers.

use std::time::{Duration, Instant};

use brood_eval::{EvalError, Evaluator};
use brood_genome::{BirthKey, Dialect, Variation};
use brood_mesh::{BuiltinMesh, Mesh};
use brood_program::Program;
use brood_scene::{SampleSet, Scene};

/// Required speed-up of the GPU: measurements on a shared machine vary.
const MARGIN: f64 = 1.2;
/// Time limit for one evaluator on one workload, including warm-up. All four take less than two
/// seconds.
const TIME_LIMIT: Duration = Duration::from_millis(450);
/// Batches before the measurement: drivers compile shaders, buffers grow, submission timing adapts.
const WARM_UP: u32 = 3;
const REPEATS: u32 = 9;

/// Times of one workload.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Times {
    /// Scalar operations times samples.
    pub(crate) work: u64,
    pub(crate) cpu_s: f64,
    pub(crate) gpu_s: f64,
}

/// Times of both workloads.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GpuBenchmark {
    /// One program at 128 x 128.
    pub(crate) small: Times,
    /// Twenty programs at 256 x 256.
    pub(crate) brood: Times,
}

impl GpuBenchmark {
    /// Measures both workloads. The times include the transfer of results to host memory.
    pub(crate) fn measure(cpu: &dyn Evaluator, gpu: &dyn Evaluator) -> Result<Self, EvalError> {
        let random = Variation::random(Dialect::default());
        let birth = |slot| random.birth(BirthKey { seed: 1, slot, attempt: 0 });
        let programs: Vec<Program> = (0..20).map(|slot| Program::lower(&birth(slot))).collect();
        let mesh = Mesh::builtin(BuiltinMesh::Sphere);
        let times = |programs: &[Program], size_px| -> Result<Times, EvalError> {
            let set = SampleSet::render(&mesh, &Scene::default(), size_px, 1);
            let programs: Vec<&Program> = programs.iter().collect();
            Ok(Times {
                work: batch_operations(&programs, &set),
                cpu_s: fastest_s(cpu, &programs, &set)?,
                gpu_s: fastest_s(gpu, &programs, &set)?,
            })
        };
        Ok(Self { small: times(&programs[..1], 128)?, brood: times(&programs, 256)? })
    }

    /// Returns the smallest batch, in operations, for which the GPU is faster by the margin, or
    /// `None` if it is not even for a brood. Times are interpolated linearly between the two
    /// workloads.
    pub(crate) fn gpu_threshold(&self) -> Option<u64> {
        let gain = |times: &Times| times.cpu_s - MARGIN * times.gpu_s;
        let (small, brood) = (gain(&self.small), gain(&self.brood));
        if brood <= 0.0 {
            return None;
        }
        if small > 0.0 {
            return Some(0);
        }
        let fraction = -small / (brood - small);
        let extra = self.brood.work.saturating_sub(self.small.work) as f64 * fraction;
        Some(self.small.work.saturating_add(extra as u64))
    }

    /// Returns the measured times as text for the report.
    pub(crate) fn describe(&self, adapter: &str) -> String {
        let ms = |seconds: f64| format!("{:.2} ms", 1e3 * seconds);
        let pair =
            |times: &Times| format!("CPU {}, {adapter} {}", ms(times.cpu_s), ms(times.gpu_s));
        format!("measured on a brood: {}; on one picture: {}", pair(&self.brood), pair(&self.small))
    }
}

/// Returns the number of scalar operations of a batch: operations times samples.
pub(crate) fn batch_operations(programs: &[&Program], set: &SampleSet) -> u64 {
    let operations: u64 = programs.iter().map(|program| program.steps().len() as u64).sum();
    operations.saturating_mul(set.len() as u64)
}

fn fastest_s(
    evaluator: &dyn Evaluator,
    programs: &[&Program],
    set: &SampleSet,
) -> Result<f64, EvalError> {
    let mut out = Vec::new();
    let first = Instant::now();
    for _ in 0..WARM_UP {
        evaluator.eval(programs, set, &mut out)?;
        if first.elapsed() > TIME_LIMIT / 2 {
            break;
        }
    }
    let mut fastest_s = f64::INFINITY;
    for _ in 0..REPEATS {
        let started = Instant::now();
        evaluator.eval(programs, set, &mut out)?;
        fastest_s = fastest_s.min(started.elapsed().as_secs_f64());
        if first.elapsed() > TIME_LIMIT {
            break;
        }
    }
    Ok(fastest_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use brood_eval::CanonicalEvaluator;

    fn benchmark(small: (f64, f64), brood: (f64, f64)) -> GpuBenchmark {
        let times = |work, (cpu_s, gpu_s)| Times { work, cpu_s, gpu_s };
        GpuBenchmark { small: times(100, small), brood: times(1100, brood) }
    }

    #[test]
    fn gpu_is_not_used_when_not_clearly_faster_for_brood() {
        assert_eq!(benchmark((1.0, 0.1), (10.0, 10.0)).gpu_threshold(), None);
        assert_eq!(benchmark((1.0, 0.1), (10.0, 9.0)).gpu_threshold(), None);
    }

    #[test]
    fn gpu_gets_every_batch_when_faster_for_one_picture() {
        assert_eq!(benchmark((1.0, 0.1), (10.0, 1.0)).gpu_threshold(), Some(0));
    }

    #[test]
    fn small_batches_stay_on_cpu_when_transfer_costs_more() {
        // Gains are 0.2 - 1.2 * 1 = -1 and 7 - 1.2 * 5 = 1, so the threshold is half-way.
        let least = benchmark((0.2, 1.0), (7.0, 5.0)).gpu_threshold().unwrap();
        assert!((599..=601).contains(&least), "{least}");
    }

    #[test]
    fn benchmark_measures_finite_times() {
        let cpu = CanonicalEvaluator::default();
        let started = Instant::now();
        let benchmark = GpuBenchmark::measure(&cpu, &cpu).unwrap();
        println!("{} in {:?}", benchmark.describe("itself"), started.elapsed());
        assert!(benchmark.brood.work > 50 * benchmark.small.work / 4);
        assert!(benchmark.brood.cpu_s.is_finite() && benchmark.small.gpu_s.is_finite());
    }
}
