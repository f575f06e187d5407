//! Losses that compare a reflectance with its target.

use brood_genome::Functions;

/// Loss of a reflectance against its target.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Loss {
    /// log2(1 + f w) - log2(1 + f* w): ln 2 times the root of its mean square is E_log.
    Logarithmic,
    /// f w - f* w.
    Squared,
}

impl Loss {
    /// Returns the number of a weighted reflectance that is compared with the value to reach.
    pub(super) fn scaled(self, weighted: f32) -> f32 {
        match self {
            Self::Logarithmic => Functions::KNOWN.log2(1.0 + weighted),
            Self::Squared => weighted,
        }
    }
}
