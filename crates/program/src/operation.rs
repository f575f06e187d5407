//! Scalar operations: numbers, operands, names, results.

use brood_genome::{Arithmetic, Function};

brood_brdf::named_enum! {
    numbered
    /// A scalar operation. Signs are part of the operation, never of an operand.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
    #[repr(u8)]
    pub enum Operation {
        /// a + b.
        Add => "add",
        /// a - b.
        Sub => "sub",
        /// a b.
        Mul => "mul",
        /// sin a.
        Sin => "sin",
        /// cos a.
        Cos => "cos",
        /// 2^a.
        Ex2 => "ex2",
        /// 2^-a.
        Ex2Neg => "ex2_neg",
        /// log2(a^2 + 2^-24).
        Lg2 => "lg2",
        /// a / (a^2 + 2^-24).
        Rcp => "rcp",
        /// 1 / sqrt(a^2 + 2^-24).
        Rsq => "rsq",
        /// log2(1 + 2^a).
        Spl => "spl",
        /// log2(1 + 2^-a).
        SplNeg => "spl_neg",
        /// a clamped to [0, 1].
        Saturate => "sat",
        /// -a clamped to [0, 1].
        SaturateNeg => "sat_neg",
        /// 1 where a >= 0, else 0.
        Step => "step",
        /// 1 where -a >= 0, else 0.
        StepNeg => "step_neg",
    }
}

impl Operation {
    /// Returns the operation that computes a function of a value, or of the negative of a value,
    /// and true if the result is to be negated.
    #[inline(always)]
    #[must_use]
    pub fn of(function: Function, is_negative: bool) -> (Self, bool) {
        match (function, is_negative) {
            (Function::Sin, _) => (Self::Sin, is_negative),
            (Function::Cos, _) => (Self::Cos, false),
            (Function::Ex2, false) => (Self::Ex2, false),
            (Function::Ex2, true) => (Self::Ex2Neg, false),
            (Function::Lg2, _) => (Self::Lg2, false),
            (Function::Rcp, _) => (Self::Rcp, is_negative),
            (Function::Rsq, _) => (Self::Rsq, false),
            (Function::Spl, false) => (Self::Spl, false),
            (Function::Spl, true) => (Self::SplNeg, false),
            (Function::Saturate, false) => (Self::Saturate, false),
            (Function::Saturate, true) => (Self::SaturateNeg, false),
            (Function::Step, false) => (Self::Step, false),
            (Function::Step, true) => (Self::StepNeg, false),
        }
    }

    /// Returns the kind of an operation with two operands, or `None` if it takes one.
    #[inline(always)]
    #[must_use]
    pub fn binary(self) -> Option<Binary> {
        match self {
            Self::Add => Some(Binary::Add),
            Self::Sub => Some(Binary::Sub),
            Self::Mul => Some(Binary::Mul),
            Self::Sin | Self::Cos | Self::Ex2 | Self::Ex2Neg => None,
            Self::Lg2 | Self::Rcp | Self::Rsq | Self::Spl | Self::SplNeg => None,
            Self::Saturate | Self::SaturateNeg | Self::Step | Self::StepNeg => None,
        }
    }

    /// True if the operation takes a second operand.
    #[must_use]
    pub fn is_binary(self) -> bool {
        self.binary().is_some()
    }

    /// Applies the operation to a pair of values; a unary operation ignores `b`.
    #[inline(always)]
    pub fn apply<T: Arithmetic>(self, a: T, b: T) -> T {
        match self {
            Self::Add => a.add(b),
            Self::Sub => a.add(b.neg()),
            Self::Mul => a.mul(b),
            Self::Sin => a.sine(),
            Self::Cos => a.cosine(),
            Self::Ex2 => a.ex2(),
            Self::Ex2Neg => a.neg().ex2(),
            Self::Lg2 => a.lg2(),
            Self::Rcp => a.rcp(),
            Self::Rsq => a.rsq(),
            Self::Spl => a.spl(),
            Self::SplNeg => a.neg().spl(),
            Self::Saturate => a.saturate(),
            Self::SaturateNeg => a.neg().saturate(),
            Self::Step => a.step(),
            Self::StepNeg => a.neg().step(),
        }
    }
}

/// An operation with two operands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Binary {
    /// a + b.
    Add,
    /// a - b.
    Sub,
    /// a b.
    Mul,
}

/// Branches once on an operation: evaluates an expression in which the operation is a constant, so
/// that loops are compiled for each operation.
#[macro_export(local_inner_macros)]
macro_rules! for_known {
    ($operation:expr, $known:ident => $do:expr) => {
        for_known!(@arms $operation, $known => $do;
            Add Sub Mul Sin Cos Ex2 Ex2Neg Lg2 Rcp Rsq Spl SplNeg
            Saturate SaturateNeg Step StepNeg)
    };
    (@arms $operation:expr, $known:ident => $do:expr; $($name:ident)*) => {
        match $operation {
            $($crate::Operation::$name => {
                let $known = $crate::Operation::$name;
                $do
            })*
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn second_operand_counts_only_for_binary_operations() {
        for operation in Operation::ALL {
            let result = |b: f64| operation.apply(0.7_f64, b);
            assert_eq!(operation.is_binary(), result(0.3).to_bits() != result(0.4).to_bits());
        }
        let binary = [Operation::Add, Operation::Sub, Operation::Mul].map(Operation::binary);
        assert_eq!(binary, [Binary::Add, Binary::Sub, Binary::Mul].map(Some));
    }

    #[test]
    fn functions_of_negative_values_are_operations_on_the_positive() {
        type Case = (Function, fn(f64) -> f64);
        let cases: [Case; 9] = [
            (Function::Sin, |x| x.sine()),
            (Function::Cos, |x| x.cosine()),
            (Function::Ex2, |x| x.ex2()),
            (Function::Lg2, |x| x.lg2()),
            (Function::Rcp, |x| x.rcp()),
            (Function::Rsq, |x| x.rsq()),
            (Function::Spl, |x| x.spl()),
            (Function::Saturate, |x| x.saturate()),
            (Function::Step, |x| x.step()),
        ];
        for (function, expected) in cases {
            for is_negative in [false, true] {
                let (operation, negate) = Operation::of(function, is_negative);
                let result = operation.apply(0.7_f64, 0.7);
                let result = if negate { -result } else { result };
                let value = if is_negative { -0.7 } else { 0.7 };
                assert_eq!(result.to_bits(), expected(value).to_bits(), "{function:?} {value}");
            }
        }
    }
}
