//! Parameters of a believable program, and their places among the constants of its genome.

use std::sync::LazyLock;

use super::structure::{self, BODY, NARROW, TERMS, UNITS, WIDE};
use crate::{CONSTANTS, Genome, Instruction, RANGE};

/// Number of weights.
pub(super) const WEIGHTS: usize = 22;

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

    /// Value of each term with the light at the normal and the eye at 45 degrees, relative to its
    /// value without the fall-off of the highlight.
    pub(super) fn flatness(&self) -> [f64; TERMS] {
        let fall_off = |term: usize| self.weights[4 + 4 * term + (term - 1)] * self.bent(term - 1);
        std::array::from_fn(|term| match term {
            NARROW | WIDE => libm::exp2(fall_off(term)).min(1.0),
            _ => 0.0,
        })
    }

    /// Value of a unit with the light at the normal and the eye at 45 degrees.
    fn bent(&self, unit: usize) -> f64 {
        // ln tan of half of 45 degrees.
        let tan = libm::log(std::f64::consts::SQRT_2 - 1.0);
        let argument = self.weights[2 * unit] * tan + self.weights[2 * unit + 1];
        libm::log2(1.0 + libm::exp2(argument))
    }

    /// Diffuse-like reflectance in each channel: pi f with the light at the normal and the eye at
    /// 45 degrees.
    pub(super) fn body_albedo(&self) -> [f64; 3] {
        // Cosine of half of 45 degrees; the inputs of these two directions.
        let cos = 0.923_879_532_511_286_7;
        let sum = 1.0 + std::f64::consts::FRAC_1_SQRT_2;
        let inputs = [
            cos,
            0.5 * libm::log(1.0 - cos + 0.002),
            libm::log(sum),
            libm::log(std::f64::consts::FRAC_1_SQRT_2),
        ];
        let mut weights = self.weights[2 * UNITS..].iter();
        let mut sums = [0.0; 3];
        for term in BODY..TERMS {
            let mut exponent = 0.0;
            if let NARROW | WIDE = term {
                exponent +=
                    weights.next().expect("a highlight has a fall-off") * self.bent(term - 1);
            }
            exponent += inputs.iter().map(|x| x * weights.next().expect("one a term")).sum::<f64>();
            for (sum, colour) in sums.iter_mut().zip(self.colours[term]) {
                *sum += libm::exp2(exponent + colour);
            }
        }
        sums.map(|sum| std::f64::consts::PI * sum * sum)
    }
}
