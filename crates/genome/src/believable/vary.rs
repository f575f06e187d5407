//! Mutation and crossover of believable programs, by parameters. All children are believable.

use super::anchor::{Anchor, Class, VALUES};
use super::parameters::Parameters;
use super::structure::{
    BODY, NARROW, TERMS, WEIGHTS, WIDE, fall_off_of, inputs_of, is_highlight, unit_of,
};
use super::{colour, draw};
use crate::random::{Operator, Stream};
use crate::steer::Kept;
use crate::{BirthKey, CONSTANTS, Instruction};

/// Probability of a new shape in the old colour, and of a new colour, at amount 1; grows with the
/// square of the amount, so that small amounts keep both.
const RESHAPE: f32 = 0.8;
const RECOLOUR: f32 = 1.0;
/// Change of the shape at amount 1, in differences of two anchors.
const STEP: f64 = 0.7;
/// Standard deviation of the change of log2 of the albedo of each channel at amount 1.
const COLOUR_STEP: f64 = 1.5;
/// Channels of bodies stay between these albedos.
const ALBEDOS: (f64, f64) = (0.03, 0.9);
/// Largest channel of a metal's colour where it becomes that of a body.
const METAL: f64 = 0.7;

/// Mutates the constants of a believable program. Channels of the mask `kept`, red in the lowest
/// bit, stay the same function; then the others change in colour only. A steer keeps the hue of
/// each term, or everything but the shape of the highlights. Returns false if the program is not
/// believable.
pub(crate) fn mutate(
    (instructions, constants): (&[Instruction], &mut [[f32; 4]; CONSTANTS]),
    mutation: f32,
    (kept, steered): (u8, Kept),
    key: BirthKey,
) -> bool {
    let Some(old) = Parameters::of(instructions, constants) else { return false };
    if mutation <= 0.0 {
        return true;
    }
    let mut stream = Stream::new(key, Operator::MutateBelievable);
    let nearest = nearest(&old);
    let (mut new, mut class) = (old, nearest.class);
    if kept == 0 && steered.all_but_gloss {
        let step = STEP * f64::from(mutation);
        change_highlights(&mut new, &draw::difference(class, &mut stream), step);
        new.write(&old, constants);
        return true;
    }
    if kept == 0 {
        if !steered.colour && stream.chance(RESHAPE * mutation * mutation) {
            class = draw::class(&mut stream);
            let shape = draw::shape(class, &mut stream);
            new = draw::coloured(class, &shape, colour_of(&old, nearest.class));
        }
        let change = draw::difference(class, &mut stream);
        let step = STEP * f64::from(mutation);
        for (weight, change) in new.weights.iter_mut().zip(change) {
            *weight += step * change;
        }
        let levels = &change[WEIGHTS..][..TERMS];
        for (term, change) in new.colours.iter_mut().zip(levels) {
            *term = term.map(|colour| colour + step * change);
        }
    }
    if steered.is_any() {
        // The shape has changed all channels of a term alike, so each term has its old hue.
        new.write(&old, constants);
        return true;
    }
    if stream.chance(RECOLOUR * mutation * mutation) {
        let albedo = colour::draw(class, &mut stream);
        draw::colour(&mut new, class, albedo);
    } else {
        let change = std::array::from_fn(|_| COLOUR_STEP * f64::from(mutation * stream.bell()));
        tint(&mut new, (&old, nearest.class), class, change);
    }
    keep(&mut new, &old, kept);
    new.write(&old, constants);
    true
}

/// Crosses two believable programs: the roles and the colour of the second replace those of the
/// first, each with probability `share`. Channels of the mask `kept` stay the same function, as in
/// [`mutate`]. Returns false if one of the programs is not believable.
pub(crate) fn recombine(
    (instructions, constants): (&[Instruction], &mut [[f32; 4]; CONSTANTS]),
    second: (&[Instruction], &[[f32; 4]; CONSTANTS]),
    (share, (kept, steered)): (f32, (u8, Kept)),
    key: BirthKey,
) -> bool {
    let Some(first) = Parameters::of(instructions, constants) else { return false };
    let Some(second) = Parameters::of(second.0, second.1) else { return false };
    let mut stream = Stream::new(key, Operator::RecombineBelievable);
    // The terms, then the colour.
    let mut taken: [bool; TERMS + 1] = std::array::from_fn(|_| stream.chance(share));
    if share > 0.0 && share < 1.0 && taken.iter().all(|one| *one == taken[0]) {
        let one = &mut taken[stream.below(TERMS as u32 + 1) as usize];
        *one = !*one;
    }
    if kept != 0 {
        taken[..TERMS].fill(false);
    }
    if steered.all_but_gloss {
        let is_highlight = |term: usize| term < TERMS && is_highlight(term);
        (0..=TERMS).filter(|term| !is_highlight(*term)).for_each(|term| taken[term] = false);
    }
    taken[TERMS] &= !steered.colour;
    let mut child = first;
    for term in (BODY..TERMS).filter(|term| taken[*term]) {
        for at in weights_of(term) {
            child.weights[at] = second.weights[at];
        }
        child.colours[term] = second.colours[term];
        if steered.is_any() {
            let mean = |of: &Parameters| of.colours[term].iter().sum::<f64>() / 3.0;
            let level = mean(&second) - mean(&first);
            child.colours[term] = first.colours[term].map(|colour| colour + level);
        }
    }
    if steered.is_any() {
        child.write(&first, constants);
        return true;
    }
    let nearest = nearest(&child);
    let albedo = if taken[TERMS] { second } else { first };
    let albedo = colour_of(&albedo, self::nearest(&albedo).class);
    if taken.iter().any(|one| *one != taken[0]) {
        draw::colour(&mut child, nearest.class, albedo);
    }
    keep(&mut child, &first, kept);
    child.write(&first, constants);
    true
}

/// Gives the old colour to the body again after a change of the shape, each channel multiplied by
/// 2^`change`. Without a change of shape and colour, everything stays as it is.
fn tint(new: &mut Parameters, old: (&Parameters, Class), class: Class, change: [f64; 3]) {
    let (old, old_class) = old;
    let half_log = |albedo: f64| 0.5 * libm::log2(albedo.max(1e-6));
    let factor = scale_of(old, old_class);
    let (own, body) = (old.body_albedo(), new.body_albedo());
    let shift: [f64; 3] = std::array::from_fn(|at| {
        let own = factor * own[at];
        // Channels that are out of range already stay there.
        let (least, most) = (ALBEDOS.0.min(own), ALBEDOS.1.max(own));
        half_log((own * libm::exp2(change[at])).clamp(least, most)) - half_log(factor * body[at])
    });
    draw::shift_colour(new, class, shift);
}

/// Changes the highlights by a multiple of a difference of two anchors; their hues stay.
fn change_highlights(new: &mut Parameters, change: &[f64; VALUES], step: f64) {
    for term in [NARROW, WIDE] {
        for at in weights_of(term) {
            new.weights[at] += step * change[at];
        }
        new.colours[term] = new.colours[term].map(|colour| colour + step * change[WEIGHTS + term]);
    }
}

/// Brings the colours of kept channels back.
fn keep(new: &mut Parameters, old: &Parameters, kept: u8) {
    for (new, old) in new.colours.iter_mut().zip(&old.colours) {
        for channel in (0..3).filter(|channel| kept >> channel & 1 == 1) {
            new[channel] = old[channel];
        }
    }
}

/// Colour of a program. The body of a metal is dark, so it is scaled to the reflectance of one.
fn colour_of(parameters: &Parameters, class: Class) -> [f64; 3] {
    let factor = scale_of(parameters, class);
    parameters.body_albedo().map(|albedo| (factor * albedo).clamp(ALBEDOS.0, ALBEDOS.1))
}

/// Factor from the albedo of a body to its colour.
fn scale_of(parameters: &Parameters, class: Class) -> f64 {
    let largest = parameters.body_albedo().iter().fold(1e-6, |a: f64, b| a.max(*b));
    if class == Class::Metal { METAL / largest } else { 1.0 }
}

/// Indices of the weights of a term and its unit.
fn weights_of(term: usize) -> Vec<usize> {
    let mut all: Vec<usize> = inputs_of(term).collect();
    if is_highlight(term) {
        all.extend(unit_of(term));
        all.push(fall_off_of(term));
    }
    all
}

/// Anchor with the most similar weights.
fn nearest(parameters: &Parameters) -> &'static Anchor {
    let distance = |anchor: &Anchor| -> f64 {
        let both = parameters.weights.iter().zip(anchor.values);
        both.map(|(a, b)| (a - b) * (a - b)).sum()
    };
    let anchors = Anchor::all().iter();
    anchors.min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("there are anchors")
}
