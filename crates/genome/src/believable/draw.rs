//! Draws believable programs: the shape of a class of materials, then a colour.

use super::anchor::{Anchor, Class, VALUES};
use super::colour;
use super::parameters::Parameters;
use super::pattern::{Pattern, Style};
use super::structure::{NARROW, Structure, TERMS, WEIGHTS, WIDE, unit_of};
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
/// Least width of the narrow highlight of a brushed material: tan theta_h where it bends.
const BRUSHED: (f64, f64) = (0.08, 0.2);
/// Stretch: ln of the ratio of the widths of a highlight.
const STRETCH: (f64, f64) = (0.9, 2.0);
/// Change of the level of the highlights of brushed cloth.
const SATIN: (f64, f64) = (0.5, 2.0);
/// Largest widening, in ln.
const WIDENING: f64 = 2.5;
/// Second albedos of patterns stay between these.
const SECOND: (f64, f64) = (0.02, 0.8);
/// Change of the level of all terms of a metal, as a share of that of its highlights.
const METAL_LEVEL: f64 = 0.5;

/// Draws a believable program with at most the modules of `most`.
pub(crate) fn genome(key: BirthKey, most: Structure) -> Genome {
    let mut stream = Stream::new(key, Operator::Believable);
    let class = class(&mut stream);
    let mut parameters = parameters(class, &mut stream);
    let mut stream = Stream::new(key, Operator::BelievableStructure);
    dress(&mut parameters, class, structure(class, most, &mut stream), &mut stream);
    parameters.genome()
}

/// Shares of brushed and of patterned materials of a class; independent of each other.
fn shares(class: Class) -> (f32, f32) {
    match class {
        Class::Metal => (0.4, 0.15),
        Class::MetallicPaint => (0.1, 0.12),
        Class::Plastic => (0.03, 0.15),
        Class::Paint => (0.0, 0.3),
        Class::Cloth => (0.15, 0.4),
        Class::Wood => (0.1, 0.8),
        Class::Stone => (0.0, 0.7),
        Class::Rubber => (0.0, 0.15),
    }
}

/// Draws a structure of a class with at most the modules of `most`.
pub(super) fn structure(class: Class, most: Structure, stream: &mut Stream) -> Structure {
    let (brushed, patterned) = shares(class);
    let (is_brushed, is_patterned) = (stream.chance(brushed), stream.chance(patterned));
    Structure {
        is_brushed: is_brushed && most.is_brushed,
        is_patterned: is_patterned && most.is_patterned,
    }
}

/// Gives parameters of the plain structure the modules of another one.
pub(super) fn dress(
    parameters: &mut Parameters,
    class: Class,
    structure: Structure,
    stream: &mut Stream,
) {
    if structure.is_brushed {
        brush(parameters, class, stream);
    }
    if structure.is_patterned {
        parameters.pattern = Some(pattern(parameters, class, stream));
    }
}

/// Draws a stretch. Widens narrow highlights, in which a stretch would not show, and strengthens
/// those of cloth, which becomes satin.
fn brush(parameters: &mut Parameters, class: Class, stream: &mut Stream) {
    let mut between = |low: f64, high: f64| low + (high - low) * f64::from(stream.unit());
    let along_v = between(0.0, 1.0) < 0.5;
    let stretch = between(STRETCH.0, STRETCH.1);
    let satin = if class == Class::Cloth { between(SATIN.0, SATIN.1) } else { 0.0 };
    parameters.stretch = Some(if along_v { stretch } else { -stretch });
    let width = libm::log(between(BRUSHED.0, BRUSHED.1));
    let unit = |highlight: usize| {
        let unit = unit_of(highlight);
        (unit.start, unit.start + 1)
    };
    let (slope, bias) = unit(NARROW);
    // A highlight bends where the argument of its unit is 0.
    let bend = -parameters.weights[bias] / parameters.weights[slope];
    let widening = (width - bend).clamp(0.0, WIDENING);
    for highlight in [NARROW, WIDE] {
        let (slope, bias) = unit(highlight);
        parameters.weights[bias] -= parameters.weights[slope] * widening;
        // f is the square of the terms, and the area of a highlight the square of its width.
        for colour in &mut parameters.colours[highlight] {
            *colour += satin - widening / std::f64::consts::LN_2;
        }
    }
}

/// Draws a pattern for a material of a class.
pub(super) fn pattern(parameters: &Parameters, class: Class, stream: &mut Stream) -> Pattern {
    let style = Style::draw(class, stream);
    let values = style.values(stream);
    Pattern { values, contrast: contrast(parameters, (class, style), stream) }
}

/// Draws the second colours of a pattern, relative to the first.
fn contrast(
    parameters: &Parameters,
    (class, style): (Class, Style),
    stream: &mut Stream,
) -> [[f64; 3]; TERMS] {
    let own = match class {
        Class::Metal => colour::draw(class, stream),
        _ => parameters.body_albedo(),
    };
    let (factor, level) = style.change(own, stream);
    let albedo = match factor {
        Some(factor) => [0, 1, 2].map(|channel| own[channel] * factor[channel]),
        None => colour::draw(class, stream),
    };
    let mut second = *parameters;
    let albedo = albedo.map(|channel| channel.clamp(SECOND.0, SECOND.1));
    if class == Class::Metal {
        // Not the brightness but the level of the terms changes.
        colour(&mut second, class, albedo);
        for term in &mut second.colours {
            *term = term.map(|colour| colour + METAL_LEVEL * level);
        }
    } else {
        colour(&mut second, class, albedo);
        for term in [NARROW, WIDE] {
            second.colours[term] = second.colours[term].map(|colour| colour + level);
        }
    }
    let apart = |term: usize, channel: usize| {
        second.colours[term][channel] - parameters.colours[term][channel]
    };
    std::array::from_fn(|term| [0, 1, 2].map(|channel| apart(term, channel)))
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
    Parameters {
        weights: std::array::from_fn(|at| shape[at]),
        colours: std::array::from_fn(level),
        stretch: None,
        pattern: None,
    }
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
