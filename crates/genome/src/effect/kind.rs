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

impl EffectKind {
    /// Short description.
    #[must_use]
    pub fn about(self) -> &'static str {
        match self {
            Self::Light => "colours of a palette by the amount of light",
            Self::Silhouette => "a colour where the surface turns away from the eye",
            Self::Highlight => "a colour where the eye sees the mirrored light",
            Self::Distance => "a colour by the distance from the eye",
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
