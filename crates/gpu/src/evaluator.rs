//! The evaluator: one engine behind a lock, opened again when its device is lost.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, MutexGuard, PoisonError};

use brood_brdf::InputMask;
use brood_eval::{EvalError, Evaluator};
use brood_program::Program;
use brood_scene::SampleSet;

use crate::adapter::describe;
use crate::engine::{Engine, Rows};
use crate::probe::probe;
use crate::{AdapterReport, Contraction, GpuError, GpuOptions};

/// Evaluates broods on a graphics adapter.
///
/// One batch runs at a time; callers on other threads wait. A batch whose device is lost on the way runs once more on a
/// new device before it fails.
#[derive(Debug)]
pub struct GpuEvaluator {
    options: GpuOptions,
    report: AdapterReport,
    barrier: bool,
    /// Empty between the loss of a device and the next batch.
    engine: Mutex<Option<Engine>>,
}

impl GpuEvaluator {
    /// Opens the best adapter that the options allow and probes it.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`] where there is no driver or no device; everything else means that there is one but it
    /// does not work.
    pub fn new(options: &GpuOptions) -> Result<Self, GpuError> {
        let start = options.contraction == Contraction::Barrier;
        let mut engine = Engine::open(options, start)?;
        let mut report = describe(&engine.device.info);
        let mut barrier = start;
        let mut finding = probe(&mut engine)?;
        if options.contraction == Contraction::Probe && !finding.exact {
            engine.set_barrier(true);
            let guarded = probe(&mut engine)?;
            if guarded.exact {
                (barrier, finding) = (true, guarded);
            } else {
                engine.set_barrier(false);
            }
        }
        let code = if barrier { "code with barriers" } else { "plain code" };
        report.exact = finding.exact;
        report.flushes_subnormals = finding.flushes_subnormals;
        report.detail = format!("{code}: {}", finding.detail);
        tracing::debug!(?report, "probed a graphics adapter");
        Ok(Self { options: options.clone(), report, barrier, engine: Mutex::new(Some(engine)) })
    }

    /// What runs, and what the probe found.
    #[must_use]
    pub fn adapter(&self) -> &AdapterReport {
        &self.report
    }

    fn lock(&self) -> MutexGuard<'_, Option<Engine>> {
        // A panic on the way leaves nothing behind: the engine is taken out while it runs.
        self.engine.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn run(&self, programs: &[&Program], rows: &Rows<'_>, out: &mut [f32]) -> Result<(), GpuError> {
        let mut place = self.lock();
        let mut engine = match place.take() {
            Some(engine) if !engine.device.is_lost() => engine,
            Some(engine) => self.replace(engine, &GpuError::Lost("between batches".to_owned()))?,
            None => self.open_again()?,
        };
        let mut result = engine.run(programs, rows, out);
        if let Err(error) = &result
            && error.is_worth_a_new_device()
        {
            engine = self.replace(engine, error)?;
            result = engine.run(programs, rows, out);
        }
        match &result {
            Err(error) if error.is_worth_a_new_device() => discard(engine, error),
            Ok(()) | Err(_) => *place = Some(engine),
        }
        result
    }

    fn replace(&self, engine: Engine, error: &GpuError) -> Result<Engine, GpuError> {
        tracing::warn!(%error, adapter = self.report.name, "opening the graphics device again");
        discard(engine, error);
        self.open_again()
    }

    fn open_again(&self) -> Result<Engine, GpuError> {
        let engine = Engine::open(&self.options, self.barrier)?;
        let report = describe(&engine.device.info);
        // What the probe found holds for one adapter and driver; another one would need an evaluator of its own.
        if (&report.name, &report.driver) != (&self.report.name, &self.report.driver) {
            let change = format!("{} came back as {}", self.report.name, report.name);
            return Err(GpuError::Lost(change));
        }
        Ok(engine)
    }
}

/// Gets rid of an engine whose device cannot be trusted any more.
fn discard(engine: Engine, error: &GpuError) {
    if matches!(error, GpuError::Timeout { .. }) {
        // Dropping a queue waits without bound for work that may never end; a leaked device is the lesser evil.
        std::mem::forget(engine);
        return;
    }
    // The API panics on some states of a lost device while it cleans up.
    if catch_unwind(AssertUnwindSafe(|| drop(engine))).is_err() {
        tracing::warn!("a lost graphics device was not cleaned up");
    }
}

impl Evaluator for GpuEvaluator {
    fn name(&self) -> &str {
        "gpu"
    }

    fn is_exact(&self) -> bool {
        self.report.exact
    }

    fn eval(
        &self,
        programs: &[&Program],
        set: &SampleSet,
        out: &mut Vec<f32>,
    ) -> Result<(), EvalError> {
        let mask = programs.iter().fold(InputMask::EMPTY, |mask, p| mask.union(p.inputs()));
        let rows = mask.iter().map(|input| set.input(input)).collect();
        out.clear();
        out.resize(programs.len() * 3 * set.len(), 0.0);
        self.run(programs, &Rows { mask, rows, len: set.len() }, out).map_err(|error| match error {
            GpuError::TooLarge { .. } => EvalError::Unsupported(error.to_string()),
            other => EvalError::Device(other.to_string()),
        })
    }
}

#[cfg(test)]
#[path = "evaluator_tests.rs"]
mod tests;
