//! How far reflectances are from each other: the figures that reports give and that fits are compared by.
//!
//! Each takes what was wanted and what there is, f cos_i of red, green and blue for every pair of directions.

/// Root of the mean square of ln(1 + f cos_i) - ln(1 + f^ cos_i) over pairs and channels.
///
/// # Source
/// Low, Kronander, Ynnerman and Unger, *BRDF Models for Accurate and Efficient Rendering of Glossy Surfaces* (2012),
/// the logarithmic metric.
#[must_use]
pub fn e_log(wanted: &[[f64; 3]], found: &[[f64; 3]]) -> f64 {
    root_mean_square(wanted, found, |value| libm::log1p(value.max(0.0)))
}

/// The same of cube roots.
///
/// # Source
/// Fores, Ferwerda and Gu, *Toward a Perceptually Based Metric for BRDF Modeling* (2012).
#[must_use]
pub fn e_cbrt(wanted: &[[f64; 3]], found: &[[f64; 3]]) -> f64 {
    root_mean_square(wanted, found, libm::cbrt)
}

/// Root of the sum of squared differences over that of the squares of what was wanted.
#[must_use]
pub fn relative_l2(wanted: &[[f64; 3]], found: &[[f64; 3]]) -> f64 {
    let nothing = vec![[0.0; 3]; wanted.len()];
    let size = root_mean_square(wanted, &nothing, |value| value);
    if size == 0.0 { 0.0 } else { root_mean_square(wanted, found, |value| value) / size }
}

fn root_mean_square(wanted: &[[f64; 3]], found: &[[f64; 3]], of: impl Fn(f64) -> f64) -> f64 {
    assert_eq!(wanted.len(), found.len(), "as many values are compared with as many");
    let pairs = wanted.as_flattened().iter().zip(found.as_flattened());
    let sum: f64 = pairs.map(|(a, b)| (of(*a) - of(*b)) * (of(*a) - of(*b))).sum();
    (sum / wanted.as_flattened().len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metrics_are_what_their_formulas_say() {
        let (wanted, found) = ([[1.0, 0.0, 3.0]], [[0.0, 0.0, 1.0]]);
        let ln2 = std::f64::consts::LN_2;
        assert!((e_log(&wanted, &found) - (2.0 * ln2 * ln2 / 3.0).sqrt()).abs() < 1e-15);
        let cube = 3f64.cbrt() - 1.0;
        assert!((e_cbrt(&wanted, &found) - ((1.0 + cube * cube) / 3.0).sqrt()).abs() < 1e-15);
        assert!((relative_l2(&wanted, &found) - (5.0f64 / 10.0).sqrt()).abs() < 1e-15);
        assert_eq!(e_log(&wanted, &wanted), 0.0);
        assert_eq!(relative_l2(&[[0.0; 3]], &found), 0.0);
    }
}
