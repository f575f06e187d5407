//! CPU against GPU, measured when a worker starts: one small picture and one brood, and from both how much work a batch
//! must be for the GPU to be worth the way there and back.

use std::time::{Duration, Instant};

use brood_eval::{EvalError, Evaluator};
use brood_genome::{BirthKey, Dialect, Variation};
use brood_program::Program;
use brood_scene::{BuiltinMesh, Mesh, SampleSet, Scene};

/// A GPU must be this much faster than the CPU to be preferred: on a shared machine measurements vary.
const MARGIN: f64 = 1.2;
/// Time for one evaluator on one workload, warming up included; four of them are under two seconds.
const PATIENCE: Duration = Duration::from_millis(450);
/// Batches that are not counted: drivers compile, buffers grow, the pace of submissions is learnt.
const WARM_UP: u32 = 3;
const REPEATS: u32 = 9;

/// What one workload takes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Times {
    /// Scalar operations times samples.
    pub(crate) work: u64,
    pub(crate) cpu_s: f64,
    pub(crate) gpu_s: f64,
}

/// Both workloads.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Comparison {
    /// One program at 128 x 128.
    pub(crate) small: Times,
    /// Twenty programs at 256 x 256.
    pub(crate) brood: Times,
}

impl Comparison {
    /// Measures both; results are those that evaluators hand out, back in memory.
    pub(crate) fn measure(cpu: &dyn Evaluator, gpu: &dyn Evaluator) -> Result<Self, EvalError> {
        let random = Variation::random(Dialect::default());
        let birth = |slot| random.birth(BirthKey { seed: 1, slot, attempt: 0 });
        let programs: Vec<Program> = (0..20).map(|slot| Program::lower(&birth(slot))).collect();
        let mesh = Mesh::builtin(BuiltinMesh::Sphere);
        let times = |programs: &[Program], size_px| -> Result<Times, EvalError> {
            let set = SampleSet::render(&mesh, &Scene::default(), size_px, 1);
            let programs: Vec<&Program> = programs.iter().collect();
            Ok(Times {
                work: work(&programs, &set),
                cpu_s: least_s(cpu, &programs, &set)?,
                gpu_s: least_s(gpu, &programs, &set)?,
            })
        };
        Ok(Self { small: times(&programs[..1], 128)?, brood: times(&programs, 256)? })
    }

    /// The least work of a batch that the GPU is faster with, by the margin; `None` where it is not even with a brood.
    /// Between the two workloads times are taken to lie on a line.
    pub(crate) fn least_work(&self) -> Option<u64> {
        let gain = |times: &Times| times.cpu_s - MARGIN * times.gpu_s;
        let (small, brood) = (gain(&self.small), gain(&self.brood));
        if brood <= 0.0 {
            return None;
        }
        if small > 0.0 {
            return Some(0);
        }
        let way = -small / (brood - small);
        let further = self.brood.work.saturating_sub(self.small.work) as f64 * way;
        Some(self.small.work.saturating_add(further as u64))
    }

    /// For a report.
    pub(crate) fn describe(&self, adapter: &str) -> String {
        let ms = |seconds: f64| format!("{:.2} ms", 1e3 * seconds);
        let pair =
            |times: &Times| format!("CPU {}, {adapter} {}", ms(times.cpu_s), ms(times.gpu_s));
        format!("measured on a brood: {}; on one picture: {}", pair(&self.brood), pair(&self.small))
    }
}

/// Scalar operations that a batch executes.
pub(crate) fn work(programs: &[&Program], set: &SampleSet) -> u64 {
    let operations: u64 = programs.iter().map(|program| program.steps().len() as u64).sum();
    operations.saturating_mul(set.len() as u64)
}

fn least_s(
    evaluator: &dyn Evaluator,
    programs: &[&Program],
    set: &SampleSet,
) -> Result<f64, EvalError> {
    let mut out = Vec::new();
    let begun = Instant::now();
    for _ in 0..WARM_UP {
        evaluator.eval(programs, set, &mut out)?;
        if begun.elapsed() > PATIENCE / 2 {
            break;
        }
    }
    let mut least_s = f64::INFINITY;
    for _ in 0..REPEATS {
        let started = Instant::now();
        evaluator.eval(programs, set, &mut out)?;
        least_s = least_s.min(started.elapsed().as_secs_f64());
        if begun.elapsed() > PATIENCE {
            break;
        }
    }
    Ok(least_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use brood_eval::CanonicalEvaluator;

    fn comparison(small: (f64, f64), brood: (f64, f64)) -> Comparison {
        let times = |work, (cpu_s, gpu_s)| Times { work, cpu_s, gpu_s };
        Comparison { small: times(100, small), brood: times(1100, brood) }
    }

    #[test]
    fn gpu_gets_nothing_when_it_is_not_clearly_faster_with_a_brood() {
        assert_eq!(comparison((1.0, 0.1), (10.0, 10.0)).least_work(), None);
        assert_eq!(comparison((1.0, 0.1), (10.0, 9.0)).least_work(), None);
    }

    #[test]
    fn gpu_gets_everything_when_it_is_faster_with_one_picture_too() {
        assert_eq!(comparison((1.0, 0.1), (10.0, 1.0)).least_work(), Some(0));
    }

    #[test]
    fn small_batches_stay_on_the_cpu_when_the_way_costs_more() {
        // Gains of -1.2 + 0.2 = -1 and 7 - 6 = 1: they meet in the middle.
        let least = comparison((0.2, 1.0), (7.0, 5.0)).least_work().unwrap();
        assert!((599..=601).contains(&least), "{least}");
    }

    #[test]
    fn evaluator_compared_with_itself_is_not_preferred() {
        let cpu = CanonicalEvaluator::default();
        let started = Instant::now();
        let comparison = Comparison::measure(&cpu, &cpu).unwrap();
        println!("{} in {:?}", comparison.describe("itself"), started.elapsed());
        assert!(comparison.brood.work > 50 * comparison.small.work / 4);
        assert!(comparison.brood.cpu_s.is_finite() && comparison.small.gpu_s.is_finite());
    }
}
