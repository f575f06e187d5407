//! Least squares with coefficients of at least 0.
//!
//! Source: Lawson and Hanson 1974, Solving Least Squares Problems, chapter 23, on the normal
//! equations.

/// Part of the diagonal that is added to it, so that equal columns do no harm.
const RIDGE: f64 = 1e-9;
/// Gradient below which a coefficient stays 0, relative to the largest.
const FLAT: f64 = 1e-9;

/// Normal equations of a weighted problem: A^T W A, symmetric by rows, and A^T W b.
pub(super) struct Normal {
    pub(super) matrix: Vec<f64>,
    pub(super) right: Vec<f64>,
}

impl Normal {
    /// Sums up rows of `size` values: values, right side, weight.
    pub(super) fn of<'a>(size: usize, rows: impl Iterator<Item = (&'a [f64], f64, f64)>) -> Self {
        let mut normal = Self { matrix: vec![0.0; size * size], right: vec![0.0; size] };
        for (values, right, weight) in rows {
            for (place, value) in values.iter().enumerate() {
                let weighted = weight * value;
                normal.right[place] += weighted * right;
                let row = &mut normal.matrix[place * size..][..=place];
                row.iter_mut().zip(values).for_each(|(sum, value)| *sum += weighted * value);
            }
        }
        for row in 0..size {
            normal.matrix[row * size + row] *= 1.0 + RIDGE;
            for column in 0..row {
                normal.matrix[column * size + row] = normal.matrix[row * size + column];
            }
        }
        normal
    }

    /// Coefficients of at least 0 with the least weighted sum of squares.
    pub(super) fn solve(&self) -> Vec<f64> {
        let size = self.right.len();
        let mut found = vec![0.0; size];
        let mut free: Vec<usize> = Vec::new();
        let largest = self.right.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        // Each step frees one more; three times their number is the limit that the source gives.
        for _ in 0..3 * size {
            let gradient = |k: usize| {
                let row = &self.matrix[k * size..][..size];
                self.right[k] - row.iter().zip(&found).map(|(a, x)| a * x).sum::<f64>()
            };
            let next = (0..size)
                .filter(|k| !free.contains(k) && self.matrix[k * size + k] > 0.0)
                .map(|k| (k, gradient(k)))
                .max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((next, slope)) = next else { break };
            if slope <= FLAT * largest {
                break;
            }
            free.push(next);
            self.descend(&mut found, &mut free);
        }
        found
    }

    /// Moves to the least sum of the free coefficients; those that reach 0 are fixed.
    fn descend(&self, found: &mut [f64], free: &mut Vec<usize>) {
        while !free.is_empty() {
            let wanted = self.unbounded(free);
            let step = free
                .iter()
                .zip(&wanted)
                .filter(|(_, wanted)| **wanted <= 0.0)
                .map(|(k, wanted)| found[*k] / (found[*k] - wanted).max(f64::MIN_POSITIVE))
                .fold(1.0_f64, f64::min);
            for (k, wanted) in free.iter().zip(&wanted) {
                found[*k] += step * (wanted - found[*k]);
            }
            if wanted.iter().all(|wanted| *wanted > 0.0) {
                return;
            }
            let before = free.len();
            let is_zero = |k: usize, wanted: f64| wanted <= 0.0 && found[k] <= 1e-12 * wanted.abs();
            let zeros: Vec<usize> = free
                .iter()
                .zip(&wanted)
                .filter(|(k, wanted)| is_zero(**k, **wanted))
                .map(|(k, _)| *k)
                .collect();
            free.retain(|k| !zeros.contains(k));
            zeros.iter().for_each(|k| found[*k] = 0.0);
            if free.len() == before {
                return;
            }
        }
    }

    /// Coefficients of the least sum without bounds, of some; the others are 0. By Cholesky.
    fn unbounded(&self, free: &[usize]) -> Vec<f64> {
        let (size, count) = (self.right.len(), free.len());
        let mut lower = vec![0.0; count * count];
        for row in 0..count {
            for column in 0..=row {
                let known: f64 =
                    (0..column).map(|k| lower[row * count + k] * lower[column * count + k]).sum();
                let rest = self.matrix[free[row] * size + free[column]] - known;
                lower[row * count + column] = match row == column {
                    true => rest.max(f64::MIN_POSITIVE).sqrt(),
                    false => rest / lower[column * count + column],
                };
            }
        }
        let mut found: Vec<f64> = free.iter().map(|k| self.right[*k]).collect();
        for row in 0..count {
            let known: f64 = (0..row).map(|k| lower[row * count + k] * found[k]).sum();
            found[row] = (found[row] - known) / lower[row * count + row];
        }
        for row in (0..count).rev() {
            let known: f64 = (row + 1..count).map(|k| lower[k * count + row] * found[k]).sum();
            found[row] = (found[row] - known) / lower[row * count + row];
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solved(rows: &[([f64; 3], f64)]) -> Vec<f64> {
        Normal::of(3, rows.iter().map(|(values, right)| (&values[..], *right, 1.0))).solve()
    }

    #[test]
    fn coefficients_above_zero_are_found_exactly() {
        let wanted = [0.5, 2.0, 0.25];
        let rows = [[1.0, 0.2, 0.0], [0.3, 1.0, 0.5], [0.0, 0.4, 1.0], [1.0, 1.0, 1.0]]
            .map(|row| (row, row.iter().zip(wanted).map(|(a, x)| a * x).sum()));
        let found = solved(&rows);
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
    }

    #[test]
    fn gradient_of_coefficients_at_zero_points_below_zero() {
        let rows = [
            ([1.0, 0.9, 0.1], 1.0),
            ([0.8, 1.0, 0.3], 0.2),
            ([0.1, 0.7, 1.0], -0.4),
            ([0.5, 0.5, 0.5], 0.6),
        ];
        let normal = Normal::of(3, rows.iter().map(|(values, right)| (&values[..], *right, 1.0)));
        let found = normal.solve();
        for k in 0..3 {
            let product: f64 = (0..3).map(|j| normal.matrix[3 * k + j] * found[j]).sum();
            let slope = normal.right[k] - product;
            assert!(found[k] >= 0.0 && slope < 1e-6, "{found:?}: {slope} of {k}");
            assert!(found[k] == 0.0 || slope.abs() < 1e-6, "{found:?}: {slope} of {k}");
        }
        assert!(found.contains(&0.0), "{found:?}");
    }
}
