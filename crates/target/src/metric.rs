//! Error metrics between reflectances, for reports and for comparing fits.
//!
//! Each metric takes the target and the found values: f cos_i of red, green and blue for every pair
//! of directions.

/// Root of the mean square of ln(1 + f cos_i) - ln(1 + f^ cos_i) over pairs and channels.
///
/// # Source
/// Low, Kronander, Ynnerman and Unger, *BRDF Models for Accurate and Efficient Rendering of Glossy
/// Surfaces* (2012), the logarithmic metric.
#[must_use]
pub fn e_log(target: &[[f64; 3]], found: &[[f64; 3]]) -> f64 {
    root_mean_square(target, found, |value| libm::log1p(value.max(0.0)))
}

/// Root mean square of the differences of the cube roots of f cos_i, over pairs and channels.
///
/// # Source
/// Fores, Ferwerda and Gu, *Toward a Perceptually Based Metric for BRDF Modeling* (2012).
#[must_use]
pub fn e_cbrt(target: &[[f64; 3]], found: &[[f64; 3]]) -> f64 {
    root_mean_square(target, found, libm::cbrt)
}

/// Root of the sum of squared differences over the root of the sum of squared target values; 0 if
/// all target values are 0.
#[must_use]
pub fn relative_l2(target: &[[f64; 3]], found: &[[f64; 3]]) -> f64 {
    let nothing = vec![[0.0; 3]; target.len()];
    let size = root_mean_square(target, &nothing, |value| value);
    if size == 0.0 { 0.0 } else { root_mean_square(target, found, |value| value) / size }
}

fn root_mean_square(target: &[[f64; 3]], found: &[[f64; 3]], of: impl Fn(f64) -> f64) -> f64 {
    assert_eq!(target.len(), found.len(), "target and found values have the same length");
    let pairs = target.as_flattened().iter().zip(found.as_flattened());
    let sum: f64 = pairs.map(|(a, b)| (of(*a) - of(*b)) * (of(*a) - of(*b))).sum();
    (sum / target.as_flattened().len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metrics_match_their_formulas() {
        let (target, found) = ([[1.0, 0.0, 3.0]], [[0.0, 0.0, 1.0]]);
        let ln2 = std::f64::consts::LN_2;
        assert!((e_log(&target, &found) - (2.0 * ln2 * ln2 / 3.0).sqrt()).abs() < 1e-15);
        let cube = 3f64.cbrt() - 1.0;
        assert!((e_cbrt(&target, &found) - ((1.0 + cube * cube) / 3.0).sqrt()).abs() < 1e-15);
        assert!((relative_l2(&target, &found) - (5.0f64 / 10.0).sqrt()).abs() < 1e-15);
        assert_eq!(e_log(&target, &target), 0.0);
        assert_eq!(relative_l2(&[[0.0; 3]], &found), 0.0);
    }
}
