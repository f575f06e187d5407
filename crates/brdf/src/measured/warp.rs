//! Tabulated densities on the unit square and the sampling maps that they define.
//!
//! Owns interpolation between slices, bilinear look-up and the inverse of the sampling map: from a
//! position to the uniform numbers that sampling would draw for it. Independent of the meaning of
//! the densities.

use glam::DVec2;

/// Largest number of slices in an interpolation: the two nearest of each of two parameters.
const MAX_SLICES: usize = 4;

/// Ascending parameter values at which slices were measured.
pub(super) struct Axis {
    values: Vec<f64>,
}

impl Axis {
    /// Returns `None` unless there are values and they ascend.
    pub(super) fn new(values: &[f32]) -> Option<Self> {
        let values: Vec<f64> = values.iter().copied().map(f64::from).collect();
        let ascends = values.windows(2).all(|pair| pair[0] < pair[1]);
        (ascends && !values.is_empty()).then_some(Self { values })
    }

    pub(super) fn len(&self) -> usize {
        self.values.len()
    }

    /// Distance from the first value to the last.
    pub(super) fn span(&self) -> f64 {
        self.values[self.values.len() - 1] - self.values[0]
    }

    /// Returns the index of the value before and the fraction of the way to the next; clamped
    /// at the ends.
    fn place(&self, value: f64) -> (usize, f64) {
        if self.values.len() == 1 {
            return (0, 0.0);
        }
        let after = self.values.partition_point(|known| *known <= value);
        let low = after.saturating_sub(1).min(self.values.len() - 2);
        let (from, to) = (self.values[low], self.values[low + 1]);
        (low, ((value - from) / (to - from)).clamp(0.0, 1.0))
    }
}

/// Interpolation weights of slices.
#[derive(Debug, Clone, Copy)]
pub(super) struct SliceWeights {
    /// Index and weight of each slice.
    parts: [(usize, f64); MAX_SLICES],
    count: usize,
}

impl SliceWeights {
    /// Weights for a table with one slice.
    pub(super) const WHOLE: Self = Self { parts: [(0, 1.0); MAX_SLICES], count: 1 };

    /// Bilinear weights at a value on each of two axes. Slices are in order of the outer axis,
    /// then of the inner one.
    pub(super) fn of(outer: (&Axis, f64), inner: (&Axis, f64)) -> Self {
        let ((row, down), (column, across)) = (outer.0.place(outer.1), inner.0.place(inner.1));
        let mut weights = Self { parts: [(0, 0.0); MAX_SLICES], count: 0 };
        for (row, part) in [(row, 1.0 - down), (row + 1, down)] {
            for (column, share) in [(column, 1.0 - across), (column + 1, across)] {
                if part * share > 0.0 {
                    weights.parts[weights.count] = (row * inner.0.len() + column, part * share);
                    weights.count += 1;
                }
            }
        }
        weights
    }

    fn parts(&self) -> &[(usize, f64)] {
        &self.parts[..self.count]
    }
}

/// Tables of equal size over the unit square, with bilinear interpolation. The outer entries lie on
/// the borders.
pub(super) struct Grid {
    width: usize,
    height: usize,
    /// Slice by slice, row by row.
    values: Vec<f32>,
}

/// A cell between four entries.
#[derive(Clone, Copy)]
struct Cell {
    /// Index of the first corner within a slice, and the row of the cell.
    first: usize,
    row: usize,
    /// Position within the cell, from 0 to 1.
    at: DVec2,
}

impl Grid {
    /// Takes as many slices as there are values for. Returns `None` if a side has fewer than
    /// two entries or the values do not fill total slices.
    pub(super) fn new((height, width): (usize, usize), values: Vec<f32>) -> Option<Self> {
        let fits = width > 1 && height > 1 && values.len().is_multiple_of(width * height);
        fits.then_some(Self { width, height, values })
    }

    /// Interpolates with `stride` slices per parameter value, of which it reads slice `offset`.
    pub(super) fn strided(
        &self,
        at: DVec2,
        weights: &SliceWeights,
        (stride, offset): (usize, usize),
    ) -> f64 {
        let cell = self.cell(at);
        let slice = |index: usize| (index * stride + offset) * self.width * self.height;
        let [a, b, c, d] = self.corners(&cell);
        let bilinear = |base: usize| {
            let value = |entry: usize| f64::from(self.values[base + entry]);
            let upper = value(a) * (1.0 - cell.at.x) + value(b) * cell.at.x;
            let lower = value(c) * (1.0 - cell.at.x) + value(d) * cell.at.x;
            upper * (1.0 - cell.at.y) + lower * cell.at.y
        };
        weights.parts().iter().map(|(index, share)| share * bilinear(slice(*index))).sum()
    }

    /// Interpolates at a position.
    pub(super) fn at(&self, at: DVec2, weights: &SliceWeights) -> f64 {
        self.strided(at, weights, (1, 0))
    }

    fn cell(&self, at: DVec2) -> Cell {
        let (column, across) = split(at.x, self.width);
        let (row, down) = split(at.y, self.height);
        Cell { first: row * self.width + column, row, at: DVec2::new(across, down) }
    }

    fn corners(&self, cell: &Cell) -> [usize; 4] {
        let below = cell.first + self.width;
        [cell.first, cell.first + 1, below, below + 1]
    }

    /// Interpolates an entry between slices.
    fn interpolate(&self, entry: usize, weights: &SliceWeights) -> f64 {
        let slice = self.width * self.height;
        let part =
            |(index, share): &(usize, f64)| share * f64::from(self.values[index * slice + entry]);
        weights.parts().iter().map(part).sum()
    }
}

/// Index of the entry before a position, and the fraction of the way to the next entry.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the table")]
fn split(at: f64, count: usize) -> (usize, f64) {
    let at = at.clamp(0.0, 1.0) * (count - 1) as f64;
    let low = (at as usize).min(count - 2);
    (low, at - low as f64)
}

/// Densities with the maps from uniform numbers to positions that are distributed by them.
///
/// Sampling draws a row by the marginal density, then a position in the row. Interpolation is
/// linear in rows, entries and slices, and all slices have the same integral, so interpolated
/// tables are the tables of the interpolated density.
pub(super) struct Warp {
    density: Grid,
    /// Integral of each row up to each entry, in steps of the table.
    along: Grid,
    /// Integral of all rows up to each row, slice by slice.
    down: Vec<f32>,
}

/// Error of [`Warp::new`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum WarpError {
    /// A side has fewer than two entries.
    Size,
    /// This entry is below 0.
    Negative(usize),
    /// This slice is 0 everywhere.
    Empty(usize),
}

impl Warp {
    /// Computes the integrals and normalises each slice to an integral of 1.
    pub(super) fn new(size: (usize, usize), mut values: Vec<f32>) -> Result<Self, WarpError> {
        let (height, width) = size;
        if width < 2 || height < 2 {
            return Err(WarpError::Size);
        }
        if let Some(entry) = values.iter().position(|value| *value < 0.0) {
            return Err(WarpError::Negative(entry));
        }
        let mut along = vec![0.0; values.len()];
        let mut down = Vec::with_capacity(values.len() / width);
        for (index, slice) in values.chunks_exact_mut(width * height).enumerate() {
            let rows: Vec<Vec<f64>> = slice.chunks_exact(width).map(sums).collect();
            let totals: Vec<f64> = rows.iter().map(|row| row[width - 1]).collect();
            let columns = accumulate(totals.iter().copied());
            let total = columns[height - 1];
            if total <= 0.0 {
                return Err(WarpError::Empty(index));
            }
            let places = &mut along[index * width * height..];
            for (place, sum) in places.iter_mut().zip(rows.iter().flatten()) {
                *place = nearest(sum / total);
            }
            for value in slice {
                *value = nearest(f64::from(*value) / total);
            }
            down.extend(columns.iter().map(|sum| nearest(sum / total)));
        }
        let grid = |values| Grid { width, height, values };
        Ok(Self { density: grid(values), along: grid(along), down })
    }

    /// Returns the uniform numbers in [0, 1] that sampling maps to this position.
    pub(super) fn invert(&self, at: DVec2, weights: &SliceWeights) -> DVec2 {
        let (width, height) = (self.density.width, self.density.height);
        let cell = self.density.cell(at);
        let DVec2 { x, y } = cell.at;
        let [a, b, c, d] = self.density.corners(&cell);
        let value = |entry| self.density.interpolate(entry, weights);
        let left = value(a) * (1.0 - y) + value(c) * y;
        let right = value(b) * (1.0 - y) + value(d) * y;
        let along = |entry| self.along.interpolate(entry, weights);
        let before = along(a) * (1.0 - y) + along(c) * y;
        let (upper, lower) = (along((cell.row + 1) * width - 1), along((cell.row + 2) * width - 1));
        let row = upper * (1.0 - y) + lower * y;
        let part = before + trapezoid(left, right, x);
        // A row of density 0 is treated as uniform.
        let first = if row > 0.0 { part / row } else { at.x };
        let above =
            |(index, share): &(usize, f64)| share * f64::from(self.down[index * height + cell.row]);
        let above: f64 = weights.parts().iter().map(above).sum();
        let second = above + trapezoid(upper, lower, y);
        DVec2::new(first, second).clamp(DVec2::ZERO, DVec2::ONE)
    }
}

/// Integral from 0 to `to` of the linear function from `left` at 0 to `right` at 1.
fn trapezoid(left: f64, right: f64, to: f64) -> f64 {
    to * (left + 0.5 * to * (right - left))
}

fn sums(row: &[f32]) -> Vec<f64> {
    accumulate(row.iter().copied().map(f64::from))
}

/// Integrals up to each entry of the piecewise linear function.
fn accumulate(numbers: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut last = None;
    let mut sum = 0.0;
    let step = |number: f64| {
        sum += last.map_or(0.0, |last: f64| 0.5 * (last + number));
        last = Some(number);
        sum
    };
    numbers.map(step).collect()
}

#[expect(clippy::cast_possible_truncation, reason = "rounded to the nearest f32")]
fn nearest(value: f64) -> f32 {
    value as f32
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Marginal and conditional distribution at a position, by summing many small steps.
    fn by_steps(density: impl Fn(f64, f64) -> f64, at: DVec2) -> DVec2 {
        const STEPS: usize = 4000;
        let integral = |to: f64, f: &dyn Fn(f64) -> f64| -> f64 {
            let step = to / STEPS as f64;
            (0..STEPS).map(|k| f((k as f64 + 0.5) * step) * step).sum()
        };
        let first = integral(at.x, &|x| density(x, at.y)) / integral(1.0, &|x| density(x, at.y));
        let row = |y: f64| (0..64).map(|k| density((f64::from(k) + 0.5) / 64.0, y) / 64.0).sum();
        let second = integral(at.y, &row) / integral(1.0, &row);
        DVec2::new(first, second)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        #[test]
        fn inverse_is_the_integral_of_the_mixed_density(
            values in prop::collection::vec(0.0..1.0_f32, 5 * 9 * 4),
            zeros in prop::collection::vec(0_usize..180, 0..60),
            (phi, theta) in (-1.5..1.5, -0.2..1.7),
            (x, y) in (0.0..1.0, 0.0..1.0),
        ) {
            let mut values = values;
            for entry in zeros {
                values[entry] = 0.0;
            }
            let axes = (Axis::new(&[-1.0, 1.0]).unwrap(), Axis::new(&[0.0, 1.5]).unwrap());
            let weights = SliceWeights::of((&axes.0, phi), (&axes.1, theta));
            let warp = Warp::new((5, 9), values).unwrap();
            let at = DVec2::new(x, y);
            let density = |x: f64, y: f64| warp.density.at(DVec2::new(x, y), &weights);
            let off = warp.invert(at, &weights) - by_steps(density, at);
            prop_assert!(off.abs().max_element() < 1e-3, "{off}");
        }
    }

    #[test]
    fn uniform_density_is_the_identity_and_corners_map_to_corners() {
        let even = Warp::new((3, 4), vec![0.3; 12]).unwrap();
        let slope = Warp::new((3, 4), (1..13).map(|k| k as f32).collect()).unwrap();
        for (x, y) in [(0.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.35, 0.8)] {
            let at = DVec2::new(x, y);
            assert!((even.invert(at, &SliceWeights::WHOLE) - at).length() < 1e-6);
            if x.fract() == 0.0 {
                assert!((slope.invert(at, &SliceWeights::WHOLE) - at).length() < 1e-6);
            }
        }
    }

    #[test]
    fn zero_rows_are_uniform_and_bad_tables_are_errors() {
        let mut values = vec![0.0; 12];
        values[11] = 1.0;
        let warp = Warp::new((4, 3), values.clone()).unwrap();
        assert_eq!(warp.invert(DVec2::new(0.25, 0.1), &SliceWeights::WHOLE), DVec2::new(0.25, 0.0));
        values.extend([0.0; 12]);
        assert_eq!(Warp::new((4, 3), values.clone()).err(), Some(WarpError::Empty(1)));
        values[3] = -1.0;
        assert_eq!(Warp::new((4, 3), values).err(), Some(WarpError::Negative(3)));
        assert_eq!(Warp::new((1, 3), vec![1.0; 3]).err(), Some(WarpError::Size));
    }

    #[test]
    fn axes_clamp_at_their_ends_and_weights_are_linear_between() {
        let axis = Axis::new(&[0.0, 1.0, 3.0]).unwrap();
        for (value, place) in
            [(-1.0, (0, 0.0)), (0.5, (0, 0.5)), (1.0, (1, 0.0)), (2.0, (1, 0.5)), (9.0, (1, 1.0))]
        {
            assert_eq!(axis.place(value), place);
        }
        assert!(Axis::new(&[]).is_none() && Axis::new(&[1.0, 1.0]).is_none());
        let grid = Grid::new((2, 2), vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 3.0, 3.0]).unwrap();
        let one = Axis::new(&[0.0]).unwrap();
        let weights = SliceWeights::of((&one, 7.0), (&Axis::new(&[0.0, 2.0]).unwrap(), 0.5));
        assert!((grid.at(DVec2::new(0.3, 0.5), &weights) - 0.5).abs() < 1e-12);
    }
}
