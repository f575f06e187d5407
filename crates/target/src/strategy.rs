//! Names of the search strategies, and the dialect of their results. Requests are checked against
//! them; the strategies themselves are in the crate `brood-search`.

use std::fmt;
use std::str::FromStr;

use brood_genome::{Dialect, OpcodeSet, Parametrisation};

/// Method by which a search fits its samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Strategy {
    /// Fits of a smooth family, and shorter fits pruned from the best of them.
    Lobes,
    /// Well-known reflectance models, one or the sum of two, fitted by their own parameters.
    Analytic,
    /// Genetic programs whose constants are tuned by derivatives; started at random or from given
    /// genomes.
    Gp,
    /// Lobes first, then genetic programs; every second island starts from the lobes.
    Hybrid,
}

impl Strategy {
    /// All strategies, in the order in which they are listed to users.
    pub const ALL: [Self; 4] = [Self::Hybrid, Self::Lobes, Self::Analytic, Self::Gp];

    /// Dialect of genomes that searches create from scratch, so that they can be bred further. Fits
    /// of lobes are shorter and can be padded to this length.
    pub const DIALECT: Dialect = Dialect {
        opcodes: OpcodeSet::Extended,
        parametrisation: Parametrisation::Smooth,
        registers: 16,
        length: 120,
        isotropic: true,
        homogeneous: true,
    };

    /// Name in requests and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Lobes => "lobes",
            Self::Analytic => "analytic",
            Self::Gp => "gp",
            Self::Hybrid => "hybrid",
        }
    }
}

impl fmt::Display for Strategy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Error for a name that no strategy has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("unknown strategy; use one of {}", Strategy::ALL.map(Strategy::name).join(", "))]
pub struct UnknownStrategy;

impl FromStr for Strategy {
    type Err = UnknownStrategy;

    fn from_str(text: &str) -> Result<Self, UnknownStrategy> {
        Self::ALL.into_iter().find(|strategy| strategy.name() == text).ok_or(UnknownStrategy)
    }
}
