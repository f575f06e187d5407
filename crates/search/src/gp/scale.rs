//! Least-squares scale and offset of a channel, so that a program whose results need only be scaled
//! and shifted is not lost.

/// Number of Gauss-Newton steps from the weighted start.
const STEPS: usize = 3;
/// Largest number of halvings of a step that increases the error.
const HALVINGS: usize = 2;

/// Target values of a channel.
pub(super) struct Observed {
    /// cos_i.
    q: Vec<f64>,
    /// f cos_i.
    y: Vec<f64>,
    /// ln(1 + f cos_i).
    target: Vec<f64>,
    /// True where f may be larger.
    is_bound: Vec<bool>,
}

impl Observed {
    /// # Shapes
    /// cos_i, the target f cos_i, and true where it is a lower bound: all of the same length.
    pub(super) fn new(q: Vec<f64>, y: Vec<f64>, is_bound: Vec<bool>) -> Self {
        Self { q, target: y.iter().map(|y| libm::log1p(*y)).collect(), y, is_bound }
    }
}

/// Returns a, b >= 0 with a small sum of (ln(1 + a p_k + b q_k) - ln(1 + y_k))^2. A term whose y is
/// a lower bound counts only where a p_k + b q_k is below y. Starts from non-negative least squares
/// weighted by 1 / (1 + y)^2, then takes damped Gauss-Newton steps while the sum falls. Never worse
/// than `start`.
///
/// # Shapes
/// p, the f cos_i of the program, has the length of the observed values.
///
/// # Domain
/// Finite, non-negative.
pub(super) fn scale_and_offset(p: &[f64], observed: &Observed, start: [f64; 2]) -> [f64; 2] {
    let problem = Problem { p, observed };
    let start = (problem.error(start), start);
    let mut best = problem.improved(problem.weighted());
    if start.0 <= best.0 {
        best = problem.improved(start.1);
    }
    if best.0 < start.0 { best.1 } else { start.1 }
}

struct Problem<'a> {
    p: &'a [f64],
    observed: &'a Observed,
}

impl Problem<'_> {
    /// p, q, target and if that is a lower bound.
    fn rows(&self) -> impl Iterator<Item = (f64, f64, f64, bool)> {
        let Observed { q, target, is_bound, .. } = self.observed;
        let all = self.p.iter().zip(q).zip(target.iter().zip(is_bound));
        all.map(|((p, q), (target, is_bound))| (*p, *q, *target, *is_bound))
    }

    fn error(&self, [a, b]: [f64; 2]) -> f64 {
        let off = |(p, q, target, is_bound): (f64, f64, f64, bool)| {
            let off = libm::log1p(a * p + b * q) - target;
            if is_bound { off.min(0.0) } else { off }
        };
        self.rows().map(off).map(|off| off * off).sum()
    }

    /// Solution with the logarithm linearised about each target value y: least squares with weights
    /// 1 / (1 + y)^2.
    fn weighted(&self) -> [f64; 2] {
        let mut sums = Sums::default();
        for ((p, q), y) in self.p.iter().zip(&self.observed.q).zip(&self.observed.y) {
            let weight = 1.0 / (1.0 + y);
            sums.add(p * weight, q * weight, y * weight);
        }
        sums.solve()
    }

    /// Damped Gauss-Newton steps from a point, while the error falls; returns error and point.
    fn improved(&self, from: [f64; 2]) -> (f64, [f64; 2]) {
        let mut best = (self.error(from), from);
        for _ in 0..STEPS {
            let [a, b] = best.1;
            let mut sums = Sums::default();
            for (p, q, target, is_bound) in self.rows() {
                let value = a * p + b * q;
                if is_bound && libm::log1p(value) >= target {
                    continue;
                }
                let slope = 1.0 / (1.0 + value);
                // Target of the linearisation about the current (a, b).
                let aim = target - libm::log1p(value) + slope * value;
                sums.add(p * slope, q * slope, aim);
            }
            let mut next = sums.solve();
            let mut found = self.error(next);
            for _ in 0..HALVINGS {
                if found < best.0 {
                    break;
                }
                next = [0, 1].map(|k| 0.5 * (next[k] + best.1[k]));
                found = self.error(next);
            }
            if found.is_nan() || found >= best.0 {
                break;
            }
            best = (found, next);
        }
        best
    }
}

/// Normal equations of two unknowns.
#[derive(Default)]
struct Sums {
    pp: f64,
    pq: f64,
    qq: f64,
    py: f64,
    qy: f64,
}

impl Sums {
    fn add(&mut self, p: f64, q: f64, y: f64) {
        self.pp += p * p;
        self.pq += p * q;
        self.qq += q * q;
        self.py += p * y;
        self.qy += q * y;
    }

    /// Non-negative solution: the unconstrained one if it is non-negative, otherwise the better of
    /// the two with one unknown.
    fn solve(&self) -> [f64; 2] {
        let Self { pp, pq, qq, py, qy } = *self;
        let determinant = pp * qq - pq * pq;
        if determinant > 1e-12 * pp * qq {
            let (a, b) = ((py * qq - qy * pq) / determinant, (qy * pp - py * pq) / determinant);
            if a >= 0.0 && b >= 0.0 {
                return [a, b];
            }
        }
        let ratio =
            |above: f64, below: f64| if below > 0.0 { (above / below).max(0.0) } else { 0.0 };
        let (a, b) = (ratio(py, pp), ratio(qy, qq));
        // Compares the reductions of the sum of squares by each unknown alone.
        if a * py >= b * qy { [a, 0.0] } else { [0.0, b] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows() -> [Vec<f64>; 2] {
        let p = (0..60).map(|k| f64::from(k * k) * 0.01).collect();
        [p, (0..60).map(|k| 1.0 - f64::from(k) / 80.0).collect()]
    }

    #[test]
    fn scale_and_offset_are_recovered() {
        let [p, q] = rows();
        for (a, b) in [(0.3, 2.0), (25.0, 0.0), (0.0, 0.4), (1e-3, 1e3)] {
            let y: Vec<f64> = p.iter().zip(&q).map(|(p, q)| a * p + b * q).collect();
            let is_bound = vec![false; p.len()];
            let found = scale_and_offset(&p, &Observed::new(q.clone(), y, is_bound), [1.0, 0.0]);
            assert!((found[0] - a).abs() < 1e-6 * (1.0 + a), "{found:?} for {a}, {b}");
            assert!((found[1] - b).abs() < 1e-6 * (1.0 + b), "{found:?} for {a}, {b}");
        }
    }

    #[test]
    fn scale_and_offset_are_never_worse_than_the_start() {
        let [p, q] = rows();
        let y: Vec<f64> = p.iter().map(|p| 1.0 / (1.0 + p)).collect();
        let is_bound = (0..p.len()).map(|k| k % 3 == 0).collect();
        let observed = Observed::new(q, y, is_bound);
        let problem = Problem { p: &p, observed: &observed };
        for start in [[1.0, 0.0], [0.0, 0.0], [0.0, 0.5], [3.0, 4.0]] {
            let found = scale_and_offset(&p, &observed, start);
            assert!(problem.error(found) <= problem.error(start));
            assert!(found.iter().all(|value| *value >= 0.0));
        }
    }
}
