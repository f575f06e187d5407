//! Expansion of genomes into scalar operations: the meaning of every opcode, written once.
//!
//! A [`ScalarMachine`] computes with values of its own kind: numbers for [`crate::interpret`],
//! nodes for lowering, counts for statistics.

use crate::{
    Function, Genome, InitialValue, Input, Instruction, Liveness, Opcode, Operand, REGISTERS,
    Register,
};

/// Scalar operations on values of some kind.
pub trait ScalarMachine {
    /// A scalar value.
    type Value: Copy + Default;

    /// Constant of the machine.
    fn constant(&mut self, value: f32) -> Self::Value;
    /// Component of a constant register of the genome.
    fn parameter(&mut self, register: u8, component: usize, value: f32) -> Self::Value {
        let _ = (register, component);
        self.constant(value)
    }
    /// Input of the sample.
    fn input(&mut self, input: Input) -> Self::Value;
    /// Negation.
    fn neg(&mut self, a: Self::Value) -> Self::Value;
    /// Clamped sum.
    fn add(&mut self, a: Self::Value, b: Self::Value) -> Self::Value;
    /// Clamped product.
    fn mul(&mut self, a: Self::Value, b: Self::Value) -> Self::Value;
    /// A function of one value.
    fn function(&mut self, function: Function, a: Self::Value) -> Self::Value;
}

/// Computes the live components of a genome in the order of its instructions, and returns g of red,
/// green and blue.
#[inline(always)]
pub fn expand<M: ScalarMachine>(
    genome: &Genome,
    liveness: &Liveness,
    machine: &mut M,
) -> [M::Value; 3] {
    let zero = machine.constant(0.0);
    if genome.instructions().is_empty() {
        // An empty genome has no program: it does not return its inputs.
        return [zero; 3];
    }
    let mut registers = [[zero; 4]; REGISTERS];
    let dialect = genome.dialect();
    for register in 0..dialect.registers {
        let read = liveness.initial[usize::from(register)];
        let components = registers[usize::from(register)].iter_mut().enumerate();
        for (component, value) in components.filter(|(component, _)| read >> component & 1 == 1) {
            *value = match dialect.initial(register, component) {
                InitialValue::Zero => zero,
                InitialValue::One => machine.constant(1.0),
                InitialValue::Input(input) => machine.input(input),
            };
        }
    }
    for (instruction, live) in genome.instructions().iter().zip(&liveness.components) {
        let live = *live;
        if live == 0 {
            continue;
        }
        let operation = Expansion { genome, registers: &registers, instruction, live, machine };
        let result = operation.run();
        let dst = &mut registers[usize::from(instruction.dst())];
        for (component, (place, value)) in dst.iter_mut().zip(result).enumerate() {
            // Branchless: this branch is unpredictable.
            *place = if live >> component & 1 == 1 { value } else { *place };
        }
    }
    [registers[0][0], registers[0][1], registers[0][2]]
}

/// Expansion of one instruction.
struct Expansion<'a, M: ScalarMachine> {
    genome: &'a Genome,
    /// Values before the instruction.
    registers: &'a [[M::Value; 4]; REGISTERS],
    instruction: &'a Instruction,
    /// Mask of the components that are written and read later.
    live: u8,
    machine: &'a mut M,
}

impl<M: ScalarMachine> Expansion<'_, M> {
    /// Returns the live components of the result and arbitrary values for the others.
    #[inline(always)]
    fn run(mut self) -> [M::Value; 4] {
        match self.instruction.opcode() {
            Opcode::Add => self.componentwise(|e, k| {
                let (a, b) = (e.read(0, k), e.read(1, k));
                e.machine.add(a, b)
            }),
            Opcode::Sub => self.componentwise(|e, k| {
                let (a, b) = (e.read(0, k), e.read(1, k));
                e.sub(a, b)
            }),
            Opcode::Mul => self.componentwise(|e, k| e.product(k, k)),
            Opcode::Mov => self.componentwise(|e, k| e.read(0, k)),
            Opcode::Mad => self.componentwise(|e, k| {
                let (product, c) = (e.product(k, k), e.read(2, k));
                e.machine.add(product, c)
            }),
            Opcode::Lrp => self.componentwise(|e, k| {
                let (a, b, c) = (e.read(0, k), e.read(1, k), e.read(2, k));
                let difference = e.sub(b, c);
                let product = e.machine.mul(a, difference);
                e.machine.add(product, c)
            }),
            Opcode::Dp3 => [self.dot(3); 4],
            Opcode::Dp4 => [self.dot(4); 4],
            Opcode::Dst => self.componentwise(|e, k| match k {
                0 => e.machine.constant(1.0),
                1 => e.product(1, 1),
                2 => e.read(0, 2),
                _ => e.read(1, 3),
            }),
            Opcode::X2d => {
                let [upper, lower] = [0, 1].map(|row| match self.live & (0b101 << row) {
                    0 => M::Value::default(),
                    _ => self.transform(row),
                });
                [upper, lower, upper, lower]
            }
            Opcode::Sin => self.function(Function::Sin),
            Opcode::Cos => self.function(Function::Cos),
            Opcode::Ex2 => self.function(Function::Ex2),
            Opcode::Lg2 => self.function(Function::Lg2),
            Opcode::Rcp => self.function(Function::Rcp),
            Opcode::Rsq => self.function(Function::Rsq),
            Opcode::Spl => self.function(Function::Spl),
        }
    }

    /// Calls `f` for each live component.
    #[inline(always)]
    fn componentwise(&mut self, f: impl Fn(&mut Self, usize) -> M::Value) -> [M::Value; 4] {
        let mut result = [M::Value::default(); 4];
        let mut live = self.live & 15;
        while live != 0 {
            let component = live.trailing_zeros() as usize & 3;
            result[component] = f(self, component);
            live &= live - 1;
        }
        result
    }

    /// Applies a function of one component; all components get the result.
    #[inline(always)]
    fn function(&mut self, function: Function) -> [M::Value; 4] {
        let argument = self.read(0, 0);
        [self.machine.function(function, argument); 4]
    }

    #[inline(always)]
    fn sub(&mut self, a: M::Value, b: M::Value) -> M::Value {
        let b = self.machine.neg(b);
        self.machine.add(a, b)
    }

    /// Product of places of the first and of the second operand.
    fn product(&mut self, place_a: usize, place_b: usize) -> M::Value {
        let (a, b) = (self.read(0, place_a), self.read(1, place_b));
        self.machine.mul(a, b)
    }

    /// Dot product of the first components of both operands.
    fn dot(&mut self, components: usize) -> M::Value {
        let mut sum = self.product(0, 0);
        for k in 1..components {
            let product = self.product(k, k);
            sum = self.machine.add(sum, product);
        }
        sum
    }

    /// Row of [`Opcode::X2d`]: a component of a, plus the product of a row of c with b.
    fn transform(&mut self, row: usize) -> M::Value {
        let mut sum = self.read(0, row);
        for k in 0..2 {
            let (b, c) = (self.read(1, k), self.read(2, 2 * row + k));
            let product = self.machine.mul(b, c);
            sum = self.machine.add(sum, product);
        }
        sum
    }

    /// Value that operand `position` has in place 0..4 after its swizzle.
    fn read(&mut self, position: usize, place: usize) -> M::Value {
        let Operand { register, swizzle, negate } = self.instruction.operand(position);
        let component = swizzle.component(place);
        let value = match register {
            Register::Temporary(register) => self.registers[usize::from(register)][component],
            Register::Constant(register) => {
                let value = self.genome.constants()[usize::from(register)][component];
                self.machine.parameter(register, component, value)
            }
        };
        if negate { self.machine.neg(value) } else { value }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interpret::Numbers;

    /// Genome that puts C0, C1 and C2 into registers, applies an opcode to them, and continues.
    fn genome(constants: &str, opcode: Opcode, dst: &str, then: &str) -> Genome {
        let operands = match (opcode.operands(), opcode.is_scalar()) {
            (1, true) => "R7.x",
            (1, false) => "R7",
            (2, _) => "R7, R8",
            _ => "R7, R8, R9",
        };
        let text = format!(
            "brood 1\n.dialect extended smooth registers 10\n{constants}MOV R7, C0\nMOV R8, C1\n\
             MOV R9, C2\n{} {dst}, {operands}\n{then}",
            opcode.name()
        );
        text.parse().unwrap()
    }

    #[test]
    fn opcodes_compute_what_their_documentation_says() {
        let constants = ".const C0 0.5 2 -3 4\n.const C1 1 -2 0.25 3\n.const C2 -1 0.5 2 0.125\n";
        for opcode in Opcode::ALL {
            let expected = match opcode {
                Opcode::Add => [1.5, 0.0, -2.75],
                Opcode::Sub => [-0.5, 4.0, -3.25],
                Opcode::Mul => [0.5, -4.0, -0.75],
                Opcode::Mov => [0.5, 2.0, -3.0],
                Opcode::Mad => [-0.5, -3.5, 1.25],
                Opcode::Lrp => [0.0, -4.5, 7.25],
                Opcode::Dp3 => [-4.25; 3],
                Opcode::Dp4 => [7.75; 3],
                Opcode::Dst => [1.0, -4.0, -3.0],
                Opcode::X2d => [-1.5, 3.75, -1.5],
                Opcode::Sin => [0.479_425_539; 3],
                Opcode::Cos => [0.877_582_562; 3],
                Opcode::Ex2 => [std::f64::consts::SQRT_2; 3],
                Opcode::Lg2 => [-2.0; 3],
                Opcode::Rcp => [2.0; 3],
                Opcode::Rsq => [2.0; 3],
                Opcode::Spl => [1.271_553_303; 3],
            };
            let genome = genome(constants, opcode, "R0", "");
            let numbers = &mut Numbers { inputs: |_: Input| 0.0 };
            let found: [f64; 3] = expand(&genome, &Liveness::written(&genome), numbers);
            let is_close = (0..3).all(|k| (found[k] - expected[k]).abs() < 1e-6);
            assert!(is_close, "{}: {found:?} {expected:?}", opcode.name());
        }
    }

    /// Sets of components of C0, C1 and C2 that a value depends on, one bit for each.
    struct Dependencies;

    impl ScalarMachine for Dependencies {
        type Value = u16;

        fn constant(&mut self, _: f32) -> u16 {
            0
        }

        fn parameter(&mut self, register: u8, component: usize, _: f32) -> u16 {
            1 << (4 * usize::from(register) + component)
        }

        fn input(&mut self, _: Input) -> u16 {
            0
        }

        fn neg(&mut self, a: u16) -> u16 {
            a
        }

        fn add(&mut self, a: u16, b: u16) -> u16 {
            a | b
        }

        fn mul(&mut self, a: u16, b: u16) -> u16 {
            a | b
        }

        fn function(&mut self, _: Function, a: u16) -> u16 {
            a
        }
    }

    #[test]
    fn opcodes_read_the_components_that_liveness_expects() {
        for opcode in Opcode::ALL {
            let genome = genome("", opcode, "R1", "DP4 R0, R1, R1\n");
            for live in 0..16 {
                let components = vec![15, 15, 15, live, 15];
                let liveness = Liveness { components, ..Liveness::default() };
                let [found, ..] = expand(&genome, &liveness, &mut Dependencies);
                let mask = |index| u16::from(opcode.reads(index, live)) << (4 * index);
                let expected: u16 = (0..opcode.operands()).map(mask).sum();
                assert_eq!(found, expected, "{} {live:04b}", opcode.name());
            }
        }
    }
}
