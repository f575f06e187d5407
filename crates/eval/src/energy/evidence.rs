//! Allowance for what the search may have missed.

/// Relative error of f32 values and of the divided output stage.
const ROUNDING: f64 = 1.0 / (1u64 << 20) as f64;

/// Signs of how much larger than the largest albedo found the maximum may be.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Evidence {
    /// Largest change of the logarithm of the albedo of a start by the finer quadrature of each
    /// stage.
    pub(super) noise: [f64; 2],
    /// Rise of the logarithm of the largest albedo from the best start to the end of the climb.
    pub(super) rise: f64,
    /// Relative gain of the last step, which bounds that of further steps.
    pub(super) gain: f64,
}

impl Evidence {
    /// Returns the relative error bound of the albedo, given its relative change by the last
    /// doubling of the order.
    pub(super) fn error_bound(&self, change: f64, is_program: bool) -> f64 {
        let settled = 2.0 * change + self.gain + ROUNDING;
        if !is_program {
            // Albedos of layers are smooth: errors are those of the last stage's quadrature and of
            // the last steps of the climb.
            return settled + 0.5 * self.noise[1] + RIDGE;
        }
        // Where a finer quadrature or a short climb changes albedos much, the grid may as well have
        // missed a higher peak: docs/maths/energy.md has the counts.
        let missed = 0.8 * self.noise[0] + self.noise[1] + 0.25 * self.rise;
        settled + libm::expm1(missed.min(LARGEST_MISS))
    }
}

/// Relative error of the last steps of the climb along a ridge.
const RIDGE: f64 = 1.0 / 2048.0;
/// Bound of the logarithm of the ratio of a missed peak to the one found.
const LARGEST_MISS: f64 = 5.0;
