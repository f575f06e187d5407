//! Checked values for the parameters of a table: of a model, or of an effect of painted materials.
//! Also their lines of text.

use std::fmt;

use super::parameter::{Parameter, ParameterKind, Values};

/// Values for all parameters of a table.
#[derive(Debug, Clone)]
pub struct ParameterValues {
    /// Name of the model or effect, for errors.
    owner: &'static str,
    table: &'static [Parameter],
    /// Values in the order of the table: one or three for each parameter.
    values: Vec<f64>,
}

/// Error of setting a parameter.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ParameterError {
    /// There is no parameter of that name.
    #[error("{owner} has no parameter {name}; it has {known}")]
    Unknown {
        /// Name of the model or effect.
        owner: &'static str,
        /// The unknown name.
        name: String,
        /// Names of the parameters.
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
    /// The text is not a colour.
    #[error("{name} must be a colour like #2b1e46, got {text}")]
    DisplayColor {
        /// The parameter.
        name: &'static str,
        /// The text that was given.
        text: String,
    },
}

/// Error of creating a model or an effect from all its values.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ParameterValuesError {
    /// Wrong number of values.
    #[error("{owner} takes {wanted} parameter values, got {found}")]
    Count {
        /// Name of the model or effect.
        owner: &'static str,
        /// Number of values that its parameters take.
        wanted: usize,
        /// Number of values that were given.
        found: usize,
    },
    /// A value is not valid for its parameter.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
}

/// Error of setting a parameter from its text.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ParameterTextError {
    /// The parameter or its values are not valid.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A value is not a number.
    #[error("{0:?} is not a number")]
    Number(String),
}

/// Values are compared alone: callers compare values of one table.
impl PartialEq for ParameterValues {
    fn eq(&self, other: &Self) -> bool {
        self.values == other.values
    }
}

impl ParameterValues {
    /// Returns the default values of a table. `owner` is the name of the model or effect.
    #[must_use]
    pub fn new(owner: &'static str, table: &'static [Parameter]) -> Self {
        let values = table.iter().flat_map(Parameter::default).collect();
        Self { owner, table, values }
    }

    /// Returns these values of a table, in its order.
    ///
    /// # Errors
    /// Returns [`ParameterValuesError`] if the number of values is wrong or a value is out of
    /// range.
    pub fn from_values(
        owner: &'static str,
        table: &'static [Parameter],
        values: &[f64],
    ) -> Result<Self, ParameterValuesError> {
        let mut made = Self::new(owner, table);
        if values.len() != made.values.len() {
            let (wanted, found) = (made.values.len(), values.len());
            return Err(ParameterValuesError::Count { owner, wanted, found });
        }
        let mut at = 0;
        for parameter in table {
            made.set(parameter.name, &values[at..at + parameter.count()])?;
            at += parameter.count();
        }
        Ok(made)
    }

    /// All values, in the order of the table.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Iterates over the parameters and their values, in the order of the table.
    pub fn iter(&self) -> impl Iterator<Item = (&'static Parameter, &[f64])> {
        let mut rest = self.values.as_slice();
        self.table.iter().map(move |parameter| {
            let (values, others) = rest.split_at(parameter.count());
            rest = others;
            (parameter, values)
        })
    }

    /// Returns the values of a parameter, or `None` if there is no such parameter.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&[f64]> {
        self.iter().find(|(parameter, _)| parameter.name == name).map(|(_, values)| values)
    }

    /// Sets the values of one parameter. The value of a choice is the index of its word. Values of
    /// display colours are rounded to multiples of 1/255.
    ///
    /// # Errors
    /// Returns [`ParameterError`] if there is no such parameter, or the number of values is
    /// wrong, or a value is out of range.
    pub fn set(&mut self, name: &str, values: &[f64]) -> Result<(), ParameterError> {
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
        let is_code = matches!(parameter.kind, ParameterKind::DisplayColor { .. });
        for (old, value) in self.values[at..].iter_mut().zip(values) {
            let value = if is_code { (value * 255.0).round() / 255.0 } else { *value };
            // Adding +0 turns -0 into 0, so that equal models have equal bits.
            *old = value + 0.0;
        }
        Ok(())
    }

    /// Sets the word of a choice, or a display colour in the form `#2b1e46`.
    ///
    /// # Errors
    /// Returns [`ParameterError`] if there is no such parameter, or it does not take such a word.
    pub fn choose(&mut self, name: &str, word: &str) -> Result<(), ParameterError> {
        let (parameter, _) = self.find(name)?;
        let name = parameter.name;
        let words = match parameter.kind {
            ParameterKind::Choice { words } => words,
            ParameterKind::DisplayColor { .. } => {
                let Some(codes) = display_codes(word) else {
                    return Err(ParameterError::DisplayColor { name, text: word.to_owned() });
                };
                return self.set(name, &codes.map(|code| f64::from(code) / 255.0));
            }
            ParameterKind::Scalar { .. } | ParameterKind::Color { .. } => {
                let wanted = if parameter.count() == 1 { "one number" } else { "three numbers" };
                return Err(ParameterError::Count { name, wanted, found: 0 });
            }
        };
        if word.is_empty() {
            return Err(ParameterError::Count { name, wanted: "one word", found: 0 });
        }
        let index = words.iter().zip(0_u32..).find(|(known, _)| **known == word);
        let Some((_, index)) = index else {
            let (known, word) = (words.join(", "), word.to_owned());
            return Err(ParameterError::Word { name, known, word });
        };
        self.set(name, &[f64::from(index)])
    }

    /// Sets a parameter from its line: values separated by blanks, the word of a choice, or a
    /// display colour.
    ///
    /// # Errors
    /// Returns [`ParameterTextError`] if a number cannot be parsed or the values are not valid.
    pub fn set_text(&mut self, name: &str, values: &str) -> Result<(), ParameterTextError> {
        let values = values.trim();
        if self.find(name)?.0.takes_word() {
            return Ok(self.choose(name, values)?);
        }
        let values: Result<Vec<f64>, _> = values
            .split_whitespace()
            .map(|word| word.parse().map_err(|_| ParameterTextError::Number(word.to_owned())))
            .collect();
        Ok(self.set(name, &values?)?)
    }

    /// Returns the index of the first value of a parameter.
    pub(super) fn position(&self, name: &str) -> Option<usize> {
        self.find(name).ok().map(|(_, at)| at)
    }

    /// Replaces one value by another that is known to be valid.
    pub(super) fn replace(&mut self, at: usize, value: f64) {
        self.values[at] = value;
    }

    /// Returns the values with their table, as formulas read them.
    pub(super) fn view(&self) -> Values<'_> {
        Values { table: self.table, values: &self.values }
    }

    fn find(&self, name: &str) -> Result<(&'static Parameter, usize), ParameterError> {
        let mut at = 0;
        for parameter in self.table {
            if parameter.name == name {
                return Ok((parameter, at));
            }
            at += parameter.count();
        }
        let known = self.table.iter().map(|p| p.name).collect::<Vec<_>>().join(", ");
        Err(ParameterError::Unknown { owner: self.owner, name: name.to_owned(), known })
    }
}

impl fmt::Display for ParameterValues {
    /// Writes each parameter on its own line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (parameter, values) in self.iter() {
            writeln!(f, "{} {}", parameter.name, parameter.text(values))?;
        }
        Ok(())
    }
}

/// Parses a colour of a display in the form `#2b1e46` to its 8-bit codes.
#[must_use]
pub fn display_codes(text: &str) -> Option<[u8; 3]> {
    let digits = text.strip_prefix('#')?;
    let is_hex = digits.len() == 6 && digits.bytes().all(|byte| byte.is_ascii_hexdigit());
    let code = |at: usize| u8::from_str_radix(&digits[at..at + 2], 16).ok();
    if is_hex { Some([code(0)?, code(2)?, code(4)?]) } else { None }
}
