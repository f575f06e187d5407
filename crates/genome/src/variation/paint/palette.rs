//! Random palettes and their mutation.

use super::threshold::linear;
use crate::oklab::Oklab;
use crate::random::Stream;
use crate::{PALETTE_MAX, PALETTE_MIN, Palette};

/// Lightness of the darkest and of the brightest colour of a random palette.
const DARKEST: (f64, f64) = (0.12, 0.37);
const BRIGHTEST: (f64, f64) = (0.70, 0.95);
/// Largest chroma of a random palette.
const CHROMA: (f64, f64) = (0.02, 0.18);
/// Share of that chroma at both ends.
const END_CHROMA: f64 = 0.6;
/// Standard deviation of the hue between both ends, in radians.
const HUE_TURN: f64 = 0.84;
/// Largest number of colours of a random palette.
const RANDOM_MAX: u32 = 4;

/// Rates and steps at amount 1 of a mutation.
const WHOLE_RATE: f64 = 2.5;
const TURN: f64 = 2.4;
const CHROMA_STEP: f64 = 0.9;
const CONTRAST_STEP: f64 = 0.5;
const SHIFT: f64 = 0.15;
const COLOR_RATE: f64 = 0.8;
const COLOR_STEP: [f64; 3] = [0.25, 0.2, 0.2];
const COUNT_RATE: f64 = 0.3;

/// Least range of lightness. Below, a shape looks flat.
const LEAST_RANGE: f64 = 0.4;
/// Range that lightness stays in.
const LIGHTNESS: (f64, f64) = (0.1, 0.98);
/// Middle of the lightness of random palettes. Palettes are drawn back to it by this share at
/// amount 1, or generations of broods would become dark or pale.
const MIDDLE: f64 = 0.535;
const PULL: f64 = 0.6;

/// Draws a random palette.
pub(super) fn random(stream: &mut Stream) -> Palette {
    let count = PALETTE_MIN as u32 + stream.below(RANDOM_MAX - PALETTE_MIN as u32 + 1);
    let (dark, bright) = (between(DARKEST, stream), between(BRIGHTEST, stream));
    let chroma = between(CHROMA, stream);
    let hue = std::f64::consts::TAU * f64::from(stream.unit());
    let turn = HUE_TURN * f64::from(stream.bell());
    let last = f64::from(count - 1);
    let colors = (0..count).map(|at| {
        let x = f64::from(at) / last;
        let arch = END_CHROMA + (1.0 - END_CHROMA) * 4.0 * x * (1.0 - x);
        let lightness = dark + (bright - dark) * x;
        Oklab::of_hue(lightness, chroma * arch, hue + turn * (x - 0.5))
    });
    let mut colors: Vec<Oklab> = colors.collect();
    stretch(&mut colors, 0.0);
    let edges = (1..count)
        .map(|edge| f64::from(edge) / f64::from(count))
        .map(|edge| linear(edge, (0.0, 1.0), super::value::SPREAD * f64::from(stream.bell())));
    let edges = edges.collect();
    valid(colors.into_iter().map(Oklab::codes).collect(), edges)
}

fn between((low, high): (f64, f64), stream: &mut Stream) -> f64 {
    low + (high - low) * f64::from(stream.unit())
}

/// Creates a palette of valid colours; sorts the edges.
pub(super) fn valid(colors: Vec<[u8; 3]>, mut edges: Vec<f64>) -> Palette {
    edges.sort_by(f64::total_cmp);
    Palette::new(Some(colors), Some(edges)).expect("operators keep to the rules of palettes")
}

/// Change of a palette as a whole.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shift {
    turn: f64,
    chroma: f64,
    contrast: f64,
    lightness: f64,
}

impl Shift {
    const NONE: Self = Self { turn: 0.0, chroma: 1.0, contrast: 1.0, lightness: 0.0 };

    /// Draws a change, or none. With `force` there is always one.
    pub(super) fn draw(amount: f64, force: bool, stream: &mut Stream) -> Self {
        let is_drawn = f64::from(stream.unit()) < WHOLE_RATE * amount;
        let mut step = |size: f64| size * amount * f64::from(stream.bell());
        let (turn, chroma) = (step(TURN), libm::exp(step(CHROMA_STEP)));
        let (contrast, lightness) = (libm::exp(step(CONTRAST_STEP)), step(SHIFT));
        if is_drawn || force { Self { turn, chroma, contrast, lightness } } else { Self::NONE }
    }

    /// Returns an overlay's colour with the hue and chroma changed like those of the palette, and a
    /// change of its own.
    pub(super) fn overlay(self, codes: [u8; 3], amount: f64, stream: &mut Stream) -> [u8; 3] {
        let old = Oklab::of_codes(codes);
        let new = stepped(old.turned(self.turn, self.chroma), amount, stream);
        if new == old { codes } else { new.codes() }
    }
}

/// Returns a colour with a change of its own, or none.
fn stepped(color: Oklab, amount: f64, stream: &mut Stream) -> Oklab {
    let is_drawn = f64::from(stream.unit()) < COLOR_RATE * amount;
    let [lightness, a, b] = COLOR_STEP.map(|step| step * amount * f64::from(stream.bell()));
    if !is_drawn {
        return color;
    }
    let color = Oklab { a: color.a + a, b: color.b + b, ..color };
    Oklab { lightness: (color.lightness + lightness).clamp(0.0, 1.0), ..color }
}

/// Mutates the colours. `may_count` allows a colour more or less, with its edge.
pub(super) fn mutate_colors(
    palette: &Palette,
    (amount, shift): (f64, Shift),
    may_count: bool,
    stream: &mut Stream,
) -> Palette {
    let old: Vec<Oklab> = palette.colors().iter().copied().map(Oklab::of_codes).collect();
    let middle = old.iter().map(|one| one.lightness).sum::<f64>() / old.len() as f64;
    let pull = PULL * amount * (MIDDLE - middle);
    let whole = |color: &Oklab| {
        let lightness = middle + (color.lightness - middle) * shift.contrast + shift.lightness;
        Oklab { lightness, ..color.turned(shift.turn, shift.chroma) }
    };
    let mut new: Vec<Oklab> =
        old.iter().map(whole).map(|color| stepped(color, amount, stream)).collect();
    let mut edges = palette.edges().to_vec();
    let counted = may_count && count(&mut new, &mut edges, amount, stream);
    if !counted && new == old {
        return palette.clone();
    }
    if !counted {
        keep_ranks(&mut new, &old);
    } else {
        new.sort_by(|one, other| one.lightness.total_cmp(&other.lightness));
    }
    stretch(&mut new, pull);
    valid(new.into_iter().map(Oklab::codes).collect(), edges)
}

/// Adds or removes a colour and an edge, or not. Returns true if it did.
fn count(colors: &mut Vec<Oklab>, edges: &mut Vec<f64>, amount: f64, stream: &mut Stream) -> bool {
    let is_drawn = f64::from(stream.unit()) < COUNT_RATE * amount;
    let is_more = stream.chance(0.5);
    let place = stream.bits();
    if !is_drawn {
        return false;
    }
    let pick = |bound: usize| ((u64::from(place) * bound as u64) >> 32) as usize;
    if colors.len() == PALETTE_MIN || is_more && colors.len() < PALETTE_MAX {
        // Between two neighbours, with the edge in two.
        let at = pick(edges.len());
        let (one, other) = (colors[at], colors[at + 1]);
        let mean = |one: f64, other: f64| 0.5 * (one + other);
        let between = Oklab {
            lightness: mean(one.lightness, other.lightness),
            a: mean(one.a, other.a),
            b: mean(one.b, other.b),
        };
        colors.insert(at + 1, between);
        let low = if at == 0 { 0.0 } else { edges[at - 1] };
        let high = edges.get(at + 1).copied().unwrap_or(1.0);
        let edge = edges[at];
        edges[at] = mean(low, edge);
        edges.insert(at + 1, mean(edge, high));
    } else {
        let at = pick(colors.len());
        colors.remove(at);
        edges.remove(at.min(edges.len() - 1));
    }
    true
}

/// Gives the colours the order of lightness that the old ones have: ascending, unless the parent's
/// palette has bands.
pub(super) fn keep_ranks(new: &mut [Oklab], old: &[Oklab]) {
    let mut places: Vec<usize> = (0..old.len()).collect();
    places.sort_by(|one, other| old[*one].lightness.total_cmp(&old[*other].lightness));
    let mut sorted = new.to_vec();
    sorted.sort_by(|one, other| one.lightness.total_cmp(&other.lightness));
    for (place, color) in places.into_iter().zip(sorted) {
        new[place] = color;
    }
}

/// Stretches lightness to its least range, then moves it by `pull` and into its range.
pub(super) fn stretch(colors: &mut [Oklab], pull: f64) {
    let (low, high) = colors.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), one| {
        (low.min(one.lightness), high.max(one.lightness))
    });
    let range = (high - low).clamp(LEAST_RANGE, LIGHTNESS.1 - LIGHTNESS.0);
    let half = 0.5 * range;
    let middle = (0.5 * (low + high) + pull).clamp(LIGHTNESS.0 + half, LIGHTNESS.1 - half);
    let last = colors.len() as f64 - 1.0;
    for (at, color) in colors.iter_mut().enumerate() {
        // Equal colours are spread evenly.
        let share = match high > low {
            true => (color.lightness - low) / (high - low),
            false => at as f64 / last,
        };
        color.lightness = middle - half + range * share;
    }
}

/// Mutates the edges.
pub(super) fn mutate_edges(palette: &Palette, amount: f64, stream: &mut Stream) -> Palette {
    let moved = palette.edges().iter().map(|edge| {
        let step = super::value::step(amount, stream);
        if step == 0.0 { *edge } else { linear(*edge, (0.0, 1.0), step) }
    });
    let moved = moved.collect();
    valid(palette.colors().to_vec(), moved)
}
