//! Kinds of effects and their parameter tables.
//!
//! Canonical bytes contain the values of a table in its order, so parameters and words are only
//! appended, together with a new number of the kind or the encoding.

use std::fmt;

use brood_brdf::{Parameter, named_enum};
use serde::{Deserialize, Serialize};

named_enum! {
    numbered
    /// Kind of an effect.
    #[derive(
        Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize,
    )]
    #[serde(rename_all = "lowercase")]
    #[repr(u8)]
    pub enum EffectKind {
        /// Colours of a palette by the amount of light; always the first effect.
        Light => "light",
        /// A colour where the surface turns away from the eye.
        Silhouette => "silhouette",
        /// A colour where the eye sees the mirrored light.
        Highlight => "highlight",
        /// A colour by the distance from the eye.
        Distance => "distance",
        /// The surroundings, mirrored in the surface and seen through the body.
        Glass => "glass",
    }
}

named_enum! {
    /// Transition between the colours of a palette: a word of the choice `basis`.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Basis {
        /// Hard edges.
        Step => "step",
        /// Straight ramps.
        Linear => "linear",
        /// Two joined parabolas per edge.
        Quadratic => "quadratic",
        /// x^2 (3 - 2 x) per edge.
        Cubic => "cubic",
        /// Bernstein polynomials over the whole palette; edges and feather have no effect.
        Bezier => "bezier",
    }
}

/// Words of the choice `basis`.
const BASES: &[&str] = &["step", "linear", "quadratic", "cubic", "bezier"];

/// Name of the colour of an overlay.
pub(crate) const COLOR: &str = "color";

const STRENGTH: Parameter =
    Parameter::scalar("strength", "share of the effect, k", 1.0, (0.0, 1.0));

const SHADOW: Parameter =
    Parameter::scalar("shadow", "share of the light that shadows take, kappa", 1.0, (0.0, 1.0));

const PROPERTY: Parameter = Parameter::choice(
    "property",
    "hull: colours stay in the convex hull of the palette; box: lights tint them",
    &["hull", "box"],
);

const LIGHT: &[Parameter] = &[
    Parameter::choice("basis", "transition between colours, S", BASES),
    Parameter::scalar("feather", "width of a transition, f", 0.1, (0.0, 1.0)),
    Parameter::choice(
        BY,
        "source of the amount: lights, the direction to the eye, or what a BRDF reflects",
        SOURCES,
    ),
    Parameter::scalar("exponent", "power of the cosine to the eye, if by facing", 1.0, (1.0, 8.0))
        .logarithmic(),
    Parameter::scalar("from", "cosine or level of the darkest amount, t0", 0.0, (-1.0, 1.0)),
    Parameter::scalar("to", "cosine or level of the brightest amount, t1", 1.0, (-1.0, 1.0)),
    SHADOW,
    STRENGTH,
    Parameter::scalar("brush", "shift of the amount by the program, w", 0.0, (0.0, 1.0)),
    PROPERTY,
];

/// Name of the choice of what makes the amount of light.
pub(crate) const BY: &str = "by";
/// Word of [`BY`]: the amount is what the BRDF of the genome reflects.
pub(crate) const BRDF: &str = "brdf";
/// Words of [`BY`]. Mutation draws among the others, see `variation/paint/value.rs`.
const SOURCES: &[&str] = &["light", "facing", BRDF];

const SILHOUETTE: &[Parameter] = &[
    Parameter::display_color(COLOR, "colour of the silhouette", [0x1a, 0x10, 0x20]),
    Parameter::scalar("from", "1 - n.e where it begins, s0", 0.7, (0.0, 1.0)),
    Parameter::scalar("to", "1 - n.e where it is complete, s1", 0.8, (0.0, 1.0)),
    STRENGTH,
];

const HIGHLIGHT: &[Parameter] = &[
    Parameter::display_color(COLOR, "colour of the highlight", [0xff, 0xff, 0xff]),
    Parameter::scalar("from", "cosine to the mirrored light where it begins, r0", 0.9, (-1.0, 1.0)),
    Parameter::scalar("to", "cosine where it is complete, r1", 0.99, (-1.0, 1.0)),
    SHADOW,
    STRENGTH,
    PROPERTY,
];

const DISTANCE: &[Parameter] = &[
    Parameter::display_color(COLOR, "colour of the distance", [0x9f, 0xb8, 0xd0]),
    Parameter::scalar("from", "depth where it begins, z0", 0.0, (-2.0, 16.0)),
    Parameter::scalar("to", "depth where it is complete, z1", 1.0, (-2.0, 16.0)),
    STRENGTH,
];

/// Indices of refraction, relative to the space around the body. The first is the default.
const INDICES: &[(&str, f64)] = &[
    ("1.5", 1.5),
    ("0.5", 0.5),
    ("0.67", 0.67),
    ("0.75", 0.75),
    ("0.9", 0.9),
    ("1", 1.0),
    ("1.05", 1.05),
    ("1.15", 1.15),
    ("1.33", 1.33),
    ("1.8", 1.8),
    ("2", 2.0),
];

/// Index of refraction of a word of the choice `index`.
pub(super) fn index(word: &str) -> f64 {
    let found = INDICES.iter().find(|(name, _)| *name == word);
    found.expect("the word is one of the choice").1
}

/// Returns the word of the next higher or lower index of refraction; at the ends the other one.
pub(crate) fn index_beside(word: u8, is_up: bool) -> u8 {
    let of = |word: usize| INDICES[word].1;
    let mut ascending: Vec<usize> = (0..INDICES.len()).collect();
    ascending.sort_by(|one, other| of(*one).total_cmp(&of(*other)));
    let at = ascending.iter().position(|own| *own == usize::from(word));
    let (at, last) = (at.expect("the word is one of the choice"), INDICES.len() - 1);
    let beside = if is_up && at < last || at == 0 { at + 1 } else { at - 1 };
    u8::try_from(ascending[beside]).expect("there are few words")
}

/// Words of the choice `index`.
const INDEX_WORDS: &[&str] = &{
    let mut words = [""; INDICES.len()];
    let mut at = 0;
    while at < words.len() {
        words[at] = INDICES[at].0;
        at += 1;
    }
    words
};

const GLASS: &[Parameter] = &[
    Parameter::display_color(COLOR, "colour of depth, D", [0x1f, 0x4e, 0x5f]),
    Parameter::scalar("from", "share of the mirror seen straight on, f0", 0.1, (0.0, 1.0)),
    Parameter::scalar("to", "share of the mirror at the limb, f1", 1.0, (0.0, 1.0)),
    Parameter::scalar("exponent", "power of 1 - n.e of the mirror, q", 3.0, (1.0, 8.0))
        .logarithmic(),
    Parameter::choice("index", "index of refraction", INDEX_WORDS),
    Parameter::scalar("depth", "way inside the body that halves the light behind, h", 2.0, DEPTHS)
        .logarithmic()
        .in_unit("radii"),
    Parameter::scalar("mirror", "brightness of what the mirror shows", 1.0, (0.0, 1.0)),
    Parameter::scalar("see", "brightness of what is seen through the body", 1.0, (0.0, 1.0)),
    STRENGTH,
];

/// Range of the parameter `depth`.
const DEPTHS: (f64, f64) = (1.0 / 16.0, 64.0);

impl EffectKind {
    /// Short description.
    #[must_use]
    pub fn about(self) -> &'static str {
        match self {
            Self::Light => "colours of a palette by the amount of light",
            Self::Silhouette => "a colour where the surface turns away from the eye",
            Self::Highlight => "a colour where the eye sees the mirrored light",
            Self::Distance => "a colour by the distance from the eye",
            Self::Glass => "what the eye sees mirrored in the surface and through the body",
        }
    }

    /// Parameters in the order of their values, without the palette.
    #[must_use]
    pub fn parameters(self) -> &'static [Parameter] {
        match self {
            Self::Light => LIGHT,
            Self::Silhouette => SILHOUETTE,
            Self::Highlight => HIGHLIGHT,
            Self::Distance => DISTANCE,
            Self::Glass => GLASS,
        }
    }

    /// True if effects of this kind have a palette.
    #[must_use]
    pub fn has_palette(self) -> bool {
        self == Self::Light
    }

    /// Number of values of the parameters.
    pub(crate) fn value_count(self) -> usize {
        self.parameters().iter().map(Parameter::count).sum()
    }
}

impl fmt::Display for EffectKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_the_basis_are_its_names() {
        assert_eq!(BASES, Basis::ALL.map(Basis::name));
    }
}
