//! Compilation of a pipeline for a single program, and the check that it gives the bits of the
//! interpreter before it is used.

use std::time::Instant;

use brood_program::Program;

use super::Engine;
use super::batch::Batch;
use crate::GpuError;
use crate::shader::Kernel;
use crate::straight::source;

impl Engine {
    /// Compiles a pipeline for one program and stores it if it gives the bits that the interpreter
    /// has just given.
    pub(crate) fn compile_own(
        &mut self,
        program: &Program,
        batch: &Batch<'_, '_>,
        interpreted: &[f32],
    ) -> Result<(), GpuError> {
        let hash = program.hash();
        let started = Instant::now();
        let text = source(program, self.style);
        let mut compiled = match self.compile(Kernel::Reflectance, &text, self.style.guard) {
            Ok(compiled) => compiled,
            Err(error @ GpuError::Rejected(_)) => {
                tracing::warn!(%error, program = %hash, "the pipeline of the program was rejected");
                self.own.reject(hash);
                return Ok(());
            }
            Err(error) => return Err(error),
        };
        let mut out = vec![f32::NAN; interpreted.len()];
        // Some drivers compile at first use.
        self.reflectances(batch, self.style, &mut compiled, &mut out)?;
        let seconds = started.elapsed().as_secs_f64();
        self.own.note_compilation(program.steps().len(), seconds);
        let is_equal = out.iter().zip(interpreted).all(|(a, b)| a.to_bits() == b.to_bits());
        if is_equal {
            tracing::debug!(program = %hash, seconds, "compiled a pipeline for the program");
            self.own.store(hash, compiled);
        } else {
            tracing::warn!(program = %hash, "the pipeline of the program gives other bits; not used");
            self.own.reject(hash);
        }
        Ok(())
    }
}
