//! Slopes of bumps: the derivatives of their height, by forward differentiation of its scalar code.

use std::cell::RefCell;

use brood_genome::{Bump, Function, Input, ScalarMachine, expand};

use crate::build::{Builder, Reference};
use crate::execute::execute_into;
use crate::lower::{SCRATCH, Scratch};
use crate::{Bumps, Meaning};

thread_local! {
    /// Memory of [`Bumps::slopes`], reused because it is called for each sample.
    static VALUES: RefCell<Vec<f64>> = const { RefCell::new(Vec::new()) };
}

impl Bumps {
    /// Lowers bumps; `None` if they are flat: no slope depends on the position or differs from 0.
    ///
    /// # Source
    /// Wengert 1964, *A simple automatic derivative evaluation program*. Where the machine clamps a
    /// value, the derivative is that of the value before the clamp.
    #[must_use]
    pub fn lower(bump: &Bump) -> Option<Self> {
        SCRATCH.with_borrow_mut(|Scratch { liveness, builder, collected }| {
            liveness.find(bump.program());
            builder.clear(false);
            let mut machine = Differentiating { builder };
            let [height, ..] = expand(bump.program(), liveness, &mut machine);
            let strength = builder.constant(bump.strength());
            let [along_u, along_v] =
                [height.by_u, height.by_v].map(|slope| builder.mul(slope, strength));
            let zero = builder.constant(0.0);
            if [along_u, along_v].iter().all(|slope| slope.node() == zero.node()) {
                return None;
            }
            let is_negative = [along_u, along_v].map(Reference::is_negative);
            let code = collected.code(builder, [along_u, along_v, zero], Meaning::Slopes);
            Some(Self { code, is_negative })
        })
    }

    /// Returns the changes of the height by u and by v, in the f64 reference.
    ///
    /// # Domain
    /// Any finite texture position; slopes are within [-65504, 65504].
    #[must_use]
    pub fn slopes(&self, u: f64, v: f64) -> [f64; 2] {
        let input = |input| match input {
            Input::U => u,
            Input::V => v,
            _ => unreachable!("bumps read u and v alone"),
        };
        let results = VALUES.with_borrow_mut(|values| {
            execute_into(&self.code, input, |constant| constant.reference, values)
        });
        [0, 1].map(|k| if self.is_negative[k] { -results[k] } else { results[k] })
    }
}

/// A value with its derivatives.
#[derive(Debug, Clone, Copy, Default)]
struct Slope {
    value: Reference,
    by_u: Reference,
    by_v: Reference,
}

/// Machine that also computes derivatives.
struct Differentiating<'a> {
    builder: &'a mut Builder,
}

impl Differentiating<'_> {
    /// Value that does not depend on the position.
    fn flat(&mut self, value: Reference) -> Slope {
        let zero = self.builder.constant(0.0);
        Slope { value, by_u: zero, by_v: zero }
    }

    /// Derivative of a function of the machine at a value, given the result. `docs/maths/bumps.md`
    /// has the formulas.
    fn derivative(&mut self, function: Function, at: Reference, result: Reference) -> Reference {
        let builder = &mut *self.builder;
        match function {
            Function::Sin => builder.function(Function::Cos, at),
            Function::Cos => {
                let sine = builder.function(Function::Sin, at);
                builder.neg(sine)
            }
            Function::Ex2 => {
                let scale = builder.constant(std::f32::consts::LN_2);
                builder.mul(scale, result)
            }
            Function::Lg2 => {
                let scale = builder.constant(2.0 * std::f32::consts::LOG2_E);
                let reciprocal = builder.function(Function::Rcp, at);
                builder.mul(scale, reciprocal)
            }
            Function::Rcp => {
                // 1 / (a^2 + e) - 2 a^2 / (a^2 + e)^2.
                let root = builder.function(Function::Rsq, at);
                let square = builder.mul(root, root);
                let twice = builder.add(result, result);
                let product = builder.mul(twice, result);
                let product = builder.neg(product);
                builder.add(square, product)
            }
            Function::Rsq => {
                let reciprocal = builder.function(Function::Rcp, at);
                let product = builder.mul(reciprocal, result);
                builder.neg(product)
            }
            Function::Spl => {
                // 2^a / (1 + 2^a) = 2^(a - result).
                let result = builder.neg(result);
                let exponent = builder.add(at, result);
                builder.function(Function::Ex2, exponent)
            }
            Function::Saturate => {
                let one = builder.constant(1.0);
                let beyond = builder.neg(at);
                let below_one = builder.add(one, beyond);
                let [above, below] = [at, below_one].map(|x| builder.function(Function::Step, x));
                builder.mul(above, below)
            }
            Function::Step => builder.constant(0.0),
        }
    }
}

impl ScalarMachine for Differentiating<'_> {
    type Value = Slope;

    fn constant(&mut self, value: f32) -> Slope {
        let value = self.builder.constant(value);
        self.flat(value)
    }

    fn parameter(&mut self, register: u8, component: usize, value: f32) -> Slope {
        let value = self.builder.parameter(register, component, value);
        self.flat(value)
    }

    fn input(&mut self, input: Input) -> Slope {
        let value = self.builder.input(input);
        let [zero, one] = [0.0, 1.0].map(|value| self.builder.constant(value));
        let by = |of| if input == of { one } else { zero };
        Slope { value, by_u: by(Input::U), by_v: by(Input::V) }
    }

    fn neg(&mut self, a: Slope) -> Slope {
        let Slope { value, by_u, by_v } = a;
        let [value, by_u, by_v] = [value, by_u, by_v].map(|part| self.builder.neg(part));
        Slope { value, by_u, by_v }
    }

    fn add(&mut self, a: Slope, b: Slope) -> Slope {
        Slope {
            value: self.builder.add(a.value, b.value),
            by_u: self.builder.add(a.by_u, b.by_u),
            by_v: self.builder.add(a.by_v, b.by_v),
        }
    }

    fn mul(&mut self, a: Slope, b: Slope) -> Slope {
        let builder = &mut *self.builder;
        let mut product_rule = |by_a, by_b| {
            let (left, right) = (builder.mul(by_a, b.value), builder.mul(a.value, by_b));
            builder.add(left, right)
        };
        let (by_u, by_v) = (product_rule(a.by_u, b.by_u), product_rule(a.by_v, b.by_v));
        Slope { value: self.builder.mul(a.value, b.value), by_u, by_v }
    }

    fn function(&mut self, function: Function, a: Slope) -> Slope {
        let value = self.builder.function(function, a.value);
        let derivative = self.derivative(function, a.value, value);
        let [by_u, by_v] = [a.by_u, a.by_v].map(|by| self.builder.mul(derivative, by));
        Slope { value, by_u, by_v }
    }
}

#[cfg(test)]
mod tests {
    use brood_genome::{BirthKey, Dialect, DialectConstraints, Genome, Variation};
    use proptest::prelude::*;

    use super::*;
    use crate::{Program, execute};

    fn bump(lines: &str) -> Bump {
        let text = format!("brood 1\n.model lambert\n{lines}");
        let genome: Genome = text.parse().unwrap();
        genome.bump().unwrap().clone()
    }

    #[test]
    fn slopes_are_those_of_the_height() {
        for (lines, slopes) in [
            (".bump MOV R0, R0\n", [1.0, 0.0]),
            (".bump MOV R0, -R0.y\n", [0.0, -1.0]),
            (".bump strength 3\n.bump MUL R0, R0, R0.y\n", [3.0 * 0.5, 3.0 * 0.3]),
            (".bump SIN R0, R0.x\n", [0.3_f64.cos(), 0.0]),
            (".bump COS R0, R0.y\n", [0.0, -(0.5_f64.sin())]),
            (".bump EX2 R0, R0.x\n", [std::f64::consts::LN_2 * 0.3_f64.exp2(), 0.0]),
            (".bump LG2 R0, R0.x\n", [2.0 / (0.3 * std::f64::consts::LN_2), 0.0]),
            (".bump RCP R0, R0.x\n", [-1.0 / 0.09, 0.0]),
            (".bump RSQ R0, R0.y\n", [0.0, -4.0]),
            (".bump SPL R0, -R0.x\n", [-1.0 / (1.0 + 0.3_f64.exp2()), 0.0]),
        ] {
            let found = Bumps::lower(&bump(lines)).unwrap().slopes(0.3, 0.5);
            let is_close = |k: usize| (found[k] - slopes[k]).abs() < 1e-4 * (1.0 + slopes[k].abs());
            assert!(is_close(0) && is_close(1), "{lines}: {found:?} {slopes:?}");
        }
        for flat in [".bump MOV R0, R0.z\n", ".bump strength 0\n.bump MOV R0, R0\n"] {
            assert_eq!(Bumps::lower(&bump(flat)), None, "{flat}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]

        #[test]
        fn slopes_of_random_bumps_are_differences_of_their_heights(
            seed: u64, u in 0.01..0.99, v in 0.01..0.99,
        ) {
            let constraints = DialectConstraints { bumps: Some(true), ..Default::default() };
            let random = Variation::random(Dialect::default()).with_constraints(constraints);
            let genome = random.birth(BirthKey { seed, slot: 0, attempt: 0 });
            let bump = genome.bump().unwrap();
            let program =
                Program { meaning: Meaning::Slopes, ..Program::lower(bump.program()) };
            let height = |u: f64, v: f64| {
                let input = |input| if input == Input::U { u } else { v };
                let [height, ..] = execute(&program, input, |constant| constant.reference);
                height
            };
            let [along_u, along_v] = Bumps::lower(bump).unwrap().slopes(u, v);
            let step = 1e-5;
            let by_u = (height(u + step, v) - height(u - step, v)) / (2.0 * step);
            let by_v = (height(u, v + step) - height(u, v - step)) / (2.0 * step);
            // The sign of a result is not part of the code.
            prop_assert!((along_u.abs() - by_u.abs()).abs() < 1e-3 * (1.0 + by_u.abs()));
            prop_assert!((along_v.abs() - by_v.abs()).abs() < 1e-3 * (1.0 + by_v.abs()));
            prop_assert_eq!((along_u * along_v).is_sign_positive(), (by_u * by_v).is_sign_positive());
            // Random bumps are neither flat nor cliffs.
            prop_assert!(along_u.hypot(along_v) < 8.0);
        }
    }
}
