//! The layers of a program as functions: one for each model, whose numbers are constants in its text, and their sum.
//!
//! This module says which formula with which numbers a layer is; the formulas are hand-written texts in `model/`, twins of
//! those of brood-brdf. They take directions in the local frame and compute in f32, where the reference computes in f64.

mod facet;
mod layer;
mod term;

use std::fmt::Write;

use brood_brdf::{Brdf, PreparedModel};
use brood_genome::{Model, RANGE};

use crate::language::{Language, Type};

/// Directions whose cosine is below this are not above the surface: so all that models divide by stays within f32.
const HORIZON: f32 = 1e-12;

/// The layers of a program, ready to be written.
pub(crate) struct Layers<'a>(Vec<(&'a Model, PreparedModel)>);

impl<'a> Layers<'a> {
    pub(crate) fn of(models: &'a [Model]) -> Self {
        Self(models.iter().map(|model| (model, model.prepare())).collect())
    }

    pub(crate) fn are_none(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether all of them reflect the same when the directions are exchanged.
    pub(crate) fn are_reciprocal(&self) -> bool {
        self.0.iter().all(|(_, prepared)| prepared.claims().reciprocal)
    }

    /// A function for each layer, and `evolved_models`, their sum.
    pub(crate) fn functions(&self, language: Language) -> String {
        let mut text = String::new();
        for (number, (model, prepared)) in (1..).zip(&self.0) {
            text += &layer::function(number, model, &prepared.constants(), language);
        }
        text += "// What the models reflect, of directions in the local frame (z = n, x = u); 0 unless both are above the surface.\n";
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
        // As large as the square of a result can be.
        let most = language.number(RANGE * RANGE);
        writeln!(text, "  return min({}, {vector}({most}));\n}}\n", sum.join(" + "))
            .expect("a string takes everything");
        text
    }
}
