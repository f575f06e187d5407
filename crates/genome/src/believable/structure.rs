//! Structure of believable programs: lobes in which every unit and term has one role.

use std::ops::Range;

use crate::lobes::Shape;
use crate::{Dialect, Input, OpcodeSet};

/// Terms in order: body, narrow highlight, wide highlight, rim.
pub(super) const BODY: usize = 0;
pub(super) const NARROW: usize = 1;
pub(super) const WIDE: usize = 2;
pub(super) const RIM: usize = 3;
/// Number of terms.
pub const TERMS: usize = 4;
/// Number of units; unit k bends the fall-off of highlight k + 1.
pub(super) const UNITS: usize = 2;
/// Number of weights that differ between believable programs.
pub const WEIGHTS: usize = 2 * UNITS + TERMS * (INPUTS.len() - 1) + UNITS;

/// Inputs of believable programs. Only units read the first one.
const INPUTS: [Input; 5] = [
    Input::LogTanHalf,
    Input::HalfDotLight,
    Input::LogHalfAngle,
    Input::LogCosineSum,
    Input::LogCosineProduct,
];

/// Length of believable programs with the instructions that change nothing; that of the programs of
/// searches, so that both can be crossed.
const LENGTH: u16 = 120;
/// Number of registers, as in the programs of searches.
const REGISTERS: u8 = 16;

/// Dialect of believable programs.
#[must_use]
pub fn dialect() -> Dialect {
    Dialect {
        opcodes: OpcodeSet::Extended,
        registers: REGISTERS,
        length: LENGTH,
        ..Dialect::default()
    }
}

/// Shape of believable programs.
#[must_use]
pub fn shape() -> Shape {
    Shape { inputs: INPUTS.to_vec(), units: UNITS, terms: TERMS }
}

/// A weight that differs between believable programs, with the distribution that fits of measured
/// materials start from.
#[derive(Debug, Clone, Copy)]
pub struct Weight {
    /// Index among the parameters of [`shape`].
    pub index: usize,
    /// Mean of the starts.
    pub start: f64,
    /// Standard deviation of the starts.
    pub spread: f64,
}

/// Weights that differ, in the order of [`shape`]'s parameters. All others are 0.
#[must_use]
pub fn weights() -> Vec<Weight> {
    let shape = shape();
    let one = INPUTS.len();
    let mut weights = Vec::new();
    // 2^-u is 1 / (1 + (tan theta_h / alpha)^2) if the slope is 2 / ln 2 and the bias
    // -2 log2 alpha.
    for (unit, bias) in [8.0, 4.0].into_iter().enumerate() {
        weights.push(Weight { index: shape.unit(unit, 0), start: 2.885, spread: 0.3 });
        weights.push(Weight { index: shape.unit(unit, one), start: bias, spread: 1.5 });
    }
    for term in 0..TERMS {
        if is_highlight(term) {
            let unit = term - NARROW;
            weights.push(Weight { index: shape.term(term, unit), start: -1.0, spread: 0.15 });
        }
        for input in 1..INPUTS.len() {
            let index = shape.term(term, UNITS + input);
            let start = if term == RIM && input == 4 { -0.4 } else { 0.0 };
            weights.push(Weight { index, start, spread: 0.15 });
        }
    }
    weights
}

/// Indices among [`weights`] of slope and bias of the unit of a highlight.
pub(super) fn unit_of(highlight: usize) -> Range<usize> {
    2 * (highlight - NARROW)..2 * (highlight - NARROW + 1)
}

/// Index among [`weights`] of the fall-off of a highlight.
pub(super) fn fall_off_of(highlight: usize) -> usize {
    first_of(highlight)
}

/// Indices among [`weights`] of the weights of the inputs of a term.
pub(super) fn inputs_of(term: usize) -> Range<usize> {
    let first = first_of(term) + usize::from(is_highlight(term));
    first..first + INPUTS.len() - 1
}

/// True for terms with a unit and a fall-off.
pub(super) fn is_highlight(term: usize) -> bool {
    matches!(term, NARROW | WIDE)
}

/// Index of the first weight of a term: those of all units and of the terms before stand before it.
fn first_of(term: usize) -> usize {
    let highlights = (BODY..term).filter(|before| is_highlight(*before)).count();
    2 * UNITS + (INPUTS.len() - 1) * term + highlights
}

/// Modules of a believable program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Structure {
    /// True if highlights are longer in one direction.
    pub is_brushed: bool,
    /// True if it changes over the surface.
    pub is_patterned: bool,
}

impl Structure {
    /// All structures, the plain one first.
    pub const ALL: [Self; 4] = [
        Self { is_brushed: false, is_patterned: false },
        Self { is_brushed: true, is_patterned: false },
        Self { is_brushed: false, is_patterned: true },
        Self { is_brushed: true, is_patterned: true },
    ];

    /// Largest structure that a dialect can show.
    #[must_use]
    pub fn of(dialect: &Dialect) -> Self {
        Self { is_brushed: !dialect.isotropic, is_patterned: !dialect.homogeneous }
    }
}
