//! Elementary functions of the models, in two forms: [`Libm`] for the f64 reference and
//! [`Branchless`] for loops that the compiler turns into vector instructions.
//!
//! Formulas are written once, generic over [`Elementary`]. Every product and sum of the branchless
//! form is rounded separately, in the order written, so the bits do not depend on the vector width.
//! Independent of models.

mod angle;
mod erfc;
mod exponential;
mod polynomial;
#[cfg(test)]
mod tests;

/// Elementary functions of f64.
pub trait Elementary {
    /// e^x.
    ///
    /// # Domain
    /// Any x; infinite above 709.78, NaN for NaN.
    fn exp(x: f64) -> f64;

    /// Natural logarithm of x.
    ///
    /// # Domain
    /// Any x; minus infinity at 0, NaN below 0.
    fn ln(x: f64) -> f64;

    /// x^y for x >= 0.
    ///
    /// # Domain
    /// Returns 1 if y is 0, also for x = 0 and x = infinity.
    fn pow(x: f64, y: f64) -> f64;

    /// Angle with cosine x.
    ///
    /// # Units
    /// Radians.
    ///
    /// # Domain
    /// x in [0, 1].
    fn acos(x: f64) -> f64;

    /// Angle in the first quadrant with this sine and cosine.
    ///
    /// # Units
    /// Radians.
    ///
    /// # Domain
    /// Both at least 0, with squares that add up to 1.
    fn angle(sin: f64, cos: f64) -> f64;

    /// Error function.
    ///
    /// # Domain
    /// x in [0, 6].
    fn erf(x: f64) -> f64;
}

/// Functions of the `libm` crate, accurate to about one unit in the last place.
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

/// Branch-free functions: sums, products, quotients, roots, comparisons and bit operations only.
///
/// # Error
/// Against `libm`: exp, ln and acos within 2 units in the last place; pow within 3 + 3 |y ln x| of
/// them; angle 8e-16 relative; erf 6e-16 absolute (`elementary/tests.rs`).
#[derive(Debug, Clone, Copy)]
pub struct Branchless;

macro_rules! call {
    ($($name:ident($($x:ident),+) = $function:path;)+) => {$(
        #[inline(always)]
        fn $name($($x: f64),+) -> f64 {
            $function($($x),+)
        }
    )+};
}

impl Elementary for Branchless {
    call! {
        exp(x) = exponential::exp;
        ln(x) = exponential::ln;
        pow(x, y) = exponential::pow;
        acos(x) = angle::acos;
        angle(sin, cos) = angle::angle;
        erf(x) = erfc::erf;
    }
}
