//! The evaluator: one engine behind a lock, opened again when its device is lost.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, MutexGuard, PoisonError};

use brood_brdf::{Input, InputMask};
use brood_eval::{EvalError, Evaluator};
use brood_program::Program;
use brood_scene::SampleSet;

use crate::adapter::describe;
use crate::engine::Engine;
use crate::guard::{Guard, Ladder};
use crate::probe::probe;
use crate::residency::Rows;
use crate::shader::Style;
use crate::shape::Shape;
use crate::tune::tune;
use crate::{AdapterReport, BatchTiming, Contraction, GpuError, GpuOptions};

/// Evaluates broods on a graphics adapter.
///
/// One batch runs at a time; callers on other threads wait. A batch whose device is lost on the way runs once more on a
/// new device before it fails.
#[derive(Debug)]
pub struct GpuEvaluator {
    options: GpuOptions,
    report: AdapterReport,
    style: Style,
    /// Empty between the loss of a device and the next batch.
    engine: Mutex<Option<Engine>>,
}

impl GpuEvaluator {
    /// Opens the best adapter that the options allow, finds how code has to be written to be exact there, on hardware
    /// how it is fastest, and probes the result.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`] where there is no driver or no device; everything else means that there is one but it
    /// does not work.
    pub fn new(options: &GpuOptions) -> Result<Self, GpuError> {
        Self::open(options, &[])
    }

    /// As [`GpuEvaluator::new`], with a compiler that is made to contract code with some guards, as hardware might.
    fn open(options: &GpuOptions, contracting: &[Guard]) -> Result<Self, GpuError> {
        let shape = options.shape.unwrap_or_default();
        let mut engine =
            Engine::open(options, Style { guard: Guard::Plain, shape, contracts: false })?;
        engine.contracting = contracting.to_vec();
        let guards = match options.contraction {
            Contraction::Probe => Guard::ALL.to_vec(),
            Contraction::Only(guard) => vec![guard],
        };
        let ladder = Ladder::climb(&guards, |guard| {
            engine.set_style(Style { guard, shape, contracts: false });
            probe(&mut engine)
        })?;
        let mut report = describe(&engine.device.info);
        report.rungs = ladder.report();
        report.has_timestamps = engine.clock.is_some();
        let exact = ladder.exact();
        let (mut guard, mut shape) = (exact.first().copied().unwrap_or(guards[0]), shape);
        let mut finding = ladder.finding(guard).expect("every guard was probed up to it").clone();
        let shapes = match options.shape {
            None if !report.is_software => Shape::ALL.to_vec(),
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

    /// What runs, and what the probe found.
    #[must_use]
    pub fn adapter(&self) -> &AdapterReport {
        &self.report
    }

    fn lock(&self) -> MutexGuard<'_, Option<Engine>> {
        // A panic on the way leaves nothing behind: the engine is taken out while it runs.
        self.engine.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Evaluates as [`Evaluator::eval`] does, and says what it took.
    ///
    /// # Errors
    /// As there.
    pub fn eval_timed(
        &self,
        programs: &[&Program],
        set: &SampleSet,
        out: &mut Vec<f32>,
    ) -> Result<BatchTiming, EvalError> {
        refuse_layers(programs).map_err(eval_error)?;
        out.clear();
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

    /// Runs a batch on the engine; once more on a new one where the device goes away.
    pub(crate) fn with_engine<T>(
        &self,
        mut batch: impl FnMut(&mut Engine) -> Result<T, GpuError>,
    ) -> Result<T, GpuError> {
        let mut place = self.lock();
        let mut engine = match place.take() {
            Some(engine) if !engine.device.is_lost() => engine,
            Some(engine) => self.replace(engine, &GpuError::Lost("between batches".to_owned()))?,
            None => self.open_again()?,
        };
        let mut result = batch(&mut engine);
        if let Err(error) = &result
            && error.is_worth_a_new_device()
        {
            engine = self.replace(engine, error)?;
            result = batch(&mut engine);
        }
        match &result {
            Err(error) if error.is_worth_a_new_device() => discard(engine, error),
            Ok(_) | Err(_) => *place = Some(engine),
        }
        result
    }

    fn replace(&self, engine: Engine, error: &GpuError) -> Result<Engine, GpuError> {
        tracing::warn!(%error, adapter = self.report.name, "opening the graphics device again");
        discard(engine, error);
        self.open_again()
    }

    fn open_again(&self) -> Result<Engine, GpuError> {
        let engine = Engine::open(&self.options, self.style)?;
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
        self.eval_timed(programs, set, out).map(|_| ())
    }
}

fn rows<'a>(
    programs: &[&Program],
    set: &SampleSet,
    row: &'a dyn Fn(Input) -> &'a [f32],
) -> Rows<'a> {
    let mask = programs.iter().fold(InputMask::EMPTY, |mask, p| mask.union(p.inputs()));
    Rows { set: Some(set.id()), mask, len: set.len(), row }
}

/// Layers have no shader.
pub(crate) fn refuse_layers(programs: &[&Program]) -> Result<(), GpuError> {
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

/// One sentence: what runs, what the probe says of it, and how the other rungs did.
fn detail(report: &AdapterReport, finding: &str) -> String {
    let mut text = format!("{}, {}: {finding}", report.guard.name(), report.shape.name());
    for rung in report.rungs.iter().filter(|rung| rung.guard != report.guard) {
        let verdict = if rung.exact { "exact as well" } else { "not exact" };
        text += &format!("; {} is {verdict}: {}", rung.guard.name(), rung.detail);
    }
    text
}

#[cfg(test)]
#[path = "evaluator_tests.rs"]
pub(crate) mod tests;
