//! What was found, in figures: how far it is from what was measured where it was not fitted, what it costs, and what physics
//! says of it.

use anyhow::{Context, Result};
use brood_eval::{energy_limit, express};
use brood_genome::Genome;
use brood_inspect::{Inspection, inspect};
use brood_program::Program;
use brood_search::lobes::Lobes;
use brood_search::{MeasuredTarget, Samples, metric, narrow_pairs};
use serde_json::{Value, json};

/// Pairs that are looked at for spikes.
const NARROW: usize = 1 << 16;

/// A material that was found.
pub struct Found {
    pub genome: Genome,
    /// Scalar operations a sample, under the energy limit.
    pub operations: usize,
    /// Numbers that were fitted.
    pub numbers: usize,
    /// E_log on the samples it was fitted to.
    pub fitted: f64,
    /// E_log on those held out.
    pub e_log: f64,
    /// By what the energy limit divides.
    divisor: f64,
    /// f of what is held out.
    held: Samples,
}

impl Found {
    /// What lobes are as a program, under the energy limit, against the target.
    pub fn of(lobes: &Lobes, target: &MeasuredTarget) -> Result<Self> {
        let genome = lobes.genome().context("write the fit as a program")?;
        let program = Program::lower(&genome);
        let divisor = energy_limit(&program).divisor;
        let program = if divisor > 1.0 { program.divided(divisor) } else { program };
        let of = |samples: &Samples| Samples::of_program(&program, samples.pairs().to_vec());
        let e_log = |wanted: &Samples, found: &Samples| {
            metric::e_log(&wanted.weighted(), &found.weighted())
        };
        let held = of(&target.held)?;
        Ok(Self {
            operations: program.steps().len(),
            numbers: lobes.free(),
            fitted: e_log(&target.fitted, &of(&target.fitted)?),
            e_log: e_log(&target.held, &held),
            divisor,
            held,
            genome,
        })
    }
}

/// The figures of the best.
pub struct Report<'a> {
    found: &'a Found,
    target: &'a MeasuredTarget,
    kind: &'static str,
    e_cbrt: f64,
    rel_l2: f64,
    inspection: Inspection,
    /// The largest f it has where samples are few.
    spike: f64,
}

impl<'a> Report<'a> {
    /// Measures it.
    pub fn of(found: &'a Found, target: &'a MeasuredTarget, kind: &'static str) -> Result<Self> {
        let (wanted, weighted) = (target.held.weighted(), found.held.weighted());
        let (e_cbrt, rel_l2) =
            (metric::e_cbrt(&wanted, &weighted), metric::relative_l2(&wanted, &weighted));
        let inspection = inspect(&found.genome);
        let narrow = Samples::of_program(&express(&found.genome), narrow_pairs(NARROW, 3))?;
        let spike = narrow.largest().max(inspection.physics.max_f.into());
        Ok(Self { found, target, kind, e_cbrt, rel_l2, inspection, spike })
    }

    /// The largest f of all samples of the target.
    fn largest(&self) -> f64 {
        self.target.fitted.largest().max(self.target.held.largest())
    }

    /// For programs; `run` says how it was searched.
    pub fn json(&self, run: &Value) -> Value {
        let Self { found, target, inspection, .. } = self;
        json!({
            "target": {
                "kind": self.kind,
                "fitted_samples": target.fitted.len(),
                "held_out_samples": target.held.len(),
                "largest_f": self.largest(),
                "reciprocal_floor": target.floor,
            },
            "search": run,
            "e_log": found.e_log,
            "e_log_fitted": found.fitted,
            "e_cbrt": self.e_cbrt,
            "rel_l2": self.rel_l2,
            "operations": found.operations,
            "numbers": found.numbers,
            "largest_f": self.spike,
            "limit_divisor": found.divisor,
            "energy": inspection.energy,
            "physics": inspection.physics,
        })
    }

    /// For people.
    pub fn text(&self) -> String {
        let Self { found, target, inspection, .. } = self;
        let physics = &inspection.physics;
        let floor = target.floor.map_or_else(String::new, |floor| {
            format!(" (no reciprocal material comes closer than {floor:.5})")
        });
        let reciprocal = match physics.not_reciprocal {
            0 => format!("the same in every bit for all {} swapped pairs", physics.swapped_pairs),
            count => format!("NOT reciprocal for {count} of {} pairs", physics.swapped_pairs),
        };
        format!(
            "{}: {} samples fitted, {} held out{floor}\n\
             E_log {:.5} on what was held out, {:.5} on what was fitted; E_cbrt {:.5}, relative L2 {:.4}\n\
             {} operations a sample, {} fitted numbers; f from {} to {:.4} (the samples' largest: {:.4}), {} values not finite\n\
             reciprocity: {reciprocal}; the energy limit divides by {:.6}\n",
            self.kind,
            target.fitted.len(),
            target.held.len(),
            found.e_log,
            found.fitted,
            self.e_cbrt,
            self.rel_l2,
            found.operations,
            found.numbers,
            physics.min_f,
            self.spike,
            self.largest(),
            physics.non_finite,
            found.divisor,
        )
    }
}
