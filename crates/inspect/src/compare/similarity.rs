//! Structural similarity (SSIM) of two pictures.

/// Radius of a window in pixels, about 3.5 standard deviations.
const REACH: usize = 5;
const WINDOW: usize = 2 * REACH + 1;
/// Standard deviation of the Gaussian window, in pixels.
const DEVIATION: f64 = 1.5;
/// (K1 L)^2 and (K2 L)^2 for values up to 1.
const STABLE: [f64; 2] = [0.01 * 0.01, 0.03 * 0.03];

/// Returns the mean SSIM over channels and all windows inside the picture: 1 for equal pictures,
/// `None` for pictures smaller than a window, 11 x 11.
///
/// # Shapes
/// `a` and `b` are `width * height` pixels of red, green and blue, row by row, from 0 to 255.
///
/// # Source
/// Wang, Bovik, Sheikh and Simoncelli, *Image Quality Assessment: From Error Visibility to
/// Structural Similarity* (2004), with their Gaussian window of deviation 1.5.
pub(super) fn ssim(a: &[u8], b: &[u8], width: usize, height: usize) -> Option<f64> {
    if width < WINDOW || height < WINDOW {
        return None;
    }
    let weights = weights();
    let blur = |values: &[f64]| blurred(values, width, height, &weights);
    let channel = |c: usize| {
        let of = |bytes: &[u8]| -> Vec<f64> {
            bytes.iter().skip(c).step_by(3).map(|value| f64::from(*value) / 255.0).collect()
        };
        let (a, b) = (of(a), of(b));
        let product =
            |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a * b).collect() };
        let means = [blur(&a), blur(&b)];
        let squares = [blur(&product(&a, &a)), blur(&product(&b, &b)), blur(&product(&a, &b))];
        let at = |k: usize| {
            let (p, q) = (means[0][k], means[1][k]);
            let [pp, qq, pq] =
                [squares[0][k] - p * p, squares[1][k] - q * q, squares[2][k] - p * q];
            (2.0 * p * q + STABLE[0]) * (2.0 * pq + STABLE[1])
                / ((p * p + q * q + STABLE[0]) * (pp + qq + STABLE[1]))
        };
        let count = means[0].len();
        (0..count).map(at).sum::<f64>() / count as f64
    };
    Some((0..3).map(channel).sum::<f64>() / 3.0)
}

/// Weights of the Gaussian window, with sum 1.
fn weights() -> [f64; WINDOW] {
    let weight = |k: usize| {
        let x = (k as f64 - REACH as f64) / DEVIATION;
        libm::exp(-0.5 * x * x)
    };
    let all: [f64; WINDOW] = std::array::from_fn(weight);
    let sum: f64 = all.iter().sum();
    all.map(|weight| weight / sum)
}

/// Weighted means of all windows inside the picture.
fn blurred(values: &[f64], width: usize, height: usize, weights: &[f64; WINDOW]) -> Vec<f64> {
    let (columns, rows) = (width - 2 * REACH, height - 2 * REACH);
    let mut along = Vec::with_capacity(columns * height);
    for row in values.chunks_exact(width) {
        let sum = |window: &[f64]| window.iter().zip(weights).map(|(v, w)| v * w).sum::<f64>();
        along.extend(row.windows(WINDOW).map(sum));
    }
    let down = |at: usize| (0..WINDOW).map(|k| weights[k] * along[at + k * columns]).sum();
    (0..rows * columns).map(down).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(shift: usize) -> Vec<u8> {
        let byte = |k: usize| ((k * 37 + shift * (k % 7)) % 251) as u8;
        (0..3 * 16 * 14).map(byte).collect()
    }

    #[test]
    fn similarity_is_one_when_pictures_are_equal_and_less_otherwise() {
        let (a, b, c) = (picture(0), picture(3), picture(60));
        assert_eq!(ssim(&a, &a, 16, 14), Some(1.0));
        let (near, far) = (ssim(&a, &b, 16, 14).unwrap(), ssim(&a, &c, 16, 14).unwrap());
        assert!(far < near && near < 1.0, "{far} {near}");
        assert_eq!(ssim(&a, &b, 16, 14), ssim(&b, &a, 16, 14));
    }

    #[test]
    fn similarity_is_none_when_pictures_are_smaller_than_a_window() {
        assert_eq!(ssim(&[0; 300], &[0; 300], 10, 10), None);
    }

    #[test]
    fn similarity_depends_on_means_when_pictures_are_constant() {
        let of = |value: u8| vec![value; 3 * 144];
        let found = ssim(&of(51), &of(102), 12, 12).unwrap();
        let (p, q) = (0.2, 0.4);
        let expected = (2.0 * p * q + 1e-4) / (p * p + q * q + 1e-4);
        assert!((found - expected).abs() < 1e-9, "{found} {expected}");
    }
}
