//! Conversion of reflectance spectra to colours: CIE 1931, then linear sRGB in which equal energy
//! is white.

use glam::{DMat3, DVec3};

/// From XYZ to linear sRGB with white point D65, in columns. Rounded to seven digits, as is common.
const SRGB: DMat3 = DMat3::from_cols_array(&[
    3.240_454_2,
    -0.969_266,
    0.055_643_4, //
    -1.537_138_5,
    1.876_010_8,
    -0.204_025_9, //
    -0.498_531_4,
    0.041_556,
    1.057_225_2,
]);

/// Returns the factors that turn the values at these wavelengths into linear red, green and blue by
/// a weighted sum.
///
/// A spectrum of ones becomes (1, 1, 1): the light has equal energy, and each channel is divided by
/// the value of a perfect diffuser. A wavelength represents half the distance to each neighbour;
/// the first and the last represent a whole step.
///
/// # Units
/// Wavelengths in nanometres, ascending, at least one. Only those in the visible range contribute.
///
/// # Error
/// The colour matching functions are fits: from 400 to 700 nm they differ from the table of CIE
/// 1931 by up to 0.014 (x), 0.007 (y) and 0.013 (z), with largest values of 1.06, 1.00 and 1.77.
/// Colours of Cornell's paints differ by 0.1 to 0.3 % of their largest channel (median), by 8 %
/// where they are darkest.
///
/// # Source
/// Wyman, Sloan and Shirley 2013, "Simple analytic approximations to the CIE XYZ color matching
/// functions", the multi-lobe fit; sRGB: IEC 61966-2-1.
pub(super) fn weights(wavelengths_nm: &[f64]) -> Vec<DVec3> {
    let last = wavelengths_nm.len() - 1;
    let step = |k: usize| {
        let before = k.checked_sub(1).map(|before| wavelengths_nm[k] - wavelengths_nm[before]);
        let after = (k < last).then(|| wavelengths_nm[k + 1] - wavelengths_nm[k]);
        match (before, after) {
            (Some(before), Some(after)) => 0.5 * (before + after),
            (only, None) | (None, only) => only.unwrap_or(1.0),
        }
    };
    let weight = |(k, wavelength): (usize, &f64)| SRGB * matching(*wavelength) * step(k);
    let weights: Vec<DVec3> = wavelengths_nm.iter().enumerate().map(weight).collect();
    let white: DVec3 = weights.iter().sum();
    weights.into_iter().map(|weight| weight / white).collect()
}

/// X, Y and Z of the standard observer at a wavelength.
fn matching(nm: f64) -> DVec3 {
    let x = 0.362 * lobe(nm, 442.0, (0.0624, 0.0374)) + 1.056 * lobe(nm, 599.8, (0.0264, 0.0323))
        - 0.065 * lobe(nm, 501.1, (0.0490, 0.0382));
    let y = 0.821 * lobe(nm, 568.8, (0.0213, 0.0247)) + 0.286 * lobe(nm, 530.9, (0.0613, 0.0322));
    let z = 1.217 * lobe(nm, 437.0, (0.0845, 0.0278)) + 0.681 * lobe(nm, 459.0, (0.0385, 0.0725));
    DVec3::new(x, y, z)
}

/// Gaussian with different widths below and above its peak.
fn lobe(nm: f64, peak: f64, (below, above): (f64, f64)) -> f64 {
    let t = (nm - peak) * if nm < peak { below } else { above };
    libm::exp(-0.5 * t * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matching_functions_are_those_of_the_standard_observer() {
        // CIE 15: x, y and z of the standard observer at a few wavelengths.
        for (nm, wanted) in [
            (450.0, [0.3362, 0.0380, 1.7721]),
            (500.0, [0.0049, 0.3230, 0.2720]),
            (550.0, [0.4334, 0.9950, 0.0087]),
            (600.0, [1.0622, 0.6310, 0.0008]),
            (650.0, [0.2835, 0.1070, 0.0000]),
        ] {
            let off = matching(nm) - DVec3::from_array(wanted);
            assert!(off.abs().max_element() < 0.014, "{nm}: {off}");
        }
    }

    #[test]
    fn equal_energy_is_white_at_any_sampling_and_bands_have_their_colours() {
        let even: Vec<f64> = (0..31).map(|k| 400.0 + 10.0 * f64::from(k)).collect();
        let uneven: Vec<f64> = (0..61).map(|k| 400.0 + f64::from(k * k) / 12.0).collect();
        for wavelengths in [&even, &uneven, &vec![550.0]] {
            let white: DVec3 = weights(wavelengths).iter().sum();
            assert!((white - DVec3::ONE).length() < 1e-12);
        }
        let band = |wavelengths: &[f64], low: f64, high: f64| -> DVec3 {
            let all = weights(wavelengths);
            let within = wavelengths.iter().zip(all).filter(|(nm, _)| (low..high).contains(*nm));
            within.map(|(_, weight)| weight).sum()
        };
        let red = band(&even, 600.0, 701.0);
        assert!(red.x > 0.5 && red.y < 0.1 && red.z < 0.01, "{red}");
        assert!((band(&uneven, 595.0, 701.0) - band(&even, 595.0, 701.0)).length() < 0.05);
        assert!(band(&even, 400.0, 480.0).max_element() > 0.9);
    }
}
