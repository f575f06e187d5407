//! Shape of a member of the family of lobes, and the order of its parameters.

use crate::Input;

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
    #[must_use]
    pub fn features(&self) -> usize {
        self.units + self.inputs.len() + 1
    }

    /// Index of the weight of input `input` in unit `unit`; `input` = d is the bias.
    #[must_use]
    pub fn unit(&self, unit: usize, input: usize) -> usize {
        unit * (self.inputs.len() + 1) + input
    }

    /// Index of the weight of feature `feature` of (u, x) in term `term`.
    #[must_use]
    pub fn term(&self, term: usize, feature: usize) -> usize {
        self.unit(self.units, 0) + term * (self.features() - 1) + feature
    }

    /// Index of log2 C of a term in a channel.
    #[must_use]
    pub fn colour(&self, term: usize, channel: usize) -> usize {
        self.term(self.terms, 0) + 3 * term + channel
    }
}
