//! Terms of the objective of a fit of lobes that can be left out.

use brood_target::Objective;

/// Terms of the objective besides E_log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Terms {
    /// Differences of dark values: ln(1 + f cos_i / m) instead of ln(1 + f cos_i).
    pub dark: bool,
    /// Bounds between samples, which are estimated from samples near them.
    pub bounds: bool,
    /// Penalty of albedos above 1.
    pub albedo: bool,
}

impl Terms {
    /// All terms.
    pub const ALL: Self = Self { dark: true, ..Self::BOUNDED };
    /// Bounds and albedo.
    pub const BOUNDED: Self = Self { dark: false, bounds: true, albedo: true };
}

impl From<Objective> for Terms {
    fn from(objective: Objective) -> Self {
        match objective {
            Objective::Seen => Self::ALL,
            Objective::ELog => Self::BOUNDED,
        }
    }
}
