//! Parameters of a believable program, and their places among the constants of its genome.

use std::sync::LazyLock;

use super::structure::{
    self, BODY, NARROW, RIM, TERMS, WEIGHTS, WIDE, fall_off_of, inputs_of, is_highlight, unit_of,
};
use crate::{CONSTANTS, Genome, Instruction, RANGE};

/// Parameters of a believable program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Parameters {
    /// Weights in the order of [`structure::weights`].
    pub(super) weights: [f64; WEIGHTS],
    /// log2 of the factor of each term in each channel.
    pub(super) colours: [[f64; 3]; TERMS],
}

/// The instructions that all believable programs share, and the places of their parameters.
struct Template {
    instructions: Vec<Instruction>,
    /// Constant register and component of each weight, then of each colour.
    places: [(usize, usize); WEIGHTS + 3 * TERMS],
}

static TEMPLATE: LazyLock<Template> = LazyLock::new(|| {
    // Different values, which are then found among the constants.
    let weights = std::array::from_fn(|at| 1.0 + at as f64);
    let colour = |at: usize| 100.0 + at as f64;
    let colours = [0, 1, 2, 3].map(|term| [0, 1, 2].map(|c| libm::log2(colour(3 * term + c))));
    let genome = Parameters { weights, colours }.genome();
    let place = |at: usize| {
        let value = if at < WEIGHTS { weights[at] } else { colour(at - WEIGHTS) };
        let held = genome.constants().as_flattened();
        let place = held.iter().position(|held| (f64::from(*held) - value).abs() < 0.1);
        let place = place.expect("every parameter is a constant");
        (place / 4, place % 4)
    };
    Template { instructions: genome.instructions().to_vec(), places: std::array::from_fn(place) }
});

impl Parameters {
    /// Program with these parameters, under the energy limit.
    pub(super) fn genome(&self) -> Genome {
        let shape = structure::shape();
        let mut parameters = vec![0.0; shape.len()];
        for (weight, value) in structure::weights().iter().zip(self.weights) {
            // Lowering skips weights of 0, which would change the instructions.
            parameters[weight.index] = if value.abs() < 1e-6 { 1e-6 } else { value };
        }
        for (term, colours) in self.colours.iter().enumerate() {
            for (channel, colour) in colours.iter().enumerate() {
                parameters[shape.colour(term, channel)] = *colour;
            }
        }
        let genome = shape.genome(&parameters).expect("the structure fits in a program");
        let length = structure::dialect().length;
        genome.padded(length).expect("the program is shorter than the dialect's length")
    }

    /// Parameters of a program; `None` if it is not believable, that is, if it has other
    /// instructions.
    pub(super) fn of(
        instructions: &[Instruction],
        constants: &[[f32; 4]; CONSTANTS],
    ) -> Option<Self> {
        let Template { instructions: own, places } = &*TEMPLATE;
        if own != instructions {
            return None;
        }
        let value = |at: usize| {
            let (register, component) = places[at];
            f64::from(constants[register][component])
        };
        let colour = |at: usize| libm::log2(value(WEIGHTS + at).max(1e-12));
        Some(Self {
            weights: std::array::from_fn(value),
            colours: [0, 1, 2, 3].map(|term| [0, 1, 2].map(|channel| colour(3 * term + channel))),
        })
    }

    /// Writes the parameters that differ from `old` into the constants.
    #[expect(clippy::cast_possible_truncation, reason = "the machine is of f32")]
    pub(super) fn write(&self, old: &Self, constants: &mut [[f32; 4]; CONSTANTS]) {
        for (at, (register, component)) in TEMPLATE.places.into_iter().enumerate() {
            let (new, old) = (self.at(at), old.at(at));
            if new.to_bits() != old.to_bits() {
                let value = if at < WEIGHTS { new } else { libm::exp2(new) };
                constants[register][component] = (value as f32).clamp(-RANGE, RANGE);
            }
        }
    }

    /// Weight or colour by index.
    fn at(&self, at: usize) -> f64 {
        match at.checked_sub(WEIGHTS) {
            Some(colour) => self.colours[colour / 3][colour % 3],
            None => self.weights[at],
        }
    }

    /// Fall-off of each highlight at [`AT_45`], at most 1; 0 for other terms.
    pub(super) fn flatness(&self) -> [f64; TERMS] {
        let flatness = |term| libm::exp2(fall_off(&self.weights, term)).min(1.0);
        std::array::from_fn(|term| if is_highlight(term) { flatness(term) } else { 0.0 })
    }

    /// Reflectance of the body in each channel: pi f at [`AT_45`].
    pub(super) fn body_albedo(&self) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for term in BODY..TERMS {
            let exponent = exponent(&self.weights, term);
            for (sum, colour) in sums.iter_mut().zip(self.colours[term]) {
                *sum += libm::exp2(exponent + colour);
            }
        }
        sums.map(|sum| std::f64::consts::PI * sum * sum)
    }
}

/// Inputs of terms with the light at the normal and the eye at 45 degrees, where bodies are
/// measured: h.wi, ln(1 - h.wi) / 2, ln(cos_i + cos_o), ln(cos_i cos_o).
static AT_45: LazyLock<[f64; 4]> = LazyLock::new(|| {
    // Cosine of half of 45 degrees.
    let cos = 0.923_879_532_511_286_7;
    let sum = 1.0 + std::f64::consts::FRAC_1_SQRT_2;
    let product = std::f64::consts::FRAC_1_SQRT_2;
    [cos, 0.5 * libm::log(1.0 - cos + 0.002), libm::log(sum), libm::log(product)]
});

/// log2 of the fall-off of a highlight at [`AT_45`].
fn fall_off(weights: &[f64; WEIGHTS], highlight: usize) -> f64 {
    // ln tan of half of 45 degrees.
    let tan = libm::log(std::f64::consts::SQRT_2 - 1.0);
    let unit = &weights[unit_of(highlight)];
    weights[fall_off_of(highlight)] * libm::log2(1.0 + libm::exp2(unit[0] * tan + unit[1]))
}

/// log2 of a term at [`AT_45`], without its colour.
fn exponent(weights: &[f64; WEIGHTS], term: usize) -> f64 {
    let fall_off = if is_highlight(term) { fall_off(weights, term) } else { 0.0 };
    let own = &weights[inputs_of(term)];
    fall_off + AT_45.iter().zip(own).map(|(x, weight)| x * weight).sum::<f64>()
}

/// Exchanges terms that a fit may have exchanged, so that each has its role: the narrow highlight
/// bends at the smaller angle, and the body is brighter than the rim at 45 degrees.
///
/// # Shapes
/// Weights in the order of [`structure::weights`]; the level of each term: the mean of log2 of its
/// factors.
pub fn assign_roles(weights: &mut [f64; WEIGHTS], levels: &mut [f64; TERMS]) {
    // A highlight bends where the argument of its unit is 0.
    let bend = |weights: &[f64; WEIGHTS], highlight: usize| {
        let unit = &weights[unit_of(highlight)];
        -unit[1] / unit[0]
    };
    if bend(weights, NARROW) > bend(weights, WIDE) {
        let all = |highlight| unit_of(highlight).chain([fall_off_of(highlight)]);
        for (narrow, wide) in all(NARROW).zip(all(WIDE)) {
            weights.swap(narrow, wide);
        }
        exchange((weights, levels), NARROW, WIDE);
    }
    let brightness =
        |weights: &_, levels: &[f64; TERMS], term| exponent(weights, term) + levels[term];
    if brightness(weights, levels, BODY) < brightness(weights, levels, RIM) {
        exchange((weights, levels), BODY, RIM);
    }
}

/// Exchanges the weights of inputs and the levels of two terms.
fn exchange(
    (weights, levels): (&mut [f64; WEIGHTS], &mut [f64; TERMS]),
    first: usize,
    second: usize,
) {
    for (a, b) in inputs_of(first).zip(inputs_of(second)) {
        weights.swap(a, b);
    }
    levels.swap(first, second);
}
