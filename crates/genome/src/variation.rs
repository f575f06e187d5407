//! Genetic operators: pure functions of a key and the parents that return one child.

mod bump;
mod draft;
mod layer;
mod mutate;
mod paint;
mod random;
mod recombine;
mod strength;
mod toward;

use crate::believable::{self, Structure};
use crate::effect;
use crate::locks::{LockedEffects, ResolvedLocks};
use crate::steer::Kept;
use crate::{
    BirthKey, Bump, Dialect, DialectConstraints, EffectKind, Genome, Locks, Output,
    PaintingPalette, Palette, Start, Steer,
};
use draft::Draft;
pub use strength::MutationScale;
use strength::{Part, Strength};

/// A way to make children: random, mutation or crossover, with its options.
#[derive(Debug, Clone, Copy)]
pub struct Variation<'a> {
    origin: Origin<'a>,
    constraints: DialectConstraints,
    output: Option<Output>,
    limited: Option<bool>,
    locks: Option<&'a Locks>,
    start: Start,
    scale: MutationScale,
    steer: &'a [Steer],
    painting: Option<&'a PaintingPalette>,
}

/// Operator with its parents and amounts.
#[derive(Debug, Clone, Copy)]
enum Origin<'a> {
    Random(Dialect),
    Mutate { parent: &'a Genome, mutation: f32 },
    Recombine { first: &'a Genome, second: &'a Genome, recombination: f32, mutation: f32 },
}

/// True if one parent is a BRDF and the other paints light.
fn is_painting(first: &Genome, second: &Genome) -> bool {
    paint::are_mixed(first, second) && !(first.is_by_brdf() || second.is_by_brdf())
}

impl<'a> Variation<'a> {
    /// Makes random genomes: programs, or models if the dialect's length is 0.
    ///
    /// # Panics
    /// If the dialect is not valid ([`Dialect::validate`]).
    #[must_use]
    pub fn random(dialect: Dialect) -> Self {
        dialect.validate().expect("the dialect of a variation is valid");
        Self::of(Origin::Random(dialect))
    }

    /// Makes mutants of a parent.
    ///
    /// # Domain
    /// `mutation` in 0..=1, a visible amount; docs/maths/variation.md has the difference that it
    /// makes.
    ///
    /// # Panics
    /// If the amount is outside its domain.
    #[must_use]
    pub fn mutate(parent: &'a Genome, mutation: f32) -> Self {
        assert!((0.0..=1.0).contains(&mutation), "`mutation` must be between 0 and 1");
        Self::of(Origin::Mutate { parent, mutation })
    }

    /// Makes crossovers of two parents: blocks of `second` in `first`, also parameters and layers
    /// of its models; then mutates. If one parent is a BRDF and the other paints light, the child
    /// has the BRDF and the effects. If the painted parent has a BRDF of its own, the unpainted
    /// BRDF gets the same effects, and both are crossed.
    ///
    /// # Domain
    /// Amounts in 0..=1; `recombination` is the expected share of the second parent. The dialects
    /// must be compatible.
    ///
    /// # Panics
    /// If an amount is outside its domain or the parents do not go together.
    #[must_use]
    pub fn crossover(
        first: &'a Genome,
        second: &'a Genome,
        recombination: f32,
        mutation: f32,
    ) -> Self {
        let amounts = [recombination, mutation];
        assert!(
            amounts.iter().all(|amount| (0.0..=1.0).contains(amount)),
            "`recombination` and `mutation` must be between 0 and 1"
        );
        assert!(
            first.dialect().is_compatible(second.dialect()),
            "the dialects of the parents must be compatible"
        );
        Self::of(Origin::Recombine { first, second, recombination, mutation })
    }

    /// Overrides the isotropic and homogeneous switches of the children, and whether they have
    /// bumps.
    #[must_use]
    pub fn with_constraints(self, constraints: DialectConstraints) -> Self {
        Self { constraints, ..self }
    }

    /// Sets the output stage of the children. By default it is the first parent's, or the identity
    /// for random children.
    #[must_use]
    pub fn with_output(self, output: Option<Output>) -> Self {
        Self { output, ..self }
    }

    /// Sets the energy limit of the children. By default it is the first parent's, or off for
    /// random children.
    #[must_use]
    pub fn with_limit(self, limited: Option<bool>) -> Self {
        Self { limited, ..self }
    }

    /// Keeps parts of the first parent. Has no effect on random children.
    ///
    /// # Panics
    /// If the locks name parts that the parent does not have ([`Locks::validate_for`]).
    #[must_use]
    pub fn with_locks(self, locks: Option<&'a Locks>) -> Self {
        if let (Some(locks), Some(first)) = (locks, self.parents().next()) {
            locks.validate_for(first).expect("locks name parts of the first parent");
        }
        Self { locks, ..self }
    }

    /// Sets the start of the lineage: under [`Start::Believable`], random children are believable
    /// programs, and children of these vary by parameters; under [`Start::Painted`], they are
    /// painted. The others vary alike.
    ///
    /// # Panics
    /// If random children are asked for and the start does not allow their dialect.
    #[must_use]
    pub fn with_start(self, start: Start) -> Self {
        if let Origin::Random(dialect) = self.origin {
            assert!(start.allows(&dialect), "the start of a variation allows its dialect");
        }
        Self { start, ..self }
    }

    /// Keeps what the words keep of the first parent, as far as its genome shows what that is:
    /// colours and highlights of models and of believable programs. Has no effect on random
    /// children.
    #[must_use]
    pub fn with_steer(self, steer: &'a [Steer]) -> Self {
        Self { steer, ..self }
    }

    /// Colours painted children with the regions of a picture, unless their palette is locked. All
    /// other parts vary as without it. Has no effect on BRDFs.
    #[must_use]
    pub fn with_painting(self, painting: Option<&'a PaintingPalette>) -> Self {
        Self { painting, ..self }
    }

    /// Sets the meaning of `mutation`. By default it is a visible amount.
    #[must_use]
    pub fn with_scale(self, scale: MutationScale) -> Self {
        Self { scale, ..self }
    }

    /// Iterates over the parents. The first one defines the positions of the child's instructions.
    pub fn parents(&self) -> impl Iterator<Item = &'a Genome> {
        let (first, second) = match self.origin {
            Origin::Random(_) => (None, None),
            Origin::Mutate { parent, .. } => (Some(parent), None),
            Origin::Recombine { first, second, .. } => (Some(first), Some(second)),
        };
        first.into_iter().chain(second)
    }

    /// True if all children are equal for any key: there is no mutation and no random choice
    /// between the parents or of the colours of a painting.
    #[must_use]
    pub fn is_deterministic(&self) -> bool {
        let locks_colors = |first: &Genome| {
            self.resolve_locks(first).effects().locks(EffectKind::Light, Palette::COLORS)
        };
        if self.painting.is_some()
            && self
                .parents()
                .next()
                .is_none_or(|first| self.parents().any(Genome::is_painted) && !locks_colors(first))
        {
            return false;
        }
        match self.origin {
            Origin::Random(_) => false,
            Origin::Mutate { mutation, .. } => mutation <= 0.0,
            Origin::Recombine { first, second, mutation, .. } if is_painting(first, second) => {
                mutation <= 0.0
            }
            Origin::Recombine { first, second, recombination, mutation } => {
                // Kinds of layers are drawn even if the second parent has a share of 1.
                let (own, other) = (first.layers(), second.layers());
                let same_kinds = own.len() <= other.len()
                    && own.iter().zip(other).all(|(own, other)| own.kind() == other.kind());
                let takes_all = recombination >= 1.0 && same_kinds;
                mutation <= 0.0 && (recombination <= 0.0 || takes_all || first == second)
            }
        }
    }

    /// True if the share of the second parent has an effect. It has none if one parent is a BRDF
    /// and the other paints light.
    #[must_use]
    pub fn has_share(&self) -> bool {
        match self.origin {
            Origin::Recombine { first, second, .. } => !is_painting(first, second),
            Origin::Random(_) | Origin::Mutate { .. } => false,
        }
    }

    /// Name of the operator in the family tree.
    #[must_use]
    pub fn operator_name(&self) -> &'static str {
        match self.origin {
            Origin::Random(_) => "random",
            Origin::Mutate { .. } => "mutate",
            Origin::Recombine { .. } => "recombine",
        }
    }

    /// Returns a parent with this variation's constraints, output stage and energy limit but no
    /// other change.
    #[must_use]
    pub fn unchanged(&self, parent: &Genome) -> Genome {
        self.finish(Draft::copy(parent))
    }

    /// Returns the child of a key.
    #[must_use]
    pub fn birth(&self, key: BirthKey) -> Genome {
        let mut draft = self.draft(key);
        draft.bump = self.bump(key);
        if let Some(painting) = self.painting
            && !draft.effects.is_empty()
        {
            let resolved = self.parents().next().map(|first| self.resolve_locks(first));
            let none = LockedEffects::default();
            let locked = resolved.as_ref().map_or(&none, ResolvedLocks::effects);
            paint::color(&mut draft.effects, painting, key, locked);
        }
        self.finish(draft)
    }

    /// Returns the bumps of the child of a key, which BRDFs have.
    fn bump(&self, key: BirthKey) -> Option<Bump> {
        let strength = |mutation| Strength::new(mutation, Part::Believable, self.scale).amount;
        let (inherited, amount) = match self.origin {
            Origin::Random(_) => (None, 1.0),
            Origin::Mutate { parent, mutation } => (parent.bump().cloned(), strength(mutation)),
            Origin::Recombine { first, second, recombination, mutation } => {
                (bump::recombine((first, second), recombination, key), strength(mutation))
            }
        };
        let first = self.parents().next();
        if let (Some(first), true) = (first, self.locks.is_some_and(|locks| locks.bump)) {
            return first.bump().cloned();
        }
        match inherited {
            Some(mut bump) => {
                bump::mutate(&mut bump, amount, key);
                Some(bump)
            }
            None if self.constraints.bumps == Some(true) && amount > 0.0 => Some(bump::random(key)),
            None => None,
        }
    }

    fn draft(&self, key: BirthKey) -> Draft {
        match self.origin {
            Origin::Random(dialect) if self.is_believable() => {
                let drawn = Draft::copy(&believable::genome(key, self.modules([&dialect])));
                Draft { dialect, ..drawn }
            }
            Origin::Random(dialect) if self.start == Start::Painted => {
                Draft { effects: paint::random(key), ..Draft::empty(dialect) }
            }
            Origin::Random(dialect) => random::genome(dialect, key),
            Origin::Mutate { parent, mutation } => {
                let mut draft = Draft::copy(parent);
                mutate::draft(
                    &mut draft,
                    key,
                    self.how(mutation, true, self.modules([parent.dialect()])),
                    &self.resolve_locks(parent),
                );
                draft
            }
            Origin::Recombine { first, second, mutation, .. } if is_painting(first, second) => {
                let (brdf, paint) =
                    if first.is_painted() { (second, first) } else { (first, second) };
                let toon = paint::painted_by(brdf, paint);
                let mut draft = Draft::copy(&toon);
                let how = self.how(mutation, true, self.modules([toon.dialect()]));
                mutate::draft(&mut draft, key, how, &self.resolve_locks_of(&toon, first));
                draft
            }
            Origin::Recombine { first, second, recombination, mutation } => {
                let matched =
                    paint::are_mixed(first, second).then(|| paint::matched(first, second));
                let (first, second) = matched.as_ref().map_or((first, second), |[a, b]| (a, b));
                let locked = self.resolve_locks(first);
                let modules = self.modules([first.dialect(), second.dialect()]);
                let how = self.how(mutation, false, modules);
                let mut draft =
                    recombine::draft((first, second), recombination, key, (how, &locked));
                mutate::draft(&mut draft, key, how, &locked);
                draft
            }
        }
    }

    fn how(&self, mutation: f32, force: bool, modules: Structure) -> mutate::How {
        let believable = self.is_believable().then_some(modules);
        mutate::How { mutation, scale: self.scale, force, believable }
    }

    /// Modules that believable children may have under the constraints, if the parents have these
    /// dialects, or random children this one.
    fn modules<const N: usize>(&self, dialects: [&Dialect; N]) -> Structure {
        let DialectConstraints { isotropic, homogeneous, bumps: _ } = self.constraints;
        let all = |is: fn(&Dialect) -> bool| dialects.into_iter().all(is);
        let isotropic = isotropic.unwrap_or_else(|| all(|dialect| dialect.isotropic));
        let homogeneous = homogeneous.unwrap_or_else(|| all(|dialect| dialect.homogeneous));
        Structure { is_brushed: !isotropic, is_patterned: !homogeneous }
    }

    fn is_believable(&self) -> bool {
        self.start == Start::Believable
    }

    /// Resolves the first parent's locks for a genome with the effects or the BRDF of that parent.
    fn resolve_locks_of(&self, genome: &Genome, first: &Genome) -> ResolvedLocks {
        match self.locks {
            // The program of a painted parent is not in the child.
            Some(locks) if first.is_painted() => {
                let locks = Locks {
                    effects: locks.effects.clone(),
                    effect_parameters: locks.effect_parameters.clone(),
                    ..Locks::default()
                };
                ResolvedLocks::of(genome, &locks).steered(genome.layers(), Kept::of(self.steer))
            }
            _ => self.resolve_locks(genome),
        }
    }

    fn resolve_locks(&self, first: &Genome) -> ResolvedLocks {
        let locked = match self.locks {
            Some(locks) => ResolvedLocks::of(first, locks),
            None => ResolvedLocks::none(first.instructions().len()),
        };
        locked.steered(first.layers(), Kept::of(self.steer))
    }

    /// Applies constraints, output stage and energy limit.
    fn finish(&self, mut draft: Draft) -> Genome {
        if let Some(isotropic) = self.constraints.isotropic {
            draft.dialect.isotropic = isotropic;
        }
        if let Some(homogeneous) = self.constraints.homogeneous {
            draft.dialect.homogeneous = homogeneous;
        }
        draft.output = self.output.unwrap_or(draft.output);
        let Draft { dialect, instructions, constants, output, limited, .. } = draft;
        let Draft { layers, effects, bump, .. } = draft;
        let bump = bump.filter(|_| self.constraints.bumps != Some(false));
        if !effects.is_empty() && !effect::are_by_brdf(&effects) {
            return Genome::painted(dialect, instructions, constants, effects)
                .expect("operators keep to the rules of effects");
        }
        let brdf = Genome::layered(dialect, instructions, constants, output, layers)
            .expect("operators keep to the dialect")
            .with_limit(self.limited.unwrap_or(limited));
        match effects.is_empty() {
            true => brdf.with_bump(bump),
            false => brdf.with_effects(effects).expect("operators keep to the rules of effects"),
        }
    }

    fn of(origin: Origin<'a>) -> Self {
        Self {
            origin,
            constraints: DialectConstraints::default(),
            output: None,
            limited: None,
            locks: None,
            start: Start::default(),
            scale: MutationScale::default(),
            steer: &[],
            painting: None,
        }
    }
}

#[cfg(test)]
#[path = "variation_tests.rs"]
mod tests;
