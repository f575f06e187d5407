//! Random starting points of fits, drawn so that refinement often succeeds.

use brood_brdf::Input;
use brood_genome::Stream;
use brood_genome::lobes::Shape;

use super::Lobes;
use super::block::Point;

/// Standard deviation of the weights of terms.
const SPREAD: f64 = 0.15;
/// The terms after the first get up to this negative weight on each unit of the half angle, so that
/// they fall off from the mirror direction.
const FALL: f64 = 1.5;
/// Number of samples that colours are fitted to.
const ENOUGH: usize = 512;

/// Draws a start. A unit is flat on one side of a bend and linear on the other. Half of the units
/// bend along ln tan theta_h at positions over its whole range, the others along one random input
/// each. The first term is diffuse, the others fall off from the mirror direction. Colours are
/// fitted.
pub(super) fn start(shape: &Shape, points: &[Point], stream: &mut Stream) -> Lobes {
    let mut lobes = Lobes::new(shape.clone());
    let ranges: Vec<(f64, f64)> = (0..shape.inputs.len()).map(|at| range(points, at)).collect();
    let half = shape.inputs.iter().position(|input| *input == Input::LogTanHalf);
    let bends = |unit: usize| unit < shape.units.div_ceil(2);
    for unit in 0..shape.units {
        let drawn = stream.below(shape.inputs.len() as u32) as usize;
        let input = half.filter(|_| bends(unit)).unwrap_or(drawn);
        let (low, high) = ranges[input];
        let slope = if bends(unit) && half.is_some() {
            1.0 + 0.2 * bell(stream)
        } else {
            // The argument changes by 4 to 12 over the range of the input.
            8.0 / (high - low).max(1e-3) * (0.5 + unit_interval(stream))
        };
        let place = low + (high - low) * unit_interval(stream);
        lobes.parameters[shape.unit(unit, input)] = slope;
        lobes.parameters[shape.unit(unit, shape.inputs.len())] = -slope * place;
    }
    for term in 0..shape.terms {
        for feature in 0..shape.features() - 1 {
            // Smaller weights for inputs with a wide range, so that the exponential stays in
            // bounds.
            let scale = match feature.checked_sub(shape.units) {
                Some(input) => 1.0f64.min(4.0 / (ranges[input].1 - ranges[input].0).max(1e-3)),
                None => 1.0,
            };
            let fall = if term > 0 && bends(feature) { FALL * unit_interval(stream) } else { 0.0 };
            lobes.parameters[shape.term(term, feature)] = SPREAD * scale * bell(stream) - fall;
        }
    }
    colour(&mut lobes, points);
    lobes
}

fn bell(stream: &mut Stream) -> f64 {
    f64::from(stream.bell())
}

fn unit_interval(stream: &mut Stream) -> f64 {
    f64::from(stream.unit())
}

fn range(points: &[Point], input: usize) -> (f64, f64) {
    let of = |point: &Point| f64::from(point.inputs[input]);
    let low = points.iter().map(of).fold(f64::INFINITY, f64::min);
    (low, points.iter().map(of).fold(f64::NEG_INFINITY, f64::max))
}

/// Fits the colours by non-negative linear least squares to S, the square root of the target f,
/// with more weight on small values.
pub(super) fn colour(lobes: &mut Lobes, points: &[Point]) {
    let terms = lobes.shape.terms;
    let points: Vec<&Point> = points.iter().step_by(points.len().div_ceil(ENOUGH)).collect();
    let rows: Vec<Vec<f64>> = points.iter().map(|point| exponentials(lobes, point)).collect();
    for channel in 0..3 {
        let (mut matrix, mut right) = (vec![0.0; terms * terms], vec![0.0; terms]);
        for (point, row) in points.iter().zip(&rows) {
            let f = libm::expm1(f64::from(point.target[channel])) / f64::from(point.weight);
            let target = f.max(0.0).sqrt();
            let counts = 1.0 / (target + 0.05);
            for (a, first) in row.iter().enumerate() {
                right[a] += counts * first * target;
                for (b, second) in row.iter().enumerate() {
                    matrix[a * terms + b] += counts * first * second;
                }
            }
        }
        let factors = non_negative(&matrix, &right);
        for (term, factor) in factors.iter().enumerate() {
            // Above 0, so that the factor can grow again.
            lobes.parameters[lobes.shape.colour(term, channel)] =
                libm::log2(factor.max(1e-4)).min(15.0);
        }
    }
}

/// Values of the terms, in f64.
fn exponentials(lobes: &Lobes, point: &Point) -> Vec<f64> {
    let (shape, parameters) = (&lobes.shape, &lobes.parameters);
    let inputs = || point.inputs.iter().map(|value| f64::from(*value));
    let unit = |unit: usize| {
        let sum: f64 =
            inputs().enumerate().map(|(at, x)| parameters[shape.unit(unit, at)] * x).sum();
        let argument = sum + parameters[shape.unit(unit, shape.inputs.len())];
        argument.max(0.0) + libm::log1p(libm::exp2(-argument.abs())) / std::f64::consts::LN_2
    };
    let features: Vec<f64> = (0..shape.units).map(unit).chain(inputs()).collect();
    let term = |term: usize| {
        let products =
            features.iter().enumerate().map(|(at, x)| parameters[shape.term(term, at)] * x);
        libm::exp2(products.sum::<f64>().clamp(-24.0, 16.0))
    };
    (0..shape.terms).map(term).collect()
}

/// Returns x >= 0 that minimises x A x / 2 - b x, by coordinate descent.
fn non_negative(matrix: &[f64], right: &[f64]) -> Vec<f64> {
    let count = right.len();
    let mut x = vec![0.0; count];
    for _ in 0..200 {
        for k in 0..count {
            let row = &matrix[k * count..][..count];
            let others: f64 = row.iter().zip(&x).map(|(a, x)| a * x).sum::<f64>() - row[k] * x[k];
            x[k] = if row[k] > 0.0 { ((right[k] - others) / row[k]).max(0.0) } else { 0.0 };
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn non_negative_solution_clamps_negative_coordinates() {
        let x = non_negative(&[2.0, 1.0, 1.0, 3.0], &[4.0, 7.0]);
        assert!((x[0] - 1.0).abs() < 1e-9 && (x[1] - 2.0).abs() < 1e-9);
        let x = non_negative(&[1.0, 0.5, 0.5, 1.0], &[-1.0, 1.0]);
        assert_eq!(x, [0.0, 1.0]);
    }
}
