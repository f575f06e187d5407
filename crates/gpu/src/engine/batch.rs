//! Programs and inputs of one call, and the shader that evaluates them.

use brood_brdf::InputMask;
use brood_program::Program;

use crate::encode::Encoded;
use crate::residency::Rows;

/// Programs and inputs of one call.
pub(crate) struct Batch<'a, 'r> {
    pub shader: BatchShader<'a>,
    pub encoded: &'a [Encoded],
    pub rows: &'a Rows<'r>,
    /// Inputs whose rows are on the device, which may be more than the programs read.
    pub mask: InputMask,
}

/// Shader that evaluates a batch; it determines what the words mean.
#[derive(Clone, Copy)]
pub(crate) enum BatchShader<'a> {
    /// The interpreter.
    Interpreter,
    /// Straight-line shader of one program.
    Own(&'a Program),
}
