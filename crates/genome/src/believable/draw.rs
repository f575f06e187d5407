//! Draws believable programs: the shape of a class of materials, then a colour.

use super::anchor::{Anchor, Class, VALUES};
use super::colour;
use super::parameters::Parameters;
use super::structure::{TERMS, WEIGHTS};
use crate::random::{Operator, Stream};
use crate::{BirthKey, Genome};

/// Shares of the classes among draws, in percent.
const SHARES: [(Class, u32); 8] = [
    (Class::Metal, 20),
    (Class::MetallicPaint, 15),
    (Class::Plastic, 24),
    (Class::Paint, 12),
    (Class::Cloth, 13),
    (Class::Wood, 5),
    (Class::Stone, 6),
    (Class::Rubber, 5),
];
/// Deviation of a draw from a point between two anchors, in differences of two anchors.
const SPREAD: f64 = 0.1;
/// Farthest point from the first of two anchors, as a share of their distance. In the middle
/// between unlike anchors highlights are lost.
const FARTHEST: f64 = 0.4;
/// Least mean albedo of the body of a metal.
const LEAST_METAL: f64 = 0.02;
/// Least albedo of a body, so that no picture is black.
const LEAST_ALBEDO: f64 = 0.01;

/// Draws a believable program.
pub(crate) fn genome(key: BirthKey) -> Genome {
    let mut stream = Stream::new(key, Operator::Believable);
    let class = class(&mut stream);
    parameters(class, &mut stream).genome()
}

/// Draws a class by share.
pub(super) fn class(stream: &mut Stream) -> Class {
    let mut draw = stream.below(SHARES.iter().map(|(_, share)| share).sum());
    for (class, share) in SHARES {
        match draw.checked_sub(share) {
            Some(rest) => draw = rest,
            None => return class,
        }
    }
    unreachable!("the draw is below the sum of the shares")
}

/// Draws the parameters of a material of a class.
pub(super) fn parameters(class: Class, stream: &mut Stream) -> Parameters {
    let shape = shape(class, stream);
    let albedo = colour::draw(class, stream);
    coloured(class, &shape, albedo)
}

/// Draws a shape: a point between two anchors of the class, plus a part of the difference of two
/// others.
pub(super) fn shape(class: Class, stream: &mut Stream) -> [f64; VALUES] {
    let anchors = Anchor::of(class);
    let mut anchor = || &anchors[stream.below(anchors.len() as u32) as usize].values;
    let (a, b) = (anchor(), anchor());
    let t = FARTHEST * f64::from(stream.unit());
    let change = difference(class, stream);
    std::array::from_fn(|at| a[at] + t * (b[at] - a[at]) + SPREAD * change[at])
}

/// Difference of two anchors of a class times a bell-shaped number: a sample with the covariance of
/// the class.
pub(super) fn difference(class: Class, stream: &mut Stream) -> [f64; VALUES] {
    let anchors = Anchor::of(class);
    let mut anchor = || &anchors[stream.below(anchors.len() as u32) as usize].values;
    let (a, b) = (anchor(), anchor());
    let factor = f64::from(stream.bell());
    std::array::from_fn(|at| factor * (a[at] - b[at]))
}

/// Parameters of a shape in grey, before it is coloured.
pub(super) fn grey(shape: &[f64; VALUES]) -> Parameters {
    let level = |term: usize| [shape[WEIGHTS + term]; 3];
    Parameters { weights: std::array::from_fn(|at| shape[at]), colours: std::array::from_fn(level) }
}

/// Parameters of a shape in a colour.
pub(super) fn coloured(class: Class, shape: &[f64; VALUES], albedo: [f64; 3]) -> Parameters {
    let mut parameters = grey(shape);
    colour(&mut parameters, class, albedo);
    parameters
}

/// Changes the colour. Each term follows by its tint ([`colour::tints`]), or by its flatness if
/// that is larger. Metals keep their brightness, of which the body is a small part.
pub(super) fn colour(parameters: &mut Parameters, class: Class, albedo: [f64; 3]) {
    // f is the square of the sum of terms.
    let half_log = |albedo: f64| 0.5 * libm::log2(albedo);
    let old = parameters.body_albedo().map(|albedo| half_log(albedo.max(1e-6)));
    let new = albedo.map(|albedo| half_log(albedo.max(LEAST_ALBEDO)));
    let kept = match class {
        Class::Metal => mean(new) - mean(old).max(half_log(LEAST_METAL)),
        _ => 0.0,
    };
    let shift = std::array::from_fn(|channel| new[channel] - old[channel] - kept);
    shift_terms(parameters, class, shift);
}

/// Shifts half of log2 of the albedo of each channel. Metals keep their brightness.
pub(super) fn shift_colour(parameters: &mut Parameters, class: Class, shift: [f64; 3]) {
    let kept = if class == Class::Metal { mean(shift) } else { 0.0 };
    shift_terms(parameters, class, shift.map(|channel| channel - kept));
}

fn mean(of: [f64; 3]) -> f64 {
    of.iter().sum::<f64>() / 3.0
}

/// Shifts the colours of each term by its share.
fn shift_terms(parameters: &mut Parameters, class: Class, shift: [f64; 3]) {
    let flat = parameters.flatness();
    let tints = colour::tints(class);
    for (term, tint) in (0..TERMS).map(|term| (term, tints[term].max(flat[term]))) {
        for (colour, shift) in parameters.colours[term].iter_mut().zip(shift) {
            *colour += tint * shift;
        }
    }
}
