//! Locks: parts of the first parent that all children keep.

mod effect;

use serde::{Deserialize, Serialize};

pub use effect::EffectLock;
pub(crate) use effect::LockedEffects;

use crate::liveness::walk_backwards;
use crate::steer::Kept;
use crate::{CONSTANTS, Dialect, EffectKind, Genome, Instruction, Model, REGISTERS};

/// A result channel of a genome, before the colour matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Channel {
    /// g of red.
    #[serde(rename = "r")]
    Red,
    /// g of green.
    #[serde(rename = "g")]
    Green,
    /// g of blue.
    #[serde(rename = "b")]
    Blue,
}

/// Parts of the first parent that breeding must not change.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Locks {
    /// Positions of instructions to keep.
    pub instructions: Vec<u16>,
    /// Constant registers whose values to keep.
    pub constants: Vec<u8>,
    /// Channels to keep as the same function of the inputs. Locks the instructions that they depend
    /// on and the constants that these read, and prevents other instructions from writing
    /// components that they read.
    pub channels: Vec<Channel>,
    /// Layers whose models to keep.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub layers: Vec<u8>,
    /// Parameters of layers whose values to keep; also keeps the kind of the layer's model.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parameters: Vec<ParameterLock>,
    /// Effects of a painted genome to keep.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<EffectKind>,
    /// Parameters of effects whose values to keep; also keeps the effect.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub effect_parameters: Vec<EffectLock>,
    /// True to keep the bumps, or that there are none.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub bump: bool,
}

/// A parameter of a layer.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParameterLock {
    /// Index of the layer.
    pub layer: u8,
    /// Name of the parameter.
    pub name: String,
}

/// Error of [`Locks::validate_for`] and [`Locks::validate`].
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LocksError {
    /// A position is beyond the length of the dialect.
    #[error(
        "there is no instruction {given}: a genome of the dialect has {length}, counted from 0"
    )]
    Instruction {
        /// Index in the list of instructions.
        at: usize,
        /// Position that was given.
        given: u16,
        /// Length of the dialect.
        length: u16,
    },
    /// The parent has no such layer.
    #[error("there is no layer {given}: the parent has {layers}, counted from 0")]
    Layer {
        /// JSON pointer to the index.
        pointer: String,
        /// Index that was given.
        given: u8,
        /// Number of layers of the parent.
        layers: usize,
    },
    /// The layer's model has no such parameter.
    #[error("the model of layer {layer} has no parameter {name:?}")]
    Parameter {
        /// JSON pointer to the name.
        pointer: String,
        /// Index of the layer.
        layer: u8,
        /// Name that was given.
        name: String,
    },
    /// The parent has no such effect.
    #[error("the parent has no effect {given}")]
    Effect {
        /// JSON pointer to the kind.
        pointer: String,
        /// Kind that was given.
        given: EffectKind,
    },
    /// The effect has no such parameter.
    #[error("the effect {effect} has no parameter {name:?}")]
    EffectParameter {
        /// JSON pointer to the name.
        pointer: String,
        /// Kind of the effect.
        effect: EffectKind,
        /// Name that was given.
        name: String,
    },
    /// Channels of a painted genome.
    #[error("a painted material has no channels: lock effects or their parameters")]
    Channels,
    /// The constant register is beyond C127.
    #[error("there is no constant C{given}: constants are 0 to 127")]
    Constant {
        /// Index in the list of constants.
        at: usize,
        /// Register that was given.
        given: u8,
    },
}

impl LocksError {
    /// JSON pointer to the invalid value, relative to the locks.
    #[must_use]
    pub fn pointer(&self) -> String {
        match self {
            Self::Instruction { at, .. } => format!("/instructions/{at}"),
            Self::Constant { at, .. } => format!("/constants/{at}"),
            Self::Channels => "/channels".to_owned(),
            Self::Layer { pointer, .. }
            | Self::Parameter { pointer, .. }
            | Self::Effect { pointer, .. }
            | Self::EffectParameter { pointer, .. } => pointer.clone(),
        }
    }
}

impl Locks {
    /// True if nothing is locked.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        let Self { instructions, constants, channels, .. } = self;
        let programs = instructions.is_empty() && constants.is_empty() && channels.is_empty();
        let Self { layers, parameters, effects, effect_parameters, bump, .. } = self;
        let models = layers.is_empty() && parameters.is_empty();
        !bump && programs && models && effects.is_empty() && effect_parameters.is_empty()
    }

    /// Checks that everything locked exists in a parent.
    ///
    /// # Errors
    /// Returns [`LocksError`] with the first lock that names nothing.
    pub fn validate_for(&self, parent: &Genome) -> Result<(), LocksError> {
        self.validate(parent.dialect())?;
        let layers = parent.layers();
        let find = |given: u8, pointer: String| {
            let missing = LocksError::Layer { pointer, given, layers: layers.len() };
            layers.get(usize::from(given)).ok_or(missing)
        };
        for (at, given) in self.layers.iter().enumerate() {
            find(*given, format!("/layers/{at}"))?;
        }
        for (at, ParameterLock { layer, name }) in self.parameters.iter().enumerate() {
            let model = find(*layer, format!("/parameters/{at}/layer"))?;
            if model.get(name).is_none() {
                let pointer = format!("/parameters/{at}/name");
                return Err(LocksError::Parameter { pointer, layer: *layer, name: name.clone() });
            }
        }
        self.validate_effects(parent)
    }

    fn validate_effects(&self, parent: &Genome) -> Result<(), LocksError> {
        if !parent.has_brdf() && !self.channels.is_empty() {
            return Err(LocksError::Channels);
        }
        let find = |given: EffectKind, pointer: String| {
            let found = parent.effects().iter().find(|effect| effect.kind() == given);
            found.ok_or(LocksError::Effect { pointer, given })
        };
        for (at, given) in self.effects.iter().enumerate() {
            find(*given, format!("/effects/{at}"))?;
        }
        for (at, EffectLock { effect, name }) in self.effect_parameters.iter().enumerate() {
            let own = find(*effect, format!("/effect_parameters/{at}/effect"))?;
            if !effect::has(own, name) {
                let pointer = format!("/effect_parameters/{at}/name");
                let (effect, name) = (*effect, name.clone());
                return Err(LocksError::EffectParameter { pointer, effect, name });
            }
        }
        Ok(())
    }

    /// Checks that the locked instructions and constants exist in genomes of a dialect.
    ///
    /// # Errors
    /// Returns [`LocksError`] with the first instruction or constant that does not exist.
    pub fn validate(&self, dialect: &Dialect) -> Result<(), LocksError> {
        let length = dialect.length;
        let beyond = self.instructions.iter().enumerate().find(|(_, given)| **given >= length);
        if let Some((at, given)) = beyond {
            return Err(LocksError::Instruction { at, given: *given, length });
        }
        let known = |given: u8| usize::from(given) < CONSTANTS;
        match self.constants.iter().enumerate().find(|(_, given)| !known(**given)) {
            Some((at, given)) => Err(LocksError::Constant { at, given: *given }),
            None => Ok(()),
        }
    }
}

/// Locks resolved for a parent.
pub(crate) struct ResolvedLocks {
    instructions: Vec<bool>,
    constants: [bool; CONSTANTS],
    /// Constants that are locked by their own index, not by a channel.
    named: [bool; CONSTANTS],
    /// Locked channels, red in the lowest bit.
    channels: u8,
    /// For each position and register, the components that locked channels read after it; empty if
    /// no channel is locked.
    needed: Vec<[u8; REGISTERS]>,
    layers: LockedLayers,
    effects: LockedEffects,
    /// Parts that a steer keeps besides.
    kept: Kept,
}

/// Locks of layers resolved for the first parent.
#[derive(Default)]
pub(crate) struct LockedLayers {
    /// For each layer and parameter value, true if it is locked; empty if there are no locks.
    values: Vec<Vec<bool>>,
    /// True if layers and programs must not be added or removed.
    is_closed: bool,
}

impl LockedLayers {
    fn of(layers: &[Model], locks: &Locks) -> Self {
        let any_channel = !locks.channels.is_empty();
        let channel = |at: usize| locks.channels.iter().any(|channel| *channel as usize == at);
        let of_layer = |(index, model): (usize, &Model)| {
            let whole = locks.layers.iter().any(|layer| usize::from(*layer) == index);
            let mut locked = Vec::with_capacity(model.parameter_values().len());
            for (parameter, values) in model.parameters() {
                let mut locks_of_parameters = locks.parameters.iter();
                let named = locks_of_parameters
                    .any(|lock| usize::from(lock.layer) == index && lock.name == parameter.name);
                // A locked channel locks its component of a colour, and all of a scalar or a
                // choice.
                let is_color = values.len() == 3;
                locked.extend(
                    (0..values.len()).map(|at| {
                        whole || named || if is_color { channel(at) } else { any_channel }
                    }),
                );
            }
            locked
        };
        let values = layers.iter().enumerate().map(of_layer).collect();
        Self { values, is_closed: any_channel }
    }

    /// Locks the parameters that a steer keeps, and the number of layers.
    fn keep(&mut self, layers: &[Model], kept: Kept) {
        self.is_closed = true;
        self.values.resize(layers.len(), Vec::new());
        for (locked, model) in self.values.iter_mut().zip(layers) {
            locked.resize(model.parameter_values().len(), false);
            let parameters = model.parameters();
            let kept = parameters
                .flat_map(|(parameter, values)| values.iter().map(move |_| kept.keeps(parameter)));
            for (locked, kept) in locked.iter_mut().zip(kept) {
                *locked |= kept;
            }
        }
    }

    /// True if a parameter value of a layer is locked.
    pub(crate) fn locks_value(&self, layer: usize, at: usize) -> bool {
        self.values.get(layer).and_then(|locked| locked.get(at)).is_some_and(|locked| *locked)
    }

    /// True if anything of a layer is locked, and with it the kind of its model.
    pub(crate) fn locks_kind(&self, layer: usize) -> bool {
        self.is_closed || self.values.get(layer).is_some_and(|locked| locked.contains(&true))
    }

    /// True if layers and programs must not be added or removed.
    pub(crate) fn is_closed(&self) -> bool {
        self.is_closed
    }
}

impl ResolvedLocks {
    /// No locks.
    pub(crate) fn none(length: usize) -> Self {
        Self {
            instructions: vec![false; length],
            constants: [false; CONSTANTS],
            named: [false; CONSTANTS],
            channels: 0,
            needed: Vec::new(),
            layers: LockedLayers::default(),
            effects: LockedEffects::default(),
            kept: Kept::default(),
        }
    }

    /// Resolves locks for a parent.
    ///
    /// # Domain
    /// Locks that [`Locks::validate_for`] accepts for the parent.
    pub(crate) fn of(parent: &Genome, locks: &Locks) -> Self {
        let instructions = parent.instructions();
        let mut locked = Self::none(instructions.len());
        locked.layers = LockedLayers::of(parent.layers(), locks);
        locked.effects = LockedEffects::of(&locks.effects, &locks.effect_parameters);
        for index in &locks.instructions {
            locked.instructions[usize::from(*index)] = true;
        }
        for index in &locks.constants {
            locked.constants[usize::from(*index)] = true;
        }
        locked.named = locked.constants;
        let result = locks.channels.iter().fold(0, |mask, channel| mask | 1 << *channel as u8);
        if result == 0 {
            return locked;
        }
        locked.channels = result;
        locked.needed = vec![[0; REGISTERS]; instructions.len()];
        walk_backwards(instructions, result, |index, live, needed| {
            locked.needed[index].copy_from_slice(&needed[..REGISTERS]);
            if live != 0 {
                locked.instructions[index] = true;
                if let Some(constant) = instructions[index].constant() {
                    locked.constants[usize::from(constant)] = true;
                }
            }
        });
        locked
    }

    /// Adds what a steer keeps.
    pub(crate) fn steered(mut self, layers: &[Model], kept: Kept) -> Self {
        self.kept = kept;
        if kept.is_any() {
            self.layers.keep(layers, kept);
        }
        self
    }

    /// Parts that stay because of a steer.
    pub(crate) fn kept(&self) -> Kept {
        self.kept
    }

    /// Locks of the layers.
    pub(crate) fn layers(&self) -> &LockedLayers {
        &self.layers
    }

    /// Locks of the effects.
    pub(crate) fn effects(&self) -> &LockedEffects {
        &self.effects
    }

    /// True if the instruction at a position is locked.
    pub(crate) fn locks_instruction(&self, position: usize) -> bool {
        // Positions are out of range if the first parent has no program; the second's program is
        // then free.
        self.instructions.get(position).is_some_and(|locked| *locked)
    }

    /// True if a constant register is locked.
    pub(crate) fn locks_constant(&self, index: usize) -> bool {
        self.constants[index]
    }

    /// True if an instruction, a constant or a channel is locked.
    pub(crate) fn locks_any(&self) -> bool {
        self.instructions.contains(&true) || self.constants.contains(&true) || self.channels != 0
    }

    /// Locked channels, red in the lowest bit.
    pub(crate) fn channels(&self) -> u8 {
        self.channels
    }

    /// Brings the constants back that are locked by their own index.
    pub(crate) fn restore_named(
        &self,
        constants: &mut [[f32; 4]; CONSTANTS],
        old: &[[f32; 4]; CONSTANTS],
    ) {
        for (index, (new, old)) in constants.iter_mut().zip(old).enumerate() {
            if self.named[index] {
                *new = *old;
            }
        }
    }

    /// True if the parent's instruction at a position may be replaced by `other`.
    pub(crate) fn allows(&self, position: usize, other: &Instruction) -> bool {
        let needed = self.needed.get(position);
        let touched = needed.map_or(0, |needed| needed[usize::from(other.dst())]);
        !self.locks_instruction(position) && other.write_mask().bits() & touched == 0
    }
}

#[cfg(test)]
#[path = "locks_tests.rs"]
mod tests;
