//! What was found, in figures: how far it is from what was measured where it was not fitted, what it costs, and what physics
//! says of it.

use anyhow::Result;
use brood_eval::express;
use brood_inspect::{Inspection, inspect};
use brood_search::{Found, MeasuredTarget, Reflected, Samples, narrow_pairs};
use serde_json::{Value, json};

/// Pairs that are looked at for spikes.
const NARROW: usize = 1 << 16;

/// The figures of the best.
pub struct Report<'a> {
    found: &'a Found,
    target: &'a MeasuredTarget,
    kind: &'static str,
    inspection: Inspection,
    /// The largest f it has where samples are few.
    spike: f64,
}

impl<'a> Report<'a> {
    /// Measures it.
    pub fn of(found: &'a Found, target: &'a MeasuredTarget, kind: &'static str) -> Result<Self> {
        let inspection = inspect(&found.genome);
        let narrow = Samples::of_program(&express(&found.genome), narrow_pairs(NARROW, 3))?;
        let spike = narrow.largest().max(inspection.physics.max_f.into());
        Ok(Self { found, target, kind, inspection, spike })
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
                "largest_albedo": target.reflected.map(|most| json!({"albedo": most.albedo, "theta_deg": most.theta_deg})),
            },
            "search": run,
            "e_log": found.e_log,
            "e_log_fitted": found.fitted,
            "e_cbrt": found.e_cbrt,
            "rel_l2": found.relative_l2,
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
        let too_much = target.reflected.filter(|most| most.is_too_much());
        let too_much = too_much.map_or_else(String::new, |most| {
            let Reflected { albedo, theta_deg } = most;
            format!("it sends back {albedo:.2} times the light from {theta_deg} degrees; what is found, no more than there is\n")
        });
        let reciprocal = match physics.not_reciprocal {
            0 => format!("the same in every bit for all {} swapped pairs", physics.swapped_pairs),
            count => format!("NOT reciprocal for {count} of {} pairs", physics.swapped_pairs),
        };
        format!(
            "{}: {} samples fitted, {} held out{floor}\n\
             {too_much}E_log {:.5} on what was held out, {:.5} on what was fitted; E_cbrt {:.5}, relative L2 {:.4}\n\
             {} operations a sample, {} fitted numbers; f from {} to {:.4} (the samples' largest: {:.4}), {} values not finite\n\
             reciprocity: {reciprocal}; the energy limit divides by {:.6}\n",
            self.kind,
            target.fitted.len(),
            target.held.len(),
            found.e_log,
            found.fitted,
            found.e_cbrt,
            found.relative_l2,
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
