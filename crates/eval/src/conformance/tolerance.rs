//! Tolerance table: largest difference between f64 and canonical f32 after one operation.

use brood_genome::{Genome, Opcode};
use brood_program::Program;
use brood_scene::SampleSet;

use super::bits::canonical;
use super::cases::sample_sets;
use crate::Evaluator;

/// Tolerance of an evaluator that is not exact after one opcode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Opcode, applied once to inputs in [-2, 2].
    pub opcode: Opcode,
    /// Largest difference in g = sqrt(f), relative to max(1, |g|).
    pub bound: f64,
}

/// Bound of each opcode. A test fails if a bound exceeds four times the largest error that was
/// measured against the f64 reference.
pub const TOLERANCES: [Tolerance; 17] = [
    Tolerance { opcode: Opcode::Add, bound: 1.2e-7 },
    Tolerance { opcode: Opcode::Sub, bound: 1.2e-7 },
    Tolerance { opcode: Opcode::Mul, bound: 1.2e-7 },
    Tolerance { opcode: Opcode::Mov, bound: 1.2e-7 },
    Tolerance { opcode: Opcode::Mad, bound: 2.4e-7 },
    Tolerance { opcode: Opcode::Lrp, bound: 2.4e-7 },
    Tolerance { opcode: Opcode::Dp3, bound: 2.4e-7 },
    Tolerance { opcode: Opcode::Dp4, bound: 2.4e-7 },
    Tolerance { opcode: Opcode::Dst, bound: 1.2e-7 },
    Tolerance { opcode: Opcode::X2d, bound: 2.4e-7 },
    Tolerance { opcode: Opcode::Sin, bound: 1.2e-7 },
    Tolerance { opcode: Opcode::Cos, bound: 1.2e-7 },
    Tolerance { opcode: Opcode::Ex2, bound: 1.8e-7 },
    Tolerance { opcode: Opcode::Lg2, bound: 2.4e-7 },
    Tolerance { opcode: Opcode::Rcp, bound: 4.8e-7 },
    Tolerance { opcode: Opcode::Rsq, bound: 4.8e-7 },
    Tolerance { opcode: Opcode::Spl, bound: 2.4e-7 },
];

/// Returns the largest difference over the samples of the suite for one opcode.
fn measure(evaluator: &dyn Evaluator, opcode: Opcode) -> f64 {
    let operands = match (opcode.operands(), opcode.is_scalar()) {
        (1, true) => "R2.y",
        (1, false) => "R2",
        (2, _) => "R2, R3.zwyx",
        _ => "R2, R3.zwyx, R4.yxwz",
    };
    let text = format!(
        "brood 1\n.dialect extended smooth registers 10 homogeneous\n{} R0, {operands}\n",
        opcode.name()
    );
    let genome: Genome = text.parse().expect("one instruction of the extended dialect");
    let program = Program::lower(&genome);
    let mut worst: f64 = 0.0;
    for set in sample_sets() {
        let mut out = Vec::new();
        evaluator.eval(&[&program], &set, &mut out).expect("one operation is evaluated");
        for sample in 0..set.len() {
            worst = worst.max(difference(&program, &set, &out, sample));
        }
    }
    worst
}

/// Returns the largest difference in g from canonical f32 at one sample, over the channels.
fn difference(program: &Program, set: &SampleSet, out: &[f32], sample: usize) -> f64 {
    let expected = canonical(program, None, set, sample);
    (0..3)
        .map(|channel| {
            let got = f64::from(out[channel * set.len() + sample]).sqrt();
            let expected = f64::from(expected[channel]).sqrt();
            (got - expected).abs() / expected.max(1.0)
        })
        .fold(0.0, f64::max)
}

/// Checks an evaluator against the table; an exact one must not differ at all.
pub(super) fn check(evaluator: &dyn Evaluator) {
    for opcode in Opcode::ALL {
        let entry = TOLERANCES.iter().find(|tolerance| tolerance.opcode == opcode);
        let bound = entry.map(|tolerance| tolerance.bound);
        let bound = bound.unwrap_or_else(|| panic!("{} has no tolerance", opcode.name()));
        let bound = if evaluator.is_exact() { 0.0 } else { bound };
        let measured = measure(evaluator, opcode);
        let name = evaluator.name();
        assert!(
            measured <= bound,
            "{name}: {} has an error of {measured:e}, at most {bound:e} is allowed",
            opcode.name(),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ReferenceEvaluator;

    #[test]
    fn bounds_are_at_most_four_times_the_measured_error() {
        for tolerance in TOLERANCES {
            let measured = measure(&ReferenceEvaluator, tolerance.opcode);
            let slack = tolerance.bound / measured.max(3e-8);
            println!("{}: measured {measured:.2e}, slack {slack:.2}", tolerance.opcode.name());
            assert!(slack <= 4.0, "{}: {measured:e}", tolerance.opcode.name());
        }
    }
}
