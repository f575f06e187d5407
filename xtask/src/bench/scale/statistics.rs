//! Order statistics and least squares.

/// Lower quartile, median and upper quartile, by nearest rank; NaN for no values.
pub fn quartiles(values: &[f64]) -> [f64; 3] {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rank = |quarters: usize| {
        let rank = (quarters * sorted.len()).div_ceil(4).max(1);
        sorted.get(rank - 1).copied().unwrap_or(f64::NAN)
    };
    [rank(1), rank(2), rank(3)]
}

/// Line of least squares through points: a fixed part, and a part for each unit of x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Value at x = 0.
    pub fixed: f64,
    /// Growth for each unit of x.
    pub each: f64,
    /// Largest difference of a point from the line, relative to the point.
    pub error: f64,
}

impl Line {
    /// Fits a line, weighting points by the inverse of their squared values, so that relative
    /// differences are least. Leaves out points whose value is not positive: too little was
    /// measured.
    pub fn fit(points: &[(f64, f64)]) -> Self {
        let points: Vec<(f64, f64)> = points.iter().copied().filter(|(_, y)| *y > 0.0).collect();
        if points.is_empty() {
            return Self { fixed: 0.0, each: 0.0, error: 0.0 };
        }
        let weigh = |of: fn(f64, f64) -> f64| -> f64 {
            points.iter().map(|(x, y)| of(*x, *y) / (y * y)).sum()
        };
        let (w, x, y) = (weigh(|_, _| 1.0), weigh(|x, _| x), weigh(|_, y| y));
        let (xx, xy) = (weigh(|x, _| x * x), weigh(|x, y| x * y));
        let spread = w * xx - x * x;
        let each = if spread > 0.0 { (w * xy - x * y) / spread } else { 0.0 };
        let fixed = (y - each * x) / w;
        let difference = |(x, y): &(f64, f64)| ((fixed + each * x) / y - 1.0).abs();
        let error = points.iter().map(difference).fold(0.0, f64::max);
        Self { fixed, each, error }
    }

    /// Value of the line.
    pub fn at(self, x: f64) -> f64 {
        self.fixed + self.each * x
    }
}

#[cfg(test)]
mod tests {
    use super::{Line, quartiles};

    #[test]
    fn quartiles_are_taken_by_rank() {
        assert_eq!(quartiles(&[3.0, 1.0, 2.0]), [1.0, 2.0, 3.0]);
        assert_eq!(quartiles(&[4.0, 3.0, 2.0, 1.0]), [1.0, 2.0, 3.0]);
        assert_eq!(quartiles(&[7.0]), [7.0; 3]);
        assert!(quartiles(&[])[1].is_nan());
    }

    #[test]
    fn line_is_found_and_its_error_is_relative() {
        let exact: Vec<(f64, f64)> = [1.0, 4.0, 20.0].map(|x| (x, 3.0 + 0.5 * x)).to_vec();
        let line = Line::fit(&exact);
        assert!((line.fixed - 3.0).abs() < 1e-9 && (line.each - 0.5).abs() < 1e-9, "{line:?}");
        assert!(line.error < 1e-9 && (line.at(64.0) - 35.0).abs() < 1e-6);
        let bent = Line::fit(&[(1.0, 1.0), (2.0, 2.2), (3.0, 3.0)]);
        assert!(bent.error > 0.01 && bent.error < 0.1, "{bent:?}");
        assert_eq!(Line::fit(&[(2.0, 5.0), (3.0, 0.0)]).at(2.0), 5.0);
        assert_eq!(Line::fit(&[]).at(2.0), 0.0);
    }
}
