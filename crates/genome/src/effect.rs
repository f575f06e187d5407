//! Effects of painted materials: a light effect with a palette, and overlays over it.
//!
//! A painted genome mixes colours of a display by weights that sum to 1. It is not a BRDF, and has
//! no layers, output stage or energy limit unless its light effect is `by brdf`: it then paints
//! what its BRDF reflects. docs/maths/painted.md has the formulas.

mod image;
mod kind;
mod palette;

use std::fmt;

use brood_brdf::{Parameter, ParameterValues};

use crate::ImageHash;

pub use image::{EffectImage, IMAGES_MAX, ImagePlace};
pub(crate) use image::{MAP, is_of_palette};
pub(crate) use kind::{BRDF, BY, COLOR, index_beside};
pub use kind::{Basis, EffectKind};
pub(crate) use palette::hex;
pub use palette::{PALETTE_MAX, PALETTE_MIN, Palette, PaletteError};

/// An effect with values for its parameters, and images in some of its places. A light effect also
/// has a palette.
#[derive(Debug, Clone, PartialEq)]
pub struct Effect {
    kind: EffectKind,
    values: ParameterValues,
    palette: Option<Palette>,
    images: Vec<EffectImage>,
}

/// Error of [`Effect::new`].
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{reason}")]
pub struct EffectError {
    /// Name of the parameter that is not valid.
    pub parameter: &'static str,
    /// Description of the error.
    pub reason: String,
}

/// Error of a list of effects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum EffectsError {
    /// The first effect is another one.
    #[error("the first effect must be light, got {0}")]
    First(EffectKind),
    /// A kind is repeated.
    #[error("a genome can have one {0} effect, got two")]
    Twice(EffectKind),
    /// There are too many different images.
    #[error("a genome can have at most {IMAGES_MAX} different images, got {0}")]
    Images(usize),
    /// There are parts of a BRDF beside effects that do not paint one.
    #[error("a genome with effects has no models, output stage or energy limit, unless `by brdf`")]
    NotByBrdf,
    /// There is no BRDF to paint.
    #[error("`by brdf` needs a BRDF: a program, or at least one model")]
    NoBrdf,
}

impl Effect {
    /// Returns the effect with default values.
    #[must_use]
    pub fn of(kind: EffectKind) -> Self {
        let values = ParameterValues::new(kind.name(), kind.parameters());
        Self {
            kind,
            values,
            palette: kind.has_palette().then(Palette::default),
            images: Vec::new(),
        }
    }

    /// Creates an effect. A light effect without a palette gets the default one.
    ///
    /// # Errors
    /// Returns [`EffectError`] if a start is above its end, or an effect that is not light has a
    /// palette.
    ///
    /// # Panics
    /// If the values are those of another table.
    pub fn new(
        kind: EffectKind,
        values: ParameterValues,
        palette: Option<Palette>,
    ) -> Result<Self, EffectError> {
        assert_eq!(values.values().len(), kind.value_count(), "the values are those of the kind");
        if palette.is_some() && !kind.has_palette() {
            let reason = format!("{kind} has no palette");
            return Err(EffectError { parameter: Palette::COLORS, reason });
        }
        let palette = palette.or_else(|| kind.has_palette().then(Palette::default));
        let effect = Self { kind, values, palette, images: Vec::new() };
        let (from, to) = (effect.scalar("from"), effect.scalar("to"));
        if from > to {
            let reason = format!("from must be at most to, got {from} and {to}");
            return Err(EffectError { parameter: "from", reason });
        }
        Ok(effect)
    }

    /// Returns the effect with these images instead of its own.
    ///
    /// # Errors
    /// Returns [`EffectError`] if a place is not one of the kind, is repeated, or a share is not
    /// between 0 and 1.
    pub fn with_images(self, mut images: Vec<EffectImage>) -> Result<Self, EffectError> {
        let rank = |image: &EffectImage| {
            self.kind.image_places().iter().position(|place| place.name == image.place)
        };
        let error = |image: &EffectImage, reason| EffectError { parameter: image.place, reason };
        for image in &images {
            if rank(image).is_none() {
                return Err(error(image, format!("{} has no image {}", self.kind, image.place)));
            }
            if !(0.0..=1.0).contains(&image.share) {
                let reason = format!("a share must be between 0 and 1, got {}", image.share);
                return Err(error(image, reason));
            }
        }
        images.sort_by_key(rank);
        if let Some(pair) = images.windows(2).find(|pair| pair[0].place == pair[1].place) {
            return Err(error(&pair[0], format!("{} is given twice", pair[0].place)));
        }
        Ok(Self { images, ..self })
    }

    /// Returns the effect with other values and another palette, and with its images.
    ///
    /// # Errors
    /// As [`Effect::new`].
    pub(crate) fn with_parts(
        &self,
        values: ParameterValues,
        palette: Option<Palette>,
    ) -> Result<Self, EffectError> {
        let made = Self::new(self.kind, values, palette)?;
        Ok(Self { images: self.images.clone(), ..made })
    }

    /// Images, in the order of their places.
    #[must_use]
    pub fn images(&self) -> &[EffectImage] {
        &self.images
    }

    /// Returns the image in a place.
    #[must_use]
    pub fn image(&self, place: &str) -> Option<&EffectImage> {
        self.images.iter().find(|image| image.place == place)
    }

    /// Kind of the effect.
    #[must_use]
    pub fn kind(&self) -> EffectKind {
        self.kind
    }

    /// Values of the parameters in its table.
    #[must_use]
    pub fn values(&self) -> &ParameterValues {
        &self.values
    }

    /// Iterates over the parameters in its table and their values.
    pub fn parameters(&self) -> impl Iterator<Item = (&'static Parameter, &[f64])> {
        self.values.iter()
    }

    /// Palette of a light effect.
    #[must_use]
    pub fn palette(&self) -> Option<&Palette> {
        self.palette.as_ref()
    }

    /// Value of a scalar, or index of the word of a choice.
    ///
    /// # Panics
    /// If the table has no such parameter.
    #[must_use]
    pub fn scalar(&self, name: &str) -> f64 {
        self.values.get(name).expect("the parameter is in the table of the kind")[0]
    }

    /// Red, green and blue of a colour, in display values from 0 to 1.
    ///
    /// # Panics
    /// If the table has no such colour.
    #[must_use]
    pub fn color(&self, name: &str) -> [f64; 3] {
        let values = self.values.get(name).and_then(|values| values.try_into().ok());
        values.expect("the colour is in the table of the kind")
    }

    /// Index of refraction of a glass effect; `None` for the others.
    #[must_use]
    pub fn index_of_refraction(&self) -> Option<f64> {
        (self.kind == EffectKind::Glass).then(|| kind::index(self.word("index")))
    }

    /// True for a light effect that paints what the BRDF of its genome reflects.
    #[must_use]
    pub fn is_by_brdf(&self) -> bool {
        self.kind == EffectKind::Light && self.word(BY) == BRDF
    }

    /// Word of a choice.
    ///
    /// # Panics
    /// If the table has no such choice.
    #[must_use]
    pub fn word(&self, name: &str) -> &'static str {
        let mut parameters = self.parameters();
        let found = parameters.find(|(parameter, _)| parameter.name == name);
        found.and_then(|(parameter, values)| parameter.word(values)).expect("the table has it")
    }
}

impl fmt::Display for Effect {
    /// Writes the effect's line, the palette, then each parameter and image on its own line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, ".effect {}", self.kind)?;
        if let Some(palette) = &self.palette {
            write!(f, "{palette}")?;
        }
        write!(f, "{}", self.values)?;
        self.images.iter().try_for_each(|EffectImage { place, image, share }| {
            write!(f, "{place} {image}")?;
            if *share < 1.0 { writeln!(f, " {share}") } else { writeln!(f) }
        })
    }
}

impl Effect {
    /// Returns the different images of effects, in the order of their first use.
    #[must_use]
    pub fn images_of(effects: &[Self]) -> Vec<ImageHash> {
        images_of(effects)
    }

    /// Checks the order and the number of effects.
    ///
    /// # Errors
    /// Returns [`EffectsError`] if the first is not light, a kind is repeated, or there are too
    /// many images.
    pub fn check_all(effects: &[Self]) -> Result<(), EffectsError> {
        for (index, effect) in effects.iter().enumerate() {
            check_next(&effects[..index], effect.kind())?;
            check_images(&effects[..index], effect)?;
        }
        Ok(())
    }
}

/// Returns the different images of effects, in the order of their first use.
pub(crate) fn images_of<'a>(effects: impl IntoIterator<Item = &'a Effect>) -> Vec<ImageHash> {
    let mut found = Vec::new();
    for EffectImage { image, .. } in effects.into_iter().flat_map(Effect::images) {
        if !found.contains(image) {
            found.push(*image);
        }
    }
    found
}

/// Checks that an effect of a kind can follow others.
pub(crate) fn check_next(others: &[Effect], kind: EffectKind) -> Result<(), EffectsError> {
    if others.is_empty() && kind != EffectKind::Light {
        return Err(EffectsError::First(kind));
    }
    match others.iter().any(|other| other.kind() == kind) {
        true => Err(EffectsError::Twice(kind)),
        false => Ok(()),
    }
}

/// Checks that the images of an effect can be beside those of others.
pub(crate) fn check_images(others: &[Effect], next: &Effect) -> Result<(), EffectsError> {
    let images = images_of(others.iter().chain([next])).len();
    if images > IMAGES_MAX { Err(EffectsError::Images(images)) } else { Ok(()) }
}

/// True if effects paint what the BRDF of their genome reflects.
pub(crate) fn are_by_brdf(effects: &[Effect]) -> bool {
    effects.first().is_some_and(Effect::is_by_brdf)
}

#[cfg(test)]
mod brdf_tests;
#[cfg(test)]
mod image_tests;
#[cfg(test)]
mod tests;
