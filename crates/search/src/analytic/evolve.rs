//! CMA-ES: an evolution strategy with covariance adaptation. It needs no derivatives and can leave
//! local minima in which Levenberg-Marquardt steps end.

use brood_genome::Stream;

use crate::solve::factor;

/// A sample of a generation: its penalised value, the normal draw z, and y = L z, which the step
/// size scales to the step from the mean. L is the Cholesky factor of the covariance.
type Drawn = (f64, Vec<f64>, Vec<f64>);

/// Stops once the largest standard deviation, as a share of the bounds' width, is below this.
const SHORTEST: f64 = 1e-7;

/// Start point, bounds and budget.
pub(super) struct Start<'a> {
    pub(super) x: &'a [f64],
    pub(super) bounds: &'a [(f64, f64)],
    /// Initial step size, as a share of the bounds' width.
    pub(super) sigma: f64,
    pub(super) generations: usize,
}

/// Minimises `objective`, and returns the best point with its value.
///
/// Coordinates are shares of their bounds. A draw outside of them is evaluated at the nearest point
/// inside, with a penalty. Names are those of the tutorial: `mu` is mu_eff, `ds` the damping of
/// sigma, `is_steady` h_sigma, `path` and `path_s` the evolution paths.
///
/// # Source
/// Hansen, *The CMA Evolution Strategy: A Tutorial* (2016), with Cholesky's factor in place of the
/// root of the covariance (Suttorp, Hansen and Igel, *Efficient covariance matrix update for
/// variable metric evolution strategies*, 2009).
pub(super) fn evolve(
    start: &Start<'_>,
    stream: &mut Stream,
    mut objective: impl FnMut(&[f64]) -> f64,
) -> (Vec<f64>, f64) {
    let count = start.x.len();
    let n = count as f64;
    let offspring = 4 + (3.0 * libm::log(n)) as usize;
    let parents = offspring / 2;
    let raw: Vec<f64> =
        (0..parents).map(|k| libm::log(parents as f64 + 0.5) - libm::log(k as f64 + 1.0)).collect();
    let all: f64 = raw.iter().sum();
    let weights: Vec<f64> = raw.iter().map(|w| w / all).collect();
    let mu = 1.0 / weights.iter().map(|w| w * w).sum::<f64>();
    let cc = (4.0 + mu / n) / (n + 4.0 + 2.0 * mu / n);
    let cs = (mu + 2.0) / (n + mu + 5.0);
    let c1 = 2.0 / ((n + 1.3) * (n + 1.3) + mu);
    let cmu = (1.0 - c1).min(2.0 * (mu - 2.0 + 1.0 / mu) / ((n + 2.0) * (n + 2.0) + mu));
    let ds = 1.0 + 2.0 * (((mu - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0) + cs;
    let expected = n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n));

    let share = |x: f64, (low, high): (f64, f64)| (x - low) / (high - low);
    let mut mean: Vec<f64> = start.x.iter().zip(start.bounds).map(|(x, b)| share(*x, *b)).collect();
    let mut sigma = start.sigma;
    let (mut covariance, mut lower) = (identity(count), identity(count));
    let (mut path, mut path_s) = (vec![0.0; count], vec![0.0; count]);
    let place = |shares: &[f64]| -> Vec<f64> {
        let of =
            |(share, (low, high)): (&f64, &(f64, f64))| low + (high - low) * share.clamp(0.0, 1.0);
        shares.iter().zip(start.bounds).map(of).collect()
    };
    let mut best = (start.x.to_vec(), objective(start.x));
    for generation in 0..start.generations {
        let mut drawn: Vec<Drawn> = (0..offspring)
            .map(|_| {
                let z: Vec<f64> = (0..count).map(|_| f64::from(stream.bell())).collect();
                let y = times(&lower, &z);
                let shares: Vec<f64> = mean.iter().zip(&y).map(|(m, y)| m + sigma * y).collect();
                let outside: f64 =
                    shares.iter().map(|s| (s - s.clamp(0.0, 1.0)) * (s - s.clamp(0.0, 1.0))).sum();
                let x = place(&shares);
                let value = objective(&x);
                if value < best.1 {
                    best = (x, value);
                }
                (value * (1.0 + outside), z, y)
            })
            .collect();
        drawn.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mixed = |part: fn(&Drawn) -> &Vec<f64>| -> Vec<f64> {
            (0..count)
                .map(|k| weights.iter().zip(&drawn).map(|(w, d)| w * part(d)[k]).sum())
                .collect()
        };
        let (z, y) = (mixed(|d| &d.1), mixed(|d| &d.2));
        for (mean, y) in mean.iter_mut().zip(&y) {
            *mean += sigma * y;
        }
        let push = (cs * (2.0 - cs) * mu).sqrt();
        for (path, z) in path_s.iter_mut().zip(&z) {
            *path = (1.0 - cs) * *path + push * z;
        }
        let length = path_s.iter().map(|p| p * p).sum::<f64>().sqrt();
        let faded = 1.0 - libm::pow(1.0 - cs, 2.0 * (generation as f64 + 1.0));
        let is_steady = length / faded.sqrt() < (1.4 + 2.0 / (n + 1.0)) * expected;
        let push = if is_steady { (cc * (2.0 - cc) * mu).sqrt() } else { 0.0 };
        for (path, y) in path.iter_mut().zip(&y) {
            *path = (1.0 - cc) * *path + push * y;
        }
        let lost = if is_steady { 0.0 } else { c1 * cc * (2.0 - cc) };
        for a in 0..count {
            for b in 0..count {
                let ranked: f64 =
                    weights.iter().zip(&drawn).map(|(w, d)| w * d.2[a] * d.2[b]).sum();
                let own = &mut covariance[a * count + b];
                *own = (1.0 - c1 - cmu + lost) * *own + c1 * path[a] * path[b] + cmu * ranked;
            }
        }
        sigma *= libm::exp((cs / ds) * (length / expected - 1.0)).clamp(0.2, 5.0);
        let Some(upper) = factor(covariance.clone(), count) else { break };
        lower = transposed(&upper, count);
        let widest = (0..count).map(|k| covariance[k * count + k]).fold(0.0, f64::max).sqrt();
        let is_wide = sigma * widest > SHORTEST;
        if !is_wide {
            break;
        }
    }
    best
}

fn identity(count: usize) -> Vec<f64> {
    (0..count * count).map(|at| f64::from(u8::from(at / count == at % count))).collect()
}

/// Returns the transpose of an upper triangular matrix, with zeros above the diagonal.
fn transposed(upper: &[f64], count: usize) -> Vec<f64> {
    let of = |at: usize| {
        let (row, column) = (at / count, at % count);
        if column <= row { upper[column * count + row] } else { 0.0 }
    };
    (0..count * count).map(of).collect()
}

/// Product of a lower triangular matrix and a vector.
fn times(lower: &[f64], z: &[f64]) -> Vec<f64> {
    let count = z.len();
    (0..count).map(|row| (0..=row).map(|k| lower[row * count + k] * z[k]).sum()).collect()
}

#[cfg(test)]
mod tests {
    use brood_genome::{BirthKey, Operator};

    use super::*;

    #[test]
    fn evolve_finds_the_minimum_of_a_curved_valley() {
        let mut stream = Stream::new(BirthKey { seed: 3, slot: 0, attempt: 0 }, Operator::Analytic);
        let start =
            Start { x: &[-1.2, 1.0], bounds: &[(-3.0, 3.0); 2], sigma: 0.1, generations: 400 };
        let rosenbrock = |x: &[f64]| {
            let (a, b) = (1.0 - x[0], x[1] - x[0] * x[0]);
            a * a + 100.0 * b * b
        };
        let (x, value) = evolve(&start, &mut stream, rosenbrock);
        assert!(value < 1e-8, "{x:?} {value}");
    }

    #[test]
    fn evolve_finds_a_minimum_at_a_corner() {
        let mut stream = Stream::new(BirthKey { seed: 4, slot: 0, attempt: 0 }, Operator::Analytic);
        let start = Start { x: &[0.5; 5], bounds: &[(0.0, 1.0); 5], sigma: 0.3, generations: 300 };
        let (x, _) = evolve(&start, &mut stream, |x| x.iter().map(|x| x * x).sum::<f64>() + 1.0);
        assert!(x.iter().all(|x| *x < 1e-3), "{x:?}");
    }
}
