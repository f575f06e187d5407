//! Classical and physical models of reflectance: named, with parameters that have a range, a default and a source.
//!
//! A [`Model`] is a kind and values for its parameters, which is what texts, mutation and searches deal in; a
//! [`PreparedModel`] is the same, ready to be evaluated. It refuses to know meshes, pictures and programs.

mod ashikhmin_shirley;
mod coat;
mod constants;
mod cook_torrance;
mod diffuse;
mod fit;
mod formula;
mod fresnel;
mod kind;
mod microfacet;
mod parameter;
mod phong;
mod prepared;
mod preset;
mod principled;
mod rough_plastic;
#[cfg(test)]
mod tests;
mod text;
mod ward;

use glam::DVec3;

use crate::{DirectionPair, Machine};
pub use coat::{CoatTables, TableDetail};
pub use constants::{
    ClearCoatConstants, DistributionConstants, FacetConstants, MetalConstants, ModelConstants,
    PrincipledConstants, SgdChannel,
};
pub use kind::{ModelKind, UnknownModel};
pub use microfacet::Shadowing;
use parameter::Values;
pub use parameter::{Parameter, Scale, Shape};
pub use phong::Highlight as PhongHighlight;
pub use prepared::PreparedModel;
pub use preset::{ModelPreset, model_presets};
pub use text::ParameterTextError;
pub use ward::Form as WardForm;

/// What reflects light.
pub trait Brdf: Send + Sync {
    /// f(wi, wo), the cosine of wi not included.
    ///
    /// # Units
    /// 1/sr; linear red, green, blue.
    ///
    /// # Domain
    /// Any pair; 0 unless both directions are above the surface. Never NaN.
    fn f(&self, pair: &DirectionPair) -> DVec3;

    /// What the source promises of it with these parameters, which tests hold it to.
    fn claims(&self) -> Claims;
}

/// Laws that a model keeps.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Claims {
    /// f(wi, wo) = f(wo, wi), in every bit.
    pub reciprocal: bool,
    /// It never reflects more light than it receives.
    pub conserving: bool,
}

/// A model with values for its parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    kind: ModelKind,
    /// Of each parameter in the order of the table, each as long as it is.
    numbers: Vec<f64>,
}

/// Why a parameter cannot be set.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ParameterError {
    /// The model has none of that name.
    #[error("{model} has no parameter {name}; it has {known}")]
    Unknown {
        /// The model.
        model: ModelKind,
        /// What was asked for.
        name: String,
        /// What there is.
        known: String,
    },
    /// As many numbers as it does not hold.
    #[error("{name} takes {wanted}, not {found}")]
    Count {
        /// The parameter.
        name: &'static str,
        /// How many it holds, in words.
        wanted: &'static str,
        /// How many were given.
        found: usize,
    },
    /// A number out of range.
    #[error("{name} is from {low} to {high}, not {value}")]
    Range {
        /// The parameter.
        name: &'static str,
        /// Its least value.
        low: f64,
        /// Its largest value.
        high: f64,
        /// What was given.
        value: f64,
    },
    /// None of the words.
    #[error("{name} is one of {known}, not {word}")]
    Word {
        /// The parameter.
        name: &'static str,
        /// The words.
        known: String,
        /// What was given.
        word: String,
    },
}

/// Why numbers are no model.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NumbersError {
    /// More or fewer than its parameters have.
    #[error("{kind} has {wanted} numbers, not {found}")]
    Count {
        /// The model.
        kind: ModelKind,
        /// How many its parameters have.
        wanted: usize,
        /// How many were given.
        found: usize,
    },
    /// One that its parameter cannot be.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
}

impl Model {
    /// The model with its defaults.
    #[must_use]
    pub fn new(kind: ModelKind) -> Self {
        let numbers = kind.parameters().iter().flat_map(Parameter::default).collect();
        Self { kind, numbers }
    }

    /// The model of numbers as [`Model::numbers`] has them.
    pub fn from_numbers(kind: ModelKind, numbers: &[f64]) -> Result<Self, NumbersError> {
        let model = Self::new(kind);
        if numbers.len() != model.numbers.len() {
            let (wanted, found) = (model.numbers.len(), numbers.len());
            return Err(NumbersError::Count { kind, wanted, found });
        }
        let mut at = 0;
        kind.parameters().iter().try_fold(model, |model, parameter| {
            let values = &numbers[at..at + parameter.count()];
            at += parameter.count();
            Ok(model.with(parameter.name, values)?)
        })
    }

    /// Which model it is.
    #[must_use]
    pub fn kind(&self) -> ModelKind {
        self.kind
    }

    /// The numbers of all parameters, in the order of the kind's table.
    #[must_use]
    pub fn numbers(&self) -> &[f64] {
        &self.numbers
    }

    /// Its parameters with their numbers, in the order of the kind's table.
    pub fn parameters(&self) -> impl Iterator<Item = (&'static Parameter, &[f64])> {
        let mut rest = self.numbers.as_slice();
        self.kind.parameters().iter().map(move |parameter| {
            let (numbers, others) = rest.split_at(parameter.count());
            rest = others;
            (parameter, numbers)
        })
    }

    /// The numbers of a parameter; none where there is no such.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&[f64]> {
        let (parameter, at) = self.kind.place(name)?;
        Some(&self.numbers[at..at + parameter.count()])
    }

    /// The same with other values of one parameter; the number of its word for a choice.
    pub fn with(mut self, name: &str, values: &[f64]) -> Result<Self, ParameterError> {
        let (parameter, at) = self.find(name)?;
        if values.len() != parameter.count() {
            let wanted = if parameter.count() == 1 { "one value" } else { "three values" };
            return Err(ParameterError::Count {
                name: parameter.name,
                wanted,
                found: values.len(),
            });
        }
        let (low, high) = parameter.range;
        for &value in values {
            let whole = !matches!(parameter.shape, Shape::Choice { .. }) || value.fract() == 0.0;
            if !((low..=high).contains(&value) && whole) {
                return Err(ParameterError::Range { name: parameter.name, low, high, value });
            }
        }
        for (number, value) in self.numbers[at..].iter_mut().zip(values) {
            // Adding +0 turns -0 into 0, so that equal models have equal bits.
            *number = value + 0.0;
        }
        Ok(self)
    }

    /// The same with another word of a choice.
    pub fn choose(self, name: &str, word: &str) -> Result<Self, ParameterError> {
        let (parameter, _) = self.find(name)?;
        let Shape::Choice { words } = parameter.shape else {
            let wanted = if parameter.count() == 1 { "one number" } else { "three numbers" };
            return Err(ParameterError::Count { name: parameter.name, wanted, found: 0 });
        };
        if word.is_empty() {
            return Err(ParameterError::Count {
                name: parameter.name,
                wanted: "one word",
                found: 0,
            });
        }
        let number = words.iter().zip(0_u32..).find(|(known, _)| **known == word);
        let Some((_, number)) = number else {
            let (known, word) = (words.join(", "), word.to_owned());
            return Err(ParameterError::Word { name: parameter.name, known, word });
        };
        self.with(name, &[f64::from(number)])
    }

    /// The same all around the normal: what draws highlights out along u or v does not.
    #[must_use]
    pub fn isotropic(&self) -> Self {
        let mut model = self.clone();
        for (of_v, of_u) in [("alpha_y", "alpha_x"), ("exponent_v", "exponent_u")] {
            if let (Some((_, v)), Some((_, u))) = (self.kind.place(of_v), self.kind.place(of_u)) {
                model.numbers[v] = self.numbers[u];
            }
        }
        for name in ["stretch", "anisotropic"] {
            if let Some((_, at)) = self.kind.place(name) {
                model.numbers[at] = 0.0;
            }
        }
        model
    }

    /// Prepared to be evaluated, on pairs and on blocks of them.
    #[must_use]
    pub fn prepare(&self) -> PreparedModel {
        let values = Values { table: self.kind.parameters(), numbers: &self.numbers };
        PreparedModel(self.kind.make(values))
    }

    /// What takes long to prepare, which models that differ in colour alone share; none where nothing takes long.
    #[must_use]
    pub fn coat_tables(&self, machine: impl Machine, detail: TableDetail) -> Option<CoatTables> {
        let values = Values { table: self.kind.parameters(), numbers: &self.numbers };
        let has_tables = self.kind == ModelKind::RoughPlastic;
        has_tables.then(|| CoatTables::new(machine, values, detail))
    }

    /// As [`Model::prepare`], with tables that have been made; models that have none do not look at them.
    #[must_use]
    pub fn prepare_with(&self, tables: &CoatTables) -> PreparedModel {
        let values = Values { table: self.kind.parameters(), numbers: &self.numbers };
        match self.kind {
            ModelKind::RoughPlastic => {
                PreparedModel(rough_plastic::rough_plastic_with(values, tables))
            }
            _ => self.prepare(),
        }
    }

    /// The same among all else that reflects light.
    #[must_use]
    pub fn brdf(&self) -> Box<dyn Brdf> {
        Box::new(self.prepare())
    }

    fn find(&self, name: &str) -> Result<(&'static Parameter, usize), ParameterError> {
        self.kind.place(name).ok_or_else(|| ParameterError::Unknown {
            model: self.kind,
            name: name.to_owned(),
            known: self.kind.parameters().iter().map(|p| p.name).collect::<Vec<_>>().join(", "),
        })
    }
}
