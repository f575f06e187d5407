//! Locks: parts of the first parent that its children keep whatever is drawn.

use serde::{Deserialize, Serialize};

use crate::liveness::walk_back;
use crate::{CONSTANTS, Dialect, Genome, Instruction, Model, REGISTERS};

/// A result of a genome, before the colour matrix.
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

/// What breeding must not touch.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Locks {
    /// Positions of instructions that stay as they are.
    pub instructions: Vec<u16>,
    /// Constant registers whose values stay.
    pub constants: Vec<u8>,
    /// Channels that stay the same function of the inputs: the instructions that they depend on stay, with the constants
    /// these read, and no other instruction comes to write what they still need.
    pub channels: Vec<Channel>,
    /// Layers whose models stay as they are.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub layers: Vec<u8>,
    /// Parameters of layers whose values stay; the layer's model does too.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parameters: Vec<ParameterLock>,
}

/// A parameter of a layer.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParameterLock {
    /// The layer's place among the layers.
    pub layer: u8,
    /// The parameter's name.
    pub name: String,
}

/// Why locks name nothing.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LocksError {
    /// A position that no genome of the dialect has.
    #[error(
        "there is no instruction {given}: a genome of the dialect has {length}, counted from 0"
    )]
    Instruction {
        /// Where in the list.
        at: usize,
        /// As given.
        given: u16,
        /// The dialect's length.
        length: u16,
    },
    /// A layer that the parent has not.
    #[error("there is no layer {given}: the parent has {layers}, counted from 0")]
    Layer {
        /// JSON pointer to it.
        pointer: String,
        /// As given.
        given: u8,
        /// How many the parent has.
        layers: usize,
    },
    /// A parameter that the layer's model has not.
    #[error("the model of layer {layer} has no parameter {name:?}")]
    Parameter {
        /// JSON pointer to it.
        pointer: String,
        /// The layer.
        layer: u8,
        /// As given.
        name: String,
    },
    /// A register that no genome has.
    #[error("there is no constant C{given}: constants are 0 to 127")]
    Constant {
        /// Where in the list.
        at: usize,
        /// As given.
        given: u8,
    },
}

impl LocksError {
    /// JSON pointer to what is wrong, within the locks.
    #[must_use]
    pub fn pointer(&self) -> String {
        match self {
            Self::Instruction { at, .. } => format!("/instructions/{at}"),
            Self::Constant { at, .. } => format!("/constants/{at}"),
            Self::Layer { pointer, .. } | Self::Parameter { pointer, .. } => pointer.clone(),
        }
    }
}

impl Locks {
    /// Whether nothing is locked.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        let Self { instructions, constants, channels, layers, parameters } = self;
        let programs = instructions.is_empty() && constants.is_empty() && channels.is_empty();
        programs && layers.is_empty() && parameters.is_empty()
    }

    /// Checks that what is named is there in a parent.
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
        Ok(())
    }

    /// Checks that the instructions and constants that are named are there in genomes of the dialect.
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

/// Locks resolved for one parent.
pub(crate) struct Held {
    instructions: Vec<bool>,
    constants: [bool; CONSTANTS],
    /// For each position, what locked channels read after it of each register; nothing where no channel is locked.
    needed: Vec<[u8; REGISTERS]>,
    layers: HeldLayers,
}

/// What of the first parent's layers stays.
#[derive(Default)]
pub(crate) struct HeldLayers {
    /// For each layer of which something stays, which of its numbers; nothing where the layer is free.
    numbers: Vec<Vec<bool>>,
    closed: bool,
}

impl HeldLayers {
    fn of(layers: &[Model], locks: &Locks) -> Self {
        let any_channel = !locks.channels.is_empty();
        let channel = |at: usize| locks.channels.iter().any(|channel| *channel as usize == at);
        let of_layer = |(index, model): (usize, &Model)| {
            let whole = locks.layers.iter().any(|layer| usize::from(*layer) == index);
            let mut held = Vec::with_capacity(model.numbers().len());
            for (parameter, numbers) in model.parameters() {
                let mut locked = locks.parameters.iter();
                let named = locked
                    .any(|lock| usize::from(lock.layer) == index && lock.name == parameter.name);
                // A channel needs its own part of what has parts, and all of what has none.
                let is_color = numbers.len() == 3;
                held.extend(
                    (0..numbers.len()).map(|at| {
                        whole || named || if is_color { channel(at) } else { any_channel }
                    }),
                );
            }
            held
        };
        let numbers = layers.iter().enumerate().map(of_layer).collect();
        Self { numbers, closed: any_channel }
    }

    /// Whether a number of a layer's model stays.
    pub(crate) fn number(&self, layer: usize, at: usize) -> bool {
        self.numbers.get(layer).and_then(|held| held.get(at)).is_some_and(|held| *held)
    }

    /// Whether anything of a layer stays, and so which model it is.
    pub(crate) fn kind(&self, layer: usize) -> bool {
        self.closed || self.numbers.get(layer).is_some_and(|held| held.contains(&true))
    }

    /// Whether no layer and no program may come to it or leave it.
    pub(crate) fn is_closed(&self) -> bool {
        self.closed
    }
}

impl Held {
    /// Nothing is held.
    pub(crate) fn nothing(length: usize) -> Self {
        Self {
            instructions: vec![false; length],
            constants: [false; CONSTANTS],
            needed: Vec::new(),
            layers: HeldLayers::default(),
        }
    }

    /// # Domain
    /// Locks that [`Locks::validate_for`] accepts for the parent.
    pub(crate) fn of(parent: &Genome, locks: &Locks) -> Self {
        let instructions = parent.instructions();
        let mut held = Self::nothing(instructions.len());
        held.layers = HeldLayers::of(parent.layers(), locks);
        for index in &locks.instructions {
            held.instructions[usize::from(*index)] = true;
        }
        for index in &locks.constants {
            held.constants[usize::from(*index)] = true;
        }
        let result = locks.channels.iter().fold(0, |mask, channel| mask | 1 << *channel as u8);
        if result == 0 {
            return held;
        }
        held.needed = vec![[0; REGISTERS]; instructions.len()];
        walk_back(instructions, result, |index, live, wanted| {
            held.needed[index].copy_from_slice(&wanted[..REGISTERS]);
            if live != 0 {
                held.instructions[index] = true;
                if let Some(constant) = instructions[index].constant() {
                    held.constants[usize::from(constant)] = true;
                }
            }
        });
        held
    }

    /// What of the layers stays.
    pub(crate) fn layers(&self) -> &HeldLayers {
        &self.layers
    }

    /// Whether the instruction at a position stays.
    pub(crate) fn instruction(&self, position: usize) -> bool {
        // A program that the first parent has not can come from the second.
        self.instructions.get(position).is_some_and(|held| *held)
    }

    /// Whether a constant register stays.
    pub(crate) fn constant(&self, index: usize) -> bool {
        self.constants[index]
    }

    /// Whether the parent's instruction at a position may give way to another one.
    pub(crate) fn allows(&self, position: usize, other: &Instruction) -> bool {
        let needed = self.needed.get(position);
        let touched = needed.map_or(0, |needed| needed[usize::from(other.dst())]);
        !self.instruction(position) && other.write_mask().bits() & touched == 0
    }
}

#[cfg(test)]
#[path = "locks_tests.rs"]
mod tests;
