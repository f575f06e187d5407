//! Everything that is told of a genome.

use brood_genome::{Genome, Input, live_instructions};
use brood_program::{Counts, Program, Tape};
use serde::{Deserialize, Serialize};

use crate::{Energy, Physics, Plane, planes, scalar_code};

/// What a genome is, what of it lives, and whether it is physical.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct Inspection {
    /// Content hash of the genome.
    pub hash: String,
    /// Identity of what it is seen as.
    pub program_hash: String,
    /// The dialect's words.
    pub dialect: String,
    /// Names of the inputs that are read.
    pub inputs: Vec<String>,
    /// How much there is, and how much of it is executed.
    pub counts: OperationCounts,
    /// Sign, finiteness, reciprocity.
    pub physics: Physics,
    /// How much it reflects.
    pub energy: Energy,
    /// The genome's text; instructions are its last lines.
    pub source: String,
    /// For each instruction whether it can change the result.
    pub live: Vec<bool>,
    /// For each instruction the channels that depend on it: some of `rgb`.
    pub channels: Vec<String>,
    /// The scalar operations that are executed, one a line.
    pub code: String,
    /// Reflectance over planes of incidence.
    pub planes: Vec<Plane>,
}

/// Counts before and after each step of lowering.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct OperationCounts {
    /// Instructions of the genome.
    pub instructions: u32,
    /// Instructions that can change the result.
    pub live_instructions: u32,
    /// Scalar operations of all components written.
    pub scalar_operations: u32,
    /// After per-component dead-code removal.
    pub live_scalar_operations: u32,
    /// After value numbering.
    pub numbered_operations: u32,
    /// After folding: what runs for each sample.
    pub operations: u32,
    /// Inputs that are read.
    pub inputs_read: usize,
    /// Inputs that there are.
    pub inputs_known: usize,
    /// Values that are kept at once.
    pub registers: usize,
}

/// Looks at everything.
#[must_use]
pub fn inspect(genome: &Genome) -> Inspection {
    let energy = Energy::of(genome);
    let program = Program::lower(genome);
    let program = if energy.divisor > 1.0 { program.divided(energy.divisor) } else { program };
    let inputs: Vec<String> =
        program.inputs().iter().map(|input| input.name().to_owned()).collect();
    let counts = Counts::of(genome);
    Inspection {
        hash: genome.hash().to_string(),
        program_hash: program.hash().to_string(),
        dialect: genome.dialect().to_string(),
        counts: OperationCounts {
            instructions: counts.instructions,
            live_instructions: counts.live_instructions,
            scalar_operations: counts.scalar_operations,
            live_scalar_operations: counts.live_scalar_operations,
            numbered_operations: counts.numbered_operations,
            operations: counts.operations,
            inputs_read: inputs.len(),
            inputs_known: Input::ALL.len(),
            registers: Tape::new(&program).registers().into(),
        },
        inputs,
        physics: Physics::of(&program),
        energy,
        source: genome.to_string(),
        live: live_instructions(genome),
        channels: channels(genome),
        code: scalar_code(&program),
        planes: planes(&program),
    }
}

/// For each instruction the channels that depend on it.
fn channels(genome: &Genome) -> Vec<String> {
    let masks = brood_genome::channels_of_instructions(genome);
    let word = |mask: u8| {
        let letters = "rgb".chars().enumerate();
        letters.filter(|(bit, _)| mask >> bit & 1 == 1).map(|(_, letter)| letter).collect()
    };
    masks.into_iter().map(word).collect()
}
