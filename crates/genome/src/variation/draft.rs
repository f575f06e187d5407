//! Parts of a child while the operators change them.

use crate::believable;
use crate::{Bump, CONSTANTS, Dialect, Effect, Genome, Instruction, Model, Output};

/// Parts of a child; becomes a [`Genome`] through the validating constructor.
pub(super) struct Draft {
    pub(super) dialect: Dialect,
    pub(super) instructions: Vec<Instruction>,
    pub(super) constants: Box<[[f32; 4]; CONSTANTS]>,
    pub(super) output: Output,
    pub(super) limited: bool,
    pub(super) layers: Vec<Model>,
    pub(super) effects: Vec<Effect>,
    pub(super) bump: Option<Bump>,
}

impl Draft {
    /// Returns no parts: neither instructions nor layers nor effects.
    pub(super) fn empty(dialect: Dialect) -> Self {
        Self {
            dialect,
            instructions: Vec::new(),
            constants: Box::new([[0.0; 4]; CONSTANTS]),
            output: Output::IDENTITY,
            limited: false,
            layers: Vec::new(),
            effects: Vec::new(),
            bump: None,
        }
    }

    /// Returns the parts of a genome.
    pub(super) fn copy(parent: &Genome) -> Self {
        Self {
            dialect: *parent.dialect(),
            instructions: parent.instructions().to_vec(),
            constants: Box::new(*parent.constants()),
            output: *parent.output(),
            limited: parent.is_limited(),
            layers: parent.layers().to_vec(),
            effects: parent.effects().to_vec(),
            bump: parent.bump().cloned(),
        }
    }

    /// Clears the switches of the dialect that would hide a module of a believable program, if the
    /// first parent lacks that module.
    pub(super) fn open_switches(&mut self, first: &Genome) {
        let structure = |of: &[Instruction]| believable::structure_of(of).unwrap_or_default();
        let (own, first) = (structure(&self.instructions), structure(first.instructions()));
        self.dialect.isotropic &= !own.is_brushed || first.is_brushed;
        self.dialect.homogeneous &= !own.is_patterned || first.is_patterned;
    }
}
