//! Solver for symmetric positive definite systems by Cholesky decomposition. The order of
//! operations is fixed, so the bits are the same on every machine; linear algebra libraries choose
//! kernels by the processor and do not guarantee that.

use brood_eval::{Level, SimdKernel};

/// Solves A x = b, A being `count` x `count`, row by row; `None` if A is not positive definite.
pub(crate) fn solve(matrix: Vec<f64>, right: &[f64]) -> Option<Vec<f64>> {
    Level::best().run(Solve { matrix, right })
}

/// Returns the diagonal of A^-1; `None` if A is not positive definite.
pub(crate) fn inverse_diagonal(matrix: Vec<f64>, count: usize) -> Option<Vec<f64>> {
    Level::best().run(InverseDiagonal { matrix, count })
}

/// Returns U with U^T U = A, row by row; `None` if A is not positive definite. Entries below the
/// diagonal are undefined.
pub(crate) fn factor(matrix: Vec<f64>, count: usize) -> Option<Vec<f64>> {
    decompose(matrix, count)
}

/// Solves U^T y = x for U of [`factor`].
pub(crate) fn forward(upper: &[f64], mut x: Vec<f64>) -> Vec<f64> {
    forwards(upper, &mut x, 0);
    x
}

/// Solves U y = x for U of [`factor`].
pub(crate) fn backward(upper: &[f64], mut x: Vec<f64>) -> Vec<f64> {
    backwards(upper, &mut x);
    x
}

struct Solve<'a> {
    matrix: Vec<f64>,
    right: &'a [f64],
}

impl SimdKernel for Solve<'_> {
    type Output = Option<Vec<f64>>;

    #[inline(always)]
    fn run(self) -> Option<Vec<f64>> {
        let count = self.right.len();
        let upper = decompose(self.matrix, count)?;
        let mut x = self.right.to_vec();
        forwards(&upper, &mut x, 0);
        backwards(&upper, &mut x);
        Some(x)
    }
}

struct InverseDiagonal {
    matrix: Vec<f64>,
    count: usize,
}

impl SimdKernel for InverseDiagonal {
    type Output = Option<Vec<f64>>;

    #[inline(always)]
    fn run(self) -> Option<Vec<f64>> {
        let count = self.count;
        let upper = decompose(self.matrix, count)?;
        let entry = |row: usize| {
            let mut x = vec![0.0; count];
            x[row] = 1.0;
            forwards(&upper, &mut x, row);
            x[row..].iter().map(|x| x * x).sum()
        };
        Some((0..count).map(entry).collect())
    }
}

/// Returns U with U^T U = A. Each row is the rest of A after elimination of the rows above, divided
/// by the root of its pivot. Entries below the diagonal are those of A.
#[inline(always)]
fn decompose(matrix: Vec<f64>, count: usize) -> Option<Vec<f64>> {
    let mut upper = matrix;
    for row in 0..count {
        let (done, rest) = upper.split_at_mut((row + 1) * count);
        let own = &mut done[row * count..][row..];
        // Also fails if the pivot is NaN.
        if !(own[0] > 0.0 && own[0].is_finite()) {
            return None;
        }
        let pivot = own[0].sqrt();
        for value in &mut *own {
            *value /= pivot;
        }
        for (below, factor) in own.iter().enumerate().skip(1) {
            let other = &mut rest[(below - 1) * count..][row + below..count];
            for (value, own) in other.iter_mut().zip(&own[below..]) {
                *value -= factor * own;
            }
        }
    }
    Some(upper)
}

/// Solves U^T y = x in place; x is 0 before `first`.
#[inline(always)]
fn forwards(upper: &[f64], x: &mut [f64], first: usize) {
    let count = x.len();
    for row in first..count {
        let own = &upper[row * count..][row..count];
        x[row] /= own[0];
        let known = x[row];
        for (x, factor) in x[row + 1..].iter_mut().zip(&own[1..]) {
            *x -= factor * known;
        }
    }
}

/// Solves U y = x in place.
#[inline(always)]
fn backwards(upper: &[f64], x: &mut [f64]) {
    let count = x.len();
    for row in (0..count).rev() {
        let own = &upper[row * count..][row..count];
        let later: f64 = own[1..].iter().zip(&x[row + 1..]).map(|(a, x)| a * x).sum();
        x[row] = (x[row] - later) / own[0];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solve_returns_solution_or_none_when_matrix_is_not_definite() {
        let count = 37;
        let entry =
            |i: usize, j: usize| 1.0 / (1.0 + i as f64 + j as f64) + if i == j { 0.1 } else { 0.0 };
        let matrix: Vec<f64> = (0..count * count).map(|at| entry(at / count, at % count)).collect();
        let right: Vec<f64> = (0..count).map(|k| libm::sin(k as f64)).collect();
        let x = solve(matrix.clone(), &right).unwrap();
        for (row, expected) in right.iter().enumerate() {
            let found: f64 = (0..count).map(|k| matrix[row * count + k] * x[k]).sum();
            assert!((found - expected).abs() < 1e-12);
        }
        let diagonal = inverse_diagonal(matrix.clone(), count).unwrap();
        for (row, found) in diagonal.iter().enumerate() {
            let mut unit = vec![0.0; count];
            unit[row] = 1.0;
            let expected = solve(matrix.clone(), &unit).unwrap()[row];
            assert!((found / expected - 1.0).abs() < 1e-9);
        }
        assert_eq!(solve(vec![1.0, 2.0, 2.0, 1.0], &[1.0, 1.0]), None);
        assert_eq!(solve(vec![f64::NAN], &[1.0]), None);
    }
}
