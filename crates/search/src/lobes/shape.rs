//! The family's shape and its numbers.

use brood_brdf::Input;

/// How large a member of the family is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shape {
    /// The inputs x, d of them.
    pub inputs: Vec<Input>,
    /// Units u: M.
    pub units: usize,
    /// Terms e: J.
    pub terms: usize,
}

impl Shape {
    /// The inputs that describe a highlight of an isotropic material, and its rim.
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

    /// With all of [`Shape::INPUTS`], and [`Input::MirrorAsymmetry`] where a material may tell left from right.
    #[must_use]
    pub fn new(units: usize, terms: usize, is_mirrored: bool) -> Self {
        let mut inputs = Self::INPUTS.to_vec();
        if !is_mirrored {
            inputs.push(Input::MirrorAsymmetry);
        }
        Self { inputs, units, terms }
    }

    /// How many numbers there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.colour(self.terms, 0)
    }

    /// Whether there is nothing at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Length of (u, x, 1).
    pub(super) fn features(&self) -> usize {
        self.units + self.inputs.len() + 1
    }

    /// Index of what unit `unit` takes of input `input`; of its bias where that is d.
    pub(super) fn unit(&self, unit: usize, input: usize) -> usize {
        unit * (self.inputs.len() + 1) + input
    }

    /// Index of what term `term` takes of feature `feature` of (u, x).
    pub(super) fn term(&self, term: usize, feature: usize) -> usize {
        self.unit(self.units, 0) + term * (self.features() - 1) + feature
    }

    /// Index of log2 C of a term in a channel.
    pub(super) fn colour(&self, term: usize, channel: usize) -> usize {
        self.term(self.terms, 0) + 3 * term + channel
    }
}

/// A member of the family.
#[derive(Debug, Clone, PartialEq)]
pub struct Lobes {
    pub(super) shape: Shape,
    /// By the indices of the shape. log2 C is -infinity where a term has nothing in a channel.
    pub(super) numbers: Vec<f64>,
    /// Whether each is fitted, or stays 0 (a factor C of 0).
    pub(super) free: Vec<bool>,
}

impl Lobes {
    /// All numbers 0, all of them to be fitted.
    pub(super) fn new(shape: Shape) -> Self {
        let count = shape.len();
        Self { shape, numbers: vec![0.0; count], free: vec![true; count] }
    }

    /// How large it is.
    #[must_use]
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// How many numbers are fitted.
    #[must_use]
    pub fn free(&self) -> usize {
        self.free.iter().filter(|free| **free).count()
    }
}
