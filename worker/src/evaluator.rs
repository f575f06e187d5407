//! Which evaluator renders a frame: decided by what was asked for, what is there, and what was measured.
//!
//! Evaluators of the exact class give the same bits, so the choice among them is about time only; the f64 reference
//! renders what was asked of it by name and nothing else, because its pictures have keys of their own.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use brood_eval::{CanonicalEvaluator, EvalError, Evaluator, ReferenceEvaluator};
use brood_genome::{BirthKey, Dialect, Variation};
use brood_program::Program;
use brood_protocol::{Backend, BackendReport};
use brood_scene::{BuiltinMesh, Mesh, SampleSet, Scene};

use crate::gpu::{self, Gpu};

/// A GPU must be this much faster than the CPU to be preferred: results also have to travel.
const MARGIN: f64 = 1.2;

/// The evaluators of one renderer.
pub(crate) struct Evaluators {
    setting: Backend,
    canonical: Arc<dyn Evaluator>,
    reference: Arc<dyn Evaluator>,
    gpu: OnceLock<Result<Gpu, String>>,
    prefers_gpu: AtomicBool,
    reason: OnceLock<String>,
    failed: AtomicBool,
}

impl Evaluators {
    /// With `gpu` the adapter is opened at once; `auto` starts on the CPU until [`Evaluators::survey`].
    pub(crate) fn new(setting: Backend) -> Self {
        let evaluators = Self {
            setting,
            canonical: Arc::new(CanonicalEvaluator::default()),
            reference: Arc::new(ReferenceEvaluator),
            gpu: OnceLock::new(),
            prefers_gpu: AtomicBool::new(false),
            reason: OnceLock::new(),
            failed: AtomicBool::new(false),
        };
        if setting == Backend::Gpu && evaluators.exact_gpu().is_some() {
            evaluators.prefer_gpu("asked for");
        }
        evaluators
    }

    /// Looks for a GPU and measures it against the CPU on a brood, where the choice is ours to make.
    pub(crate) fn survey(&self) {
        if self.setting != Backend::Auto || self.reason.get().is_some() {
            return;
        }
        let hardware = match self.gpu.get() {
            Some(opened) => opened.as_ref().map_err(Clone::clone),
            // Software adapters are not even probed: they are never faster than the CPU they run on.
            None => gpu::open(false)
                .and_then(|gpu| self.gpu.get_or_init(|| Ok(gpu)).as_ref().map_err(Clone::clone)),
        };
        let reason = match hardware {
            Err(reason) => format!("no hardware GPU: {reason}"),
            Ok(gpu) if gpu.is_software => format!("{} is software", gpu.adapter),
            Ok(gpu) if !gpu.is_exact => format!("{} is not bit-exact: {}", gpu.adapter, gpu.detail),
            Ok(gpu) => match measure(&*self.canonical, &*gpu.evaluator) {
                Err(error) => format!("{} failed the measurement: {error}", gpu.adapter),
                Ok((cpu, device)) => {
                    let faster = cpu.as_secs_f64() > MARGIN * device.as_secs_f64();
                    self.prefers_gpu.store(faster, Ordering::Release);
                    format!("measured on a brood: CPU {cpu:.1?}, {} {device:.1?}", gpu.adapter)
                }
            },
        };
        tracing::info!(gpu = self.prefers_gpu.load(Ordering::Acquire), reason, "evaluator chosen");
        self.reason.get_or_init(|| reason);
    }

    /// The evaluator for a frame, and whether it is the GPU.
    pub(crate) fn choose(&self, wanted: Backend) -> (Arc<dyn Evaluator>, bool) {
        let gpu = match (wanted, self.setting) {
            (Backend::Reference, _) => return (self.reference.clone(), false),
            (Backend::Cpu, _) | (_, Backend::Cpu) | (Backend::Auto, Backend::Reference) => None,
            (Backend::Auto, Backend::Auto | Backend::Gpu) => {
                let preferred = self.prefers_gpu.load(Ordering::Acquire);
                preferred.then(|| self.exact_gpu()).flatten()
            }
            (Backend::Gpu, Backend::Auto | Backend::Gpu | Backend::Reference) => self.exact_gpu(),
        };
        gpu.map_or_else(|| (self.canonical.clone(), false), |gpu| (gpu.evaluator.clone(), true))
    }

    /// Evaluates a batch with the evaluator for the frame; what a GPU cannot do is done by the CPU, with the same bits.
    pub(crate) fn eval(
        &self,
        wanted: Backend,
        programs: &[&Program],
        set: &SampleSet,
        out: &mut Vec<f32>,
    ) -> Result<(), EvalError> {
        let (evaluator, is_gpu) = self.choose(wanted);
        match evaluator.eval(programs, set, out) {
            Err(error) if is_gpu => {
                if self.failed.swap(true, Ordering::AcqRel) {
                    tracing::debug!(%error, "the GPU failed again; the CPU does this batch");
                } else {
                    tracing::warn!(%error, "the GPU failed; the CPU does this batch");
                }
                self.canonical.eval(programs, set, out)
            }
            result => result,
        }
    }

    /// Whether a bit-exact GPU has been opened.
    pub(crate) fn has_gpu(&self) -> bool {
        matches!(self.gpu.get(), Some(Ok(gpu)) if gpu.is_exact)
    }

    /// What renders where nothing else is asked for, and why.
    pub(crate) fn report(&self) -> BackendReport {
        let reason = self.reason.get().cloned();
        if self.setting == Backend::Reference {
            return BackendReport {
                name: Backend::Reference.name().to_owned(),
                adapter: processor(),
                exact: false,
                reason: "asked for".to_owned(),
            };
        }
        match (self.prefers_gpu.load(Ordering::Acquire), self.gpu.get()) {
            (true, Some(Ok(gpu))) => BackendReport {
                name: Backend::Gpu.name().to_owned(),
                adapter: gpu.adapter.clone(),
                exact: gpu.is_exact,
                reason: reason.unwrap_or_default(),
            },
            _ => BackendReport {
                name: Backend::Cpu.name().to_owned(),
                adapter: processor(),
                exact: self.canonical.is_exact(),
                reason: reason.unwrap_or_else(|| match self.setting {
                    Backend::Cpu => "asked for".to_owned(),
                    _ => "no GPU has been looked for yet".to_owned(),
                }),
            },
        }
    }

    fn prefer_gpu(&self, reason: &str) {
        self.reason.get_or_init(|| reason.to_owned());
        self.prefers_gpu.store(true, Ordering::Release);
    }

    /// The GPU if it is there and bit-exact; says once why it is not used.
    fn exact_gpu(&self) -> Option<&Gpu> {
        let mut opened_now = false;
        let gpu = self.gpu.get_or_init(|| {
            opened_now = true;
            gpu::open(true)
        });
        let problem = match gpu {
            Ok(gpu) if gpu.is_exact => {
                if opened_now {
                    tracing::info!(adapter = gpu.adapter, detail = gpu.detail, "GPU opened");
                }
                return Some(gpu);
            }
            Ok(gpu) => format!("{} is not bit-exact: {}", gpu.adapter, gpu.detail),
            Err(reason) => format!("no GPU: {reason}"),
        };
        if opened_now {
            tracing::warn!("{problem}; the CPU renders instead");
        }
        if self.setting == Backend::Gpu {
            self.reason.get_or_init(|| problem);
        }
        None
    }
}

fn processor() -> String {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    format!("{}, {threads} threads", brood_eval::Level::best().name())
}

/// Best of three of a brood of 21 at 128 x 128, on the CPU and on the GPU.
fn measure(cpu: &dyn Evaluator, gpu: &dyn Evaluator) -> Result<(Duration, Duration), EvalError> {
    let random = Variation::random(Dialect::default());
    let birth = |slot| random.birth(BirthKey { seed: 1, slot, attempt: 0 });
    let programs: Vec<Program> = (0..21).map(|slot| Program::lower(&birth(slot))).collect();
    let programs: Vec<&Program> = programs.iter().collect();
    let set = SampleSet::render(&Mesh::builtin(BuiltinMesh::Sphere), &Scene::default(), 128, 1);
    let best = |evaluator: &dyn Evaluator| {
        let mut out = Vec::new();
        evaluator.eval(&programs, &set, &mut out)?;
        let mut best = Duration::MAX;
        for _ in 0..3 {
            let start = Instant::now();
            evaluator.eval(&programs, &set, &mut out)?;
            best = best.min(start.elapsed());
        }
        Ok(best)
    };
    Ok((best(cpu)?, best(gpu)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_gets_its_exactness_class_whatever_the_setting() {
        for setting in [Backend::Auto, Backend::Cpu, Backend::Reference] {
            let evaluators = Evaluators::new(setting);
            for wanted in [Backend::Auto, Backend::Cpu] {
                let (evaluator, is_gpu) = evaluators.choose(wanted);
                assert!(evaluator.is_exact() && !is_gpu, "{setting:?} {wanted:?}");
            }
            let (evaluator, _) = evaluators.choose(Backend::Reference);
            assert!(!evaluator.is_exact(), "{setting:?}");
        }
    }

    #[test]
    fn gpu_setting_reports_what_runs() {
        let evaluators = Evaluators::new(Backend::Gpu);
        let report = evaluators.report();
        assert_eq!(report.name == "gpu", evaluators.has_gpu(), "{report:?}");
        assert!(report.exact && !report.reason.is_empty(), "{report:?}");
    }

    #[test]
    fn cpu_setting_never_opens_a_gpu() {
        let evaluators = Evaluators::new(Backend::Cpu);
        evaluators.survey();
        let (_, is_gpu) = evaluators.choose(Backend::Gpu);
        assert!(!is_gpu && evaluators.gpu.get().is_none());
        assert_eq!(evaluators.report().reason, "asked for");
    }
}
