//! Options of broods that painted materials do not have, or that only they have.

use brood_genome::Genome;

use crate::BreedOptions;

/// Error of [`BreedOptions::check_painted`] and [`check_painted_defaults`].
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum PaintedError {
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
    /// Checks that the options suit the parents: children that paint light have no options of
    /// BRDFs, and BRDFs no painting. Without parents, `is_painted_start` decides.
    ///
    /// # Errors
    /// [`PaintedError`] for the first reason why they do not.
    pub fn check_painted(
        &self,
        parents: &[&Genome],
        is_painted_start: bool,
    ) -> Result<(), PaintedError> {
        let is_painted = match parents {
            [] => is_painted_start,
            parents => parents.iter().any(|parent| parent.is_painted()),
        };
        if !is_painted {
            return if self.painting.is_some() { Err(PaintedError::Painting) } else { Ok(()) };
        }
        // A BRDF beside a painted parent is painted.
        let is_mixed = parents.iter().any(|parent| !parent.is_painted());
        if is_mixed || parents.first().is_some_and(|first| first.has_brdf()) {
            return Ok(());
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
        let grey = BreedOptions { saturation: Some(0.5), ..BreedOptions::default() };
        assert_eq!(grey.check_painted(&[], true), Err(PaintedError::Saturation(0.5)));
        assert_eq!(grey.check_painted(&[], false), Ok(()));
        for parents in [[&painted, &model], [&model, &painted]] {
            assert_eq!(grey.check_painted(&parents, true), Ok(()), "the BRDF is painted");
        }
        assert_eq!(grey.check_painted(&[&model], true), Ok(()));
        let limited = BreedOptions { energy_limit: Some(true), ..BreedOptions::default() };
        let error = limited.check_painted(&[&painted], false).unwrap_err();
        assert_eq!((error, error.pointer()), (PaintedError::EnergyLimit, "/energy_limit"));
        let toon = "brood 1\n.model lambert\n.effect light\nby brdf\n".parse().unwrap();
        assert_eq!(grey.check_painted(&[&toon, &painted], true), Ok(()));
        assert_eq!(limited.check_painted(&[&toon], true), Ok(()));
        assert_eq!(plain.check_painted(&[&toon, &model], true), Ok(()));
        let kept = BreedOptions {
            saturation: Some(1.0),
            energy_limit: Some(false),
            ..BreedOptions::default()
        };
        assert_eq!(kept.check_painted(&[&painted], true), Ok(()));
    }
}
