//! Parameters of a believable program: the values of its genome by their roles.

use std::sync::LazyLock;

use super::pattern::Pattern;
use super::program::{self, Layout, PATTERN, SCALE};
use super::structure::{
    BODY, NARROW, RIM, Structure, TERMS, WEIGHTS, WIDE, fall_off_of, inputs_of, is_highlight,
    unit_of,
};
use crate::{CONSTANTS, Genome, Instruction};

/// Parameters of a believable program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Parameters {
    /// Weights in the order of [`super::structure::weights`].
    pub(super) weights: [f64; WEIGHTS],
    /// log2 of the factor of each term in each channel.
    pub(super) colours: [[f64; 3]; TERMS],
    /// ln of the ratio of the widths of highlights along v and u, if it is brushed.
    pub(super) stretch: Option<f64>,
    /// Pattern, if it has one.
    pub(super) pattern: Option<Pattern>,
}

impl Parameters {
    /// Modules that the program has.
    pub(super) fn structure(&self) -> Structure {
        Structure { is_brushed: self.stretch.is_some(), is_patterned: self.pattern.is_some() }
    }

    /// Program with these parameters, under the energy limit.
    pub(super) fn genome(&self) -> Genome {
        program::genome(self.structure(), &self.values())
    }

    /// Values in the order of [`Layout`].
    fn values(&self) -> Vec<f64> {
        let mut values = self.weights.to_vec();
        values.extend(self.colours.as_flattened().iter().map(|colour| libm::exp2(*colour)));
        let scale = f64::from(SCALE);
        values.extend(self.stretch.iter().flat_map(|s| [libm::cosh(*s), scale * libm::sinh(*s)]));
        if let Some(pattern) = &self.pattern {
            values.extend(pattern.values);
            let both = self.colours.as_flattened().iter().zip(pattern.contrast.as_flattened());
            values.extend(both.map(|(colour, contrast)| libm::exp2(colour + contrast)));
        }
        values
    }

    /// Parameters of a program; `None` if it is not believable, that is, if it has other
    /// instructions.
    pub(super) fn of(
        instructions: &[Instruction],
        constants: &[[f32; 4]; CONSTANTS],
    ) -> Option<Self> {
        let (structure, values) = program::read(instructions, constants)?;
        let layout = Layout::of(structure);
        let logs = |from: usize| -> [[f64; 3]; TERMS] {
            let log = |at: usize| libm::log2(values[from + at].max(1e-12));
            std::array::from_fn(|term| [0, 1, 2].map(|channel| log(3 * term + channel)))
        };
        let colours = logs(layout.colours.start);
        let pattern = structure.is_patterned.then(|| {
            let second = logs(layout.second.start);
            let contrast = |term: usize| [0, 1, 2].map(|c| second[term][c] - colours[term][c]);
            let own: &[f64; PATTERN] = values[layout.pattern.clone()].try_into().expect("its size");
            Pattern { values: *own, contrast: std::array::from_fn(contrast) }
        });
        Some(Self {
            weights: std::array::from_fn(|at| values[at]),
            colours,
            stretch: structure
                .is_brushed
                .then(|| libm::asinh(values[layout.stretch.end - 1] / f64::from(SCALE))),
            pattern,
        })
    }

    /// Writes the parameters that differ from `old` into the program, which has those of `old`. If
    /// they have another structure, it replaces the program.
    pub(super) fn write(
        &self,
        old: &Self,
        (instructions, constants): (&mut Vec<Instruction>, &mut [[f32; 4]; CONSTANTS]),
    ) {
        let structure = self.structure();
        if structure == old.structure() {
            program::write(structure, (&self.values(), &old.values()), constants);
        } else {
            let genome = self.genome();
            *instructions = genome.instructions().to_vec();
            *constants = *genome.constants();
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
