//! Members of the family of lobes, and the meaning of their parameters.

use brood_genome::Genome;
use brood_genome::lobes::{LobesError, Shape};

/// Meaning of a parameter: the weight of a feature in a slot, or a colour (log2 C).
#[derive(Clone, Copy)]
pub(super) enum Place {
    Slot { slot: usize, feature: usize },
    Colour { channel: usize, term: usize },
}

impl Place {
    /// Places in the order of the parameters: weights of units, weights of terms, colours.
    pub(super) fn all(shape: &Shape) -> Vec<Self> {
        let mut places = Vec::with_capacity(shape.len());
        for unit in 0..shape.units {
            // Of the features (u, x, 1), a unit uses x and 1.
            let features = shape.units..shape.features();
            let slot = shape.terms + unit;
            places.extend(features.map(|feature| Self::Slot { slot, feature }));
        }
        for slot in 0..shape.terms {
            places.extend((0..shape.features() - 1).map(|feature| Self::Slot { slot, feature }));
        }
        for term in 0..shape.terms {
            places.extend((0..3).map(|channel| Self::Colour { channel, term }));
        }
        places
    }
}

/// A member of the family.
#[derive(Debug, Clone, PartialEq)]
pub struct Lobes {
    pub(super) shape: Shape,
    /// Parameters by the indices of the shape: weights, biases and log2 C.
    pub(super) parameters: Vec<f64>,
    /// True for fitted parameters; the others are weights that pruning has set to 0.
    pub(super) free: Vec<bool>,
}

impl Lobes {
    /// All parameters 0 and free.
    pub(super) fn new(shape: Shape) -> Self {
        let count = shape.len();
        Self { shape, parameters: vec![0.0; count], free: vec![true; count] }
    }

    /// Inputs and size.
    #[must_use]
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Number of fitted parameters.
    #[must_use]
    pub fn free(&self) -> usize {
        self.free.iter().filter(|free| **free).count()
    }

    /// Program that computes the lobes, under the energy limit.
    ///
    /// # Errors
    /// As [`Shape::genome`].
    pub fn genome(&self) -> Result<Genome, LobesError> {
        self.shape.genome(&self.parameters)
    }
}
