//! Interval arithmetic over a program: the range of each step, given those of the inputs, and
//! thereby the clamps that can never act.
//!
//! Rounding to nearest is monotone, so the range of a rounded sum or product is spanned by the
//! rounded ends; the ranges hold for every bit of canonical f32, not only up to an error.

use brood_genome::{Arithmetic, Functions, Input, RANGE};

use crate::{Operand, Operation, Program};

/// 1 / sqrt(e), the largest reciprocal root, with e = [`Functions::EPSILON`].
const RSQ_MAX: f32 = 4096.0;
const _: () = assert!(
    (RSQ_MAX * RSQ_MAX * Functions::EPSILON).to_bits() == 1f32.to_bits(),
    "the largest reciprocal root is that of EPSILON"
);
/// log2 of e, a power of two: its exponent.
const LG2_MIN: f32 = (Functions::EPSILON.to_bits() >> 23) as f32 - 127.0;
/// Bound of log2(x^2 + e): the range of the machine ends below 2^16.
const LG2_MAX: f32 = 32.0;
const _: () = assert!(RANGE < 65536.0, "the range ends below 2^16");

/// All values from `low` to `high`, both finite and within the machine's range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Least value.
    pub low: f32,
    /// Largest value.
    pub high: f32,
}

/// Range and clamps of one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepRange {
    /// Range of the result.
    pub result: Range,
    /// True if the clamp of the result can act; false for operations that clamp only their
    /// argument.
    pub clamps: bool,
    /// True if the clamp of the argument of sine, cosine or the power of two can act.
    pub clamps_argument: bool,
}

impl Range {
    /// Every number of the machine.
    pub const ALL: Self = Self { low: -RANGE, high: RANGE };

    /// Returns the range of one value.
    #[must_use]
    pub fn point(value: f32) -> Self {
        Self { low: value, high: value }
    }

    /// Returns the least range that contains all values, or [`Range::ALL`] if there are none.
    #[must_use]
    pub fn of(values: &[f32]) -> Self {
        let Some((first, rest)) = values.split_first() else { return Self::ALL };
        rest.iter().fold(Self::point(*first), |range, value| Self {
            low: if *value < range.low { *value } else { range.low },
            high: if *value > range.high { *value } else { range.high },
        })
    }

    fn is_within(self, low: f32, high: f32) -> bool {
        low <= self.low && self.high <= high
    }

    /// Widens the range by 2^-20 relative and the least normal number, which is more than the error
    /// of any function.
    #[inline(always)]
    fn widened(self) -> Self {
        let slack = |x: f32| x.abs() * (1.0 / 1_048_576.0) + f32::MIN_POSITIVE;
        Self { low: self.low - slack(self.low), high: self.high + slack(self.high) }
    }

    /// Returns the range clamped to that of the machine, and true if that changes it.
    #[inline(always)]
    fn clamped(self) -> (Self, bool) {
        let result =
            Self { low: self.low.clamp(-RANGE, RANGE), high: self.high.clamp(-RANGE, RANGE) };
        (result, result != self)
    }

    fn negated(self) -> Self {
        Self { low: -self.high, high: -self.low }
    }
}

/// Returns the ranges of all steps in order.
///
/// # Domain
/// `input` returns a range that contains every value of that input: any finite range within that of
/// the machine.
///
/// # Error
/// None: no canonical f32 value leaves its range (`no_value_leaves_its_range`).
#[must_use]
pub fn step_ranges(program: &Program, input: impl Fn(Input) -> Range) -> Vec<StepRange> {
    let mut ranges: Vec<StepRange> = Vec::with_capacity(program.steps().len());
    for step in program.steps() {
        let read = |operand| match operand {
            Operand::Step(index) => ranges[usize::from(index)].result,
            Operand::Input(name) => input(name),
            Operand::Constant(index) => {
                Range::point(program.constants()[usize::from(index)].canonical)
            }
        };
        let (a, b) = (read(step.a), read(step.b));
        ranges.push(StepRange::of(step.operation, a, b, step.a == step.b));
    }
    ranges
}

impl StepRange {
    /// Returns the range of an operation on operands of these ranges; `same` if both are one value.
    // Inlined into the calling loop: a struct returned from a call would be read back from memory
    // late.
    #[inline(always)]
    #[must_use]
    pub fn of(operation: Operation, a: Range, b: Range, same: bool) -> Self {
        match operation {
            Operation::Add => arithmetic(Range { low: a.low + b.low, high: a.high + b.high }),
            Operation::Sub => arithmetic(Range { low: a.low - b.high, high: a.high - b.low }),
            Operation::Mul => arithmetic(product(a, b, same)),
            Operation::Sin | Operation::Cos => Self {
                // The polynomials may exceed 1 by a rounding.
                result: Range { low: -1.0, high: 1.0 }.widened(),
                clamps: false,
                clamps_argument: !a.is_within(-Functions::ANGLE_RANGE, Functions::ANGLE_RANGE),
            },
            Operation::Ex2 => power(a),
            Operation::Ex2Neg => power(a.negated()),
            Operation::Lg2 => function(Range { low: LG2_MIN, high: LG2_MAX }),
            // |x| / (x^2 + e) has its largest value, 1 / (2 sqrt e), at sqrt e = 2^-12.
            Operation::Rcp => function(Range { low: -0.5 * RSQ_MAX, high: 0.5 * RSQ_MAX }),
            Operation::Rsq => function(Range { low: 0.0, high: RSQ_MAX }),
            Operation::Spl | Operation::SplNeg => Self {
                result: Range { low: 0.0, high: RANGE },
                clamps: true,
                clamps_argument: true,
            },
            Operation::Saturate => saturated(a),
            Operation::SaturateNeg => saturated(a.negated()),
            Operation::Step | Operation::StepNeg => Self {
                result: Range { low: 0.0, high: 1.0 },
                clamps: false,
                clamps_argument: false,
            },
        }
    }
}

/// Range of a saturated value. Its clamp is the operation itself, and is never left out.
#[inline(always)]
fn saturated(argument: Range) -> StepRange {
    let result = Range { low: argument.low.saturate(), high: argument.high.saturate() };
    StepRange { result, clamps: false, clamps_argument: false }
}

/// Range of a sum, difference or product, given its range before the clamp.
#[inline(always)]
fn arithmetic(exact: Range) -> StepRange {
    let (result, clamps) = exact.clamped();
    StepRange { result, clamps, clamps_argument: false }
}

/// Range of a function without clamps, given the range of its exact values.
#[inline(always)]
fn function(result: Range) -> StepRange {
    StepRange { result: result.widened(), clamps: false, clamps_argument: false }
}

/// Range of a product before the clamp. With `square` it is that of one value with itself, which is
/// not negative.
#[inline(always)]
fn product(a: Range, b: Range, square: bool) -> Range {
    let ends = [a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high];
    if !square {
        return Range::of(&ends);
    }
    let low = if a.low <= 0.0 && a.high >= 0.0 { 0.0 } else { smaller(ends[0], ends[3]) };
    Range { low, high: if ends[0] > ends[3] { ends[0] } else { ends[3] } }
}

#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Range of the power of two.
#[inline(always)]
fn power(argument: Range) -> StepRange {
    let ends = Range { low: argument.low.ex2(), high: argument.high.ex2() };
    let (result, _) = ends.widened().clamped();
    StepRange {
        result,
        // 2^15.99 is below the end of the range, 2^16 is not.
        clamps: argument.high > 15.9,
        clamps_argument: !argument.is_within(Functions::EX2_RANGE.0, Functions::EX2_RANGE.1),
    }
}

#[cfg(test)]
mod tests {
    use brood_genome::{BirthKey, Dialect, OpcodeSet, Variation};
    use proptest::prelude::*;

    use super::*;

    /// Returns the values of all steps by their definition.
    fn values(program: &Program, input: impl Fn(Input) -> f32) -> Vec<f32> {
        let mut values: Vec<f32> = Vec::new();
        for step in program.steps() {
            let read = |operand| match operand {
                Operand::Step(index) => values[usize::from(index)],
                Operand::Input(name) => input(name),
                Operand::Constant(index) => program.constants()[usize::from(index)].canonical,
            };
            values.push(step.operation.apply(read(step.a), read(step.b)));
        }
        values
    }

    /// Returns the result without the clamp.
    fn unclamped(operation: Operation, a: f32, b: f32) -> f32 {
        match operation {
            Operation::Add => a + b,
            Operation::Sub => a - b,
            Operation::Mul => a * b,
            _ => operation.apply(a, b),
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]

        #[test]
        fn no_value_leaves_its_range(
            seed in any::<u64>(), extended: bool, exponent in -20i32..16, samples in any::<[u16; 8]>(),
        ) {
            let opcodes = if extended { OpcodeSet::Extended } else { OpcodeSet::Paper };
            let dialect = Dialect { opcodes, registers: 10, ..Dialect::default() };
            let genome = Variation::random(dialect).birth(BirthKey { seed, slot: 0, attempt: 0 });
            let program = Program::lower(&genome);
            let scale = 2f32.powi(exponent).min(RANGE / 2.0);
            let range = |input: Input| {
                let shift = input.index() as f32 / 23.0 - 0.5;
                Range { low: (shift - 0.5) * scale, high: (shift + 0.7) * scale }
            };
            let ranges = step_ranges(&program, range);
            prop_assert_eq!(ranges.len(), program.steps().len());
            for sample in samples {
                let input = |name: Input| {
                    let Range { low, high } = range(name);
                    let mix = sample.rotate_left(name.index() as u32) % 5;
                    [low, high, 0.5 * (low + high), low, high][usize::from(mix)]
                };
                let values = values(&program, input);
                let operand = |operand| match operand {
                    Operand::Step(index) => values[usize::from(index)],
                    Operand::Input(name) => input(name),
                    Operand::Constant(index) => program.constants()[usize::from(index)].canonical,
                };
                for ((step, value), range) in program.steps().iter().zip(&values).zip(&ranges) {
                    let (a, b) = (operand(step.a), operand(step.b));
                    prop_assert!(range.result.is_within(-RANGE, RANGE), "{:?}", range);
                    prop_assert!(range.result.low <= *value && *value <= range.result.high, "{step:?} {a} {b} {value} {range:?}");
                    if !range.clamps {
                        prop_assert_eq!(unclamped(step.operation, a, b).to_bits(), value.to_bits());
                    }
                    if !range.clamps_argument && matches!(step.operation, Operation::Sin | Operation::Cos) {
                        prop_assert!(a.abs() <= Functions::ANGLE_RANGE);
                    }
                }
            }
        }
    }

    #[test]
    fn functions_stay_within_their_ranges_over_the_whole_range_of_the_machine() {
        for operation in Operation::ALL.into_iter().filter(|operation| !operation.is_binary()) {
            let whole = StepRange::of(operation, Range::ALL, Range::ALL, true);
            for exponent in -30..=15 {
                for mantissa in 0..4096u32 {
                    let magnitude = 2f32.powi(exponent) * (1.0 + mantissa as f32 / 4096.0);
                    for x in [magnitude, -magnitude, 0.0] {
                        let x = x.clamp(-RANGE, RANGE);
                        let y = operation.apply(x, x);
                        assert!(
                            whole.result.low <= y && y <= whole.result.high,
                            "{operation:?} {x} {y}"
                        );
                        let near =
                            StepRange::of(operation, Range::point(x), Range::point(x), true).result;
                        assert!(near.low <= y && y <= near.high, "{operation:?} {x} {y} {near:?}");
                    }
                }
            }
        }
    }

    fn range(low: f32, high: f32) -> Range {
        Range { low, high }
    }

    #[test]
    fn sums_and_products_are_spanned_by_their_ends() {
        let of = |operation, a, b, same| {
            let StepRange { result, clamps, clamps_argument } =
                StepRange::of(operation, a, b, same);
            assert!(!clamps_argument);
            (result, clamps)
        };
        let (a, b) = (range(-1.0, 2.0), range(3.0, 5.0));
        assert_eq!(of(Operation::Add, a, b, false), (range(2.0, 7.0), false));
        assert_eq!(of(Operation::Sub, a, b, false), (range(-6.0, -1.0), false));
        assert_eq!(of(Operation::Mul, a, b, false), (range(-5.0, 10.0), false));
        assert_eq!(of(Operation::Mul, a, a, false), (range(-2.0, 4.0), false));
        let squares = [(a, 0.0, 4.0), (b, 9.0, 25.0), (b.negated(), 9.0, 25.0)];
        for (of_both, low, high) in squares {
            assert_eq!(of(Operation::Mul, of_both, of_both, true), (range(low, high), false));
        }
        let whole = Range::ALL;
        assert_eq!(of(Operation::Add, whole, whole, false), (whole, true));
        assert_eq!(of(Operation::Mul, whole, whole, true), (range(0.0, RANGE), true));
        let half = range(-0.5 * RANGE, 0.5 * RANGE);
        assert_eq!(of(Operation::Add, half, half, false), (whole, false));
    }

    #[test]
    fn functions_have_their_ranges_with_a_margin() {
        let of = |operation, a: Range| StepRange::of(operation, a, a, true);
        let margin = |x: f32| x * (1.0 + 1.0 / 1_048_576.0);
        let any = range(-3.0, 4.0);
        let bounds = [
            (Operation::Sin, margin(-1.0), margin(1.0)),
            (Operation::Cos, margin(-1.0), margin(1.0)),
            (Operation::Lg2, margin(-24.0), margin(32.0)),
            (Operation::Rcp, margin(-2048.0), margin(2048.0)),
            (Operation::Rsq, -f32::MIN_POSITIVE, margin(4096.0)),
        ];
        for (operation, low, high) in bounds {
            let expected =
                StepRange { result: range(low, high), clamps: false, clamps_argument: false };
            assert_eq!(of(operation, any), expected, "{operation:?}");
        }
        for operation in [Operation::Spl, Operation::SplNeg] {
            let expected =
                StepRange { result: range(0.0, RANGE), clamps: true, clamps_argument: true };
            assert_eq!(of(operation, any), expected);
        }
        let power = of(Operation::Ex2, range(0.0, 3.0));
        assert_eq!(power.result, range(1.0, 8.0).widened());
        assert_eq!(of(Operation::Ex2Neg, range(-3.0, 0.0)), power);
    }

    #[test]
    fn clamps_can_act_only_outside_of_their_limits() {
        let (angle, power) = (Functions::ANGLE_RANGE, Functions::EX2_RANGE);
        let clamps_argument = |operation, low, high| {
            let argument = range(low, high);
            StepRange::of(operation, argument, argument, true).clamps_argument
        };
        for operation in [Operation::Sin, Operation::Cos] {
            assert!(!clamps_argument(operation, -angle, angle));
            assert!(clamps_argument(operation, -angle.next_up(), angle));
            assert!(clamps_argument(operation, -angle, angle.next_up()));
        }
        assert!(!clamps_argument(Operation::Ex2, power.0, power.1));
        assert!(clamps_argument(Operation::Ex2, power.0.next_down(), power.1));
        assert!(clamps_argument(Operation::Ex2, power.0, power.1.next_up()));
        let clamps = |high: f32| {
            let argument = range(0.0, high);
            StepRange::of(Operation::Ex2, argument, argument, true).clamps
        };
        assert_eq!([15.0, 15.9, 15.9_f32.next_up(), 20.0].map(clamps), [false, false, true, true]);
    }

    #[test]
    fn range_of_values_contains_them() {
        assert_eq!(Range::of(&[2.0, -1.0, 3.0]), range(-1.0, 3.0));
        assert_eq!(Range::of(&[]), Range::ALL);
    }
}
