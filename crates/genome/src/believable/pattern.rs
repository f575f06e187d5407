//! Patterns of believable programs: values drawn by style.

use std::f64::consts::TAU;

use super::anchor::Class;
use super::program::PATTERN;
use super::structure::{BODY, TERMS};
use crate::random::Stream;

/// Pattern of the surface: a number t from 0 to 1 that mixes two sets of colours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pattern {
    /// Values in the order of [`Place`].
    pub(super) values: [f64; PATTERN],
    /// log2 of the factor of each term in each channel where t is 1, relative to where it is 0.
    pub(super) contrast: [[f64; 3]; TERMS],
}

/// First index of each group of values.
#[derive(Clone, Copy)]
struct Place;

impl Place {
    /// Radians per unit of u, of four waves: whole turns, so that there is no seam.
    const TURNS: usize = 0;
    /// Radians per unit of v.
    const ACROSS: usize = 4;
    const PHASES: usize = 8;
    /// Radians by which the first wave bends the third and the fourth, then the second.
    const WARP: usize = 12;
    /// Weights of squares and product of the third and fourth wave, of both, and the bias; t is
    /// 1 / (1 + 2^x) of the sum x.
    const FORM: usize = 16;
    const BIAS: usize = 21;
    /// Change of ln tan theta_h where t is 1; above 0, highlights are narrower there.
    const NARROWING: usize = 22;
}

/// Look of a pattern.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Style {
    /// Wood grain.
    Grain,
    /// Veins of marble.
    Veins,
    /// Checks of woven cloth.
    Weave,
    /// Stripes in both directions.
    Plaid,
    /// Spots, flakes and grains.
    Speckle,
    /// Patches with sharp edges, as of worn paint.
    Worn,
    /// Two colours that run into each other.
    Glaze,
    /// Fine parallel lines.
    Streaks,
}

/// Shares of the styles of a class.
fn styles(class: Class) -> &'static [(Style, u32)] {
    use Style::{Glaze, Grain, Plaid, Speckle, Streaks, Veins, Weave, Worn};
    match class {
        Class::Metal => &[(Streaks, 5), (Worn, 4), (Glaze, 1)],
        Class::MetallicPaint => &[(Speckle, 4), (Worn, 3), (Glaze, 3)],
        Class::Plastic => &[(Glaze, 4), (Speckle, 2), (Veins, 2), (Plaid, 1), (Weave, 1)],
        Class::Paint => &[(Worn, 6), (Glaze, 2), (Plaid, 1)],
        Class::Cloth => &[(Weave, 5), (Plaid, 5)],
        Class::Wood => &[(Grain, 1)],
        Class::Stone => &[(Veins, 6), (Speckle, 4)],
        Class::Rubber => &[(Speckle, 2), (Weave, 1), (Worn, 1)],
    }
}

impl Style {
    /// Draws a style of a class.
    pub(super) fn draw(class: Class, stream: &mut Stream) -> Self {
        let styles = styles(class);
        let mut draw = stream.below(styles.iter().map(|(_, share)| share).sum());
        for (style, share) in styles {
            match draw.checked_sub(*share) {
                Some(rest) => draw = rest,
                None => return *style,
            }
        }
        unreachable!("the draw is below the sum of the shares")
    }

    /// Draws the values of a pattern.
    pub(super) fn values(self, stream: &mut Stream) -> [f64; PATTERN] {
        let mut drawn = Drawn { values: [0.0; PATTERN], stream };
        for at in 0..4 {
            drawn.between(Place::PHASES + at, (0.0, TAU));
        }
        match self {
            Self::Grain => {
                drawn.waves([(1, 1), (2, 4), (0, 0), (1, 3)]);
                drawn.across([(3.0, 8.0), (8.0, 16.0), (45.0, 110.0), (120.0, 200.0)]);
                drawn.warp([(1.0, 3.5), (1.0, 3.0), (0.4, 1.4), (0.5, 1.5)]);
                drawn.form([(0.0, 0.0), (0.0, 0.0), (-1.0, 1.0), (2.0, 5.0), (0.8, 2.0)]);
                drawn.between(Place::BIAS, (-0.5, 2.0));
                drawn.between(Place::NARROWING, (-0.3, 0.0));
            }
            Self::Veins => {
                drawn.waves([(1, 2), (2, 4), (1, 3), (1, 3)]);
                drawn.across([(4.0, 9.0), (9.0, 18.0), (3.0, 10.0), (-12.0, -4.0)]);
                drawn.warp([(1.2, 2.6), (1.0, 2.0), (0.6, 1.4), (0.6, 1.4)]);
                drawn.form([(12.0, 40.0), (0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (1.0, 4.0)]);
                drawn.between(Place::BIAS, (-2.5, 0.5));
            }
            Self::Weave => {
                drawn.waves([(2, 4), (2, 4), (8, 16), (0, 0)]);
                drawn.across([(5.0, 15.0), (5.0, 15.0), (0.0, 0.0), (0.0, 0.0)]);
                // Squares: as many waves from pole to pole as around half of the equator.
                drawn.values[Place::ACROSS + 3] = 0.5 * drawn.values[Place::TURNS + 2];
                drawn.warp([(0.0, 0.15), (0.0, 0.15), (0.0, 0.1), (0.0, 0.1)]);
                drawn.form([(-1.0, 1.0), (-1.0, 1.0), (4.0, 12.0), (0.0, 0.0), (0.0, 0.0)]);
                drawn.between(Place::BIAS, (-0.5, 0.5));
                drawn.between(Place::NARROWING, (-0.4, 0.4));
            }
            Self::Plaid => {
                drawn.waves([(2, 4), (2, 4), (4, 10), (0, 0)]);
                drawn.across([(5.0, 15.0), (5.0, 15.0), (0.0, 0.0), (0.0, 0.0)]);
                drawn.values[Place::ACROSS + 3] = 0.5 * drawn.values[Place::TURNS + 2];
                drawn.warp([(0.0, 0.1), (0.0, 0.1), (0.0, 0.1), (0.0, 0.1)]);
                drawn.form([(0.0, 2.0), (0.0, 2.0), (0.0, 0.0), (2.0, 6.0), (2.0, 6.0)]);
                drawn.between(Place::BIAS, (-2.0, 2.0));
                drawn.between(Place::NARROWING, (-0.2, 0.2));
            }
            Self::Speckle => {
                drawn.waves([(5, 9), (7, 12), (10, 18), (9, 15)]);
                drawn.across([(17.0, 30.0), (-40.0, -22.0), (30.0, 60.0), (-60.0, -30.0)]);
                drawn.warp([(1.5, 3.5), (1.5, 3.5), (1.5, 3.0), (1.5, 3.0)]);
                drawn.form([(0.0, 0.0), (0.0, 0.0), (-3.0, 0.0), (-8.0, -4.0), (-8.0, -4.0)]);
                drawn.between(Place::BIAS, (2.0, 9.0));
                drawn.between(Place::NARROWING, (-0.3, 0.5));
            }
            Self::Worn => {
                drawn.waves([(3, 5), (5, 8), (1, 2), (2, 3)]);
                drawn.across([(9.0, 16.0), (-22.0, -14.0), (3.0, 8.0), (-10.0, -5.0)]);
                drawn.warp([(1.0, 2.2), (1.0, 2.2), (0.5, 1.2), (0.5, 1.2)]);
                drawn.form([(0.0, 0.0), (0.0, 0.0), (2.0, 6.0), (6.0, 12.0), (5.0, 9.0)]);
                drawn.between(Place::BIAS, (0.0, 9.0));
                drawn.between(Place::NARROWING, (-1.0, -0.3));
            }
            Self::Glaze => {
                drawn.waves([(2, 4), (4, 7), (0, 0), (1, 2)]);
                drawn.across([(2.0, 5.0), (3.0, 8.0), (3.0, 7.0), (-5.0, -2.0)]);
                drawn.warp([(0.3, 1.0), (0.2, 0.6), (0.1, 0.5), (0.1, 0.4)]);
                drawn.form([(0.0, 0.0), (0.0, 0.0), (0.0, 1.0), (3.0, 8.0), (0.5, 2.0)]);
                drawn.between(Place::BIAS, (-1.5, 1.5));
                drawn.between(Place::NARROWING, (-0.5, 0.2));
            }
            Self::Streaks => {
                drawn.waves([(0, 0), (1, 2), (0, 0), (0, 0)]);
                drawn.across([(60.0, 90.0), (20.0, 40.0), (130.0, 220.0), (240.0, 330.0)]);
                drawn.warp([(1.0, 2.5), (1.0, 2.5), (0.2, 0.6), (0.2, 0.6)]);
                drawn.form([(0.0, 0.0), (0.0, 0.0), (0.5, 2.0), (1.0, 2.5), (1.0, 2.5)]);
                drawn.between(Place::BIAS, (-0.5, 0.5));
                drawn.between(Place::NARROWING, (-0.3, 0.0));
            }
        }
        drawn.values
    }

    /// Draws the factor of the second albedo, by channel, and the levels of both highlights where
    /// t is 1. `None`: the second albedo is another colour of the class.
    pub(super) fn change(self, albedo: [f64; 3], stream: &mut Stream) -> (Option<[f64; 3]>, f64) {
        let mut between = |low: f64, high: f64| low + (high - low) * f64::from(stream.unit());
        let bright = albedo.iter().sum::<f64>() > 0.75;
        match self {
            Self::Grain => {
                let dark = between(0.15, 0.5);
                (Some([dark, 0.85 * dark, 0.7 * dark]), between(-0.6, 0.2))
            }
            Self::Veins if bright => {
                (Some([0, 1, 2].map(|_| between(0.08, 0.3))), between(-0.5, 0.3))
            }
            Self::Veins => (Some([0, 1, 2].map(|_| between(3.0, 6.0))), between(-0.5, 0.3)),
            Self::Weave | Self::Plaid | Self::Speckle if between(0.0, 1.0) < 0.6 => {
                let factor = if bright || between(0.0, 1.0) < 0.4 {
                    between(0.1, 0.5)
                } else {
                    between(2.0, 4.5)
                };
                (Some([factor; 3]), between(-0.8, 0.8))
            }
            Self::Weave | Self::Plaid | Self::Speckle => (None, between(-0.8, 0.8)),
            Self::Worn => {
                let is_primer = between(0.0, 1.0) < 0.4;
                let grey = between(0.3, 1.5);
                (is_primer.then_some([grey; 3]), between(-3.5, -1.0))
            }
            Self::Glaze => (None, between(-1.0, 0.3)),
            Self::Streaks => (Some([between(0.5, 0.85); 3]), between(-0.7, -0.2)),
        }
    }
}

/// Values that are being drawn.
struct Drawn<'a> {
    values: [f64; PATTERN],
    stream: &'a mut Stream,
}

impl Drawn<'_> {
    fn between(&mut self, at: usize, (low, high): (f64, f64)) {
        self.values[at] = low + (high - low) * f64::from(self.stream.unit());
    }

    /// Draws whole turns.
    fn waves(&mut self, turns: [(u32, u32); 4]) {
        for (at, (low, high)) in turns.into_iter().enumerate() {
            let drawn = low + self.stream.below(high - low + 1);
            self.values[Place::TURNS + at] = TAU * f64::from(drawn);
        }
    }

    fn across(&mut self, ranges: [(f64, f64); 4]) {
        (0..4).for_each(|at| self.between(Place::ACROSS + at, ranges[at]));
    }

    fn warp(&mut self, ranges: [(f64, f64); 4]) {
        (0..4).for_each(|at| self.between(Place::WARP + at, ranges[at]));
    }

    fn form(&mut self, ranges: [(f64, f64); 5]) {
        (0..5).for_each(|at| self.between(Place::FORM + at, ranges[at]));
    }
}

impl Pattern {
    /// Changes the values by steps. Waves keep their turns, and their phases in the middle of the
    /// surface.
    pub(super) fn step(&mut self, amount: f64, stream: &mut Stream) {
        let mut bell = || amount * f64::from(stream.bell());
        let values = &mut self.values;
        for wave in 0..4 {
            let across = &mut values[Place::ACROSS + wave];
            let change = *across * (libm::exp2(ACROSS_STEP * bell()) - 1.0);
            *across += change;
            values[Place::PHASES + wave] += PHASE_STEP * bell() - 0.5 * change;
            let warp = &mut values[Place::WARP + wave];
            *warp = (*warp + WARP_STEP * bell()).clamp(-WARP_MOST, WARP_MOST);
        }
        let all = &mut values[Place::FORM..=Place::BIAS];
        let size = all.iter().fold(1.0, |size: f64, value| size.max(value.abs()));
        for value in all {
            *value += FORM_STEP * size * bell();
        }
        // Phases repeat after a turn.
        for phase in &mut values[Place::PHASES..][..4] {
            *phase = phase.rem_euclid(TAU);
        }
        let narrowing = &mut values[Place::NARROWING];
        *narrowing = (*narrowing + NARROWING_STEP * bell()).clamp(-NARROWING_MOST, NARROWING_MOST);
        self.shift_level(LEVEL_STEP * bell());
    }

    /// Changes the level of the highlights and the rim where t is 1, unless it would be too large.
    /// Hues stay.
    fn shift_level(&mut self, level: f64) {
        let terms = &mut self.contrast[BODY + 1..];
        let changed = |channel: &f64| (channel + level).abs() <= CONTRAST_MOST;
        if terms.as_flattened().iter().all(changed) {
            terms.as_flattened_mut().iter_mut().for_each(|channel| *channel += level);
        }
    }

    /// Changes the second colours: each term by its tint, half of log2 of the albedo by `change`.
    pub(super) fn tint(&mut self, tints: [f64; TERMS], change: [f64; 3]) {
        for (term, tint) in self.contrast.iter_mut().zip(tints) {
            for (channel, change) in term.iter_mut().zip(change) {
                let most = CONTRAST_MOST.max(channel.abs());
                *channel = (*channel + 0.5 * tint * change).clamp(-most, most);
            }
        }
    }

    /// Multiplies the contrast by 2^`exponent`, or changes its level only, so that hues stay.
    pub(super) fn scale(&mut self, exponent: f64, keeps_hue: bool) {
        let factor = libm::exp2(exponent);
        let narrowing = &mut self.values[Place::NARROWING];
        *narrowing = (factor * *narrowing).clamp(-NARROWING_MOST, NARROWING_MOST);
        let all = self.contrast.as_flattened_mut();
        let largest = all.iter().fold(0.0, |largest: f64, one| largest.max(one.abs()));
        if keeps_hue {
            // Larger levels in the direction of the present mean.
            for term in &mut self.contrast {
                let mean = term.iter().sum::<f64>() / 3.0;
                let changed = (factor * mean).clamp(-CONTRAST_MOST, CONTRAST_MOST);
                *term = term.map(|channel| channel + changed - mean);
            }
        } else {
            let factor = factor.min(CONTRAST_MOST.max(largest) / largest.max(1e-6));
            all.iter_mut().for_each(|channel| *channel *= factor);
        }
    }

    /// Gives both colours of each term the same hue.
    pub(super) fn keep_hue(&mut self) {
        for term in &mut self.contrast {
            *term = [term.iter().sum::<f64>() / 3.0; 3];
        }
    }
}

/// Steps at amount 1.
const ACROSS_STEP: f64 = 0.4;
const PHASE_STEP: f64 = 2.0;
const WARP_STEP: f64 = 0.8;
/// In multiples of the largest weight.
const FORM_STEP: f64 = 0.5;
const NARROWING_STEP: f64 = 0.4;
const LEVEL_STEP: f64 = 1.0;
/// Largest values.
const WARP_MOST: f64 = 4.0;
const NARROWING_MOST: f64 = 1.5;
const CONTRAST_MOST: f64 = 5.0;
