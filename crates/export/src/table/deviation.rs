//! Difference of a table or fit from the BRDF that it was made from.

use std::fmt;

use brood_brdf::Brdf;

use super::source::Source;
use crate::reflectance::even_pairs;

/// Pairs at which the two are compared.
const PAIRS: usize = 2048;

/// Difference of a table or fit from its BRDF, as fractions.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Deviation {
    /// Mean |df cos_i| / mean f cos_i.
    pub(crate) mean: f64,
    /// Median of |df| / f over pairs with f above 0.
    pub(crate) median: f64,
}

impl Deviation {
    /// Compares at pairs that are spread evenly, half of them near the mirror direction.
    pub(crate) fn of(made: &dyn Brdf, source: &Source<'_>) -> Self {
        let pairs = even_pairs(PAIRS);
        let wanted = source.f(&pairs);
        let (mut difference, mut sum) = (0.0, 0.0);
        let mut ratios = Vec::with_capacity(pairs.len());
        for (pair, f) in pairs.iter().zip(wanted) {
            let off = (made.f(pair) - f).abs().element_sum();
            difference += off * pair.cos_i();
            sum += f.abs().element_sum() * pair.cos_i();
            if f.element_sum() > 0.0 {
                ratios.push(off / f.element_sum());
            }
        }
        let mean = if sum > 0.0 { difference / sum } else { 0.0 };
        let middle = ratios.len() / 2;
        let median = match ratios.is_empty() {
            true => 0.0,
            false => *ratios.select_nth_unstable_by(middle, f64::total_cmp).1,
        };
        Self { mean, median }
    }
}

impl fmt::Display for Deviation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |share: f64| format!("{:.3} %", 100.0 * share);
        write!(
            f,
            "error {}, median over pairs {} (mean |df cos| / mean f cos, {PAIRS} \
             pairs, half near the mirror direction)",
            percent(self.mean),
            percent(self.median),
        )
    }
}
