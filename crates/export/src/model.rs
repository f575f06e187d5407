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

use crate::language::{Language, Type};

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
    pub(crate) fn functions(&self, language: Language) -> String {
        let mut text = String::new();
        for (number, (model, prepared)) in (1..).zip(&self.0) {
            text += &layer::function(number, model, &prepared.constants(), language);
        }
        text += "// Reflectance of the models, for directions in the local frame (z = n, x = u); 0 unless both\n\
                 // are above the surface.\n";
        text += &language.head("evolved_models", &[(Type::Vec3, "wi"), (Type::Vec3, "wo")]);
        let vector = language.type_name(Type::Vec3);
        let horizon = language.number(HORIZON);
        writeln!(
            text,
            "  if (!(wi.z >= {horizon} && wo.z >= {horizon})) {{\n    return {vector}(0.0);\n  }}"
        )
        .expect("a string takes everything");
        text += &language.let_line_of("BroodPair", "p", "brood_pair(wi, wo)");
        let sum: Vec<String> =
            (1..=self.0.len()).map(|number| format!("layer_{number}(p)")).collect();
        // The largest value that the square of a result can have.
        let most = language.number(RANGE * RANGE);
        writeln!(text, "  return min({}, {vector}({most}));\n}}\n", sum.join(" + "))
            .expect("a string takes everything");
        text
    }
}
