//! Layers of a program as functions: one for each model, with its constants as literals, and their
//! sum.
//!
//! Chooses the formula and the constants of each layer. The formulas are hand-written texts in
//! `model/`, twins of those of brood-brdf. They take directions in the local frame and compute in
//! f32; the reference computes in f64.

mod facet;
mod layer;
mod term;

use std::fmt::Write;

use brood_brdf::{Brdf, PreparedModel};
use brood_genome::{Model, RANGE};

use crate::source::{let_line, number};

/// Least cosine at which a direction counts as above the surface. Keeps all divisors of the models
/// within f32.
const HORIZON: f32 = 1e-12;

/// Layers of a program, prepared for printing.
pub(crate) struct Layers<'a>(Vec<(&'a Model, PreparedModel)>);

impl<'a> Layers<'a> {
    pub(crate) fn of(models: &'a [Model]) -> Self {
        Self(models.iter().map(|model| (model, model.prepare())).collect())
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// True if all models are reciprocal.
    pub(crate) fn are_reciprocal(&self) -> bool {
        self.0.iter().all(|(_, prepared)| prepared.claims().reciprocal)
    }

    /// Prints a function for each layer, and `evolved_models`, their sum.
    pub(crate) fn functions(&self) -> String {
        let mut text = String::new();
        for (layer, (model, prepared)) in (1..).zip(&self.0) {
            text += &layer::function(layer, model, &prepared.constants());
        }
        text += "// Reflectance of the models, for directions in the local frame (z = n, x = u); 0 unless both\n\
                 // are above the surface.\n";
        text += "fn evolved_models(wi: vec3f, wo: vec3f) -> vec3f {\n";
        let horizon = number(HORIZON);
        writeln!(
            text,
            "  if (!((wi.z >= {horizon}) && (wo.z >= {horizon}))) {{\n    return vec3f(0.0);\n  }}"
        )
        .expect("a string takes everything");
        text += &let_line("BroodPair", "p", "brood_pair(wi, wo)");
        let sum: Vec<String> =
            (1..=self.0.len()).map(|layer| format!("layer_{layer}(p)")).collect();
        // The largest value that the square of a result can have.
        let most = number(RANGE * RANGE);
        writeln!(text, "  return min({}, vec3f({most}));\n}}\n", sum.join(" + "))
            .expect("a string takes everything");
        text
    }
}
