//! Searches whose errors are measured in Python.

use std::sync::{Mutex, MutexGuard, PoisonError};

use brood_genome::Genome;
use brood_search::{AskOptions, AskTell, Evaluated};
use brood_target::Strategy;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::error::value_error;
use crate::material::NativeMaterial;

/// An evaluated material: genome, error and number of operations.
type EvaluatedRow = (NativeMaterial, f64, u32);

/// Ask-tell search.
#[pyclass(frozen, module = "brood_brdf._native")]
pub(crate) struct NativeEvolution {
    search: Mutex<AskTell>,
}

impl NativeEvolution {
    fn search(&self) -> MutexGuard<'_, AskTell> {
        self.search.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl NativeEvolution {
    /// Starts a search, or resumes it from the bytes of `checkpoint`.
    #[new]
    #[pyo3(signature = (start, seed, count, kept, checkpoint))]
    fn new(
        py: Python<'_>,
        start: Vec<Bound<'_, NativeMaterial>>,
        seed: u64,
        count: u32,
        kept: usize,
        checkpoint: Option<&[u8]>,
    ) -> PyResult<Self> {
        let start: Vec<Genome> = start.iter().map(|it| it.get().genome().clone()).collect();
        for genome in &start {
            if genome.is_painted() {
                return Err(value_error("`start`: a painted material is not a BRDF"));
            }
            if !genome.dialect().is_compatible(start[0].dialect()) {
                return Err(value_error("`start`: the materials must have one dialect"));
            }
        }
        if !(1..=4096).contains(&count) || !(2..=4096).contains(&kept) {
            return Err(value_error(format!(
                "`count` must be 1 to 4096 and `kept` 2 to 4096, got {count} and {kept}"
            )));
        }
        if start.len() > count as usize {
            return Err(value_error(format!(
                "`count` must be at least the number of materials to start from, {}, got {count}",
                start.len()
            )));
        }
        let options = AskOptions { dialect: Strategy::DIALECT, start, seed, count, kept };
        let search = py.detach(|| match checkpoint {
            Some(bytes) => AskTell::resume(options, bytes).map_err(value_error),
            None => Ok(AskTell::new(options)),
        })?;
        Ok(Self { search: Mutex::new(search) })
    }

    /// Materials of the current generation.
    fn ask(&self) -> Vec<NativeMaterial> {
        self.search().ask().iter().cloned().map(NativeMaterial::new).collect()
    }

    /// Takes the error of each material and breeds the next generation.
    fn tell(&self, py: Python<'_>, errors: Vec<f64>) -> PyResult<()> {
        py.detach(|| self.search().tell(&errors)).map(drop).map_err(value_error)
    }

    /// Numbers of generations and of evaluations.
    #[getter]
    fn counts(&self) -> (u32, u64) {
        let progress = self.search().progress();
        (progress.generation, progress.evaluations)
    }

    /// Median error and diversity of the materials that are kept.
    #[getter]
    fn probe(&self) -> (f64, f64) {
        let probe = self.search().probe();
        (probe.median, probe.diversity)
    }

    /// Best material.
    #[getter]
    fn best(&self) -> Option<EvaluatedRow> {
        self.search().best().map(row)
    }

    /// Front, from the shortest to the longest.
    #[getter]
    fn front(&self) -> Vec<EvaluatedRow> {
        self.search().front().iter().map(row).collect()
    }

    /// State of the search.
    fn checkpoint<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.search().checkpoint())
    }
}

fn row(evaluated: &Evaluated) -> EvaluatedRow {
    let material = NativeMaterial::new(evaluated.genome.clone());
    (material, evaluated.error, evaluated.operations)
}
