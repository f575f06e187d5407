//! Genetic operators: a key first, parents in, one child out. Pure functions of both.

mod layer;
mod mutate;
mod random;
mod recombine;

use crate::locks::Held;
use crate::{BirthKey, CONSTANTS, Dialect, Genome, Instruction, Locks, Model, Output};

/// Overrides of the dialect's switches that a brood may carry; the child's genome holds the result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Constraints {
    /// Overrides `Dialect::isotropic`.
    pub isotropic: Option<bool>,
    /// Overrides `Dialect::homogeneous`.
    pub homogeneous: Option<bool>,
}

/// How children come to be.
#[derive(Debug, Clone, Copy)]
pub struct Variation<'a> {
    origin: Origin<'a>,
    constraints: Constraints,
    output: Option<Output>,
    limited: Option<bool>,
    locks: Option<&'a Locks>,
}

#[derive(Debug, Clone, Copy)]
enum Origin<'a> {
    Random(Dialect),
    Mutate { parent: &'a Genome, mutation: f32 },
    Recombine { first: &'a Genome, second: &'a Genome, recombination: f32, mutation: f32 },
}

/// A genome in the making; becomes a [`Genome`] through its validating constructor.
struct Draft {
    dialect: Dialect,
    instructions: Vec<Instruction>,
    constants: Box<[[f32; 4]; CONSTANTS]>,
    output: Output,
    limited: bool,
    layers: Vec<Model>,
}

impl<'a> Variation<'a> {
    /// Genomes from nothing: programs, or models where the dialect has the length 0.
    ///
    /// # Panics
    /// Where the dialect is not valid ([`Dialect::validate`]).
    #[must_use]
    pub fn random(dialect: Dialect) -> Self {
        dialect.validate().expect("a variation is made for a valid dialect");
        Self::of(Origin::Random(dialect))
    }

    /// Mutants of one parent.
    ///
    /// # Domain
    /// `mutation` in 0..=1: see docs/maths/variation.md for the rate that each field of an instruction gets from it.
    ///
    /// # Panics
    /// Where the amount is outside its domain.
    #[must_use]
    pub fn mutate(parent: &'a Genome, mutation: f32) -> Self {
        assert!((0.0..=1.0).contains(&mutation), "mutation is an amount from 0 to 1");
        Self::of(Origin::Mutate { parent, mutation })
    }

    /// Children of two parents: blocks of `second` in `first`, parameters and layers of its models, then mutation.
    ///
    /// # Domain
    /// Amounts in 0..=1; `recombination` is the expected share of the second parent. Dialects must be compatible.
    ///
    /// # Panics
    /// Where an amount is outside its domain or the dialects are not compatible.
    #[must_use]
    pub fn recombine(
        first: &'a Genome,
        second: &'a Genome,
        recombination: f32,
        mutation: f32,
    ) -> Self {
        let amounts = [recombination, mutation];
        assert!(
            amounts.iter().all(|amount| (0.0..=1.0).contains(amount)),
            "recombination and mutation are amounts from 0 to 1"
        );
        assert!(
            first.dialect().is_compatible(second.dialect()),
            "parents are of compatible dialects"
        );
        Self::of(Origin::Recombine { first, second, recombination, mutation })
    }

    /// Overrides the isotropic and homogeneous switches of the children.
    #[must_use]
    pub fn with_constraints(self, constraints: Constraints) -> Self {
        Self { constraints, ..self }
    }

    /// Gives the children this output stage instead of the first parent's (random children: the identity).
    #[must_use]
    pub fn with_output(self, output: Option<Output>) -> Self {
        Self { output, ..self }
    }

    /// Puts the children under the energy limit, or not, instead of as the first parent is (random children: not).
    #[must_use]
    pub fn with_limit(self, limited: Option<bool>) -> Self {
        Self { limited, ..self }
    }

    /// Keeps parts of the first parent; random children have nothing to keep.
    ///
    /// # Panics
    /// Where the locks name what the parent has not ([`Locks::validate_for`]).
    #[must_use]
    pub fn with_locks(self, locks: Option<&'a Locks>) -> Self {
        if let (Some(locks), Some(first)) = (locks, self.parents().next()) {
            locks.validate_for(first).expect("locks name what is there");
        }
        Self { locks, ..self }
    }

    /// The parents, first the one whose place the child's instructions keep.
    pub fn parents(&self) -> impl Iterator<Item = &'a Genome> {
        let (first, second) = match self.origin {
            Origin::Random(_) => (None, None),
            Origin::Mutate { parent, .. } => (Some(parent), None),
            Origin::Recombine { first, second, .. } => (Some(first), Some(second)),
        };
        first.into_iter().chain(second)
    }

    /// Whether no key makes a difference: all children are one, for want of mutation and of anything to choose between.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        match self.origin {
            Origin::Random(_) => false,
            Origin::Mutate { mutation, .. } => mutation <= 0.0,
            Origin::Recombine { first, second, recombination, mutation } => {
                // Kinds of layers are drawn even where the second parent has the whole share.
                let (own, other) = (first.layers(), second.layers());
                let same_kinds = own.len() <= other.len()
                    && own.iter().zip(other).all(|(own, other)| own.kind() == other.kind());
                let takes_all = recombination >= 1.0 && same_kinds;
                mutation <= 0.0 && (recombination <= 0.0 || takes_all || first == second)
            }
        }
    }

    /// The name of the operator that the family tree records.
    #[must_use]
    pub fn operator_name(&self) -> &'static str {
        match self.origin {
            Origin::Random(_) => "random",
            Origin::Mutate { .. } => "mutate",
            Origin::Recombine { .. } => "recombine",
        }
    }

    /// A parent as it would be born unchanged: under this variation's constraints, output stage and energy limit.
    #[must_use]
    pub fn unchanged(&self, parent: &Genome) -> Genome {
        self.finish(Draft::copy(parent))
    }

    /// The child of that key.
    #[must_use]
    pub fn birth(&self, key: BirthKey) -> Genome {
        self.finish(self.draft(key))
    }

    fn draft(&self, key: BirthKey) -> Draft {
        match self.origin {
            Origin::Random(dialect) => random::genome(dialect, key),
            Origin::Mutate { parent, mutation } => {
                let mut draft = Draft::copy(parent);
                mutate::draft(&mut draft, mutation, key, true, &self.held(parent));
                draft
            }
            Origin::Recombine { first, second, recombination, mutation } => {
                let held = self.held(first);
                let mut draft = recombine::draft(first, second, recombination, key, &held);
                mutate::draft(&mut draft, mutation, key, false, &held);
                draft
            }
        }
    }

    fn held(&self, first: &Genome) -> Held {
        match self.locks {
            Some(locks) => Held::of(first, locks),
            None => Held::nothing(first.instructions().len()),
        }
    }

    fn finish(&self, mut draft: Draft) -> Genome {
        if let Some(isotropic) = self.constraints.isotropic {
            draft.dialect.isotropic = isotropic;
        }
        if let Some(homogeneous) = self.constraints.homogeneous {
            draft.dialect.homogeneous = homogeneous;
        }
        draft.output = self.output.unwrap_or(draft.output);
        let Draft { dialect, instructions, constants, output, limited, layers } = draft;
        Genome::layered(dialect, instructions, constants, output, layers)
            .expect("operators keep to the dialect")
            .with_limit(self.limited.unwrap_or(limited))
    }

    fn of(origin: Origin<'a>) -> Self {
        Self {
            origin,
            constraints: Constraints::default(),
            output: None,
            limited: None,
            locks: None,
        }
    }
}

impl Draft {
    fn copy(parent: &Genome) -> Self {
        Self {
            dialect: *parent.dialect(),
            instructions: parent.instructions().to_vec(),
            constants: Box::new(*parent.constants()),
            output: *parent.output(),
            limited: parent.is_limited(),
            layers: parent.layers().to_vec(),
        }
    }
}

#[cfg(test)]
#[path = "variation_tests.rs"]
mod tests;
