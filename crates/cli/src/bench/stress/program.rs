//! Programs meant to break evaluators: every dialect, ordinary constants and those at the ends of the range.

use brood_genome::{
    BirthKey, CONSTANTS, Dialect, Genome, OpcodeSet, Operator, Output, Parametrisation, RANGE,
    Stream, Variation,
};
use brood_program::Program;

/// A program and whether its constants reach to the ends of the range.
pub struct Candidate {
    pub program: Program,
    pub is_extreme: bool,
}

/// The program of that seed.
pub fn candidate(seed: u64) -> Candidate {
    let paper = Dialect::default();
    let dialect = match seed % 4 {
        0 | 1 => paper,
        2 => Dialect { parametrisation: Parametrisation::Paper, ..paper },
        _ => Dialect { opcodes: OpcodeSet::Extended, registers: 10, ..paper },
    };
    let key = BirthKey { seed, slot: u32::MAX - 1, attempt: 0 };
    let genome = Variation::random(dialect).birth(key);
    let is_extreme = seed % 8 >= 4;
    if !is_extreme {
        return Candidate { program: Program::lower(&genome), is_extreme };
    }
    let mut stream = Stream::new(key, Operator::MutateConstants);
    let mut constants = Box::new([[0.0; 4]; CONSTANTS]);
    for constant in constants.iter_mut().flatten() {
        *constant = extreme(&mut stream);
    }
    let instructions = genome.instructions().to_vec();
    let genome = Genome::new(dialect, instructions, constants, Output::IDENTITY)
        .expect("the constants are within the range");
    Candidate { program: Program::lower(&genome), is_extreme }
}

/// Uniform over the range, at its ends, ordinary, tiny, subnormal or zero.
fn extreme(stream: &mut Stream) -> f32 {
    let uniform = 2.0 * stream.unit() - 1.0;
    match stream.below(8) {
        0..3 => uniform * RANGE,
        3 => RANGE.copysign(uniform),
        4 => uniform * 4.0,
        5 => uniform * 1e-20,
        6 => uniform * 1e-39,
        _ => 0.0f32.copysign(uniform),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_the_programs_reach_the_ends_of_the_range() {
        let candidates: Vec<Candidate> = (0..160).map(candidate).collect();
        let extreme = candidates.iter().filter(|c| c.is_extreme);
        assert_eq!(extreme.clone().count(), 80);
        let at_the_end = |c: &&Candidate| {
            c.program.constants().iter().any(|constant| constant.canonical >= RANGE)
        };
        assert!(extreme.clone().filter(at_the_end).count() > 20);
    }
}
