//! Full report on a genome.

use brood_genome::{Genome, Input, live_instructions};
use brood_program::{Bumps, Counts, Program, Tape};
use serde::{Deserialize, Serialize};

use crate::{Energy, Physics, Plane, planes, scalar_code};

/// Code, live parts, physical checks and reflectance of a genome.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct Inspection {
    /// Content hash of the genome.
    pub hash: String,
    /// Hash of the expressed program.
    pub program_hash: String,
    /// Dialect in its text form.
    pub dialect: String,
    /// Names of the inputs the program reads.
    pub inputs: Vec<String>,
    /// Sizes before and after lowering.
    pub counts: OperationCounts,
    /// Sign, finiteness, reciprocity.
    pub physics: Physics,
    /// Largest directional albedo.
    pub energy: Energy,
    /// Slopes of its bumps. The other checks are of the BRDF about the normal that they turn. About
    /// the mesh's normal, f is then not reciprocal, and the energy limit holds where the surface is
    /// not steep.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub bumps: Option<Slopes>,
    /// Genome text; the last lines are the instructions.
    pub source: String,
    /// Per instruction: true if it can change the result.
    pub live: Vec<bool>,
    /// Per instruction: the channels that depend on it, a subset of `rgb`.
    pub channels: Vec<String>,
    /// Scalar operations executed, one per line.
    pub code: String,
    /// Reflectance over planes of incidence.
    pub planes: Vec<Plane>,
}

/// Slopes of bumps, on a grid of texture positions in the unit square.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct Slopes {
    /// Mean slope: the tangent of the angle by which the normal turns.
    pub mean: f64,
    /// Largest slope that was found.
    pub largest: f64,
}

impl Slopes {
    /// Number of positions along u and v: a prime, so that few waves repeat at each.
    const SIDE: u32 = 61;

    fn of(bumps: &Bumps) -> Self {
        let at = |k: u32| (f64::from(k) + 0.5) / f64::from(Self::SIDE);
        let slopes = (0..Self::SIDE * Self::SIDE).map(|k| {
            let [along_u, along_v] = bumps.slopes(at(k % Self::SIDE), at(k / Self::SIDE));
            along_u.hypot(along_v)
        });
        let (sum, largest) =
            slopes.fold((0.0, 0.0), |(sum, largest): (f64, f64), s| (sum + s, largest.max(s)));
        Self { mean: sum / f64::from(Self::SIDE * Self::SIDE), largest }
    }
}

/// Sizes before and after each step of lowering.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct OperationCounts {
    /// Number of instructions of the genome.
    pub instructions: u32,
    /// Number of instructions that can change the result.
    pub live_instructions: u32,
    /// Number of scalar operations for all components written.
    pub scalar_operations: u32,
    /// Number after per-component dead-code removal.
    pub live_scalar_operations: u32,
    /// Number after value numbering.
    pub numbered_operations: u32,
    /// Number after constant folding, executed per sample.
    pub operations: u32,
    /// Number of inputs the program reads.
    pub inputs_read: usize,
    /// Number of inputs in the catalogue.
    pub inputs_known: usize,
    /// Number of values live at once.
    pub registers: usize,
}

/// Returns the full report on a genome.
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
            inputs_known: Input::SYMMETRIC,
            registers: Tape::new(&program).registers().into(),
        },
        inputs,
        physics: Physics::of(&program),
        energy,
        bumps: program.bumps().map(Slopes::of),
        source: genome.to_string(),
        live: live_instructions(genome),
        channels: channels(genome),
        code: scalar_code(&program),
        planes: planes(&program),
    }
}

/// Per instruction, the letters of the channels that depend on it.
fn channels(genome: &Genome) -> Vec<String> {
    let masks = brood_genome::channels_of_instructions(genome);
    let word = |mask: u8| {
        let letters = "rgb".chars().enumerate();
        letters.filter(|(bit, _)| mask >> bit & 1 == 1).map(|(_, letter)| letter).collect()
    };
    masks.into_iter().map(word).collect()
}
