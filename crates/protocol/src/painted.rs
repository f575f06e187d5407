//! Options of broods that painted materials do not have, or that only they have.

use brood_genome::Genome;

use crate::BreedOptions;

/// Error of [`BreedOptions::check_painted`] and [`check_painted_defaults`].
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum PaintedError {
    /// One of two parents is painted.
    #[error(
        "a painted material can be recombined only with another one: the other parent is a BRDF"
    )]
    Mixed,
    /// A saturation below 1.
    #[error(
        "`saturation` acts on BRDFs, but children of a painted lineage or parent are painted: \
         leave it out, got {0}"
    )]
    Saturation(f32),
    /// An energy limit.
    #[error(
        "`energy_limit` acts on BRDFs, but children of a painted lineage or parent are painted: \
         leave it out"
    )]
    EnergyLimit,
    /// Colours of a painting.
    #[error(
        "`painting` colours painted materials, but children of this lineage or parent are BRDFs: \
         leave it out"
    )]
    Painting,
}

impl PaintedError {
    /// JSON pointer to the value that is to be changed, relative to the request.
    #[must_use]
    pub fn pointer(self) -> &'static str {
        match self {
            Self::Mixed => "/parents/1",
            Self::Saturation(_) => "/saturation",
            Self::EnergyLimit => "/energy_limit",
            Self::Painting => "/painting",
        }
    }
}

/// Checks the saturation and the energy limit of painted children, also as defaults of a lineage.
///
/// # Errors
/// [`PaintedError`] for the first that changes something.
pub fn check_painted_defaults(
    saturation: Option<f32>,
    energy_limit: Option<bool>,
) -> Result<(), PaintedError> {
    match saturation.filter(|saturation| *saturation < 1.0) {
        Some(saturation) => Err(PaintedError::Saturation(saturation)),
        None if energy_limit == Some(true) => Err(PaintedError::EnergyLimit),
        None => Ok(()),
    }
}

impl BreedOptions {
    /// Checks that the options suit the parents: both are painted or neither, painted children have
    /// no options of BRDFs, and others no painting. Without parents, `is_painted_start` decides.
    ///
    /// # Errors
    /// [`PaintedError`] for the first reason why they do not.
    pub fn check_painted(
        &self,
        parents: &[&Genome],
        is_painted_start: bool,
    ) -> Result<(), PaintedError> {
        let is_painted = parents.first().map_or(is_painted_start, |first| first.is_painted());
        if parents.iter().any(|parent| parent.is_painted() != is_painted) {
            return Err(PaintedError::Mixed);
        }
        if !is_painted {
            return if self.painting.is_some() { Err(PaintedError::Painting) } else { Ok(()) };
        }
        check_painted_defaults(self.saturation, self.energy_limit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_of_brdfs_are_refused_for_painted_children() {
        let painted: Genome = "brood 1\n.effect light\n".parse().unwrap();
        let model: Genome = "brood 1\n.model lambert\n".parse().unwrap();
        let plain = BreedOptions::default();
        assert_eq!(plain.check_painted(&[&painted, &painted], false), Ok(()));
        assert_eq!(plain.check_painted(&[&painted, &model], true), Err(PaintedError::Mixed));
        assert_eq!(plain.check_painted(&[&model, &painted], true), Err(PaintedError::Mixed));
        let grey = BreedOptions { saturation: Some(0.5), ..BreedOptions::default() };
        assert_eq!(grey.check_painted(&[], true), Err(PaintedError::Saturation(0.5)));
        assert_eq!(grey.check_painted(&[], false), Ok(()));
        assert_eq!(grey.check_painted(&[&model], true), Ok(()));
        let limited = BreedOptions { energy_limit: Some(true), ..BreedOptions::default() };
        let error = limited.check_painted(&[&painted], false).unwrap_err();
        assert_eq!((error, error.pointer()), (PaintedError::EnergyLimit, "/energy_limit"));
        let kept = BreedOptions {
            saturation: Some(1.0),
            energy_limit: Some(false),
            ..BreedOptions::default()
        };
        assert_eq!(kept.check_painted(&[&painted], true), Ok(()));
    }
}
