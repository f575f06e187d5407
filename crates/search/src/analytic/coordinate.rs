//! A free parameter of a form as a coordinate: its scale and its bounds.

use brood_brdf::{Parameter, ParameterScale};

/// A linear range of non-negative values that reaches above this gets logarithmic coordinates.
const WIDE: f64 = 100.0;
/// Offset of that logarithm, so that 0 has a coordinate.
const NEAR_ZERO: f64 = 1e-3;
/// Longest step: a share of a linear range, and a difference of natural logarithms.
const LONGEST: (f64, f64) = (0.5, 1.5);

/// Map from values to coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Spread {
    Linear,
    Logarithmic,
    /// ln(value + [`NEAR_ZERO`]).
    Wide,
}

/// A free parameter.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Coordinate {
    spread: Spread,
    /// Range of values.
    range: (f64, f64),
    /// Range of coordinates.
    pub(super) bounds: (f64, f64),
    /// Longest step of the coordinate.
    pub(crate) longest: f64,
    /// Index of the model, and of the parameter value in it.
    pub(super) lobe: usize,
    pub(super) at: usize,
    /// Another parameter value of the model that is set to the same value.
    pub(super) also: Option<usize>,
    /// Shares of the bounds between which starts are drawn.
    pub(super) starts: (f64, f64),
}

impl Coordinate {
    pub(super) fn new(parameter: &Parameter, lobe: usize, at: usize) -> Self {
        let range = parameter.range;
        let spread = match parameter.scale {
            ParameterScale::Logarithmic => Spread::Logarithmic,
            ParameterScale::Linear if range.0 >= 0.0 && range.1 > WIDE => Spread::Wide,
            ParameterScale::Linear => Spread::Linear,
        };
        let bounds = (into(spread, range.0), into(spread, range.1));
        let longest = match spread {
            Spread::Linear => LONGEST.0 * (bounds.1 - bounds.0),
            Spread::Logarithmic | Spread::Wide => LONGEST.1,
        };
        let starts = starts(parameter.name);
        Self { spread, range, bounds, longest, lobe, at, also: None, starts }
    }

    /// Coordinate of a value.
    pub(super) fn of(&self, value: f64) -> f64 {
        into(self.spread, value.clamp(self.range.0, self.range.1))
    }

    /// Value of a coordinate, clamped to the range against rounding.
    pub(super) fn value(&self, x: f64) -> f64 {
        let value = match self.spread {
            Spread::Linear => x,
            Spread::Logarithmic => libm::exp(x),
            Spread::Wide => libm::exp(x) - NEAR_ZERO,
        };
        value.clamp(self.range.0, self.range.1)
    }

    /// Start coordinate for a uniform draw `share`.
    pub(super) fn start(&self, share: f64) -> f64 {
        let (low, high) = self.bounds;
        let share = self.starts.0 + (self.starts.1 - self.starts.0) * share;
        low + (high - low) * share
    }
}

fn into(spread: Spread, value: f64) -> f64 {
    match spread {
        Spread::Linear => value,
        Spread::Logarithmic => libm::log(value),
        Spread::Wide => libm::log(value + NEAR_ZERO),
    }
}

/// Shares of a parameter's bounds between which starts are drawn. Excludes values that samples
/// hardly show: highlights narrower than any sample, sheen alone.
fn starts(name: &str) -> (f64, f64) {
    match name {
        // Values from 0.03 on: the logarithmic ranges begin at 1e-4 (roughness) and 1e-3 (alpha).
        "roughness" => (0.62, 1.0),
        "alpha_x" | "alpha_y" => (0.5, 1.0),
        "exponent" | "exponent_u" | "exponent_v" => (0.15, 0.8),
        "eta" => (0.25, 0.9),
        "k" => (0.5, 0.9),
        "ior" => (0.1, 0.8),
        "a" | "b" => (0.2, 0.8),
        _ => (0.05, 0.95),
    }
}

#[cfg(test)]
mod tests {
    use brood_brdf::ModelKind;

    use super::*;

    #[test]
    fn coordinate_round_trips_every_value() {
        for kind in ModelKind::ALL {
            for parameter in kind.parameters() {
                let coordinate = Coordinate::new(parameter, 0, 0);
                for share in [0.0, 0.01, 0.3, 0.99, 1.0] {
                    let value = parameter.at_share(share);
                    let back = coordinate.value(coordinate.of(value));
                    let size = value.abs().max(1e-3);
                    assert!((back - value).abs() < 1e-12 * size, "{kind} {}", parameter.name);
                }
            }
        }
    }
}
