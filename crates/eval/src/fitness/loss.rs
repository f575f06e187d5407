//! Losses that compare a reflectance with its target.

use brood_genome::Functions;

/// Deviation of a reflectance f from the target f*, both multiplied by the weight w of the sample;
/// errors are sums of its square.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Loss {
    /// log2(1 + f w) - log2(1 + f* w). The root of its mean square, times ln 2, is the error E_log
    /// of docs/maths/fit.md.
    Logarithmic,
    /// f w - f* w.
    Squared,
}

impl Loss {
    /// Returns the quantity that is compared with the value to reach, given f w.
    pub(super) fn scaled(self, weighted: f32) -> f32 {
        match self {
            Self::Logarithmic => Functions::KNOWN.log2(1.0 + weighted),
            Self::Squared => weighted,
        }
    }
}
