//! Colours of a painting for the effects of a child.

use super::{palette, random};
use crate::effect;
use crate::locks::LockedEffects;
use crate::oklab::Oklab;
use crate::random::{Operator, Stream};
use crate::{BirthKey, Effect, EffectKind, PaintingPalette, PaintingRegion, Palette};

/// Probability that the bright colours are of another region than the dark ones.
const CROSS_RATE: f32 = 0.5;

/// Gives effects colours of a painting: the palette those of one region, or the dark one of a
/// region and the bright one of another, and overlays those that suit the palette. The number of
/// colours and the edges stay. A locked palette keeps everything, a locked colour itself.
pub(in super::super) fn color(
    effects: &mut [Effect],
    painting: &PaintingPalette,
    key: BirthKey,
    locked: &LockedEffects,
) {
    if locked.locks(EffectKind::Light, Palette::COLORS) {
        return;
    }
    let mut stream = Stream::new(key, Operator::Painting);
    let keys = draw(painting.regions(), &mut stream);
    let old = effects[0].palette().expect("the first effect is light");
    let palette = spread(keys, old);
    for effect in effects.iter_mut() {
        if effect.kind() == EffectKind::Light {
            let light = effect.with_parts(effect.values().clone(), Some(palette.clone()));
            *effect = light.expect("both parts are valid");
        } else if !locked.locks(effect.kind(), effect::COLOR) {
            *effect = random::suited(effect, &palette);
        }
    }
}

/// Draws a dark, a middle and a bright colour, in this order of lightness. Regions are drawn by the
/// square root of their share, so that small ones are not lost.
fn draw(regions: &[PaintingRegion], stream: &mut Stream) -> [Oklab; 3] {
    let first = pick(regions, None, stream);
    let second = pick(regions, Some(first), stream);
    let (is_crossed, is_first) = (stream.chance(CROSS_RATE), stream.chance(0.5));
    let of = |region: usize| regions[region].colors().map(Oklab::of_codes);
    if !is_crossed || first == second {
        return of(first);
    }
    let (mut one, mut other) = (of(first), of(second));
    if one[0].lightness > other[2].lightness {
        std::mem::swap(&mut one, &mut other);
    }
    let (dark, bright) = (one[0], other[2]);
    let middle = if is_first { one[1] } else { other[1] };
    let lightness = middle.lightness.clamp(dark.lightness, bright.lightness);
    [dark, Oklab { lightness, ..middle }, bright]
}

/// Draws a region, another one than `taken` if there is another.
fn pick(regions: &[PaintingRegion], taken: Option<usize>, stream: &mut Stream) -> usize {
    let may_take = |at: &usize| Some(*at) != taken || regions.len() == 1;
    let weight = |at: usize| regions[at].share.sqrt();
    let free = || (0..regions.len()).filter(may_take);
    let mut left = f64::from(stream.unit()) * free().map(weight).sum::<f64>();
    for at in free() {
        left -= weight(at);
        if left < 0.0 {
            return at;
        }
    }
    // Rounding may leave nothing of the sum.
    free().next_back().expect("a region is free")
}

/// Returns a palette with the number of colours and the edges of an old one, in its order of
/// lightness. Each colour has hue and chroma of the nearest key, because mixtures of two hues would
/// be greyer than the painting.
fn spread(keys: [Oklab; 3], old: &Palette) -> Palette {
    let last = old.colors().len() as f64 - 1.0;
    let mut colors: Vec<Oklab> = (0..old.colors().len())
        .map(|at| {
            let x = 2.0 * at as f64 / last;
            let (low, high) = if x <= 1.0 { (keys[0], keys[1]) } else { (keys[1], keys[2]) };
            let between = x - if x <= 1.0 { 0.0 } else { 1.0 };
            let nearest = if between < 0.5 { low } else { high };
            let lightness = low.lightness + (high.lightness - low.lightness) * between;
            Oklab { lightness, ..nearest }
        })
        .collect();
    let ranks: Vec<Oklab> = old.colors().iter().copied().map(Oklab::of_codes).collect();
    palette::keep_ranks(&mut colors, &ranks);
    palette::stretch(&mut colors, 0.0);
    palette::valid(colors.into_iter().map(Oklab::codes).collect(), old.edges().to_vec())
}
