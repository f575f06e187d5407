//! Random programs for the stress test: every dialect, with ordinary constants and constants at the
//! ends of the range.

use brood_genome::{
    BirthKey, CONSTANTS, Dialect, Genome, OpcodeSet, Operator, Output, Parametrisation, RANGE,
    Stream, Variation,
};
use brood_program::Program;

/// Program of the stress test.
pub struct StressProgram {
    pub program: Program,
    /// True if the constants reach the ends of the range.
    pub is_extreme: bool,
}

/// Program of the given seed.
pub fn candidate(seed: u64) -> StressProgram {
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
        return StressProgram { program: Program::lower(&genome), is_extreme };
    }
    let mut stream = Stream::new(key, Operator::MutateConstants);
    let mut constants = Box::new([[0.0; 4]; CONSTANTS]);
    for constant in constants.iter_mut().flatten() {
        *constant = extreme(&mut stream);
    }
    let instructions = genome.instructions().to_vec();
    let genome = Genome::new(dialect, instructions, constants, Output::IDENTITY)
        .expect("the constants are within the range");
    StressProgram { program: Program::lower(&genome), is_extreme }
}

/// Random constant: uniform over the range, at its ends, ordinary, tiny, subnormal or zero.
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
        let candidates: Vec<StressProgram> = (0..160).map(candidate).collect();
        let extreme = candidates.iter().filter(|c| c.is_extreme);
        assert_eq!(extreme.clone().count(), 80);
        let at_the_end = |c: &&StressProgram| {
            c.program.constants().iter().any(|constant| constant.canonical >= RANGE)
        };
        assert!(extreme.clone().filter(at_the_end).count() > 20);
    }
}
