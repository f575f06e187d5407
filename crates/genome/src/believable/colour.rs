//! Colours of believable programs, by class.

use super::anchor::Class;
use super::structure::TERMS;
use crate::random::Stream;

/// Reflectance of bare metals at normal incidence, linear RGB: silver, aluminium, gold, copper,
/// brass, bronze, iron, nickel, titanium, zinc.
const METALS: [[f64; 3]; 10] = [
    [0.96, 0.94, 0.90],
    [0.91, 0.91, 0.92],
    [1.00, 0.71, 0.30],
    [0.95, 0.60, 0.47],
    [0.90, 0.74, 0.40],
    [0.80, 0.56, 0.33],
    [0.56, 0.55, 0.53],
    [0.68, 0.63, 0.56],
    [0.60, 0.55, 0.50],
    [0.70, 0.73, 0.76],
];
/// Share of metals that are anodised, in any hue.
const ANODISED: f32 = 0.25;

/// Tint of each term: how far it takes the colour of the body, 0 to 1. Highlights of dielectrics
/// are white, those of metals are not.
pub(super) fn tints(class: Class) -> [f64; TERMS] {
    match class {
        Class::Metal => [1.0; TERMS],
        Class::MetallicPaint => [1.0, 0.3, 0.8, 0.8],
        Class::Plastic | Class::Stone => [1.0, 0.0, 0.2, 0.7],
        Class::Paint | Class::Wood => [1.0, 0.0, 0.3, 0.8],
        Class::Cloth => [1.0, 0.5, 0.8, 0.9],
        Class::Rubber => [1.0, 0.1, 0.4, 0.9],
    }
}

/// Draws a colour for a class: the albedo of its body, or the reflectance of a metal.
pub(super) fn draw(class: Class, stream: &mut Stream) -> [f64; 3] {
    match class {
        Class::Metal if stream.chance(ANODISED) => {
            pigment(stream, (0.0, 1.0), (0.3, 0.75), (0.5, 0.9))
        }
        Class::Metal => METALS[stream.below(METALS.len() as u32) as usize],
        Class::MetallicPaint => pigment(stream, (0.0, 1.0), (0.3, 0.97), (0.08, 0.4)),
        Class::Plastic | Class::Paint if stream.chance(0.12) => {
            pigment(stream, (0.0, 1.0), (0.0, 0.08), (0.05, 0.8))
        }
        Class::Plastic => pigment(stream, (0.0, 1.0), (0.8, 0.99), (0.05, 0.55)),
        Class::Paint => pigment(stream, (0.0, 1.0), (0.7, 0.99), (0.1, 0.6)),
        Class::Cloth => pigment(stream, (0.0, 1.0), (0.4, 0.98), (0.08, 0.5)),
        Class::Wood => pigment(stream, (0.03, 0.1), (0.6, 0.92), (0.08, 0.4)),
        Class::Stone => pigment(stream, (0.0, 1.0), (0.0, 0.6), (0.1, 0.7)),
        Class::Rubber => pigment(stream, (0.0, 1.0), (0.0, 0.9), (0.06, 0.4)),
    }
}

/// Draws a colour by ranges of hue (0 to 1, red to red), saturation and largest channel.
fn pigment(
    stream: &mut Stream,
    hue: (f64, f64),
    saturation: (f64, f64),
    value: (f64, f64),
) -> [f64; 3] {
    // Half of the draws from the whole circle are warm: red to yellow.
    let is_any = hue == (0.0, 1.0);
    let hue = if is_any && stream.chance(0.5) { (-0.03, 0.17) } else { hue };
    let mut within = |(low, high): (f64, f64)| low + (high - low) * f64::from(stream.unit());
    let (hue, saturation, value) = (6.0 * within(hue), within(saturation), within(value));
    let channel = |offset: f64| {
        let place = (hue + offset).rem_euclid(6.0);
        // 1 near the hue, 0 opposite to it. The square makes mixed hues as deep as pure ones.
        let share = (2.0 - (place - 3.0).abs()).clamp(0.0, 1.0);
        value * (1.0 - saturation * (1.0 - share * share))
    };
    [3.0, 1.0, 5.0].map(channel)
}
