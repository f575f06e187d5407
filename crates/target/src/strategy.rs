//! Names of the search strategies, and the dialect of their results. Requests are checked against
//! them; the strategies themselves are in the crate `brood-search`.

use std::fmt;
use std::str::FromStr;

use brood_genome::{Dialect, OpcodeSet, Parametrisation};

use crate::measured::FEWEST;

brood_brdf::named_enum! {
    /// Method by which a search fits its samples; the name is that in requests and on the command
    /// line. Listed to users in this order.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum Strategy {
        /// Lobes first, then genetic programs; every second island starts from the lobes.
        Hybrid => "hybrid",
        /// Fits of a smooth family, and shorter fits pruned from the best of them.
        Lobes => "lobes",
        /// Well-known reflectance models, one or the sum of two, fitted by their own parameters.
        Analytic => "analytic",
        /// Genetic programs whose constants are tuned by derivatives; started at random or from
        /// given genomes.
        Gp => "gp",
    }
}

impl Strategy {
    /// Strategy if none is chosen. Pictures show few pairs of directions: models keep to what
    /// materials do elsewhere. Measurements show all of them, and programs match them better.
    #[must_use]
    pub fn of_target(is_picture: bool) -> Self {
        if is_picture { Self::Analytic } else { Self::Hybrid }
    }

    /// Checks that a target's pixels suit the strategy: `used` that one light reaches, and
    /// `several` that are lit from several directions, which only models are fitted to.
    ///
    /// # Errors
    /// Returns [`FewPixels`] if they do not.
    pub fn check_pixels(self, used: u64, several: u64) -> Result<(), FewPixels> {
        let has_few = used < FEWEST as u64 && several > 0;
        if self != Self::Analytic && has_few {
            return Err(FewPixels { strategy: self, used, several });
        }
        Ok(())
    }

    /// Reads the choice of a strategy; `None` for `auto`, which leaves it to
    /// [`Strategy::of_target`].
    ///
    /// # Errors
    /// Returns [`UnknownStrategy`] for other names.
    pub fn choice(text: &str) -> Result<Option<Self>, UnknownStrategy> {
        if text == "auto" { Ok(None) } else { text.parse().map(Some) }
    }

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
}

brood_brdf::named_enum! {
    /// Error that fits of lobes minimise; the name is that in requests and on the command line.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
    pub enum Objective {
        /// E_log, with differences of dark values added: E_log alone does not separate a dark body
        /// below a bright highlight from a black one, and pictures do.
        #[default]
        Seen => "seen",
        /// E_log alone.
        ELog => "e_log",
    }
}

impl Strategy {
    /// Checks the objective of a search. Only lobes can minimise [`Objective::Seen`], which is
    /// their default; the other strategies minimise E_log.
    ///
    /// # Errors
    /// Returns [`NoObjective`] if the strategy cannot minimise it.
    pub fn objective(self, asked: Option<Objective>) -> Result<Objective, NoObjective> {
        let has_lobes = matches!(self, Self::Lobes | Self::Hybrid);
        match asked {
            Some(Objective::Seen) if !has_lobes => Err(NoObjective(self)),
            Some(objective) => Ok(objective),
            None if has_lobes => Ok(Objective::Seen),
            None => Ok(Objective::ELog),
        }
    }
}

impl Strategy {
    /// True if searches of this strategy can be spread over islands: they have a population of
    /// programs, whose best can migrate.
    #[must_use]
    pub fn has_islands(self) -> bool {
        matches!(self, Self::Gp | Self::Hybrid)
    }
}

impl FromStr for Objective {
    type Err = UnknownObjective;

    fn from_str(text: &str) -> Result<Self, UnknownObjective> {
        Self::from_name(text).ok_or(UnknownObjective)
    }
}

/// Error for a name that no objective has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("unknown objective; use {}", Objective::ALL.map(Objective::name).join(" or "))]
pub struct UnknownObjective;

/// Error for an objective that the strategy cannot minimise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the strategy {0} minimises e_log; the objective seen needs the strategy lobes or hybrid")]
pub struct NoObjective(pub Strategy);

impl fmt::Display for Strategy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Error for a strategy that needs more pixels that one light reaches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "the strategy {strategy} fits pixels that one light reaches; it needs {FEWEST}, and the target \
     has {used}; use analytic, which also fits the {several} pixels that are lit from several directions"
)]
pub struct FewPixels {
    /// The strategy.
    pub strategy: Strategy,
    /// Number of pixels that one light reaches.
    pub used: u64,
    /// Number of pixels that are lit from several directions.
    pub several: u64,
}

/// Error for a name that no strategy has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("unknown strategy; use auto or one of {}", Strategy::ALL.map(Strategy::name).join(", "))]
pub struct UnknownStrategy;

impl FromStr for Strategy {
    type Err = UnknownStrategy;

    fn from_str(text: &str) -> Result<Self, UnknownStrategy> {
        Self::from_name(text).ok_or(UnknownStrategy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_lobes_minimise_what_is_seen() {
        for strategy in Strategy::ALL {
            let has_lobes = matches!(strategy, Strategy::Lobes | Strategy::Hybrid);
            let own = if has_lobes { Objective::Seen } else { Objective::ELog };
            assert_eq!(strategy.objective(None), Ok(own), "{strategy}");
            assert_eq!(strategy.objective(Some(Objective::ELog)), Ok(Objective::ELog));
            assert_eq!(strategy.objective(Some(Objective::Seen)).is_ok(), has_lobes);
        }
        let error = Strategy::Gp.objective(Some(Objective::Seen)).unwrap_err().to_string();
        assert!(error.contains("gp minimises e_log"), "{error}");
        assert_eq!(
            "elog".parse::<Objective>().unwrap_err().to_string(),
            "unknown objective; use seen or e_log"
        );
    }
}
