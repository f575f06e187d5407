//! Lowering of a genome to a program: liveness finds the components that can change the result,
//! [`scalarise`] expands the instructions that write them into scalar nodes of a [`Builder`], and
//! [`Collected`] orders the nodes that the results read.

use std::cell::RefCell;

use brood_genome::{
    Genome, InitialValue, Instruction, Liveness, Model, Opcode, REGISTERS, Register,
};

use crate::build::{Builder, Node, Reference};
use crate::{Constant, Operand, Program, Step};

/// Buffers of lowering, reused for the next genome because allocating them takes as long as
/// lowering itself.
pub(crate) struct Scratch {
    pub(crate) liveness: Liveness,
    pub(crate) builder: Builder,
    pub(crate) collected: Collected,
}

thread_local! {
    pub(crate) static SCRATCH: RefCell<Scratch> = RefCell::new(Scratch {
        liveness: Liveness::default(),
        builder: Builder::new(true),
        collected: Collected::default(),
    });
}

impl Program {
    /// Lowers a genome to its live scalar code, bit-equal to it in canonical f32 and in the f64
    /// reference. Under an isotropic dialect each layer is replaced by [`Model::isotropic`] of it.
    #[must_use]
    pub fn lower(genome: &Genome) -> Self {
        SCRATCH.with_borrow_mut(|Scratch { liveness, builder, collected }| {
            liveness.find(genome);
            builder.clear();
            let results = scalarise(genome, liveness, builder, false);
            collected.collect(builder, results, genome)
        })
    }
}

/// Builds the scalar nodes of the live components and returns g of red, green and blue. With
/// `is_tunable` the constants of the genome become parameters, which are not folded.
pub(crate) fn scalarise(
    genome: &Genome,
    liveness: &Liveness,
    builder: &mut Builder,
    is_tunable: bool,
) -> [Reference; 3] {
    let zero = builder.constant(0.0);
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
                InitialValue::One => builder.constant(1.0),
                InitialValue::Input(input) => builder.input(input),
            };
        }
    }
    for (instruction, live) in genome.instructions().iter().zip(&liveness.components) {
        let live = *live;
        if live == 0 {
            continue;
        }
        let result =
            Expansion { genome, registers: &registers, instruction, live, is_tunable, builder }
                .run();
        let dst = &mut registers[usize::from(instruction.dst())];
        for (component, (place, value)) in dst.iter_mut().zip(result).enumerate() {
            // Branchless: this branch is unpredictable.
            *place = if live >> component & 1 == 1 { value } else { *place };
        }
    }
    [registers[0][0], registers[0][1], registers[0][2]]
}

/// Expansion of one instruction into scalar nodes.
struct Expansion<'a> {
    genome: &'a Genome,
    /// Values before the instruction.
    registers: &'a [[Reference; 4]; REGISTERS],
    instruction: &'a Instruction,
    /// Mask of the components that are written and read later.
    live: u8,
    is_tunable: bool,
    builder: &'a mut Builder,
}

impl Expansion<'_> {
    /// Returns references for the live components and arbitrary ones for the others.
    fn run(mut self) -> [Reference; 4] {
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
                [dot; 4]
            }
            Opcode::Dp4 => {
                let dot = self.dot(4);
                [dot; 4]
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

    /// Calls `f` for each live component.
    fn componentwise(
        &mut self,
        mut f: impl FnMut(&mut Self, usize) -> Reference,
    ) -> [Reference; 4] {
        let mut result = [Reference::default(); 4];
        let mut live = self.live & 15;
        while live != 0 {
            let component = live.trailing_zeros() as usize & 3;
            result[component] = f(self, component);
            live &= live - 1;
        }
        result
    }

    /// Applies a function of one component; all components get the result.
    fn function(&mut self, f: impl FnOnce(&mut Builder, Reference) -> Reference) -> [Reference; 4] {
        let argument = self.read(0, 0);
        let value = f(self.builder, argument);
        [value; 4]
    }

    /// Product of places of the first and of the second operand.
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

    /// Component of [`Opcode::X2d`]: x and z are the first row, y and w the second.
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

    /// Value that operand `position` has in place 0..4 after its swizzle.
    fn read(&mut self, position: usize, place: usize) -> Reference {
        let operand = self.instruction.operand(position);
        let component = operand.swizzle.component(place);
        let value = match operand.register {
            Register::Temporary(register) => self.registers[usize::from(register)][component],
            Register::Constant(register) => {
                let value = self.genome.constants()[usize::from(register)][component];
                if self.is_tunable {
                    let component = u32::try_from(component).expect("there are four components");
                    self.builder.parameter(4 * u32::from(register) + component, value)
                } else {
                    self.builder.constant(value)
                }
            }
        };
        if operand.negate { value.negated() } else { value }
    }
}

/// Steps and constants of a program, collected in post-order from the results.
#[derive(Debug, Default)]
pub(crate) struct Collected {
    /// Operand of each node, once the node has been collected.
    operands: Vec<Option<Operand>>,
    /// Stack of operations that are not collected yet.
    pending: Vec<u32>,
    steps: Vec<Step>,
    constants: Vec<Constant>,
    /// Index in the builder of each constant.
    pub(crate) sources: Vec<u32>,
}

impl Collected {
    /// Returns the program of these results, with output stage and layers of the genome.
    pub(crate) fn collect(
        &mut self,
        builder: &Builder,
        results: [Reference; 3],
        genome: &Genome,
    ) -> Program {
        self.operands.clear();
        self.operands.resize(builder.len(), None);
        self.pending.clear();
        self.steps.clear();
        self.constants.clear();
        self.sources.clear();
        let results = results.map(|result| self.visit(builder, result.node()));
        let is_isotropic = genome.dialect().isotropic;
        let layer = |model: &Model| if is_isotropic { model.isotropic() } else { model.clone() };
        Program {
            steps: self.steps.clone(),
            constants: self.constants.clone(),
            results,
            output: *genome.output(),
            layers: genome.layers().iter().map(layer).collect(),
        }
    }

    /// Collects a node and all that it reads, with a stack instead of recursion.
    fn visit(&mut self, builder: &Builder, root: u32) -> Operand {
        if let Some(operand) = self.operand_of(builder, root) {
            return operand;
        }
        self.pending.push(root);
        while let Some(node) = self.pending.last().copied() {
            let Node::Operation { operation, a, b } = builder.node(node) else {
                unreachable!("only operations are pending");
            };
            let (a_pending, b_pending) = (self.is_pending(builder, a), self.is_pending(builder, b));
            if a_pending | b_pending {
                // Visits the operand that needs more registers first; the other is visited when
                // this node is on top of the stack again.
                let is_a = a_pending & (!b_pending | (builder.need(a) >= builder.need(b)));
                self.pending.push(if is_a { a } else { b });
                continue;
            }
            let (Some(a), Some(b)) = (self.operand_of(builder, a), self.operand_of(builder, b))
            else {
                unreachable!("operands that are not pending are collected");
            };
            self.operands[node as usize] = Some(Operand::Step(narrow(self.steps.len())));
            self.steps.push(Step { operation, a, b });
            self.pending.pop();
        }
        self.operands[root as usize].expect("the root has just been collected")
    }

    /// True if the node is an operation that is not collected yet.
    #[inline(always)]
    fn is_pending(&self, builder: &Builder, node: u32) -> bool {
        builder.is_operation(node) & self.operands[node as usize].is_none()
    }

    /// Returns the operand of a node, if it is known. Collects inputs and constants at their first
    /// use.
    #[inline(always)]
    fn operand_of(&mut self, builder: &Builder, node: u32) -> Option<Operand> {
        let known = self.operands[node as usize];
        if known.is_some() {
            return known;
        }
        let operand = match builder.node(node) {
            Node::Input(input) => Operand::Input(input),
            Node::Constant(index) | Node::Parameter(index) => {
                self.constants.push(builder.constant_of(index));
                self.sources.push(index);
                Operand::Constant(narrow(self.constants.len() - 1))
            }
            Node::Operation { .. } => return None,
        };
        self.operands[node as usize] = Some(operand);
        Some(operand)
    }
}

fn narrow(index: usize) -> u16 {
    u16::try_from(index).expect("1024 instructions make fewer than 65536 scalar operations")
}

#[cfg(test)]
#[path = "lower_tests.rs"]
mod tests;
