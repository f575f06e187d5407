//! Strength of mutation: from the knob to the amounts, rates and steps of the operators.
//!
//! `mutation` is a visible amount: the mean difference of children from their parent is the same
//! function of it for all kinds of genomes. [`AMOUNTS`] maps it to the amounts of the operators.
//! docs/maths/variation.md has the measurement.

/// Meaning of `mutation` in a variation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MutationScale {
    /// Visible amount, equal for all kinds of genomes.
    #[default]
    Visible,
    /// Amount of the operators that breed, from which the visible amount is calibrated.
    Operators,
    /// Amount of the operators with the rates of searches: values are seldom perturbed and often
    /// redrawn, also at small amounts.
    Search,
}

/// Part of a genome that mutates by its own operator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    /// Instructions and constants.
    Program,
    /// Parameters of a believable program.
    Believable,
    /// Models.
    Layers,
}

/// Share of mutations of constants that redraw, at amount 1; in searches at any amount.
const REDRAW: f32 = 0.1;
/// Probability that a constant or a value of a model mutates: at amount 1 in searches, else at
/// amount 0.
const VALUE_RATE: f32 = 0.5;
/// Probability that the kind of a model mutates at amount 1.
const KIND_RATE: f32 = 0.9;
/// The same in searches.
const SEARCH_KIND_RATE: f32 = 0.15;

/// Knots of [`AMOUNTS`].
const KNOBS: [f32; 13] = [0.0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0];

/// Amounts of the operators at [`KNOBS`], for programs, believable programs and layers; linear in
/// between. The mean FLIP between children and parents is then that at 1 times knob^0.75.
const AMOUNTS: [[f32; KNOBS.len()]; 3] = [
    [0.0, 0.023, 0.053, 0.089, 0.142, 0.188, 0.233, 0.281, 0.343, 0.419, 0.539, 0.705, 1.0],
    [0.0, 0.014, 0.037, 0.073, 0.148, 0.231, 0.323, 0.403, 0.5, 0.621, 0.735, 0.848, 1.0],
    [0.0, 0.018, 0.047, 0.096, 0.195, 0.298, 0.387, 0.48, 0.568, 0.654, 0.745, 0.849, 1.0],
];

/// Strength with which a part of a genome mutates.
///
/// Steps, not rates, make small amounts small, so that the difference is smooth. Large amounts draw
/// most of a model anew, because steps alone keep it recognisable.
#[derive(Debug, Clone, Copy)]
pub(super) struct Strength {
    /// Amount of the operators, 0 to 1.
    pub(super) amount: f32,
    part: Part,
    is_search: bool,
}

impl Strength {
    pub(super) fn new(mutation: f32, part: Part, scale: MutationScale) -> Self {
        let amount = match scale {
            MutationScale::Visible => calibrated(mutation, part),
            MutationScale::Operators | MutationScale::Search => mutation,
        };
        Self { amount, part, is_search: scale == MutationScale::Search }
    }

    /// Probability that a constant that is read, or a value of a model, mutates.
    pub(super) fn value_rate(self) -> f32 {
        match self.part {
            _ if self.is_search => VALUE_RATE * self.amount,
            Part::Program | Part::Believable => VALUE_RATE,
            Part::Layers => VALUE_RATE + (1.0 - VALUE_RATE) * self.cube(),
        }
    }

    /// Share of mutations of values that redraw instead of perturbing.
    pub(super) fn redraw(self) -> f32 {
        match self.part {
            _ if self.is_search => REDRAW,
            Part::Program | Part::Believable => REDRAW * self.amount,
            Part::Layers => self.cube(),
        }
    }

    /// Probability that the kind of a model mutates.
    pub(super) fn kind_rate(self) -> f32 {
        if self.is_search {
            SEARCH_KIND_RATE * self.amount * self.amount
        } else {
            KIND_RATE * self.cube()
        }
    }

    /// Probability that an instruction mutates if none has by chance.
    pub(super) fn forced_instruction(self) -> f32 {
        if self.is_search { 2.0 * self.amount } else { 0.0 }
    }

    /// True if a forced change may be a choice of a model.
    pub(super) fn forces_choices(self) -> bool {
        self.is_search
    }

    fn cube(self) -> f32 {
        self.amount * self.amount * self.amount
    }
}

/// Amount of the operators of a part at a visible amount.
fn calibrated(mutation: f32, part: Part) -> f32 {
    let amounts = &AMOUNTS[part as usize];
    let above = KNOBS.iter().position(|knob| *knob >= mutation).unwrap_or(KNOBS.len() - 1).max(1);
    let (low, high) = (KNOBS[above - 1], KNOBS[above]);
    let share = (mutation - low) / (high - low);
    amounts[above - 1] + share * (amounts[above] - amounts[above - 1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_grow_with_the_knob_from_nothing_to_all() {
        for part in [Part::Program, Part::Believable, Part::Layers] {
            assert_eq!((calibrated(0.0, part), calibrated(1.0, part)), (0.0, 1.0));
            let amounts: Vec<f32> =
                (0..=1000).map(|at| calibrated(at as f32 / 1000.0, part)).collect();
            assert!(amounts.windows(2).all(|pair| pair[0] < pair[1]), "{part:?}");
            assert!(calibrated(f32::MIN_POSITIVE, part) > 0.0);
        }
    }
}
