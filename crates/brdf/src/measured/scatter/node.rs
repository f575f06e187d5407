//! Local polynomial of a sample: passes through the sample's value and fits its neighbours.
//!
//! Owns the least-squares fit and the limits of extrapolation.

use glam::DVec3;

/// Linear and quadratic terms of three coordinates.
const TERMS: usize = 9;
const LINEAR: usize = 3;
/// Ridge added to the diagonal for linear and quadratic terms, relative to the sum of the weights,
/// so that the system has a solution.
const RIDGE: [f64; 2] = [1e-6, 1e-5];
/// Largest number of neighbours for a polynomial without quadratic terms.
const MAX_FOR_LINEAR: usize = 18;
/// Largest number of neighbours for a constant.
const MAX_FOR_CONSTANT: usize = 6;
/// Margin of allowed values beyond the neighbours' range, as a fraction of that range, for a
/// perfect fit.
const MAX_MARGIN: f64 = 0.5;
/// Reduction of the margin per unit of relative fit error.
const MARGIN_LOSS: f64 = 16.0;

/// Local polynomials of the three channels.
pub(super) struct Node {
    value: [f64; 3],
    terms: [[f32; TERMS]; 3],
    /// Largest deviation from `value` that predictions may have, larger for a better fit.
    margin: [f64; 3],
}

/// A neighbouring sample: its offset and its values.
pub(super) struct Neighbour {
    pub(super) offset: DVec3,
    pub(super) value: [f64; 3],
}

impl Node {
    /// Fits the neighbours within `radius`, which must be above 0.
    pub(super) fn fit(value: [f64; 3], neighbours: &[Neighbour], radius: f64) -> Self {
        let mut node = Self { value, terms: [[0.0; TERMS]; 3], margin: [0.0; 3] };
        let terms = match neighbours.len() {
            count if count <= MAX_FOR_CONSTANT => return node,
            count if count <= MAX_FOR_LINEAR => LINEAR,
            _ => TERMS,
        };
        let mut fit = Fit::default();
        for neighbour in neighbours {
            let offset = neighbour.offset / radius;
            fit.add(weight(offset), monomials(offset), difference(neighbour.value, value));
        }
        let lower = fit.decompose(terms);
        for channel in 0..3 {
            let solution = solve(&lower, fit.right[channel], terms);
            for (term, place) in node.terms[channel].iter_mut().enumerate().take(terms) {
                let unit = if term < LINEAR { radius } else { radius * radius };
                *place = nearest(solution[term] / unit);
            }
            node.margin[channel] = node.margin(channel, neighbours, radius);
        }
        node
    }

    /// Predicts the values at an offset from the sample.
    pub(super) fn at(&self, offset: DVec3) -> [f64; 3] {
        let monomials = monomials(offset);
        [0, 1, 2].map(|channel| {
            let terms = self.terms[channel].iter().zip(monomials);
            self.value[channel] + terms.map(|(term, x)| f64::from(*term) * x).sum::<f64>()
        })
    }

    /// Least and largest value of a channel that predictions may have.
    pub(super) fn range(&self, channel: usize) -> (f64, f64) {
        let (value, margin) = (self.value[channel], self.margin[channel]);
        (value - margin, value + margin)
    }

    /// Computes the margin of a channel from the range of the neighbours and the fit's error.
    fn margin(&self, channel: usize, neighbours: &[Neighbour], radius: f64) -> f64 {
        let own = self.value[channel];
        let (mut error, mut spread, mut low, mut high) = (0.0, 0.0, own, own);
        for neighbour in neighbours {
            let weight = weight(neighbour.offset / radius);
            let (predicted, value) = (self.at(neighbour.offset)[channel], neighbour.value[channel]);
            error += weight * (predicted - value) * (predicted - value);
            spread += weight * (value - own) * (value - own);
            (low, high) = (low.min(value), high.max(value));
        }
        if spread <= 0.0 {
            return 0.0;
        }
        let loss = MARGIN_LOSS * (error / spread).sqrt();
        MAX_MARGIN * (high - low) * (1.0 - loss).max(0.0)
    }
}

/// Normal equations of the weighted least-squares fit.
#[derive(Default)]
struct Fit {
    left: [[f64; TERMS]; TERMS],
    right: [[f64; TERMS]; 3],
    weight: f64,
}

impl Fit {
    /// Adds a neighbour with its monomials `x` and its values `y`.
    fn add(&mut self, weight: f64, x: [f64; TERMS], y: [f64; 3]) {
        self.weight += weight;
        for i in 0..TERMS {
            for j in 0..=i {
                self.left[i][j] += weight * x[i] * x[j];
            }
            for (right, y) in self.right.iter_mut().zip(y) {
                right[i] += weight * x[i] * y;
            }
        }
    }

    /// Cholesky factor of the first `terms` terms, with the ridge.
    fn decompose(&self, terms: usize) -> [[f64; TERMS]; TERMS] {
        let mut lower = [[0.0; TERMS]; TERMS];
        for i in 0..terms {
            for j in 0..=i {
                let known: f64 = (0..j).map(|k| lower[i][k] * lower[j][k]).sum();
                let sum = self.left[i][j] - known;
                lower[i][j] = if i == j {
                    let ridge = self.weight * RIDGE[usize::from(i >= LINEAR)];
                    // Rounding errors could exceed the ridge.
                    (sum + ridge).max(0.5 * ridge).max(f64::MIN_POSITIVE).sqrt()
                } else {
                    sum / lower[j][j]
                };
            }
        }
        lower
    }
}

/// Solves the system of a Cholesky factor for the right-hand side `x`.
fn solve(lower: &[[f64; TERMS]; TERMS], mut x: [f64; TERMS], terms: usize) -> [f64; TERMS] {
    for i in 0..terms {
        let known: f64 = (0..i).map(|k| lower[i][k] * x[k]).sum();
        x[i] = (x[i] - known) / lower[i][i];
    }
    for i in (0..terms).rev() {
        let known: f64 = (i + 1..terms).map(|k| lower[k][i] * x[k]).sum();
        x[i] = (x[i] - known) / lower[i][i];
    }
    x
}

/// Weight of a neighbour: falls with the distance to 0 at the radius.
fn weight(offset: DVec3) -> f64 {
    let square = offset.length_squared();
    let left = (1.0 - square.sqrt()).max(0.0);
    left * left / (square + 0.01)
}

/// Linear, then quadratic terms of an offset.
fn monomials(DVec3 { x, y, z }: DVec3) -> [f64; TERMS] {
    [x, y, z, x * x, y * y, z * z, x * y, x * z, y * z]
}

fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[expect(clippy::cast_possible_truncation, reason = "rounded to the nearest f32")]
fn nearest(value: f64) -> f32 {
    value as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn neighbours(count: u32, value: impl Fn(DVec3) -> [f64; 3]) -> Vec<Neighbour> {
        let part = |k: u32, step: f64| (f64::from(k + 1) * step).fract() - 0.5;
        let offset = |k| DVec3::new(part(k, 0.618), part(k, 0.755), part(k, 0.57)) * 0.2;
        (0..count).map(|k| Neighbour { offset: offset(k), value: value(offset(k)) }).collect()
    }

    #[test]
    fn quadratic_is_fitted_with_a_positive_margin() {
        let wanted = |d: DVec3| {
            [1.0 + d.x - 2.0 * d.y, 1.0 + 3.0 * d.x * d.x + d.y * d.z, 1.0 - d.z + 4.0 * d.x * d.y]
        };
        let node = Node::fit([1.0; 3], &neighbours(28, wanted), 0.2);
        for offset in [DVec3::ZERO, DVec3::new(0.05, -0.02, 0.04), DVec3::new(-0.1, 0.1, 0.0)] {
            let off = difference(node.at(offset), wanted(offset));
            assert!(off.iter().all(|off| off.abs() < 1e-3), "{off:?}");
        }
        let (low, high) = node.range(0);
        assert!(low < 0.95 && high > 1.05);
    }

    #[test]
    fn noise_has_no_margin_and_few_neighbours_reduce_the_degree() {
        let noise = |d: DVec3| [(d.x * 1e4).sin(), (d.y * 1e4).sin(), 0.0];
        let node = Node::fit([0.0; 3], &neighbours(28, noise), 0.2);
        assert_eq!(node.range(0), (0.0, 0.0));
        let slope = |d: DVec3| [d.x, d.x * d.x, 2.0];
        let node = Node::fit([0.0, 0.0, 2.0], &neighbours(6, slope), 0.2);
        assert_eq!(node.at(DVec3::X), [0.0, 0.0, 2.0]);
        let node = Node::fit([0.0, 0.0, 2.0], &neighbours(12, slope), 0.2);
        assert!((node.at(DVec3::X * 0.1)[0] - 0.1).abs() < 1e-4);
    }
}
