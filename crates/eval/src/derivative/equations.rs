//! Normal equations of a least squares step.

/// J^T J and J^T r, with the residuals r of a program against a target and their Jacobian J with
/// respect to the constants of the program.
#[derive(Debug, Clone, PartialEq)]
pub struct NormalEquations {
    /// Number of constants of the program, n.
    pub constants: usize,
    /// J^T J, n x n, symmetric, row by row.
    pub matrix: Vec<f64>,
    /// J^T r, of length n.
    pub gradient: Vec<f64>,
    /// r^T r, the sum of squared residuals.
    pub sum: f64,
}

impl NormalEquations {
    pub(super) fn zero(constants: usize) -> Self {
        let (matrix, gradient) = (vec![0.0; constants * constants], vec![0.0; constants]);
        Self { constants, matrix, gradient, sum: 0.0 }
    }

    pub(super) fn add(&mut self, other: &Self) {
        for (sum, value) in self.matrix.iter_mut().zip(&other.matrix) {
            *sum += value;
        }
        for (sum, value) in self.gradient.iter_mut().zip(&other.gradient) {
            *sum += value;
        }
        self.sum += other.sum;
    }
}
