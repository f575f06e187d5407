//! The GPU evaluator: one engine behind a lock, reopened when its device is lost.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, MutexGuard, PoisonError};

use brood_brdf::{Input, InputMask};
use brood_eval::{EvalError, EvalResult, Evaluator, Lowered};
use brood_program::Program;
use brood_scene::SampleSet;

use crate::adapter::describe;
use crate::engine::Engine;
use crate::guard::{Guard, GuardSearch};
use crate::interpreter_layout::InterpreterLayout;
use crate::probe::probe;
use crate::residency::Rows;
use crate::shader::Style;
use crate::tune::tune;
use crate::{AdapterReport, BatchTiming, Contraction, GpuError, GpuOptions};

/// Evaluates broods on a graphics adapter.
///
/// One batch runs at a time; callers on other threads wait. If the device is lost during a batch,
/// the batch is repeated once on a new device before it fails.
#[derive(Debug)]
pub struct GpuEvaluator {
    options: GpuOptions,
    report: AdapterReport,
    style: Style,
    /// `None` between the loss of a device and the next batch.
    engine: Mutex<Option<Engine>>,
}

impl GpuEvaluator {
    /// Opens the best adapter that the options allow, finds the guards with which code is exact
    /// there and, on hardware, the fastest of them and the fastest layout, and probes that
    /// combination.
    ///
    /// # Errors
    /// Returns [`GpuError::NoAdapter`] if there is no driver or no matching device; any other error
    /// means that there is an adapter but it does not work.
    pub fn new(options: &GpuOptions) -> Result<Self, GpuError> {
        Self::open(options, &[])
    }

    /// As [`GpuEvaluator::new`], with shaders that contract deliberately under some guards, as
    /// hardware might.
    fn open(options: &GpuOptions, contracting: &[Guard]) -> Result<Self, GpuError> {
        let shape = options.shape.unwrap_or_default();
        let mut engine =
            Engine::open(options, Style { guard: Guard::Plain, shape, contracts: false })?;
        engine.contracting = contracting.to_vec();
        let guards = match options.contraction {
            Contraction::Probe => Guard::ALL.to_vec(),
            Contraction::Only(guard) => vec![guard],
        };
        let search = GuardSearch::run(&guards, |guard| {
            engine.set_style(Style { guard, shape, contracts: false });
            probe(&mut engine)
        })?;
        let mut report = describe(&engine.device.info);
        report.guards = search.report();
        report.has_timestamps = engine.clock.is_some();
        let exact = search.exact();
        let (mut guard, mut shape) = (exact.first().copied().unwrap_or(guards[0]), shape);
        let mut finding = search.finding(guard).expect("the guard in use was probed").clone();
        let shapes = match options.shape {
            None if !report.is_software => InterpreterLayout::ALL.to_vec(),
            Some(_) | None => vec![shape],
        };
        if finding.exact && (shapes.len() > 1 || exact.len() > 1) {
            report.timed = tune(&mut engine, &shapes, &exact)?;
            for (fast, guarded, _) in &report.timed {
                engine.set_style(Style { guard: *guarded, shape: *fast, contracts: false });
                let found = probe(&mut engine)?;
                if found.exact {
                    (shape, guard, finding) = (*fast, *guarded, found);
                    break;
                }
            }
        }
        engine.set_style(Style { guard, shape, contracts: false });
        (report.guard, report.shape) = (guard, shape);
        report.exact = finding.exact;
        report.flushes_subnormals = finding.flushes_subnormals;
        report.detail = detail(&report, &finding.detail);
        tracing::debug!(?report, "probed a graphics adapter");
        let style = engine.style;
        Ok(Self { options: options.clone(), report, style, engine: Mutex::new(Some(engine)) })
    }

    /// Returns the adapter in use and the result of the probe.
    #[must_use]
    pub fn adapter(&self) -> &AdapterReport {
        &self.report
    }

    fn lock(&self) -> MutexGuard<'_, Option<Engine>> {
        // A panic during a batch leaves no broken engine behind: the engine is taken out while it
        // runs.
        self.engine.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Evaluates as [`Evaluator::eval`] does, and returns the cost.
    ///
    /// # Errors
    /// As [`Evaluator::eval`].
    pub fn eval_timed(
        &self,
        programs: &[&Program],
        set: &SampleSet,
        out: &mut Vec<f32>,
    ) -> Result<BatchTiming, EvalError> {
        let lowered = Lowered::of(programs, set)?;
        let programs = &*lowered.programs();
        reject_layers(programs).map_err(eval_error)?;
        // Every value is written below; values of the last batch need not be cleared.
        out.resize(programs.len() * 3 * set.len(), 0.0);
        let row = |input| set.input(input);
        let rows = rows(programs, set, &row);
        self.with_engine(|engine| {
            engine.timing = BatchTiming::default();
            engine.run(programs, &rows, out)?;
            Ok(engine.timing)
        })
        .map_err(eval_error)
    }

    /// Runs a batch on the engine; if the device is lost, once more on a new one.
    pub(crate) fn with_engine<T>(
        &self,
        mut batch: impl FnMut(&mut Engine) -> Result<T, GpuError>,
    ) -> Result<T, GpuError> {
        let mut slot = self.lock();
        let mut engine = match slot.take() {
            Some(engine) if !engine.device.is_lost() => engine,
            Some(engine) => self.replace(engine, &GpuError::Lost("between batches".to_owned()))?,
            None => self.reopen()?,
        };
        let mut result = batch(&mut engine);
        if let Err(error) = &result
            && error.may_succeed_on_a_new_device()
        {
            engine = self.replace(engine, error)?;
            result = batch(&mut engine);
        }
        match &result {
            Err(error) if error.may_succeed_on_a_new_device() => discard(engine, error),
            Ok(_) | Err(_) => *slot = Some(engine),
        }
        result
    }

    /// Discards an engine and opens a new one on the same adapter.
    fn replace(&self, engine: Engine, error: &GpuError) -> Result<Engine, GpuError> {
        tracing::warn!(%error, adapter = self.report.name, "reopening the graphics device");
        discard(engine, error);
        self.reopen()
    }

    /// Opens an engine on the adapter that was probed.
    fn reopen(&self) -> Result<Engine, GpuError> {
        let engine = Engine::open(&self.options, self.style)?;
        let report = describe(&engine.device.info);
        // The result of the probe is valid for one adapter and driver; another one needs a new
        // evaluator.
        if (&report.name, &report.driver) != (&self.report.name, &self.report.driver) {
            let change = format!("{} was replaced by {}", self.report.name, report.name);
            return Err(GpuError::Lost(change));
        }
        Ok(engine)
    }
}

/// Discards an engine whose device cannot be trusted any more.
fn discard(engine: Engine, error: &GpuError) {
    if matches!(error, GpuError::Timeout { .. }) {
        // Dropping a queue waits without bound for work that may never end; leaking the device is
        // better.
        std::mem::forget(engine);
        return;
    }
    // The API panics on some states of a lost device during clean-up.
    if catch_unwind(AssertUnwindSafe(|| drop(engine))).is_err() {
        tracing::warn!("clean-up of a lost graphics device panicked");
    }
}

impl Evaluator for GpuEvaluator {
    fn name(&self) -> &str {
        "gpu"
    }

    fn is_exact(&self) -> bool {
        self.report.exact
    }

    fn eval(&self, programs: &[&Program], set: &SampleSet, out: &mut Vec<f32>) -> EvalResult {
        self.eval_timed(programs, set, out).map(|_| ())
    }
}

/// Returns the inputs of a batch.
fn rows<'a>(
    programs: &[&Program],
    set: &SampleSet,
    row: &'a dyn Fn(Input) -> &'a [f32],
) -> Rows<'a> {
    let mask = programs.iter().fold(InputMask::EMPTY, |mask, p| mask.union(p.inputs()));
    Rows { set: Some(set.id()), mask, len: set.len(), row }
}

/// Rejects programs with layers, for which there is no shader.
pub(crate) fn reject_layers(programs: &[&Program]) -> Result<(), GpuError> {
    match programs.iter().any(|program| !program.layers().is_empty()) {
        true => Err(GpuError::Layers),
        false => Ok(()),
    }
}

pub(crate) fn eval_error(error: GpuError) -> EvalError {
    match error {
        GpuError::TooLarge { .. } | GpuError::Layers => EvalError::Unsupported(error.to_string()),
        other => EvalError::Device(other.to_string()),
    }
}

/// Returns one sentence: guard and layout in use, the result of their probe, and those of the other
/// guards.
fn detail(report: &AdapterReport, finding: &str) -> String {
    let mut text = format!("{}, {}: {finding}", report.guard.name(), report.shape.name());
    for other in report.guards.iter().filter(|other| other.guard != report.guard) {
        let verdict = if other.exact { "also exact" } else { "not exact" };
        text += &format!("; {} is {verdict}: {}", other.guard.name(), other.detail);
    }
    text
}

#[cfg(test)]
#[path = "evaluator_tests.rs"]
pub(crate) mod tests;
