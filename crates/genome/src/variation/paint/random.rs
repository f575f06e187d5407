//! Random effects.

use super::{palette, value};
use crate::effect;
use crate::oklab::Oklab;
use crate::random::{Operator, Stream};
use crate::{BirthKey, Effect, EffectKind, Palette};

/// Probabilities of the overlays of a random genome, in the order of painting.
const OVERLAYS: [(EffectKind, f32); 3] =
    [(EffectKind::Distance, 0.15), (EffectKind::Silhouette, 0.7), (EffectKind::Highlight, 0.6)];
/// Lightness of a silhouette, as a share of the darkest colour's.
const SILHOUETTE: f64 = 0.6;
/// Lightness of a highlight, and its share of the brightest colour's chroma.
const HIGHLIGHT: (f64, f64) = (0.96, 0.4);
/// Lightness and chroma of a distance, as shares of the brightest colour's.
const DISTANCE: (f64, f64) = (0.9, 0.5);

/// Draws the effects of a random genome.
pub(in super::super) fn random(key: BirthKey) -> Vec<Effect> {
    let mut stream = Stream::new(key, Operator::RandomEffects);
    let palette = palette::random(&mut stream);
    let values = value::random(EffectKind::Light, &mut stream);
    let light = Effect::new(EffectKind::Light, values, Some(palette.clone()));
    let mut effects = vec![light.expect("drawn from the rules of effects")];
    for (kind, share) in OVERLAYS {
        if stream.chance(share) {
            effects.push(overlay(kind, &palette, &mut stream));
        }
    }
    effects
}

/// Draws an overlay whose colour suits a palette.
pub(super) fn overlay(kind: EffectKind, palette: &Palette, stream: &mut Stream) -> Effect {
    let values = value::random(kind, stream);
    let overlay = Effect::new(kind, values, None).expect("drawn from the rules of effects");
    suited(&overlay, palette)
}

/// Returns an overlay with the colour that suits a palette.
pub(super) fn suited(overlay: &Effect, palette: &Palette) -> Effect {
    let color = color(overlay.kind(), palette).map(|code| f64::from(code) / 255.0);
    let mut values = overlay.values().clone();
    values.set(effect::COLOR, &color).expect("codes are display values");
    overlay.with_parts(values, None).expect("the rest was valid")
}

/// Colour of an overlay that suits a palette.
fn color(kind: EffectKind, palette: &Palette) -> [u8; 3] {
    let colors = palette.colors().iter().copied().map(Oklab::of_codes);
    let by_lightness = |one: &Oklab, other: &Oklab| one.lightness.total_cmp(&other.lightness);
    let darkest = colors.clone().min_by(by_lightness).expect("palettes have colours");
    let brightest = colors.max_by(by_lightness).expect("palettes have colours");
    let color = match kind {
        EffectKind::Light | EffectKind::Silhouette => {
            Oklab { lightness: SILHOUETTE * darkest.lightness, ..darkest }
        }
        EffectKind::Highlight => {
            Oklab { lightness: HIGHLIGHT.0, ..brightest.turned(0.0, HIGHLIGHT.1) }
        }
        // The colour of a deep body: the palette's in half shade.
        EffectKind::Glass => {
            let lightness = 0.5 * (darkest.lightness + brightest.lightness);
            Oklab { lightness, ..darkest }
        }
        EffectKind::Distance => {
            let lightness = DISTANCE.0 * brightest.lightness;
            Oklab { lightness, ..brightest.turned(0.0, DISTANCE.1) }
        }
    };
    color.codes()
}
