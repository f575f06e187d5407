//! Lowering: genome to program.

use brood_genome::{Genome, Instruction, Opcode, Register, Source};

use crate::build::{Builder, Node, Reference};
use crate::liveness::live_components;
use crate::{Operand, Program, Step};

impl Program {
    /// The live scalar code of a genome: bit-equal to it in canonical f32 and in the f64 reference.
    #[must_use]
    pub fn lower(genome: &Genome) -> Self {
        let mut builder = Builder::new(true);
        let results = scalarise(genome, &mut builder);
        Collector::collect(&builder, results, genome)
    }
}

/// Builds the scalar nodes of the live components and returns g of red, green and blue.
pub(crate) fn scalarise(genome: &Genome, builder: &mut Builder) -> [Reference; 3] {
    let dialect = genome.dialect();
    let mut registers: Vec<[Reference; 4]> = (0..dialect.registers)
        .map(|register| {
            std::array::from_fn(|component| match dialect.initial(register, component) {
                Source::Zero => builder.constant(0.0),
                Source::One => builder.constant(1.0),
                Source::Input(input) => builder.input(input),
            })
        })
        .collect();
    for (instruction, live) in genome.instructions().iter().zip(live_components(genome)) {
        if live == 0 {
            continue;
        }
        let result = Expansion { genome, registers: &registers, instruction, live, builder }.run();
        let dst = &mut registers[usize::from(instruction.dst())];
        for (component, value) in result.into_iter().enumerate() {
            if let Some(value) = value {
                dst[component] = value;
            }
        }
    }
    [registers[0][0], registers[0][1], registers[0][2]]
}

/// One instruction being taken apart into scalars.
struct Expansion<'a> {
    genome: &'a Genome,
    registers: &'a [[Reference; 4]],
    instruction: &'a Instruction,
    live: u8,
    builder: &'a mut Builder,
}

impl Expansion<'_> {
    fn run(mut self) -> [Option<Reference>; 4] {
        match self.instruction.opcode() {
            Opcode::Add => self.componentwise(|e, k| {
                let (a, b) = (e.read(0, k), e.read(1, k));
                e.builder.add(a, b)
            }),
            Opcode::Sub => self.componentwise(|e, k| {
                let (a, b) = (e.read(0, k), e.read(1, k));
                e.builder.add(a, b.negated())
            }),
            Opcode::Mul => self.componentwise(|e, k| e.product(k, k)),
            Opcode::Mov => self.componentwise(|e, k| e.read(0, k)),
            Opcode::Mad => self.componentwise(|e, k| {
                let (product, c) = (e.product(k, k), e.read(2, k));
                e.builder.add(product, c)
            }),
            Opcode::Lrp => self.componentwise(|e, k| {
                let (a, b, c) = (e.read(0, k), e.read(1, k), e.read(2, k));
                let difference = e.builder.add(b, c.negated());
                let product = e.builder.mul(a, difference);
                e.builder.add(product, c)
            }),
            Opcode::Dp3 => {
                let dot = self.dot(3);
                self.componentwise(|_, _| dot)
            }
            Opcode::Dp4 => {
                let dot = self.dot(4);
                self.componentwise(|_, _| dot)
            }
            Opcode::Dst => self.componentwise(|e, k| match k {
                0 => e.builder.constant(1.0),
                1 => e.product(1, 1),
                2 => e.read(0, 2),
                _ => e.read(1, 3),
            }),
            Opcode::X2d => self.componentwise(|e, k| e.transform(k)),
            Opcode::Sin => self.function(Builder::sin),
            Opcode::Cos => self.function(Builder::cos),
            Opcode::Ex2 => self.function(Builder::ex2),
            Opcode::Lg2 => self.function(Builder::lg2),
            Opcode::Rcp => self.function(Builder::rcp),
            Opcode::Rsq => self.function(Builder::rsq),
            Opcode::Spl => self.function(Builder::spl),
        }
    }

    fn componentwise(
        &mut self,
        mut f: impl FnMut(&mut Self, usize) -> Reference,
    ) -> [Option<Reference>; 4] {
        std::array::from_fn(|k| (self.live >> k & 1 == 1).then(|| f(self, k)))
    }

    fn function(
        &mut self,
        f: impl FnOnce(&mut Builder, Reference) -> Reference,
    ) -> [Option<Reference>; 4] {
        let argument = self.read(0, 0);
        let value = f(self.builder, argument);
        self.componentwise(|_, _| value)
    }

    fn product(&mut self, place_a: usize, place_b: usize) -> Reference {
        let (a, b) = (self.read(0, place_a), self.read(1, place_b));
        self.builder.mul(a, b)
    }

    fn dot(&mut self, components: usize) -> Reference {
        let mut sum = self.product(0, 0);
        for k in 1..components {
            let product = self.product(k, k);
            sum = self.builder.add(sum, product);
        }
        sum
    }

    fn transform(&mut self, component: usize) -> Reference {
        let row = component % 2;
        let mut sum = self.read(0, row);
        for k in 0..2 {
            let (b, c) = (self.read(1, k), self.read(2, 2 * row + k));
            let product = self.builder.mul(b, c);
            sum = self.builder.add(sum, product);
        }
        sum
    }

    fn read(&mut self, position: usize, place: usize) -> Reference {
        let operand = self.instruction.operand(position);
        let component = operand.swizzle.component(place);
        let value = match operand.register {
            Register::Temporary(register) => self.registers[usize::from(register)][component],
            Register::Constant(register) => {
                let value = self.genome.constants()[usize::from(register)][component];
                self.builder.constant(value)
            }
        };
        if operand.negate { value.negated() } else { value }
    }
}

/// Walks from the results and keeps what it meets, in post-order.
pub(crate) struct Collector<'a> {
    builder: &'a Builder,
    /// For each node where its value is found, once it has been collected.
    operands: Vec<Option<Operand>>,
    needs: Vec<u32>,
    program: Program,
}

impl<'a> Collector<'a> {
    pub(crate) fn collect(
        builder: &'a Builder,
        results: [Reference; 3],
        genome: &Genome,
    ) -> Program {
        let program = Program {
            steps: Vec::with_capacity(builder.nodes().len()),
            constants: Vec::with_capacity(8),
            results: [Operand::Constant(0); 3],
            output: *genome.output(),
        };
        let needs = register_needs(builder);
        let mut collector = Self { builder, operands: vec![None; needs.len()], needs, program };
        for (channel, result) in results.into_iter().enumerate() {
            collector.program.results[channel] = collector.visit(result.node);
        }
        collector.program
    }

    fn visit(&mut self, root: u32) -> Operand {
        let mut stack = vec![root];
        while let Some(node) = stack.last().copied() {
            if self.operands[node as usize].is_some() {
                stack.pop();
                continue;
            }
            let operand = match self.builder.node(node) {
                Node::Input(input) => Operand::Input(input),
                Node::Constant(constant) => {
                    self.program.constants.push(constant);
                    Operand::Constant(narrow(self.program.constants.len() - 1))
                }
                Node::Operation { operation, a, b } => {
                    let both = (self.operands[a as usize], self.operands[b as usize]);
                    let (Some(a), Some(b)) = both else {
                        // The one to be collected first on top: the one that needs more registers.
                        let first_is_a = self.needs[a as usize] >= self.needs[b as usize];
                        let pending = if first_is_a { [b, a] } else { [a, b] };
                        let operands = &self.operands;
                        stack.extend(
                            pending.into_iter().filter(|n| operands[*n as usize].is_none()),
                        );
                        continue;
                    };
                    self.program.steps.push(Step { operation, a, b });
                    Operand::Step(narrow(self.program.steps.len() - 1))
                }
            };
            self.operands[node as usize] = Some(operand);
            stack.pop();
        }
        self.operands[root as usize].expect("the root has just been collected")
    }
}

/// Registers that the tree under each node would need (Sethi and Ullman 1970); sharing makes it an estimate. Nodes are
/// numbered after their operands, so one sweep fills the table.
fn register_needs(builder: &Builder) -> Vec<u32> {
    let mut needs: Vec<u32> = Vec::with_capacity(builder.nodes().len());
    for node in builder.nodes() {
        needs.push(match node {
            Node::Input(_) | Node::Constant(_) => 0,
            Node::Operation { a, b, .. } => {
                let (a, b) = (needs[*a as usize], needs[*b as usize]);
                if a == b { a + 1 } else { a.max(b) }
            }
        });
    }
    needs
}

fn narrow(index: usize) -> u16 {
    u16::try_from(index).expect("1024 instructions make fewer than 65536 scalar operations")
}

#[cfg(test)]
#[path = "lower_tests.rs"]
mod tests;
