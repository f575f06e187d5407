//! The native class of a material: a genome with its program.

use std::sync::OnceLock;

use brood_eval::{energy_limit, express, is_anisotropic};
use brood_export::SamplingTable;
use brood_genome::preset::PRESETS;
use brood_genome::{Genome, Input};
use brood_program::Program;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::error::{genome_error, json_error, syntax_error, text_error, value_error};

/// A genome; its program and sampling table are computed at first use.
#[pyclass(frozen, module = "brood_brdf._native")]
pub(crate) struct NativeMaterial {
    genome: Genome,
    program: OnceLock<Program>,
    table: OnceLock<SamplingTable>,
}

impl NativeMaterial {
    pub(crate) fn new(genome: Genome) -> Self {
        Self { genome, program: OnceLock::new(), table: OnceLock::new() }
    }

    /// Returns a material whose program, energy limit included, is known.
    pub(crate) fn expressed(genome: Genome, program: Program) -> Self {
        Self { genome, program: OnceLock::from(program), table: OnceLock::new() }
    }

    pub(crate) fn genome(&self) -> &Genome {
        &self.genome
    }

    /// Returns the program, energy limit included.
    ///
    /// The program is computed outside the lock: a rayon thread that waits for the search of the
    /// limit may run another call that needs the same program, and would wait for itself.
    pub(crate) fn program(&self) -> &Program {
        if let Some(program) = self.program.get() {
            return program;
        }
        let program = express(&self.genome);
        self.program.get_or_init(|| program)
    }

    /// Returns the sampling table of the BRDF `program`, computed outside the lock for the same
    /// reason.
    pub(crate) fn table(&self, program: &Program) -> &SamplingTable {
        if let Some(table) = self.table.get() {
            return table;
        }
        let table = SamplingTable::of(program);
        self.table.get_or_init(|| table)
    }

    /// Returns an error unless the material has a BRDF.
    pub(crate) fn check_brdf(&self) -> PyResult<()> {
        if !self.genome.has_brdf() {
            return Err(value_error(
                "a painted material is not a BRDF: it has colours as a display shows them",
            ));
        }
        Ok(())
    }

    /// Returns the program of the BRDF; of a material painted by its BRDF, that of the latter.
    pub(crate) fn brdf(&self) -> Program {
        self.program().brdf().expect("the caller has checked that there is a BRDF")
    }
}

#[pymethods]
impl NativeMaterial {
    /// Parses a genome as text or JSON.
    #[staticmethod]
    fn parse(py: Python<'_>, text: &str) -> PyResult<Self> {
        let text = text.trim_start_matches('\u{feff}');
        let genome = if text.trim_start().starts_with('{') {
            let json = serde_json::from_str(text).map_err(|error| syntax_error(py, &error))?;
            Genome::from_json(json).map_err(|error| json_error(py, error))?
        } else {
            text.parse().map_err(|error| text_error(py, &error))?
        };
        Ok(Self::new(genome))
    }

    /// Decodes the canonical bytes of a genome.
    #[staticmethod]
    fn decode(py: Python<'_>, bytes: &[u8]) -> PyResult<Self> {
        let genome = Genome::from_canonical_bytes(bytes);
        let genome = genome.map_err(|error| genome_error(py, error.to_string(), None, None))?;
        Ok(Self::new(genome))
    }

    fn encode<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.genome.canonical_bytes())
    }

    fn text(&self) -> String {
        self.genome.to_string()
    }

    fn json(&self) -> String {
        self.genome.to_json().to_string()
    }

    #[getter]
    fn hash(&self) -> String {
        self.genome.hash().to_string()
    }

    #[getter]
    fn program_hash(&self, py: Python<'_>) -> String {
        py.detach(|| self.program().hash().to_string())
    }

    #[getter]
    fn operations(&self, py: Python<'_>) -> usize {
        py.detach(|| self.program().operations())
    }

    /// Names of the inputs that the program reads.
    #[getter]
    fn inputs(&self, py: Python<'_>) -> Vec<String> {
        py.detach(|| self.program().inputs().iter().map(|input| input.name().into()).collect())
    }

    #[getter]
    fn is_painted(&self) -> bool {
        self.genome.is_painted()
    }

    #[getter]
    fn has_brdf(&self) -> bool {
        self.genome.has_brdf()
    }

    #[getter]
    fn is_limited(&self) -> bool {
        self.genome.is_limited()
    }

    #[getter]
    fn is_anisotropic(&self, py: Python<'_>) -> bool {
        py.detach(|| is_anisotropic(self.program()) || self.program().bumps().is_some())
    }

    #[getter]
    fn is_textured(&self, py: Python<'_>) -> bool {
        py.detach(|| {
            let program = self.program();
            let inputs = program.inputs();
            program.bumps().is_some() || [Input::U, Input::V].iter().any(|it| inputs.contains(*it))
        })
    }

    /// Copy with the energy limit on or off.
    fn with_limit(&self, limited: bool) -> Self {
        Self::new(self.genome.clone().with_limit(limited))
    }

    /// Upper bound of the directional albedo, and the angle of incidence in degrees of the largest
    /// albedo found.
    fn largest_albedo(&self, py: Python<'_>) -> PyResult<(f64, f64)> {
        self.check_brdf()?;
        let limit = py.detach(|| energy_limit(&self.brdf()));
        Ok((limit.bound(), limit.theta_deg))
    }
}

/// Name, title, description and text of each preset.
#[pyfunction]
pub(crate) fn presets() -> Vec<(&'static str, &'static str, &'static str, &'static str)> {
    PRESETS.iter().map(|preset| (preset.name, preset.title, preset.words, preset.text)).collect()
}
