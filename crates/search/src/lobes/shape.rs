//! Shape and parameters of a member of the family of lobes, and the order of the parameters.

use brood_brdf::Input;

/// Inputs and size of a member of the family.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shape {
    /// Inputs x; their number is d.
    pub inputs: Vec<Input>,
    /// Number of units u: M.
    pub units: usize,
    /// Number of terms e: J.
    pub terms: usize,
}

/// Meaning of a parameter: the weight of a feature in a slot, or a colour (log2 C).
#[derive(Clone, Copy)]
pub(super) enum Place {
    Slot { slot: usize, feature: usize },
    Colour { channel: usize, term: usize },
}

impl Shape {
    /// Inputs that describe the highlight and the rim of an isotropic material.
    pub const INPUTS: [Input; 8] = [
        Input::LogTanHalf,
        Input::HalfDotLight,
        Input::CosineProduct,
        Input::CosineDifference,
        Input::LogHalfDotLight,
        Input::LogHalfAngle,
        Input::LogCosineSum,
        Input::LogCosineProduct,
    ];

    /// Creates a shape with all of [`Shape::INPUTS`], plus [`Input::MirrorAsymmetry`] unless the
    /// material `is_mirrored`.
    #[must_use]
    pub fn new(units: usize, terms: usize, is_mirrored: bool) -> Self {
        let mut inputs = Self::INPUTS.to_vec();
        if !is_mirrored {
            inputs.push(Input::MirrorAsymmetry);
        }
        Self { inputs, units, terms }
    }

    /// Number of parameters.
    #[must_use]
    pub fn len(&self) -> usize {
        self.colour(self.terms, 0)
    }

    /// True if there are no parameters.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of features: length of (u, x, 1).
    pub(super) fn features(&self) -> usize {
        self.units + self.inputs.len() + 1
    }

    /// Index of the weight of input `input` in unit `unit`; `input` = d is the bias.
    pub(super) fn unit(&self, unit: usize, input: usize) -> usize {
        unit * (self.inputs.len() + 1) + input
    }

    /// Index of the weight of feature `feature` of (u, x) in term `term`.
    pub(super) fn term(&self, term: usize, feature: usize) -> usize {
        self.unit(self.units, 0) + term * (self.features() - 1) + feature
    }

    /// Index of log2 C of a term in a channel.
    pub(super) fn colour(&self, term: usize, channel: usize) -> usize {
        self.term(self.terms, 0) + 3 * term + channel
    }

    /// Places in the order of the parameters: weights of units, weights of terms, colours.
    pub(super) fn places(&self) -> Vec<Place> {
        let mut places = Vec::with_capacity(self.len());
        for unit in 0..self.units {
            // Of the features (u, x, 1), a unit uses x and 1.
            let features = self.units..self.features();
            let slot = self.terms + unit;
            places.extend(features.map(|feature| Place::Slot { slot, feature }));
        }
        for slot in 0..self.terms {
            places.extend((0..self.features() - 1).map(|feature| Place::Slot { slot, feature }));
        }
        for term in 0..self.terms {
            places.extend((0..3).map(|channel| Place::Colour { channel, term }));
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
}
