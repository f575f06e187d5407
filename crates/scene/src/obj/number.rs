//! Coordinates of `v`, `vt` and `vn` statements.

use super::ObjErrorKind;
use crate::mesh::COORDINATE_MAX;

/// One coordinate.
///
/// # Error
/// Not a number, or NaN, infinite or beyond the range of 32-bit floats.
pub(super) fn coordinate(word: &[u8], what: &'static str) -> Result<f64, ObjErrorKind> {
    let number: Option<f64> = std::str::from_utf8(word).ok().and_then(|text| text.parse().ok());
    let number = number.ok_or(ObjErrorKind::NotANumber { what })?;
    // Written so that NaN fails.
    if number.abs() <= COORDINATE_MAX {
        return Ok(number);
    }
    Err(ObjErrorKind::NotFinite { what })
}

/// The first `N` coordinates of a statement; what follows (weights, colours) is not read.
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
