//! Lowering of a genome to a program: liveness finds the components that can change the result,
//! [`expand`] turns the instructions that write them into scalar nodes of a [`Builder`], and
//! [`Collected`] orders the nodes that the results read.

use std::cell::RefCell;

use brood_genome::{Genome, Liveness, Model, Output, expand};

use crate::build::{Builder, Node, Reference};
use crate::{Bumps, Constant, Meaning, Operand, Program, Step};

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
    /// A painted genome becomes a [`Meaning::Style`].
    #[must_use]
    pub fn lower(genome: &Genome) -> Self {
        let program = SCRATCH.with_borrow_mut(|Scratch { liveness, builder, collected }| {
            liveness.find(genome);
            builder.clear(false);
            let results = expand(genome, liveness, builder);
            collected.collect(builder, results, genome)
        });
        let bumps = genome.bump().and_then(Bumps::lower).map(Box::new);
        Self { bumps, ..program }
    }
}

/// Returns the meaning of the results of a genome.
fn meaning(genome: &Genome) -> Meaning {
    match genome.is_painted() {
        true => Meaning::Style(genome.effects().to_vec()),
        false => Meaning::Reflectance,
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
    /// Returns the program of these results, with output stage and layers or effects of the genome.
    pub(crate) fn collect(
        &mut self,
        builder: &Builder,
        results: [Reference; 3],
        genome: &Genome,
    ) -> Program {
        let is_isotropic = genome.dialect().isotropic;
        let layer = |model: &Model| if is_isotropic { model.isotropic() } else { model.clone() };
        Program {
            output: *genome.output(),
            layers: genome.layers().iter().map(layer).collect(),
            ..self.code(builder, results, meaning(genome))
        }
    }

    /// Returns the program of these results, without layers and output stage.
    pub(crate) fn code(
        &mut self,
        builder: &Builder,
        results: [Reference; 3],
        meaning: Meaning,
    ) -> Program {
        self.operands.clear();
        self.operands.resize(builder.len(), None);
        self.pending.clear();
        self.steps.clear();
        self.constants.clear();
        self.sources.clear();
        let results = results.map(|result| self.visit(builder, result.node()));
        Program {
            steps: self.steps.clone(),
            constants: self.constants.clone(),
            results,
            output: Output::IDENTITY,
            layers: Vec::new(),
            meaning,
            bumps: None,
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
