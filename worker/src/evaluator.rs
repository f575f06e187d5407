//! Choice of the evaluator for a frame: by the request, the available hardware and a benchmark.
//!
//! Evaluators of the exact class compute the same bits, so the choice among them affects time only.
//! The f64 reference is used only if it is requested by name, because its pictures have their own
//! keys.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use brood_eval::{CanonicalEvaluator, EvalError, Evaluator, ReferenceEvaluator};
use brood_program::Program;
use brood_protocol::{Backend, BackendReport};
use brood_scene::SampleSet;

use crate::gpu::{self, Gpu};
use crate::gpu_benchmark::{GpuBenchmark, batch_operations};

/// Value of `gpu_threshold` that keeps every batch on the CPU.
const NEVER: u64 = u64::MAX;

/// Evaluators of one renderer.
pub(crate) struct Evaluators {
    setting: Backend,
    canonical: Arc<dyn Evaluator>,
    reference: Arc<dyn Evaluator>,
    gpu: OnceLock<Result<Gpu, String>>,
    /// Batches with fewer operations stay on the CPU; see [`batch_operations`].
    gpu_threshold: AtomicU64,
    reason: OnceLock<String>,
    failed: AtomicBool,
}

impl Evaluators {
    /// Creates the evaluators. The setting `gpu` opens the adapter immediately; `auto` uses the CPU
    /// until [`Evaluators::survey`].
    pub(crate) fn new(setting: Backend) -> Self {
        let evaluators = Self {
            setting,
            canonical: Arc::new(CanonicalEvaluator::default()),
            reference: Arc::new(ReferenceEvaluator),
            gpu: OnceLock::new(),
            gpu_threshold: AtomicU64::new(NEVER),
            reason: OnceLock::new(),
            failed: AtomicBool::new(false),
        };
        if setting == Backend::Gpu && evaluators.exact_gpu().is_some() {
            evaluators.gpu_threshold.store(0, Ordering::Release);
            let configuration = evaluators.opened().map_or("", |gpu| gpu.configuration.as_str());
            evaluators.reason.get_or_init(|| format!("requested; {configuration}"));
        }
        evaluators
    }

    /// With the setting `auto`: looks for a GPU and benchmarks it against the CPU. The GPU is used
    /// if it is faster for a brood; batches below the threshold stay on the CPU.
    pub(crate) fn survey(&self) {
        if self.setting != Backend::Auto || self.reason.get().is_some() {
            return;
        }
        let hardware = match self.gpu.get() {
            Some(opened) => opened.as_ref().map_err(Clone::clone),
            // Software adapters are not probed: they are never faster than the CPU that they run
            // on.
            None => gpu::open(false)
                .and_then(|gpu| self.gpu.get_or_init(|| Ok(gpu)).as_ref().map_err(Clone::clone)),
        };
        let reason = match hardware {
            Err(reason) => format!("no hardware GPU: {reason}"),
            Ok(gpu) if gpu.is_software => format!("{} is a software adapter", gpu.adapter),
            Ok(gpu) if !gpu.is_exact => format!("{} is not bit-exact: {}", gpu.adapter, gpu.detail),
            Ok(gpu) => match GpuBenchmark::measure(&*self.canonical, &*gpu.evaluator) {
                Err(error) => format!("{} failed the benchmark: {error}", gpu.adapter),
                Ok(benchmark) => {
                    let least = benchmark.gpu_threshold();
                    self.gpu_threshold.store(least.unwrap_or(NEVER), Ordering::Release);
                    let small = match least {
                        None | Some(0) => String::new(),
                        Some(least) => format!("; CPU for batches below {least} operations"),
                    };
                    format!("{}{small}; {}", benchmark.describe(&gpu.adapter), gpu.configuration)
                }
            },
        };
        tracing::info!(gpu = self.prefers_gpu(), reason, "evaluator chosen");
        self.reason.get_or_init(|| reason);
    }

    /// Returns the evaluator for a batch of this many operations, and true if it is the GPU.
    pub(crate) fn choose(&self, wanted: Backend, work: u64) -> (Arc<dyn Evaluator>, bool) {
        let gpu = match (wanted, self.setting) {
            (Backend::Reference, _) => return (self.reference.clone(), false),
            (Backend::Cpu, _) | (_, Backend::Cpu) | (Backend::Auto, Backend::Reference) => None,
            (Backend::Auto, Backend::Auto | Backend::Gpu) => {
                let least = self.gpu_threshold.load(Ordering::Acquire);
                (least != NEVER && work >= least).then(|| self.exact_gpu()).flatten()
            }
            (Backend::Gpu, Backend::Auto | Backend::Gpu | Backend::Reference) => self.exact_gpu(),
        };
        gpu.map_or_else(|| (self.canonical.clone(), false), |gpu| (gpu.evaluator.clone(), true))
    }

    /// Evaluates a batch. If the GPU cannot do it, the CPU does, with the same bits.
    pub(crate) fn eval(
        &self,
        wanted: Backend,
        programs: &[&Program],
        set: &SampleSet,
        out: &mut Vec<f32>,
    ) -> Result<(), EvalError> {
        let (evaluator, is_gpu) = self.choose(wanted, batch_operations(programs, set));
        if is_gpu && !programs.iter().all(|program| program.layers().is_empty()) {
            // There are no shaders for layers.
            return self.canonical.eval(programs, set, out);
        }
        match evaluator.eval(programs, set, out) {
            Err(error) if is_gpu => {
                if self.failed.swap(true, Ordering::AcqRel) {
                    tracing::debug!(%error, "the GPU failed again; falling back to the CPU");
                } else {
                    tracing::warn!(%error, "the GPU failed; falling back to the CPU for this batch");
                }
                self.canonical.eval(programs, set, out)
            }
            result => result,
        }
    }

    /// True if a bit-exact GPU is open.
    pub(crate) fn has_gpu(&self) -> bool {
        matches!(self.gpu.get(), Some(Ok(gpu)) if gpu.is_exact)
    }

    /// Returns the default evaluator with the reason for it.
    pub(crate) fn report(&self) -> BackendReport {
        let reason = self.reason.get().cloned();
        if self.setting == Backend::Reference {
            return BackendReport {
                name: Backend::Reference.name().to_owned(),
                adapter: processor(),
                exact: false,
                reason: "requested".to_owned(),
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
                    Backend::Cpu => "requested".to_owned(),
                    _ => "the search for a GPU has not finished".to_owned(),
                }),
            },
        }
    }

    fn prefers_gpu(&self) -> bool {
        self.gpu_threshold.load(Ordering::Acquire) != NEVER
    }

    fn opened(&self) -> Option<&Gpu> {
        self.gpu.get().and_then(|gpu| gpu.as_ref().ok())
    }

    /// Returns the GPU if it is open and bit-exact. Otherwise logs the reason once.
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
            tracing::warn!("{problem}; falling back to the CPU");
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
    fn evaluator_has_requested_exactness_class_for_every_setting() {
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
    fn report_names_evaluator_in_use_when_setting_is_gpu() {
        let evaluators = Evaluators::new(Backend::Gpu);
        let report = evaluators.report();
        assert_eq!(report.name == "gpu", evaluators.has_gpu(), "{report:?}");
        assert!(report.exact && !report.reason.is_empty(), "{report:?}");
    }

    #[test]
    fn batch_stays_on_cpu_when_below_gpu_threshold() {
        let evaluators = Evaluators::new(Backend::Gpu);
        if !evaluators.has_gpu() {
            eprintln!("skipped: no exact GPU");
            return;
        }
        evaluators.gpu_threshold.store(1000, Ordering::Release);
        assert!(!evaluators.choose(Backend::Auto, 999).1);
        assert!(evaluators.choose(Backend::Auto, 1000).1);
        assert!(evaluators.choose(Backend::Gpu, 1).1, "a request by name ignores the threshold");
    }

    #[test]
    fn gpu_stays_closed_when_setting_is_cpu() {
        let evaluators = Evaluators::new(Backend::Cpu);
        evaluators.survey();
        let (_, is_gpu) = evaluators.choose(Backend::Gpu, 1);
        assert!(!is_gpu && evaluators.gpu.get().is_none());
        assert_eq!(evaluators.report().reason, "requested");
    }
}
