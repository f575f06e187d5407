//! The builder: makes scalar nodes, each once, folds what is constant, and keeps signs out of operands.
//!
//! Negation commutes with every rounding and clamp of the machine, so signs are carried on references and end up in
//! the choice between sum and difference. The sign of a zero may change on the way; no operation turns that into any
//! other difference, and results are squared.

use brood_genome::{Arithmetic, Input, RANGE};

use crate::{Constant, Operation};

/// A node and whether its negative is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Reference {
    pub node: u32,
    pub negate: bool,
}

impl Reference {
    pub(crate) fn negated(self) -> Self {
        Self { negate: !self.negate, ..self }
    }

    fn signed(self, negate: bool) -> Self {
        Self { negate: self.negate ^ negate, ..self }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Node {
    Input(Input),
    Constant(Constant),
    Operation { operation: Operation, a: u32, b: u32 },
}

/// Slots of the table of nodes at the start; a usual genome fills less than half of them.
const FIRST_SLOTS: usize = 512;

pub(crate) struct Builder {
    nodes: Vec<Node>,
    /// Hash of the whole tree under a node: orders commuting operands independently of the genome's order.
    shapes: Vec<u64>,
    /// Open addressing by shape: one more than the index of a node, 0 where there is none.
    known: Vec<u32>,
    fold: bool,
}

impl Builder {
    /// With `fold` false only value numbering happens, for the counts.
    pub(crate) fn new(fold: bool) -> Self {
        let (nodes, shapes) =
            (Vec::with_capacity(FIRST_SLOTS / 2), Vec::with_capacity(FIRST_SLOTS / 2));
        Self { nodes, shapes, known: vec![0; FIRST_SLOTS], fold }
    }

    pub(crate) fn node(&self, index: u32) -> Node {
        self.nodes[index as usize]
    }

    /// All nodes; operands come before what reads them.
    pub(crate) fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    pub(crate) fn input(&mut self, input: Input) -> Reference {
        let shape = mix(1, input.index() as u64, 0);
        self.intern(Node::Input(input), shape)
    }

    pub(crate) fn constant(&mut self, value: f32) -> Reference {
        self.folded(value, f64::from(value))
    }

    pub(crate) fn add(&mut self, a: Reference, b: Reference) -> Reference {
        if let Some(value) = self.fold_binary(a, b, f32::add, f64::add) {
            return value;
        }
        if self.fold {
            if self.is_zero(a) {
                return b;
            }
            if self.is_zero(b) {
                return a;
            }
            if a == b.negated() {
                return self.constant(0.0);
            }
        }
        let (first, second) = if self.precedes(b, a) { (b, a) } else { (a, b) };
        let operation = if first.negate == second.negate { Operation::Add } else { Operation::Sub };
        self.operation(operation, first.node, second.node).signed(first.negate)
    }

    pub(crate) fn mul(&mut self, a: Reference, b: Reference) -> Reference {
        if let Some(value) = self.fold_binary(a, b, f32::mul, f64::mul) {
            return value;
        }
        let negate = a.negate ^ b.negate;
        if self.fold {
            if self.is_zero(a) || self.is_zero(b) {
                return self.constant(0.0);
            }
            if self.is_one(a) {
                return b.signed(a.negate);
            }
            if self.is_one(b) {
                return a.signed(b.negate);
            }
        }
        let (first, second) = if self.precedes(b, a) { (b, a) } else { (a, b) };
        let product = self.operation(Operation::Mul, first.node, second.node);
        Reference { negate, ..product }
    }

    pub(crate) fn sin(&mut self, a: Reference) -> Reference {
        self.unary(a, Operation::Sin, f32::sine, f64::sine).signed(a.negate)
    }

    pub(crate) fn cos(&mut self, a: Reference) -> Reference {
        self.unary(a, Operation::Cos, f32::cosine, f64::cosine)
    }

    pub(crate) fn ex2(&mut self, a: Reference) -> Reference {
        if a.negate {
            self.unary(a, Operation::Ex2Neg, |x| x.neg().ex2(), |x| x.neg().ex2())
        } else {
            self.unary(a, Operation::Ex2, f32::ex2, f64::ex2)
        }
    }

    pub(crate) fn lg2(&mut self, a: Reference) -> Reference {
        self.unary(a, Operation::Lg2, f32::lg2, f64::lg2)
    }

    pub(crate) fn rcp(&mut self, a: Reference) -> Reference {
        self.unary(a, Operation::Rcp, f32::rcp, f64::rcp).signed(a.negate)
    }

    pub(crate) fn rsq(&mut self, a: Reference) -> Reference {
        self.unary(a, Operation::Rsq, f32::rsq, f64::rsq)
    }

    pub(crate) fn spl(&mut self, a: Reference) -> Reference {
        if a.negate {
            self.unary(a, Operation::SplNeg, |x| x.neg().spl(), |x| x.neg().spl())
        } else {
            self.unary(a, Operation::Spl, f32::spl, f64::spl)
        }
    }

    /// The operation on the node itself; the caller puts the operand's sign where it belongs.
    fn unary(
        &mut self,
        a: Reference,
        operation: Operation,
        canonical: fn(f32) -> f32,
        reference: fn(f64) -> f64,
    ) -> Reference {
        if let (true, Node::Constant(value)) = (self.fold, self.node(a.node)) {
            return self.folded(canonical(value.canonical), reference(value.reference));
        }
        self.operation(operation, a.node, a.node)
    }

    fn fold_binary(
        &mut self,
        a: Reference,
        b: Reference,
        canonical: fn(f32, f32) -> f32,
        reference: fn(f64, f64) -> f64,
    ) -> Option<Reference> {
        let (a, b) = (self.value(a)?, self.value(b)?);
        self.fold.then(|| {
            let value = reference(a.reference, b.reference);
            self.folded(canonical(a.canonical, b.canonical), value)
        })
    }

    /// A constant with its reference's sign applied.
    fn value(&self, reference: Reference) -> Option<Constant> {
        match self.node(reference.node) {
            Node::Constant(value) if reference.negate => {
                Some(Constant { canonical: -value.canonical, reference: -value.reference })
            }
            Node::Constant(value) => Some(value),
            Node::Input(_) | Node::Operation { .. } => None,
        }
    }

    /// A constant node of non-negative canonical value, its sign on the reference.
    fn folded(&mut self, canonical: f32, reference: f64) -> Reference {
        debug_assert!(canonical.abs() <= RANGE && reference.is_finite());
        let negate = canonical < 0.0;
        // Adding +0 turns -0 into 0, so that zeros are one node.
        let canonical = canonical.abs() + 0.0;
        let reference = if negate { -reference } else { reference } + 0.0;
        let bits = (canonical.to_bits(), reference.to_bits());
        let shape = mix(2, u64::from(bits.0), bits.1);
        let node = Node::Constant(Constant { canonical, reference });
        self.intern(node, shape).signed(negate)
    }

    fn is_zero(&self, a: Reference) -> bool {
        self.value(a).is_some_and(|v| v.canonical.abs() <= 0.0 && v.reference.abs() <= 0.0)
    }

    fn is_one(&self, a: Reference) -> bool {
        let one = Constant { canonical: 1.0, reference: 1.0 };
        matches!(self.node(a.node), Node::Constant(value) if value == one)
    }

    fn precedes(&self, a: Reference, b: Reference) -> bool {
        (self.shapes[a.node as usize], a.node) < (self.shapes[b.node as usize], b.node)
    }

    fn operation(&mut self, operation: Operation, a: u32, b: u32) -> Reference {
        let (left, right) = (self.shapes[a as usize], self.shapes[b as usize]);
        let shape = mix(3 + u64::from(operation.number()), left, right);
        let node = Node::Operation { operation, a, b };
        self.intern(node, shape)
    }

    fn intern(&mut self, node: Node, shape: u64) -> Reference {
        if 2 * self.nodes.len() >= self.known.len() {
            self.grow();
        }
        let mut slot = self.slot(shape);
        while let Some(index) = self.known[slot].checked_sub(1) {
            if self.nodes[index as usize] == node {
                return Reference { node: index, negate: false };
            }
            slot = (slot + 1) & (self.known.len() - 1);
        }
        let index = u32::try_from(self.nodes.len()).expect("at most 1024 instructions");
        self.known[slot] = index + 1;
        self.nodes.push(node);
        self.shapes.push(shape);
        Reference { node: index, negate: false }
    }

    fn slot(&self, shape: u64) -> usize {
        // The length is a power of two; the low bits of a shape are well mixed.
        shape as usize & (self.known.len() - 1)
    }

    fn grow(&mut self) {
        self.known = vec![0; 2 * self.known.len()];
        for (number, shape) in (1..).zip(&self.shapes) {
            let mut slot = *shape as usize & (self.known.len() - 1);
            while self.known[slot] != 0 {
                slot = (slot + 1) & (self.known.len() - 1);
            }
            self.known[slot] = number;
        }
    }
}

/// Mixes three numbers into one; the multipliers and shifts are those of the MurmurHash3 finaliser.
fn mix(tag: u64, a: u64, b: u64) -> u64 {
    let mut hash = tag.wrapping_mul(0x9E37_79B9_7F4A_7C15);
    for part in [a, b] {
        hash = (hash ^ part).wrapping_mul(0xFF51_AFD7_ED55_8CCD);
        hash ^= hash >> 33;
        hash = hash.wrapping_mul(0xC4CE_B9FE_1A85_EC53);
        hash ^= hash >> 29;
    }
    hash
}
