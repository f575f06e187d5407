//! Which evaluator renders a frame: decided by what was asked for, what is there, and what was measured.
//!
//! Evaluators of the exact class give the same bits, so the choice among them is about time only; the f64 reference
//! renders what was asked of it by name and nothing else, because its pictures have keys of their own.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use brood_eval::{CanonicalEvaluator, EvalError, Evaluator, ReferenceEvaluator};
use brood_program::Program;
use brood_protocol::{Backend, BackendReport};
use brood_scene::SampleSet;

use crate::comparison::{Comparison, work};
use crate::gpu::{self, Gpu};

/// Least work of a batch for the GPU where it gets none.
const NEVER: u64 = u64::MAX;

/// The evaluators of one renderer.
pub(crate) struct Evaluators {
    setting: Backend,
    canonical: Arc<dyn Evaluator>,
    reference: Arc<dyn Evaluator>,
    gpu: OnceLock<Result<Gpu, String>>,
    /// Smaller batches stay on the CPU; see [`work`].
    least_work: AtomicU64,
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
            least_work: AtomicU64::new(NEVER),
            reason: OnceLock::new(),
            failed: AtomicBool::new(false),
        };
        if setting == Backend::Gpu && evaluators.exact_gpu().is_some() {
            evaluators.least_work.store(0, Ordering::Release);
            let how = evaluators.opened().map_or("", |gpu| gpu.how.as_str());
            evaluators.reason.get_or_init(|| format!("asked for; {how}"));
        }
        evaluators
    }

    /// Looks for a GPU and measures it against the CPU, where the choice is ours to make. A brood decides whether it is
    /// used at all; batches that are too small for it stay on the CPU.
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
            Ok(gpu) => match Comparison::measure(&*self.canonical, &*gpu.evaluator) {
                Err(error) => format!("{} failed the measurement: {error}", gpu.adapter),
                Ok(comparison) => {
                    let least = comparison.least_work();
                    self.least_work.store(least.unwrap_or(NEVER), Ordering::Release);
                    let small = match least {
                        None | Some(0) => String::new(),
                        Some(least) => format!("; under {least} operations the CPU"),
                    };
                    format!("{}{small}; {}", comparison.describe(&gpu.adapter), gpu.how)
                }
            },
        };
        tracing::info!(gpu = self.prefers_gpu(), reason, "evaluator chosen");
        self.reason.get_or_init(|| reason);
    }

    /// The evaluator for a batch of that much work, and whether it is the GPU.
    pub(crate) fn choose(&self, wanted: Backend, work: u64) -> (Arc<dyn Evaluator>, bool) {
        let gpu = match (wanted, self.setting) {
            (Backend::Reference, _) => return (self.reference.clone(), false),
            (Backend::Cpu, _) | (_, Backend::Cpu) | (Backend::Auto, Backend::Reference) => None,
            (Backend::Auto, Backend::Auto | Backend::Gpu) => {
                let least = self.least_work.load(Ordering::Acquire);
                (least != NEVER && work >= least).then(|| self.exact_gpu()).flatten()
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
        let (evaluator, is_gpu) = self.choose(wanted, work(programs, set));
        if is_gpu && programs.iter().any(|program| !program.layers().is_empty()) {
            // Models of reflectance have no shaders.
            return self.canonical.eval(programs, set, out);
        }
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
        match (self.prefers_gpu(), self.gpu.get()) {
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

    fn prefers_gpu(&self) -> bool {
        self.least_work.load(Ordering::Acquire) != NEVER
    }

    fn opened(&self) -> Option<&Gpu> {
        self.gpu.get().and_then(|gpu| gpu.as_ref().ok())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_gets_its_exactness_class_whatever_the_setting() {
        for setting in [Backend::Auto, Backend::Cpu, Backend::Reference] {
            let evaluators = Evaluators::new(setting);
            for wanted in [Backend::Auto, Backend::Cpu] {
                let (evaluator, is_gpu) = evaluators.choose(wanted, u64::MAX);
                assert!(evaluator.is_exact() && !is_gpu, "{setting:?} {wanted:?}");
            }
            let (evaluator, _) = evaluators.choose(Backend::Reference, 1);
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
    fn batch_stays_on_the_cpu_when_it_is_too_small_for_the_gpu() {
        let evaluators = Evaluators::new(Backend::Gpu);
        if !evaluators.has_gpu() {
            eprintln!("skipped: no exact GPU");
            return;
        }
        evaluators.least_work.store(1000, Ordering::Release);
        assert!(!evaluators.choose(Backend::Auto, 999).1);
        assert!(evaluators.choose(Backend::Auto, 1000).1);
        assert!(evaluators.choose(Backend::Gpu, 1).1, "asked for by name");
    }

    #[test]
    fn cpu_setting_never_opens_a_gpu() {
        let evaluators = Evaluators::new(Backend::Cpu);
        evaluators.survey();
        let (_, is_gpu) = evaluators.choose(Backend::Gpu, 1);
        assert!(!is_gpu && evaluators.gpu.get().is_none());
        assert_eq!(evaluators.report().reason, "asked for");
    }
}
