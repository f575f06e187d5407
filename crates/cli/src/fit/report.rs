//! Report of a fit: errors on held-out samples, cost, and physical measures.

use anyhow::Result;
use brood_eval::express;
use brood_inspect::{Inspection, inspect};
use brood_search::Found;
use brood_target::{AsMeasured, MeasuredTarget, Reflected, Samples, narrow_pairs};
use serde_json::{Value, json};

/// Number of pairs checked for spikes.
const NARROW: usize = 1 << 16;

/// Measures of the best genome.
pub struct Report<'a> {
    found: &'a Found,
    target: &'a MeasuredTarget,
    kind: &'static str,
    inspection: Inspection,
    /// E_log on the samples as measured.
    as_measured: Option<f64>,
    /// Largest f among directions where samples are sparse.
    spike: f64,
}

impl<'a> Report<'a> {
    /// Measures the genome.
    pub fn of(found: &'a Found, target: &'a MeasuredTarget, kind: &'static str) -> Result<Self> {
        let inspection = inspect(&found.genome);
        let narrow = Samples::of_program(&express(&found.genome), narrow_pairs(NARROW, 3))?;
        let spike = narrow.largest().max(inspection.physics.max_f.into());
        let as_measured = found.e_log_as_measured(target)?;
        Ok(Self { found, target, kind, inspection, as_measured, spike })
    }

    /// Largest f of all samples of the target.
    fn largest(&self) -> f64 {
        self.target.fitted.largest().max(self.target.held.largest())
    }

    /// Report as JSON; `run` describes the search.
    pub fn json(&self, run: &Value) -> Value {
        let Self { found, target, inspection, .. } = self;
        json!({
            "target": {
                "kind": self.kind,
                "fitted_samples": target.fitted.observations(),
                "held_out_samples": target.held.observations(),
                "largest_f": self.largest(),
                "reciprocal_floor": target.floor(),
                "repeated_samples": target.measured.as_ref().map(|measured| measured.repeated),
                "largest_albedo": target.reflected.map(|most| json!({"albedo": most.albedo, "theta_deg": most.theta_deg})),
            },
            "search": run,
            "e_log": found.e_log,
            "e_log_fitted": found.fitted,
            "e_log_as_measured": self.as_measured,
            "e_cbrt": found.e_cbrt,
            "rel_l2": found.relative_l2,
            "operations": found.operations,
            "numbers": found.parameters,
            "largest_f": self.spike,
            "limit_divisor": found.divisor,
            "energy": inspection.energy,
            "physics": inspection.physics,
        })
    }

    /// Report for a terminal.
    pub fn text(&self) -> String {
        let Self { found, target, inspection, .. } = self;
        let physics = &inspection.physics;
        let floor = target.measured.as_ref().zip(self.as_measured);
        let floor = floor.map_or_else(String::new, |(AsMeasured { samples, repeated, floor }, error)| {
            format!(
                "E_log {error:.5} on {} samples as measured, {repeated} of them in both orders of light and eye or repeated; no \
                 reciprocal isotropic material is below {floor:.5} there\n",
                samples.len(),
            )
        });
        let too_much = target.reflected.filter(|most| most.is_too_much());
        let too_much = too_much.map_or_else(String::new, |most| {
            let Reflected { albedo, theta_deg } = most;
            format!("the target reflects {albedo:.2} times the light from {theta_deg} degrees; the fit is limited to 1\n")
        });
        let reciprocal = match physics.not_reciprocal {
            0 => format!("exact for all {} swapped pairs", physics.swapped_pairs),
            count => format!("NOT reciprocal for {count} of {} pairs", physics.swapped_pairs),
        };
        format!(
            "{}: {} samples fitted, {} held out\n\
             {too_much}E_log {:.5} on held-out samples, {:.5} on fitted samples; E_cbrt {:.5}, relative L2 {:.4}\n\
             {floor}\
             {} operations per sample, {} fitted parameters; f from {} to {:.4} (largest sample: {:.4}), {} values not finite\n\
             reciprocity: {reciprocal}; the energy limit divides by {:.6}\n",
            self.kind,
            target.fitted.observations(),
            target.held.observations(),
            found.e_log,
            found.fitted,
            found.e_cbrt,
            found.relative_l2,
            found.operations,
            found.parameters,
            physics.min_f,
            self.spike,
            self.largest(),
            physics.non_finite,
            found.divisor,
        )
    }
}
