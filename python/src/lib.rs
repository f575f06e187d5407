//! Native part of the Python package `brood_brdf`: materials on numpy arrays.
//!
//! Owns the conversion between Python objects and the crates of brood, and the release of Python's
//! lock while they work. Public classes, their defaults and documentation are in the package's
//! Python files.

mod ask;
mod breed;
mod error;
mod evaluate;
mod export;
mod fit;
mod material;
mod picture;
mod rows;
mod sampling;
mod threads;

use pyo3::prelude::pymodule;

/// Native part of the package `brood_brdf`.
#[pymodule(gil_used = true)]
mod _native {
    use numpy::PyArray1;
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::ask::NativeEvolution;
    #[pymodule_export]
    use crate::breed::breed;
    #[pymodule_export]
    use crate::evaluate::{albedo, eval, simd_level};
    #[pymodule_export]
    use crate::export::{export, export_formats};
    #[pymodule_export]
    use crate::fit::{NativeTarget, fit};
    #[pymodule_export]
    use crate::material::{NativeMaterial, presets};
    #[pymodule_export]
    use crate::picture::{picture, pixels, radiance, sheet};
    #[pymodule_export]
    use crate::sampling::{pdf, sample, sampling_quality};

    /// Loads numpy's functions, which would fail at the end of an interrupted call.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        drop(PyArray1::<f64>::zeros(module.py(), [0], false));
        Ok(())
    }
}
