//! Starts of lineages: sources of random genomes.

use serde::{Deserialize, Serialize};

use crate::{Dialect, believable};

crate::named_enum! {
    /// Source of the random genomes of a lineage, which also decides how its genomes vary.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
    #[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
    #[serde(rename_all = "lowercase")]
    pub enum Start {
        /// Programs with the parameters of measured materials. They vary by their parameters, so
        /// that children look like materials too.
        Believable => "believable",
        /// Models of reflectance with random parameters: the dialect of length 0.
        Models => "models",
        /// Painted materials with random effects: the dialect of length 0.
        Painted => "painted",
        /// Random programs.
        #[default]
        Wild => "wild",
    }
}

impl Start {
    /// Returns the start of a lineage of which only the dialect is given.
    #[must_use]
    pub fn of(dialect: &Dialect) -> Self {
        if dialect.length == 0 { Self::Models } else { Self::Wild }
    }

    /// Returns the dialect of a lineage of which only the start is given.
    #[must_use]
    pub fn dialect(self) -> Dialect {
        match self {
            Self::Believable => believable::dialect(),
            Self::Models | Self::Painted => Dialect { length: 0, ..Dialect::default() },
            Self::Wild => Dialect::default(),
        }
    }

    /// True if genomes of the dialect can be drawn from this start.
    #[must_use]
    pub fn allows(self, dialect: &Dialect) -> bool {
        match self {
            Self::Believable => dialect.length > 0 && dialect.is_compatible(&self.dialect()),
            Self::Models | Self::Painted => dialect.length == 0,
            Self::Wild => dialect.length > 0,
        }
    }
}
