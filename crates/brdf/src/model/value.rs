//! A model with checked values for its parameters: what texts, mutation and searches work with.
//!
//! The text form is a line that names the model, and one line for each parameter:
//!
//! ```text
//! .model cook-torrance
//! f0 1 0.71 0.29
//! roughness 0.3
//! distribution beckmann
//! ```
//! Numbers are written so that they read back to the same bits. The rest of a file is the caller's
//! business.

use std::fmt;

use super::coat::{CoatTables, TableDetail};
use super::kind::ModelKind;
use super::parameter::{Parameter, Values};
use super::parameter_values::{
    ParameterError, ParameterTextError, ParameterValues, ParameterValuesError,
};
use super::prepared::PreparedModel;
use crate::{Brdf, Machine};

/// A model with values for its parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    kind: ModelKind,
    values: ParameterValues,
}

impl Model {
    /// Returns the model with default values.
    #[must_use]
    pub fn new(kind: ModelKind) -> Self {
        Self { kind, values: ParameterValues::new(kind.name(), kind.parameters()) }
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
        let values = ParameterValues::from_values(kind.name(), kind.parameters(), values)?;
        Ok(Self { kind, values })
    }

    /// Kind of the model.
    #[must_use]
    pub fn kind(&self) -> ModelKind {
        self.kind
    }

    /// Values of all parameters, in the order of the kind's table.
    #[must_use]
    pub fn parameter_values(&self) -> &[f64] {
        self.values.values()
    }

    /// Iterates over the parameters and their values, in the order of the kind's table.
    pub fn parameters(&self) -> impl Iterator<Item = (&'static Parameter, &[f64])> {
        self.values.iter()
    }

    /// Returns the values of a parameter, or `None` if the model has no such parameter.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&[f64]> {
        self.values.get(name)
    }

    /// Returns the model with other values of one parameter. The value of a choice is the index
    /// of its word.
    ///
    /// # Errors
    /// Returns [`ParameterError`] if there is no such parameter, or the number of values is
    /// wrong, or a value is out of range.
    pub fn with(mut self, name: &str, values: &[f64]) -> Result<Self, ParameterError> {
        self.values.set(name, values)?;
        Ok(self)
    }

    /// Returns the model with another word of a choice.
    ///
    /// # Errors
    /// Returns [`ParameterError`] if there is no such choice or no such word.
    pub fn choose(mut self, name: &str, word: &str) -> Result<Self, ParameterError> {
        self.values.choose(name, word)?;
        Ok(self)
    }

    /// Returns the model with a parameter set from its line: values separated by blanks, or
    /// the word of a choice.
    ///
    /// # Errors
    /// Returns [`ParameterTextError`] if a number cannot be parsed or the model rejects the
    /// values.
    pub fn with_text(mut self, name: &str, values: &str) -> Result<Self, ParameterTextError> {
        self.values.set_text(name, values)?;
        Ok(self)
    }

    /// Returns the model without anisotropy: the width along v becomes that along u.
    #[must_use]
    pub fn isotropic(&self) -> Self {
        let mut model = self.clone();
        for (name_v, name_u) in [("alpha_y", "alpha_x"), ("exponent_v", "exponent_u")] {
            if let (Some(v), Some([u])) = (self.values.position(name_v), self.get(name_u)) {
                model.values.replace(v, *u);
            }
        }
        for name in ["stretch", "anisotropic"] {
            if let Some(at) = self.values.position(name) {
                model.values.replace(at, 0.0);
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
        self.values.view()
    }
}

impl fmt::Display for Model {
    /// Writes the model's line, then each parameter on its own line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, ".model {}\n{}", self.kind, self.values)
    }
}
