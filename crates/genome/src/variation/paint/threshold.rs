//! Steps of the thresholds `from` and `to` of an effect, in the coordinates in which they are even
//! to the eye: the width of an outline, the radius and softness of a highlight.

use crate::EffectKind;

/// Cosines of a light effect.
const COSINES: (f64, f64) = (-1.0, 1.0);
/// Thresholds of an outline, as 1 - n.e.
const OUTLINE: (f64, f64) = (0.0, 1.0);
/// Levels of what a BRDF reflects.
const LEVELS: (f64, f64) = (0.0, 1.0);
/// Widths of outlines and sizes of highlights, on a logarithmic scale.
const SIZES: (f64, f64) = (0.002, 1.0);
/// Shares of the mirror.
const SHARES: (f64, f64) = (0.0, 1.0);
/// Depths around an object, whose own are 0 to 1.
const DEPTHS: (f64, f64) = (-0.5, 2.0);

/// Returns the thresholds about which random effects are drawn.
pub(super) fn centre(kind: EffectKind) -> (f64, f64) {
    match kind {
        EffectKind::Light => (-0.4, 0.95),
        EffectKind::Silhouette => (0.72, 0.78),
        EffectKind::Highlight => (0.95, 0.97),
        EffectKind::Distance => (0.1, 1.0),
        EffectKind::Glass => (0.1, 0.9),
    }
}

/// Moves the thresholds by two steps, as shares of the ranges of their coordinates. They stay in
/// order. A step of 0 keeps its coordinate.
pub(super) fn moved(kind: EffectKind, (from, to): (f64, f64), steps: [f64; 2]) -> (f64, f64) {
    if steps == [0.0; 2] {
        return (from, to);
    }
    match kind {
        EffectKind::Light => sorted(linear(from, COSINES, steps[0]), linear(to, COSINES, steps[1])),
        EffectKind::Silhouette => {
            let start = linear(from, OUTLINE, steps[0]);
            (start, (start + size(to - from, steps[1])).min(OUTLINE.1))
        }
        EffectKind::Highlight => {
            let end = 1.0 - size(1.0 - to, steps[0]);
            ((end - size(to - from, steps[1])).max(COSINES.0), end)
        }
        EffectKind::Glass => sorted(linear(from, SHARES, steps[0]), linear(to, SHARES, steps[1])),
        EffectKind::Distance => {
            sorted(linear(from, DEPTHS, steps[0]), linear(to, DEPTHS, steps[1]))
        }
    }
}

/// As [`moved`], for a light effect by levels of what a BRDF reflects.
pub(super) fn moved_levels((from, to): (f64, f64), steps: [f64; 2]) -> (f64, f64) {
    match steps == [0.0; 2] {
        true => (from, to),
        false => sorted(linear(from, LEVELS, steps[0]), linear(to, LEVELS, steps[1])),
    }
}

fn sorted(one: f64, other: f64) -> (f64, f64) {
    (one.min(other), one.max(other))
}

/// Moves a value within a range; the ends reflect. A value outside widens the range.
pub(super) fn linear(value: f64, (low, high): (f64, f64), step: f64) -> f64 {
    let (low, high) = (low.min(value), high.max(value));
    low + (high - low) * reflected((value - low) / (high - low) + step)
}

fn size(value: f64, step: f64) -> f64 {
    if step == 0.0 {
        return value;
    }
    let (low, high) = SIZES;
    let span = libm::log(high / low);
    let share = libm::log(value.clamp(low, high) / low) / span;
    low * libm::exp(span * reflected(share + step))
}

/// Folds a share at 0 and 1.
pub(super) fn reflected(share: f64) -> f64 {
    let folded = share.rem_euclid(2.0);
    if folded > 1.0 { 2.0 - folded } else { folded }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_stay_in_order_and_in_their_ranges() {
        for kind in EffectKind::ALL {
            for step in -40..=40 {
                let step = f64::from(step) * 0.09;
                for steps in [[step, 0.0], [0.0, step], [step, -step], [step, step]] {
                    let (from, to) = moved(kind, centre(kind), steps);
                    assert!(from <= to, "{kind} {steps:?}: {from} {to}");
                    for (name, value) in [("from", from), ("to", to)] {
                        let mut table = kind.parameters().iter();
                        let (low, high) = table.find(|one| one.name == name).unwrap().range;
                        assert!((low..=high).contains(&value), "{kind} {name} {value}");
                    }
                }
            }
            assert_eq!(moved(kind, (0.3, 0.4), [0.0; 2]), (0.3, 0.4));
        }
    }
}
