//! The builder: a graph of scalar nodes, in which equal nodes are stored once (value numbering),
//! operations on constants are folded, and operands have no signs.
//!
//! Negation commutes with every rounding and clamp of the machine, so a sign is carried on the
//! reference to a node and ends up in the choice between sum and difference. The sign of a zero may
//! change on the way; no operation turns that into any other difference, and results are squared or
//! saturated.

use brood_genome::{Arithmetic, Function, Input, RANGE, ScalarMachine};

use crate::{Constant, Operation};

/// A node, or the negative of it: twice the node's index, plus 1 if negative.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Reference(u32);

impl Reference {
    fn to(node: u32) -> Self {
        Self(node << 1)
    }

    #[inline]
    pub(crate) fn node(self) -> u32 {
        self.0 >> 1
    }

    #[inline]
    pub(crate) fn is_negative(self) -> bool {
        self.0 & 1 != 0
    }

    #[inline]
    fn signed(self, negate: bool) -> Self {
        Self(self.0 ^ u32::from(negate))
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Node {
    Input(Input),
    /// Index of the value.
    Constant(u32),
    /// Index of the value of a constant that may change later, so nothing is folded with it.
    Parameter(u32),
    Operation {
        operation: Operation,
        a: u32,
        b: u32,
    },
}

/// A node with properties of the tree under it.
#[derive(Debug, Clone, Copy)]
struct Entry {
    /// Hash of the whole tree. Orders commuting operands independently of the order in the genome.
    shape: u64,
    node: Node,
    /// Number of registers that the tree needs (Sethi and Ullman 1970); sharing of nodes makes it
    /// an estimate.
    need: u16,
}

/// Initial number of slots of the node table; a usual genome fills less than half of them.
const FIRST_SLOTS: usize = 512;

/// Graph of scalar nodes under construction.
pub(crate) struct Builder {
    /// Nodes, operands before their users.
    entries: Vec<Entry>,
    /// Open-addressing hash table by shape: index of a node plus 1, or 0 for an empty slot.
    known: Vec<u32>,
    /// Values of constants and parameters.
    constants: Vec<Constant>,
    /// Index of each parameter and its place in the genome, 4 times the register plus the
    /// component.
    places: Vec<(u32, u32)>,
    fold: bool,
    /// True if the constants of the genome become parameters, which are not folded.
    is_tunable: bool,
}

impl Builder {
    /// Creates an empty builder. With `fold` false it only numbers values, for [`crate::Counts`].
    pub(crate) fn new(fold: bool) -> Self {
        let entries = Vec::with_capacity(FIRST_SLOTS / 2);
        Self {
            entries,
            known: vec![0; FIRST_SLOTS],
            constants: Vec::new(),
            places: Vec::new(),
            fold,
            is_tunable: false,
        }
    }

    /// Removes all nodes and keeps the allocations. With `is_tunable` the constants of the genome
    /// become parameters.
    pub(crate) fn clear(&mut self, is_tunable: bool) {
        self.is_tunable = is_tunable;
        self.entries.clear();
        self.constants.clear();
        self.places.clear();
        self.known.clear();
        self.known.resize(FIRST_SLOTS, 0);
    }

    #[inline]
    pub(crate) fn node(&self, index: u32) -> Node {
        self.entries[index as usize].node
    }

    #[inline]
    pub(crate) fn is_operation(&self, index: u32) -> bool {
        self.need(index) != 0
    }

    /// Number of registers that the tree under a node needs; 0 if the node is not an operation.
    #[inline]
    pub(crate) fn need(&self, index: u32) -> u16 {
        self.entries[index as usize].need
    }

    /// Value with this index.
    #[inline]
    pub(crate) fn constant_of(&self, index: u32) -> Constant {
        self.constants[index as usize]
    }

    /// Number of nodes.
    pub(crate) fn len(&self) -> usize {
        self.entries.len()
    }

    /// Returns the node of a constant of the genome that may change: one node per place, whatever
    /// the value.
    fn tunable(&mut self, place: u32, value: f32) -> Reference {
        let shape = mix(20, u64::from(place), 0);
        let accepts = |builder: &Self, node| match node {
            Node::Parameter(index) => builder.place_of(index) == Some(place),
            Node::Input(_) | Node::Constant(_) | Node::Operation { .. } => false,
        };
        match self.find(shape, accepts) {
            Ok(reference) => reference,
            Err(slot) => {
                let index = u32::try_from(self.constants.len())
                    .expect("there are at most as many constants as nodes");
                self.constants.push(Constant { canonical: value, reference: f64::from(value) });
                self.places.push((index, place));
                self.add_entry(slot, Entry { shape, node: Node::Parameter(index), need: 0 })
            }
        }
    }

    /// Returns the node of an operation of a program; a unary operation ignores `b`.
    pub(crate) fn apply(&mut self, operation: Operation, a: Reference, b: Reference) -> Reference {
        match operation {
            Operation::Add => self.add(a, b),
            Operation::Sub => self.add(a, b.signed(true)),
            Operation::Mul => self.mul(a, b),
            Operation::Sin => self.function(Function::Sin, a),
            Operation::Cos => self.function(Function::Cos, a),
            Operation::Ex2 => self.function(Function::Ex2, a),
            Operation::Ex2Neg => self.function(Function::Ex2, a.signed(true)),
            Operation::Lg2 => self.function(Function::Lg2, a),
            Operation::Rcp => self.function(Function::Rcp, a),
            Operation::Rsq => self.function(Function::Rsq, a),
            Operation::Spl => self.function(Function::Spl, a),
            Operation::SplNeg => self.function(Function::Spl, a.signed(true)),
            Operation::Saturate => self.function(Function::Saturate, a),
            Operation::SaturateNeg => self.function(Function::Saturate, a.signed(true)),
            Operation::Step => self.function(Function::Step, a),
            Operation::StepNeg => self.function(Function::Step, a.signed(true)),
        }
    }

    /// Returns the place in the genome of the parameter with this index.
    pub(crate) fn place_of(&self, index: u32) -> Option<u32> {
        self.places.iter().find(|(known, _)| *known == index).map(|(_, place)| *place)
    }

    /// Returns the sum if a constant operand decides it.
    fn folded_sum(&mut self, a: Reference, b: Reference) -> Option<Reference> {
        match (self.value(a), self.value(b)) {
            (Some(a), Some(b)) => {
                let reference = Arithmetic::add(a.reference, b.reference);
                Some(self.folded(Arithmetic::add(a.canonical, b.canonical), reference))
            }
            (Some(value), None) if is_zero(value) => Some(b),
            (None, Some(value)) if is_zero(value) => Some(a),
            _ => None,
        }
    }

    /// Returns the product if a constant operand decides it.
    fn folded_product(&mut self, a: Reference, b: Reference) -> Option<Reference> {
        let (value, other) = match (self.value(a), self.value(b)) {
            (Some(a), Some(b)) => {
                let reference = Arithmetic::mul(a.reference, b.reference);
                return Some(self.folded(Arithmetic::mul(a.canonical, b.canonical), reference));
            }
            (Some(value), None) => (value, b),
            (None, Some(value)) => (value, a),
            (None, None) => return None,
        };
        if is_zero(value) {
            return Some(self.constant(0.0));
        }
        let is = |one: f32| value == Constant { canonical: one, reference: f64::from(one) };
        (is(1.0) || is(-1.0)).then(|| other.signed(value.canonical < 0.0))
    }

    /// Returns the value of a constant node with the sign of the reference applied.
    #[inline]
    fn value(&self, reference: Reference) -> Option<Constant> {
        let Node::Constant(index) = self.node(reference.node()) else { return None };
        let value = self.constant_of(index);
        Some(match reference.is_negative() {
            true => Constant { canonical: -value.canonical, reference: -value.reference },
            false => value,
        })
    }

    /// Returns a constant node of non-negative canonical value, with the sign on the reference.
    pub(crate) fn folded(&mut self, canonical: f32, reference: f64) -> Reference {
        debug_assert!(canonical.abs() <= RANGE && reference.abs() <= f64::from(RANGE));
        let negate = canonical < 0.0;
        let canonical = canonical.abs();
        // Adding +0 turns -0 into 0, so that zeros are one node.
        let reference = if negate { -reference } else { reference } + 0.0;
        let bits = (canonical.to_bits(), reference.to_bits());
        let shape = mix(2, u64::from(bits.0), bits.1);
        let value = Constant { canonical, reference };
        let accepts = |builder: &Self, node| match node {
            Node::Constant(index) => builder.constant_of(index) == value,
            Node::Input(_) | Node::Parameter(_) | Node::Operation { .. } => false,
        };
        let found = match self.find(shape, accepts) {
            Ok(reference) => reference,
            Err(slot) => {
                let index = u32::try_from(self.constants.len())
                    .expect("there are at most as many constants as nodes");
                self.constants.push(value);
                self.add_entry(slot, Entry { shape, node: Node::Constant(index), need: 0 })
            }
        };
        found.signed(negate)
    }

    /// Returns both in the order of their shapes. Branchless, because this branch is unpredictable.
    #[inline(always)]
    fn ordered(&self, a: Reference, b: Reference) -> (Reference, Reference) {
        let shape = |r: Reference| self.entries[r.node() as usize].shape;
        let (shape_a, shape_b) = (shape(a), shape(b));
        let alike = (shape_a == shape_b) & (b.node() < a.node());
        let swap = 0u32.wrapping_sub(u32::from((shape_b < shape_a) | alike));
        let both = (a.0 ^ b.0) & swap;
        (Reference(a.0 ^ both), Reference(b.0 ^ both))
    }

    #[inline(always)]
    fn operation(&mut self, operation: Operation, a: u32, b: u32) -> Reference {
        let (left, right) = (&self.entries[a as usize], &self.entries[b as usize]);
        let shape = mix(3 + u64::from(operation.number()), left.shape, right.shape);
        let need = if left.need == right.need { left.need + 1 } else { left.need.max(right.need) };
        self.intern(Node::Operation { operation, a, b }, shape, need)
    }

    /// Returns the node if it exists, otherwise adds it.
    #[inline(always)]
    fn intern(&mut self, node: Node, shape: u64, need: u16) -> Reference {
        match self.find(shape, |_, known| known == node) {
            Ok(reference) => reference,
            Err(slot) => self.add_entry(slot, Entry { shape, node, need }),
        }
    }

    /// Returns the node of this shape that `accepts` accepts, or the slot where a new one belongs.
    #[inline(always)]
    fn find(&self, shape: u64, accepts: impl Fn(&Self, Node) -> bool) -> Result<Reference, usize> {
        // The length is a power of two; the low bits of a shape are well mixed.
        let mask = self.known.len() - 1;
        let mut slot = shape as usize & mask;
        while let Some(index) = self.known[slot].checked_sub(1) {
            let entry = &self.entries[index as usize];
            if entry.shape == shape && accepts(self, entry.node) {
                return Ok(Reference::to(index));
            }
            slot = (slot + 1) & mask;
        }
        Err(slot)
    }

    #[inline(always)]
    fn add_entry(&mut self, slot: usize, entry: Entry) -> Reference {
        let index =
            u32::try_from(self.entries.len()).expect("a genome has at most 1024 instructions");
        self.entries.push(entry);
        self.known[slot] = index + 1;
        if 2 * self.entries.len() >= self.known.len() {
            self.grow();
        }
        Reference::to(index)
    }

    /// Doubles the hash table.
    #[cold]
    fn grow(&mut self) {
        let slots = 2 * self.known.len();
        self.known.clear();
        self.known.resize(slots, 0);
        for (number, entry) in (1..).zip(&self.entries) {
            let mut slot = entry.shape as usize & (slots - 1);
            while self.known[slot] != 0 {
                slot = (slot + 1) & (slots - 1);
            }
            self.known[slot] = number;
        }
    }
}

impl ScalarMachine for Builder {
    type Value = Reference;

    fn constant(&mut self, value: f32) -> Reference {
        self.folded(value, f64::from(value))
    }

    fn parameter(&mut self, register: u8, component: usize, value: f32) -> Reference {
        if self.is_tunable {
            let component = u32::try_from(component).expect("there are four components");
            self.tunable(4 * u32::from(register) + component, value)
        } else {
            self.constant(value)
        }
    }

    fn input(&mut self, input: Input) -> Reference {
        let shape = mix(1, input.index() as u64, 0);
        self.intern(Node::Input(input), shape, 0)
    }

    #[inline(always)]
    fn neg(&mut self, a: Reference) -> Reference {
        a.signed(true)
    }

    fn add(&mut self, a: Reference, b: Reference) -> Reference {
        if self.fold {
            if let Some(value) = self.folded_sum(a, b) {
                return value;
            }
            if a == b.signed(true) {
                return self.constant(0.0);
            }
        }
        // The sign of the first operand is factored out: -a + b = -(a - b).
        let (first, second) = self.ordered(a, b);
        let differ = first.is_negative() ^ second.is_negative();
        let operation = [Operation::Add, Operation::Sub][usize::from(differ)];
        self.operation(operation, first.node(), second.node()).signed(first.is_negative())
    }

    fn mul(&mut self, a: Reference, b: Reference) -> Reference {
        if self.fold
            && let Some(value) = self.folded_product(a, b)
        {
            return value;
        }
        let negate = a.is_negative() ^ b.is_negative();
        let (first, second) = self.ordered(a, b);
        self.operation(Operation::Mul, first.node(), second.node()).signed(negate)
    }

    fn function(&mut self, function: Function, a: Reference) -> Reference {
        let (operation, negate) = Operation::of(function, a.is_negative());
        let value = match self.node(a.node()) {
            Node::Constant(index) if self.fold => {
                let Constant { canonical, reference } = self.constant_of(index);
                let reference = operation.apply(reference, reference);
                self.folded(operation.apply(canonical, canonical), reference)
            }
            _ => self.operation(operation, a.node(), a.node()),
        };
        value.signed(negate)
    }
}

fn is_zero(value: Constant) -> bool {
    value.canonical.abs() <= 0.0 && value.reference.abs() <= 0.0
}

/// Hashes three numbers. `tag` separates the kinds of nodes: 1 for inputs, 2 for constants, from 3
/// on for operations, 20 for parameters.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn builder() -> (Builder, [Reference; 2]) {
        let mut builder = Builder::new(true);
        builder.clear(false);
        let inputs = [Input::ALL[0], Input::ALL[1]].map(|input| builder.input(input));
        (builder, inputs)
    }

    #[test]
    fn operations_are_folded_when_a_constant_decides_them() {
        let (mut builder, [x, y]) = builder();
        let [zero, one, half] = [0.0, 1.0, 0.5].map(|value| builder.constant(value));
        assert!(!zero.is_negative());
        for (a, b) in [(x, zero), (zero, x)] {
            assert_eq!(builder.add(a, b), x);
            assert_eq!(builder.mul(a, b), zero);
        }
        for (a, b) in [(x, one), (one, x)] {
            assert_eq!(builder.mul(a, b), x);
        }
        let minus_one = builder.constant(-1.0);
        assert_eq!(builder.mul(minus_one, x), x.signed(true));
        assert_eq!(minus_one, one.signed(true));
        assert_eq!(builder.add(x, x.signed(true)), zero);
        assert_eq!(builder.add(half, half), one);
        assert_eq!(builder.mul(half, half), builder.constant(0.25));
        // Nothing else is folded.
        let nodes = builder.len();
        for (a, b) in [(x, half), (half, x), (x, y)] {
            let (sum, product) = (builder.add(a, b), builder.mul(a, b));
            assert!(builder.is_operation(sum.node()) && builder.is_operation(product.node()));
        }
        assert_eq!(builder.len(), nodes + 4, "equal operations are one node");
    }

    #[test]
    fn nothing_is_folded_unless_asked_for() {
        let mut builder = Builder::new(false);
        builder.clear(false);
        let [x, half] = [builder.input(Input::ALL[0]), builder.constant(0.5)];
        let results = [
            builder.add(half, half),
            builder.mul(half, half),
            builder.add(x, x.signed(true)),
            builder.function(Function::Rcp, half),
        ];
        assert!(results.iter().all(|result| builder.is_operation(result.node())));
    }

    #[test]
    fn equal_constants_are_one_node() {
        let (mut builder, _) = builder();
        let zero = builder.constant(0.0);
        assert_eq!(builder.constant(-0.0), zero);
        let sum = builder.constant(0.1);
        let nodes = builder.len();
        assert_eq!(builder.constant(0.1), sum);
        assert_eq!(builder.constant(-0.1), sum.signed(true));
        assert_eq!(builder.len(), nodes);
        // In f64 arithmetic, 0.1 + 0.2 differs from the nearest f32.
        let fifth = builder.constant(0.2);
        let together = builder.add(sum, fifth);
        let direct = builder.constant(builder.value(together).unwrap().canonical);
        assert_ne!(together, direct);
    }

    #[test]
    fn parameters_are_one_node_per_place() {
        let (mut builder, _) = builder();
        builder.clear(true);
        let first = builder.parameter(2, 3, 0.5);
        assert_eq!(builder.parameter(2, 3, 0.5), first);
        assert_ne!(builder.parameter(3, 2, 0.5), first);
        let Node::Parameter(index) = builder.node(first.node()) else { panic!("a parameter") };
        assert_eq!(builder.place_of(index), Some(4 * 2 + 3));
        assert_eq!(builder.len(), 2);
    }
}
