//! The elementary functions that models take, in two forms: [`Libm`], which the reference is made of, and [`Branchless`],
//! loops over which become vector instructions.
//!
//! Formulas are written once, over either. Every product and sum of the branchless form rounds on its own, in the order
//! written, so that its bits do not depend on the width of the vectors. It refuses to know models.

mod angle;
mod erfc;
mod exponential;
#[cfg(test)]
mod tests;

/// Elementary functions of f64.
pub trait Elementary {
    /// e^x.
    ///
    /// # Domain
    /// All; infinite above 709.78, NaN of NaN.
    fn exp(x: f64) -> f64;

    /// The natural logarithm.
    ///
    /// # Domain
    /// All; minus infinity at 0, NaN below 0.
    fn ln(x: f64) -> f64;

    /// x^y for x >= 0.
    ///
    /// # Domain
    /// 1 where y is 0, also of x = 0 and infinity.
    fn pow(x: f64, y: f64) -> f64;

    /// The angle whose cosine is x.
    ///
    /// # Units
    /// Radians.
    ///
    /// # Domain
    /// 0 to 1.
    fn acos(x: f64) -> f64;

    /// The angle of the first quadrant with that sine and cosine.
    ///
    /// # Units
    /// Radians.
    ///
    /// # Domain
    /// Neither below 0; their squares add up to 1.
    fn angle(sin: f64, cos: f64) -> f64;

    /// The error function.
    ///
    /// # Domain
    /// 0 to 6.
    fn erf(x: f64) -> f64;
}

/// As the `libm` crate has them: right to about one unit of the last place.
#[derive(Debug, Clone, Copy)]
pub struct Libm;

impl Elementary for Libm {
    fn exp(x: f64) -> f64 {
        libm::exp(x)
    }

    fn ln(x: f64) -> f64 {
        libm::log(x)
    }

    fn pow(x: f64, y: f64) -> f64 {
        libm::pow(x, y)
    }

    fn acos(x: f64) -> f64 {
        libm::acos(x)
    }

    fn angle(sin: f64, cos: f64) -> f64 {
        libm::atan2(sin, cos)
    }

    fn erf(x: f64) -> f64 {
        libm::erf(x)
    }
}

/// Sums, products, quotients, roots, comparisons and operations on bits, and no branch.
///
/// # Error
/// Against `libm`: exp, ln and acos 2 units of the last place; pow 3 + 3 |y ln x| of them; angle 8e-16 relative; erf 6e-16
/// absolute (`elementary/tests.rs`).
#[derive(Debug, Clone, Copy)]
pub struct Branchless;

impl Elementary for Branchless {
    #[inline(always)]
    fn exp(x: f64) -> f64 {
        exponential::exp(x)
    }

    #[inline(always)]
    fn ln(x: f64) -> f64 {
        exponential::ln(x)
    }

    #[inline(always)]
    fn pow(x: f64, y: f64) -> f64 {
        exponential::pow(x, y)
    }

    #[inline(always)]
    fn acos(x: f64) -> f64 {
        angle::acos(x)
    }

    #[inline(always)]
    fn angle(sin: f64, cos: f64) -> f64 {
        angle::angle(sin, cos)
    }

    #[inline(always)]
    fn erf(x: f64) -> f64 {
        erfc::erf(x)
    }
}

/// The polynomial with these coefficients, that of the highest power last.
#[inline(always)]
fn polynomial<const N: usize>(x: f64, coefficients: [f64; N]) -> f64 {
    let mut sum = coefficients[N - 1];
    let mut k = N - 1;
    while k > 0 {
        k -= 1;
        sum = sum * x + coefficients[k];
    }
    sum
}
