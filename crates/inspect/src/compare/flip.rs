//! FLIP: perceptual difference of two pictures that alternate in place. LDR-FLIP compares linear
//! RGB in 0..1; HDR-FLIP is its largest value at each pixel over exposures of radiance.
//!
//! # Source
//! Andersson et al., FLIP: A Difference Evaluator for Alternating Images, 2020 (LDR-FLIP).
//! Andersson, Nilsson, Shirley and Akenine-Moeller, Visualizing Errors in Rendered High Dynamic
//! Range Images, 2021 (HDR-FLIP).

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use super::exposures::Exposures;

/// Pixels per degree of visual angle: a display of 3840 pixels seen from as far as it is wide. The
/// papers round to 67, their code does not.
const PIXELS_PER_DEGREE: f64 = 3840.0 * PI / 180.0;
/// Exponent of colour differences, q_c.
const COLOUR_POWER: f64 = 0.7;
/// Share of the largest colour difference that maps to `KNEE_ERROR`, p_c.
const KNEE_SHARE: f64 = 0.4;
/// Error at the knee, p_t.
const KNEE_ERROR: f64 = 0.95;
/// Width of the feature detector in degrees, w.
const FEATURE_WIDTH_DEG: f64 = 0.082;
/// Contrast sensitivity filters: sums of Gaussians of weight a and scale b, in order Y, Cx, Cz.
const ACHROMATIC: [(f64, f64); 1] = [(1.0, 0.0047)];
const RED_GREEN: [(f64, f64); 1] = [(1.0, 0.0053)];
const BLUE_YELLOW: [(f64, f64); 2] = [(34.1, 0.04), (13.5, 0.025)];
/// Largest scale of the filters, which sets their radius.
const LARGEST_SCALE: f64 = 0.04;
/// Reference white, D65.
const WHITE: [f64; 3] = [0.950_428_545, 1.0, 1.088_900_371];
const TO_XYZ: [[f64; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];
const FROM_XYZ: [[f64; 3]; 3] = [
    [3.241_003_275, -1.537_398_934, -0.498_615_861],
    [-0.969_224_334, 1.875_930_071, 0.041_554_224],
    [0.055_639_423, -0.204_011_202, 1.057_148_933],
];

/// Returns the mean LDR-FLIP error of `test` against `reference`, both linear RGB in 0..1.
pub fn mean(width: usize, reference: &[[f64; 3]], test: &[[f64; 3]]) -> f64 {
    mean_of(&errors(width, reference, test))
}

/// Returns the mean HDR-FLIP error of `test` against `reference`, both linear RGB from 0 up.
pub fn mean_over(
    exposures: &Exposures,
    width: usize,
    reference: &[[f64; 3]],
    test: &[[f64; 3]],
) -> f64 {
    let mut largest = vec![0.0; reference.len()];
    for ev in exposures.evs() {
        let [reference, test] = [reference, test].map(|picture| exposures.tone_mapped(picture, ev));
        for (largest, error) in largest.iter_mut().zip(errors(width, &reference, &test)) {
            *largest = f64::max(*largest, error);
        }
    }
    mean_of(&largest)
}

fn mean_of(errors: &[f64]) -> f64 {
    errors.iter().sum::<f64>() / errors.len().max(1) as f64
}

/// Error of each pixel, 0 to 1.
fn errors(width: usize, reference: &[[f64; 3]], test: &[[f64; 3]]) -> Vec<f64> {
    if reference.is_empty() {
        return Vec::new();
    }
    let filters = Filters::new();
    let [reference, test] = [reference, test].map(|pixels| Seen::of(&filters, width, pixels));
    let largest = largest_distance();
    let error = |pixel: usize| {
        let [a, b] = [&reference, &test].map(|picture| picture.colours[pixel]);
        let [one, other] = [&reference, &test].map(|picture| &picture.features[pixel]);
        let colour = colour_error(libm::pow(distance(a, b), COLOUR_POWER), largest);
        let feature = f64::max((one.edge - other.edge).abs(), (one.point - other.point).abs());
        libm::pow(colour, 1.0 - (feature * FRAC_1_SQRT_2).sqrt())
    };
    (0..reference.colours.len()).map(error).collect()
}

/// Maps a colour difference to 0..1; differences above the knee are compressed.
fn colour_error(difference: f64, largest: f64) -> f64 {
    let knee = KNEE_SHARE * largest;
    if difference < knee {
        difference * KNEE_ERROR / knee
    } else {
        KNEE_ERROR + (difference - knee) / (largest - knee) * (1.0 - KNEE_ERROR)
    }
}

/// Colour difference of green and blue, the largest in the gamut.
fn largest_distance() -> f64 {
    let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(hunt_lab);
    libm::pow(distance(green, blue), COLOUR_POWER)
}

/// HyAB distance.
fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let [l, a, b] = [0, 1, 2].map(|index| a[index] - b[index]);
    l.abs() + (a * a + b * b).sqrt()
}

/// CIELAB of linear RGB, with chroma scaled by lightness (Hunt effect).
fn hunt_lab(rgb: [f64; 3]) -> [f64; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let response = |value: f64| {
        if value > DELTA * DELTA * DELTA {
            libm::cbrt(value)
        } else {
            value / (3.0 * DELTA * DELTA) + 4.0 / 29.0
        }
    };
    let [x, y, z] = relative_xyz(rgb).map(response);
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// XYZ relative to white.
fn relative_xyz(rgb: [f64; 3]) -> [f64; 3] {
    let xyz = apply(&TO_XYZ, rgb);
    [0, 1, 2].map(|index| xyz[index] / WHITE[index])
}

/// YCxCz, which is linear in RGB, so that it can be filtered.
fn opponent(rgb: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = relative_xyz(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn opponent_to_rgb([y, cx, cz]: [f64; 3]) -> [f64; 3] {
    let y = (y + 16.0) / 116.0;
    let relative = [y + cx / 500.0, y, y - cz / 200.0];
    apply(&FROM_XYZ, [0, 1, 2].map(|index| relative[index] * WHITE[index]))
}

fn apply(matrix: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// Weights of the one-dimensional filters. All filters are separable.
struct Filters {
    achromatic: Vec<f64>,
    red_green: Vec<f64>,
    /// The sum of the two products is the filter.
    blue_yellow: [Vec<f64>; 2],
    gaussian: Vec<f64>,
    /// First derivative of the Gaussian.
    edge: Vec<f64>,
    /// Second derivative of the Gaussian.
    point: Vec<f64>,
}

impl Filters {
    fn new() -> Self {
        let [achromatic] = sensitivity(ACHROMATIC);
        let [red_green] = sensitivity(RED_GREEN);
        let deviation_px = 0.5 * FEATURE_WIDTH_DEG * PIXELS_PER_DEGREE;
        let at = offsets(3.0 * deviation_px);
        let gaussian = |x: f64| libm::exp(-x * x / (2.0 * deviation_px * deviation_px));
        let edge = |x: f64| -x * gaussian(x);
        let point = |x: f64| (x * x / (deviation_px * deviation_px) - 1.0) * gaussian(x);
        Self {
            achromatic,
            red_green,
            blue_yellow: sensitivity(BLUE_YELLOW),
            gaussian: balanced(at.clone().map(gaussian).collect()),
            edge: balanced(at.clone().map(edge).collect()),
            point: balanced(at.map(point).collect()),
        }
    }
}

/// Whole offsets up to `radius`, rounded up.
fn offsets(radius: f64) -> impl Iterator<Item = f64> + Clone {
    let radius = radius.ceil() as i32;
    (-radius..=radius).map(f64::from)
}

/// One-dimensional factors of a contrast sensitivity filter; the squares of their sums add up to 1.
fn sensitivity<const N: usize>(gaussians: [(f64, f64); N]) -> [Vec<f64>; N] {
    let radius = 3.0 * (LARGEST_SCALE / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE;
    let mut factors = gaussians.map(|(weight, scale)| -> Vec<f64> {
        let weight = (weight * (PI / scale).sqrt()).sqrt();
        let factor = |x: f64| {
            let degrees = x / PIXELS_PER_DEGREE;
            weight * libm::exp(-PI * PI * degrees * degrees / scale)
        };
        offsets(radius).map(factor).collect()
    });
    let sums = factors.each_ref().map(|factor| factor.iter().sum::<f64>());
    let norm = sums.iter().map(|sum| sum * sum).sum::<f64>().sqrt();
    factors.iter_mut().flatten().for_each(|weight| *weight /= norm);
    factors
}

/// Scales the positive weights to a sum of 1, the negative ones to -1.
fn balanced(mut weights: Vec<f64>) -> Vec<f64> {
    let positive: f64 = weights.iter().filter(|weight| **weight > 0.0).sum();
    let negative: f64 = weights.iter().filter(|weight| **weight < 0.0).sum();
    for weight in &mut weights {
        *weight /= if *weight > 0.0 { positive } else { -negative };
    }
    weights
}

/// Picture as the eye resolves it.
struct Seen {
    /// Filtered colours, see [`hunt_lab`].
    colours: Vec<[f64; 3]>,
    features: Vec<Features>,
}

/// Strength of edges and points at a pixel.
struct Features {
    edge: f64,
    point: f64,
}

impl Seen {
    fn of(filters: &Filters, width: usize, pixels: &[[f64; 3]]) -> Self {
        let opponent: Vec<_> = pixels.iter().map(|rgb| opponent(*rgb)).collect();
        let plane = |channel: usize| -> Vec<f64> {
            opponent.iter().map(|colour| colour[channel]).collect()
        };
        let [y, cx, cz] = [0, 1, 2].map(plane);
        let lightness: Vec<f64> = y.iter().map(|y| (y + 16.0) / 116.0).collect();
        let of = |plane: &[f64], across: &[f64], down: &[f64]| {
            filtered_columns(width, &filtered_rows(width, plane, across), down)
        };
        let square = |plane: &[f64], filter: &[f64]| of(plane, filter, filter);
        let [y, cx] = [square(&y, &filters.achromatic), square(&cx, &filters.red_green)];
        let [broad, narrow] = filters.blue_yellow.each_ref().map(|filter| square(&cz, filter));
        let colour = |index: usize| {
            let filtered = [y[index], cx[index], broad[index] + narrow[index]];
            hunt_lab(opponent_to_rgb(filtered).map(|value| value.clamp(0.0, 1.0)))
        };
        let gradient = |filter: &[f64]| -> Vec<f64> {
            let across = of(&lightness, filter, &filters.gaussian);
            let down = of(&lightness, &filters.gaussian, filter);
            across.iter().zip(&down).map(|(x, y)| (x * x + y * y).sqrt()).collect()
        };
        let (edges, points) = (gradient(&filters.edge), gradient(&filters.point));
        let features = edges.into_iter().zip(points).map(|(edge, point)| Features { edge, point });
        Self { colours: (0..pixels.len()).map(colour).collect(), features: features.collect() }
    }
}

/// Correlates each row with the weights. Pixels beyond the border equal the border's.
fn filtered_rows(width: usize, plane: &[f64], weights: &[f64]) -> Vec<f64> {
    let radius = weights.len() / 2;
    let mut out = vec![0.0; plane.len()];
    let mut padded = vec![0.0; width + 2 * radius];
    for (row, out) in plane.chunks_exact(width).zip(out.chunks_exact_mut(width)) {
        padded[..radius].fill(row[0]);
        padded[radius..radius + width].copy_from_slice(row);
        padded[radius + width..].fill(row[width - 1]);
        for (offset, weight) in weights.iter().enumerate() {
            add_scaled(out, &padded[offset..offset + width], *weight);
        }
    }
    out
}

/// Correlates each column with the weights. Pixels beyond the border equal the border's.
fn filtered_columns(width: usize, plane: &[f64], weights: &[f64]) -> Vec<f64> {
    let (radius, height) = (weights.len() / 2, plane.len() / width);
    let mut out = vec![0.0; plane.len()];
    for (y, out) in out.chunks_exact_mut(width).enumerate() {
        for (offset, weight) in weights.iter().enumerate() {
            let from = (y + offset).saturating_sub(radius).min(height - 1) * width;
            add_scaled(out, &plane[from..from + width], *weight);
        }
    }
    out
}

fn add_scaled(out: &mut [f64], row: &[f64], weight: f64) {
    out.iter_mut().zip(row).for_each(|(out, value)| *out += weight * value);
}

#[cfg(test)]
mod tests;
