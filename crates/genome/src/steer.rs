//! Steering: properties of the first parent that the children of a brood keep, or the direction in
//! which they change.
//!
//! Keeps the parts of a genome that are known to be its colour or its gloss, and biases draws
//! towards the directions. `steered_brood` of the eval crate then chooses among draws by their
//! pictures.

use brood_brdf::{Model, Parameter, ParameterKind};
use serde::{Deserialize, Serialize};

use crate::random::Stream;
use crate::{DialectConstraints, Genome};

crate::named_enum! {
    /// Property that children keep or change, compared with the first parent.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
    #[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
    #[serde(rename_all = "kebab-case")]
    pub enum Steer {
        /// Hue and saturation stay.
        KeepColour => "keep-colour",
        /// Colour and pattern stay, highlights change.
        OnlyGloss => "only-gloss",
        /// Towards red, orange and yellow.
        Warmer => "warmer",
        /// Towards green and blue.
        Cooler => "cooler",
        /// Wider, weaker highlights.
        Rougher => "rougher",
        /// Narrower, stronger highlights.
        Glossier => "glossier",
        /// Larger differences between places on the surface.
        MorePattern => "more-pattern",
        /// Smaller differences between places on the surface.
        LessPattern => "less-pattern",
    }
}

/// Pairs that cannot be combined.
const CONTRADICTIONS: [(Steer, Steer); 9] = [
    (Steer::Warmer, Steer::Cooler),
    (Steer::Rougher, Steer::Glossier),
    (Steer::MorePattern, Steer::LessPattern),
    (Steer::KeepColour, Steer::Warmer),
    (Steer::KeepColour, Steer::Cooler),
    (Steer::OnlyGloss, Steer::Warmer),
    (Steer::OnlyGloss, Steer::Cooler),
    (Steer::OnlyGloss, Steer::MorePattern),
    (Steer::OnlyGloss, Steer::LessPattern),
];

/// Scalar parameters of models that form their highlights, and 1 if a larger value is glossier, -1
/// if a smaller one is.
const GLOSS: [(&str, f64); 12] = [
    ("alpha_x", -1.0),
    ("alpha_y", -1.0),
    ("anisotropic", 0.0),
    ("clearcoat", 1.0),
    ("clearcoat_gloss", 1.0),
    ("exponent", 1.0),
    ("exponent_u", 1.0),
    ("exponent_v", 1.0),
    ("ior", 1.0),
    ("roughness", -1.0),
    ("specular", 1.0),
    ("stretch", 0.0),
];
/// Scalar parameters of models that decide how far a colour shows.
const TINTS: [&str; 2] = ["sheen_tint", "spec_tint"];

/// Error of [`Steer::check`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SteerError {
    /// A word is given twice.
    #[error("`steer` lists `{}` twice", .0.name())]
    Twice(Steer),
    /// Two words exclude each other.
    #[error("`{}` contradicts `{}`: leave one of them out", .1.name(), .0.name())]
    Contradiction(Steer, Steer),
    /// There is no parent.
    #[error("`steer` needs a parent: children are compared with the first parent")]
    NoParent,
    /// The first parent is painted.
    #[error("`steer` compares BRDFs; a parent is a painted material")]
    Painted,
    /// The children cannot have a pattern.
    #[error(
        "`{}` needs children that can vary over the surface: these are homogeneous, \
         or models without a program",
        .0.name()
    )]
    NoPattern(Steer),
    /// The first parent has no highlight that can change.
    #[error(
        "`only-gloss` needs a parent with a gloss parameter, such as a roughness: its models have \
         none"
    )]
    NoGloss,
    /// The first parent has nothing but colours.
    #[error("`keep-colour` leaves nothing to change: the parent's models have colours only")]
    OnlyColours,
}

impl Steer {
    /// Checks that the words can be combined.
    ///
    /// # Errors
    /// Returns [`SteerError::Twice`] or [`SteerError::Contradiction`] for the first word that
    /// does not fit.
    pub fn check_words(words: &[Self]) -> Result<(), SteerError> {
        for (at, word) in words.iter().enumerate() {
            for before in &words[..at] {
                let (word, before) = (*word, *before);
                if word == before {
                    return Err(SteerError::Twice(word));
                }
                let pairs = [(word, before), (before, word)];
                if CONTRADICTIONS.iter().any(|pair| pairs.contains(pair)) {
                    return Err(SteerError::Contradiction(before, word));
                }
            }
        }
        Ok(())
    }

    /// Checks that the words can be combined and that a child of these parents can follow them.
    ///
    /// # Errors
    /// Returns [`SteerError`] for the first word that does not fit. Without words there is none.
    pub fn check(
        words: &[Self],
        parents: &[&Genome],
        constraints: DialectConstraints,
    ) -> Result<(), SteerError> {
        Self::check_words(words)?;
        if words.is_empty() {
            return Ok(());
        }
        let Some(first) = parents.first() else { return Err(SteerError::NoParent) };
        if parents.iter().any(|parent| parent.is_painted()) {
            return Err(SteerError::Painted);
        }
        let is_homogeneous = constraints.homogeneous.unwrap_or(first.dialect().homogeneous);
        let has_program = parents.iter().any(|parent| !parent.instructions().is_empty());
        for word in words {
            let is_pattern = matches!(word, Self::MorePattern | Self::LessPattern);
            if is_pattern && (is_homogeneous || !has_program) {
                return Err(SteerError::NoPattern(*word));
            }
            let is_of_models = first.instructions().is_empty();
            if *word == Self::OnlyGloss && is_of_models && !has_gloss(first.layers()) {
                return Err(SteerError::NoGloss);
            }
            if *word == Self::KeepColour && is_of_models && has_only_colours(first.layers()) {
                return Err(SteerError::OnlyColours);
            }
        }
        Ok(())
    }
}

/// True if a model has a parameter that forms its highlights.
fn has_gloss(layers: &[Model]) -> bool {
    layers.iter().flat_map(Model::parameters).any(|(parameter, _)| is_gloss(parameter))
}

/// True if no model has a parameter that can change besides colours.
fn has_only_colours(layers: &[Model]) -> bool {
    let is_fixed = |parameter: &Parameter| parameter.words().is_some_and(|words| words.len() == 1);
    let mut parameters = layers.iter().flat_map(Model::parameters);
    parameters.all(|(parameter, _)| is_colour(parameter) || is_fixed(parameter))
}

fn is_gloss(parameter: &Parameter) -> bool {
    let is_named = GLOSS.iter().any(|(name, _)| *name == parameter.name);
    is_named && matches!(parameter.kind, ParameterKind::Scalar { .. })
}

/// Sign with which a scalar parameter makes a model glossier: 0 if it does not form highlights.
pub(crate) fn gloss_sign(parameter: &Parameter) -> f64 {
    GLOSS.iter().find(|(name, _)| *name == parameter.name).map_or(0.0, |(_, sign)| *sign)
}

fn is_colour(parameter: &Parameter) -> bool {
    matches!(parameter.kind, ParameterKind::Color { .. }) || TINTS.contains(&parameter.name)
}

/// Parts of the first parent that a steer keeps or changes. Only models and believable programs
/// have parameters of which colour or gloss is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Kept {
    /// Colours stay.
    pub(crate) colour: bool,
    /// Everything but highlights stays.
    pub(crate) all_but_gloss: bool,
    /// Directions in which children change.
    pub(crate) toward: Toward,
}

/// Directions of a steer, each -1, 0 or 1. Draws of models and believable programs are biased
/// towards them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Toward {
    /// Above 0: warmer.
    pub(crate) warmth: i8,
    /// Above 0: glossier.
    pub(crate) gloss: i8,
    /// Above 0: more pattern.
    pub(crate) pattern: i8,
}

impl Toward {
    fn of(words: &[Steer]) -> Self {
        let either = |more: Steer, less: Steer| {
            i8::from(words.contains(&more)) - i8::from(words.contains(&less))
        };
        Self {
            warmth: either(Steer::Warmer, Steer::Cooler),
            gloss: either(Steer::Glossier, Steer::Rougher),
            pattern: either(Steer::MorePattern, Steer::LessPattern),
        }
    }

    /// Size of a step in a direction: half to one and a half of the amount of mutation. Redraws
    /// take larger steps, because smaller ones were not enough.
    pub(crate) fn step(amount: f32, attempt: u32, stream: &mut Stream) -> f64 {
        let redraws = f64::from(attempt.min(MOST_REDRAWS));
        f64::from(amount) * (0.5 + f64::from(stream.unit())) * (1.0 + REDRAW_STEP * redraws)
    }
}

/// Growth of steps from draw to draw, and the draw from which they grow no more.
const REDRAW_STEP: f64 = 0.15;
const MOST_REDRAWS: u32 = 32;

impl Kept {
    pub(crate) fn of(words: &[Steer]) -> Self {
        Self {
            colour: words.contains(&Steer::KeepColour),
            all_but_gloss: words.contains(&Steer::OnlyGloss),
            toward: Toward::of(words),
        }
    }

    /// True if a parameter of a model stays.
    pub(crate) fn keeps(self, parameter: &Parameter) -> bool {
        self.colour && is_colour(parameter) || self.all_but_gloss && !is_gloss(parameter)
    }

    /// True if anything stays. Directions alone keep nothing.
    pub(crate) fn is_any(self) -> bool {
        self.colour || self.all_but_gloss
    }
}

#[cfg(test)]
#[path = "steer_tests.rs"]
mod tests;
