//! A model with checked values for its parameters: what texts, mutation and searches work with.

use super::coat::{CoatTables, TableDetail};
use super::kind::ModelKind;
use super::parameter::{Parameter, ParameterKind, Values};
use super::prepared::PreparedModel;
use crate::{Brdf, Machine};

/// A model with values for its parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    kind: ModelKind,
    /// Values of all parameters, in the order of the kind's table: one or three for each
    /// parameter.
    values: Vec<f64>,
}

/// Error of setting a parameter.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ParameterError {
    /// The model has no parameter of that name.
    #[error("{model} has no parameter {name}; it has {known}")]
    Unknown {
        /// The model.
        model: ModelKind,
        /// The unknown name.
        name: String,
        /// Names of the model's parameters.
        known: String,
    },
    /// Wrong number of values.
    #[error("{name} takes {wanted}, not {found}")]
    Count {
        /// The parameter.
        name: &'static str,
        /// Number of values that the parameter takes, in words.
        wanted: &'static str,
        /// Number of values that were given.
        found: usize,
    },
    /// A value is out of range, or not an index of a word.
    #[error("{name} must be between {low} and {high}, got {value}")]
    Range {
        /// The parameter.
        name: &'static str,
        /// Least value.
        low: f64,
        /// Largest value.
        high: f64,
        /// The value that was given.
        value: f64,
    },
    /// The word is not one of the choice.
    #[error("{name} must be one of {known}, got {word}")]
    Word {
        /// The parameter.
        name: &'static str,
        /// Words of the choice.
        known: String,
        /// The word that was given.
        word: String,
    },
}

/// Error of [`Model::from_parameter_values`].
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ParameterValuesError {
    /// Wrong number of values.
    #[error("{kind} takes {wanted} parameter values, got {found}")]
    Count {
        /// The model.
        kind: ModelKind,
        /// Number of values that its parameters take.
        wanted: usize,
        /// Number of values that were given.
        found: usize,
    },
    /// A value is not valid for its parameter.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
}

impl Model {
    /// Returns the model with default values.
    #[must_use]
    pub fn new(kind: ModelKind) -> Self {
        let values = kind.parameters().iter().flat_map(Parameter::default).collect();
        Self { kind, values }
    }

    /// Returns the model with these values, in the order of [`Model::parameter_values`].
    ///
    /// # Errors
    /// Returns [`ParameterValuesError`] if the number of values is wrong or a value is out of
    /// range.
    pub fn from_parameter_values(
        kind: ModelKind,
        values: &[f64],
    ) -> Result<Self, ParameterValuesError> {
        let model = Self::new(kind);
        if values.len() != model.values.len() {
            let (wanted, found) = (model.values.len(), values.len());
            return Err(ParameterValuesError::Count { kind, wanted, found });
        }
        let mut at = 0;
        kind.parameters().iter().try_fold(model, |model, parameter| {
            let own = &values[at..at + parameter.count()];
            at += parameter.count();
            Ok(model.with(parameter.name, own)?)
        })
    }

    /// Kind of the model.
    #[must_use]
    pub fn kind(&self) -> ModelKind {
        self.kind
    }

    /// Values of all parameters, in the order of the kind's table.
    #[must_use]
    pub fn parameter_values(&self) -> &[f64] {
        &self.values
    }

    /// Iterates over the parameters and their values, in the order of the kind's table.
    pub fn parameters(&self) -> impl Iterator<Item = (&'static Parameter, &[f64])> {
        let mut rest = self.values.as_slice();
        self.kind.parameters().iter().map(move |parameter| {
            let (values, others) = rest.split_at(parameter.count());
            rest = others;
            (parameter, values)
        })
    }

    /// Returns the values of a parameter, or `None` if the model has no such parameter.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&[f64]> {
        let (parameter, at) = self.kind.find(name)?;
        Some(&self.values[at..at + parameter.count()])
    }

    /// Returns the model with other values of one parameter. The value of a choice is the index
    /// of its word.
    ///
    /// # Errors
    /// Returns [`ParameterError`] if there is no such parameter, or the number of values is
    /// wrong, or a value is out of range.
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
            let whole =
                !matches!(parameter.kind, ParameterKind::Choice { .. }) || value.fract() == 0.0;
            if !((low..=high).contains(&value) && whole) {
                return Err(ParameterError::Range { name: parameter.name, low, high, value });
            }
        }
        for (old, value) in self.values[at..].iter_mut().zip(values) {
            // Adding +0 turns -0 into 0, so that equal models have equal bits.
            *old = value + 0.0;
        }
        Ok(self)
    }

    /// Returns the model with another word of a choice.
    ///
    /// # Errors
    /// Returns [`ParameterError`] if there is no such choice or no such word.
    pub fn choose(self, name: &str, word: &str) -> Result<Self, ParameterError> {
        let (parameter, _) = self.find(name)?;
        let ParameterKind::Choice { words } = parameter.kind else {
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
        let index = words.iter().zip(0_u32..).find(|(known, _)| **known == word);
        let Some((_, index)) = index else {
            let (known, word) = (words.join(", "), word.to_owned());
            return Err(ParameterError::Word { name: parameter.name, known, word });
        };
        self.with(name, &[f64::from(index)])
    }

    /// Returns the model without anisotropy: the width along v becomes that along u.
    #[must_use]
    pub fn isotropic(&self) -> Self {
        let mut model = self.clone();
        for (name_v, name_u) in [("alpha_y", "alpha_x"), ("exponent_v", "exponent_u")] {
            if let (Some((_, v)), Some((_, u))) = (self.kind.find(name_v), self.kind.find(name_u)) {
                model.values[v] = self.values[u];
            }
        }
        for name in ["stretch", "anisotropic"] {
            if let Some((_, at)) = self.kind.find(name) {
                model.values[at] = 0.0;
            }
        }
        model
    }

    /// True if the directional albedo stays finite as the light nears the horizon. Highlights that
    /// are divided by cos_i, or by a root of it, reflect without bound there.
    #[must_use]
    pub fn is_bounded_at_horizon(&self) -> bool {
        match self.kind {
            ModelKind::Phong
            | ModelKind::BlinnPhong
            | ModelKind::ReflectedBlinnPhong
            | ModelKind::Sgd => false,
            ModelKind::Ward => {
                let form = self.parameters().find(|(parameter, _)| parameter.name == "form");
                form.and_then(|(form, values)| form.word(values)) == Some("bounded")
            }
            ModelKind::Lambert
            | ModelKind::OrenNayar
            | ModelKind::NormalisedBlinnPhong
            | ModelKind::CookTorrance
            | ModelKind::Conductor
            | ModelKind::Coated
            | ModelKind::RoughPlastic
            | ModelKind::Principled
            | ModelKind::AshikhminShirley
            | ModelKind::Abc => true,
        }
    }

    /// Computes everything that does not depend on directions.
    #[must_use]
    pub fn prepare(&self) -> PreparedModel {
        self.kind.prepare(self.values(), None)
    }

    /// Returns the part of the preparation that is slow, or `None` if no part is. Models that
    /// differ only in colour can share it.
    #[must_use]
    pub fn coat_tables(&self, machine: impl Machine, detail: TableDetail) -> Option<CoatTables> {
        let has_tables = self.kind == ModelKind::RoughPlastic;
        has_tables.then(|| CoatTables::new(machine, self.values(), detail))
    }

    /// As [`Model::prepare`], but reuses these tables. Models without tables ignore them.
    #[must_use]
    pub fn prepare_with(&self, tables: &CoatTables) -> PreparedModel {
        self.kind.prepare(self.values(), Some(tables))
    }

    /// Returns the prepared model as a trait object.
    #[must_use]
    pub fn brdf(&self) -> Box<dyn Brdf> {
        Box::new(self.prepare())
    }

    fn values(&self) -> Values<'_> {
        Values { table: self.kind.parameters(), values: &self.values }
    }

    fn find(&self, name: &str) -> Result<(&'static Parameter, usize), ParameterError> {
        self.kind.find(name).ok_or_else(|| ParameterError::Unknown {
            model: self.kind,
            name: name.to_owned(),
            known: self.kind.parameters().iter().map(|p| p.name).collect::<Vec<_>>().join(", "),
        })
    }
}
