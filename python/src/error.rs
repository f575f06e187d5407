//! Python exceptions.

use std::fmt::Display;

use brood_genome::{JsonError, TextError};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Returns a `ValueError` with the text of an error.
pub(crate) fn value_error(error: impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// Returns the `GenomeError` of a genome's text.
pub(crate) fn text_error(py: Python<'_>, error: &TextError) -> PyErr {
    genome_error(py, error.to_string(), Some((error.line as usize, error.column as usize)), None)
}

/// Returns the `GenomeError` of a text that is no JSON.
pub(crate) fn syntax_error(py: Python<'_>, error: &serde_json::Error) -> PyErr {
    genome_error(py, error.to_string(), Some((error.line(), error.column())), None)
}

/// Returns the `GenomeError` of JSON that is no genome.
pub(crate) fn json_error(py: Python<'_>, error: JsonError) -> PyErr {
    genome_error(py, error.to_string(), None, Some(error.pointer))
}

/// Returns a `GenomeError`, whose class is in Python, at a line and column or a JSON pointer.
pub(crate) fn genome_error(
    py: Python<'_>,
    message: String,
    place: Option<(usize, usize)>,
    pointer: Option<String>,
) -> PyErr {
    let (line, column) = place.unzip();
    let class = py.import("brood_brdf.error").and_then(|module| module.getattr("GenomeError"));
    match class.and_then(|class| class.call1((message, line, column, pointer))) {
        Ok(error) => PyErr::from_value(error),
        Err(error) => error,
    }
}
