//! Exports for other renderers.

use brood_export::{Exported, Format, Within, export_genome};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::error::value_error;
use crate::material::NativeMaterial;
use crate::threads;

/// Name, label, file extension and media type of a format, and true if it is binary.
type FormatRow = (&'static str, &'static str, &'static str, &'static str, bool);

/// Exports a material in a format; returns the file, and a note about a table's error. `limit`
/// overrides the energy limit.
#[pyfunction]
#[pyo3(signature = (material, format, limit, lights))]
pub(crate) fn export<'py>(
    py: Python<'py>,
    material: &Bound<'py, NativeMaterial>,
    format: &str,
    limit: Option<bool>,
    lights: usize,
) -> PyResult<(Bound<'py, PyBytes>, Option<String>)> {
    let material = material.get();
    let format: Format = format.parse().map_err(value_error)?;
    let exported = threads::run(py, None, || {
        let within = Within { lights, ..Within::default() };
        export_genome(material.genome(), format, limit, within)
    })?;
    let Exported { bytes, note } = exported.map_err(value_error)?;
    Ok((PyBytes::new(py, &bytes), note))
}

/// Formats of exports.
#[pyfunction]
pub(crate) fn export_formats() -> Vec<FormatRow> {
    let row = |it: Format| (it.name(), it.label(), it.extension(), it.media_type(), it.is_binary());
    Format::ALL.into_iter().map(row).collect()
}
