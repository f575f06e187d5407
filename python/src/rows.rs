//! Arrays of directions and texture positions, read without copies.

use brood_brdf::{DirectionError, DirectionPair};
use glam::{DVec2, DVec3};
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;

use crate::error::value_error;

/// A C-contiguous array of numpy with one row per sample, or one row for all samples.
#[derive(FromPyObject)]
pub(crate) enum Rows<'py> {
    Single(PyReadonlyArray2<'py, f32>),
    Double(PyReadonlyArray2<'py, f64>),
}

impl Rows<'_> {
    /// Returns the numbers.
    ///
    /// # Errors
    /// If the array is not contiguous, which the Python files of the package prevent.
    pub(crate) fn numbers(&self) -> PyResult<Numbers<'_>> {
        Ok(match self {
            Self::Single(array) => Numbers::Single(array.as_slice().map_err(value_error)?),
            Self::Double(array) => Numbers::Double(array.as_slice().map_err(value_error)?),
        })
    }
}

/// Numbers of an array.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Numbers<'a> {
    Single(&'a [f32]),
    Double(&'a [f64]),
}

impl Numbers<'_> {
    fn len(&self) -> usize {
        match self {
            Self::Single(numbers) => numbers.len(),
            Self::Double(numbers) => numbers.len(),
        }
    }

    /// Returns the number of rows of N numbers.
    pub(crate) fn rows<const N: usize>(&self) -> usize {
        self.len() / N
    }

    /// Returns a row of N numbers; the only row if there is one.
    #[inline]
    pub(crate) fn row<const N: usize>(&self, index: usize) -> [f64; N] {
        let start = if self.len() == N { 0 } else { N * index };
        match self {
            Self::Single(numbers) => {
                let row = &numbers[start..start + N];
                std::array::from_fn(|k| f64::from(row[k]))
            }
            Self::Double(numbers) => {
                let row = &numbers[start..start + N];
                std::array::from_fn(|k| row[k])
            }
        }
    }
}

/// First row of an argument that is not as it must be.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct BadRow {
    pub(crate) argument: &'static str,
    pub(crate) row: usize,
    pub(crate) reason: String,
}

impl From<BadRow> for PyErr {
    fn from(BadRow { argument, row, reason }: BadRow) -> Self {
        value_error(format!("`{argument}`, row {row}: {reason}"))
    }
}

/// Number of samples of arrays with these numbers of rows: the largest; 0 if one is empty.
pub(crate) fn longest(rows: impl Iterator<Item = usize>) -> usize {
    rows.reduce(|a, b| if a.min(b) == 0 { 0 } else { a.max(b) }).unwrap_or(0)
}

/// Directions to light and eye, and texture positions.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PairRows<'a> {
    pub(crate) wi: Numbers<'a>,
    pub(crate) wo: Numbers<'a>,
    pub(crate) uv: Option<Numbers<'a>>,
}

impl PairRows<'_> {
    /// Returns the number of samples: that of the longest array.
    pub(crate) fn count(&self) -> usize {
        let uv = self.uv.map(|uv| uv.rows::<2>());
        longest([self.wi.rows::<3>(), self.wo.rows::<3>()].into_iter().chain(uv))
    }

    /// Returns a pair of directions.
    #[inline]
    pub(crate) fn pair(&self, index: usize) -> Result<DirectionPair, BadRow> {
        let (wi, wo) = (DVec3::from(self.wi.row::<3>(index)), DVec3::from(self.wo.row::<3>(index)));
        DirectionPair::new(wi, wo).map_err(|_| self.bad_pair(index))
    }

    #[cold]
    fn bad_pair(&self, index: usize) -> BadRow {
        bad_direction("wi", &self.wi, index)
            .or_else(|| bad_direction("wo", &self.wo, index))
            .expect("one of both directions is bad")
    }

    /// Returns a texture position; 0 if there are none.
    #[inline]
    pub(crate) fn uv(&self, index: usize) -> Result<DVec2, BadRow> {
        let Some(uv) = &self.uv else { return Ok(DVec2::ZERO) };
        let position = DVec2::from(uv.row::<2>(index));
        if position.is_finite() {
            return Ok(position);
        }
        let row = index.min(uv.rows::<2>() - 1);
        let reason = format!("a coordinate is not finite: {position}");
        Err(BadRow { argument: "uv", row, reason })
    }
}

/// Returns a direction of an array.
pub(crate) fn direction(
    argument: &'static str,
    numbers: &Numbers<'_>,
    index: usize,
) -> Result<DVec3, BadRow> {
    let direction = DVec3::from(numbers.row::<3>(index));
    match DirectionPair::new(direction, DVec3::Z) {
        Ok(pair) => Ok(pair.wi()),
        Err(error) => Err(bad(argument, numbers, index, error)),
    }
}

fn bad_direction(argument: &'static str, numbers: &Numbers<'_>, index: usize) -> Option<BadRow> {
    direction(argument, numbers, index).err()
}

fn bad(
    argument: &'static str,
    numbers: &Numbers<'_>,
    index: usize,
    error: DirectionError,
) -> BadRow {
    let row = index.min(numbers.rows::<3>() - 1);
    let [x, y, z] = numbers.row::<3>(index);
    BadRow { argument, row, reason: format!("{error}: ({x}, {y}, {z})") }
}
