//! Interpreter of genomes as written: the test oracle for lowered programs.

use crate::{Arithmetic, Genome, InitialValue, Input, Instruction, Opcode, Operand, Register};

/// Runs a genome for one sample and returns the reflectance of the three channels.
///
/// # Shapes
/// `inputs` returns the value of an input; the result is (red, green, blue).
///
/// # Domain
/// Inputs within `[-65504, 65504]`. The result is finite and not negative. Layers are not included.
pub fn interpret<T: Arithmetic>(genome: &Genome, inputs: impl Fn(Input) -> T) -> [T; 3] {
    let mut registers = [[T::from_f32(0.0); 4]; 16];
    for (register, values) in (0..genome.dialect().registers).zip(&mut registers) {
        for (component, value) in values.iter_mut().enumerate() {
            *value = match genome.dialect().initial(register, component) {
                InitialValue::Zero => T::from_f32(0.0),
                InitialValue::One => T::from_f32(1.0),
                InitialValue::Input(input) => inputs(input),
            };
        }
    }
    for instruction in genome.instructions() {
        let result = execute(instruction, |operand| read(genome, &registers, operand));
        let dst = &mut registers[usize::from(instruction.dst())];
        for component in 0..4 {
            if instruction.write_mask().contains(component) {
                dst[component] = result[component];
            }
        }
    }
    let [r, g, b, _] = match genome.instructions() {
        [] => [T::from_f32(0.0); 4],
        _ => registers[0],
    };
    genome.output().apply([r.square(), g.square(), b.square()])
}

fn read<T: Arithmetic>(genome: &Genome, registers: &[[T; 4]; 16], operand: Operand) -> [T; 4] {
    std::array::from_fn(|place| {
        let component = operand.swizzle.component(place);
        let value = match operand.register {
            Register::Temporary(index) => registers[usize::from(index)][component],
            Register::Constant(index) => {
                T::from_f32(genome.constants()[usize::from(index)][component])
            }
        };
        if operand.negate { value.neg() } else { value }
    })
}

fn execute<T: Arithmetic>(instruction: &Instruction, read: impl Fn(Operand) -> [T; 4]) -> [T; 4] {
    let operand = |index: usize| read(instruction.operand(index));
    let componentwise = |f: &dyn Fn(usize) -> T| std::array::from_fn(f);
    match instruction.opcode() {
        Opcode::Add => {
            let (a, b) = (operand(0), operand(1));
            componentwise(&|k| a[k].add(b[k]))
        }
        Opcode::Sub => {
            let (a, b) = (operand(0), operand(1));
            componentwise(&|k| a[k].add(b[k].neg()))
        }
        Opcode::Mul => {
            let (a, b) = (operand(0), operand(1));
            componentwise(&|k| a[k].mul(b[k]))
        }
        Opcode::Mov => operand(0),
        Opcode::Mad => {
            let (a, b, c) = (operand(0), operand(1), operand(2));
            componentwise(&|k| a[k].mul(b[k]).add(c[k]))
        }
        Opcode::Lrp => {
            let (a, b, c) = (operand(0), operand(1), operand(2));
            componentwise(&|k| a[k].mul(b[k].add(c[k].neg())).add(c[k]))
        }
        Opcode::Dp3 => {
            let (a, b) = (operand(0), operand(1));
            [a[0].mul(b[0]).add(a[1].mul(b[1])).add(a[2].mul(b[2])); 4]
        }
        Opcode::Dp4 => {
            let (a, b) = (operand(0), operand(1));
            let three = a[0].mul(b[0]).add(a[1].mul(b[1])).add(a[2].mul(b[2]));
            [three.add(a[3].mul(b[3])); 4]
        }
        Opcode::Dst => {
            let (a, b) = (operand(0), operand(1));
            [T::from_f32(1.0), a[1].mul(b[1]), a[2], b[3]]
        }
        Opcode::X2d => {
            let (a, b, c) = (operand(0), operand(1), operand(2));
            let upper = a[0].add(b[0].mul(c[0])).add(b[1].mul(c[1]));
            let lower = a[1].add(b[0].mul(c[2])).add(b[1].mul(c[3]));
            [upper, lower, upper, lower]
        }
        Opcode::Sin => [operand(0)[0].sine(); 4],
        Opcode::Cos => [operand(0)[0].cosine(); 4],
        Opcode::Ex2 => [operand(0)[0].ex2(); 4],
        Opcode::Lg2 => [operand(0)[0].lg2(); 4],
        Opcode::Rcp => [operand(0)[0].rcp(); 4],
        Opcode::Rsq => [operand(0)[0].rsq(); 4],
        Opcode::Spl => [operand(0)[0].spl(); 4],
    }
}
