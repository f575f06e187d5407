//! Coordinates of `v`, `vt` and `vn` statements.

use super::ObjErrorKind;
use crate::mesh::COORDINATE_MAX;

/// Parses one coordinate.
///
/// # Errors
/// Returns an error if the word is not a number, or is NaN, infinite or beyond the range of f32.
pub(super) fn coordinate(word: &[u8], what: &'static str) -> Result<f64, ObjErrorKind> {
    let number: Option<f64> = std::str::from_utf8(word).ok().and_then(|text| text.parse().ok());
    let number = number.ok_or(ObjErrorKind::NotANumber { what })?;
    // This form of the comparison rejects NaN.
    if number.abs() <= COORDINATE_MAX {
        return Ok(number);
    }
    Err(ObjErrorKind::NotFinite { what })
}

/// Parses the first `N` coordinates of a statement; further ones (weights, colours) are ignored.
///
/// # Errors
/// Returns an error if there are fewer than `N` or one is invalid.
pub(super) fn coordinates<'a, const N: usize>(
    words: &mut impl Iterator<Item = &'a [u8]>,
    what: &'static str,
) -> Result<[f64; N], ObjErrorKind> {
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        let word = words.next().ok_or(ObjErrorKind::MissingNumber { what, needed: N })?;
        *number = coordinate(word, what)?;
    }
    Ok(numbers)
}
