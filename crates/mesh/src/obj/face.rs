//! Parser of face corners: index forms v, v/t, v//n and v/t/n, from 1 or backwards from -1.

use super::ObjErrorKind;

/// Value of an omitted index.
pub(super) const ABSENT: u32 = u32::MAX;

/// Indices of a corner, from 0; `t` and `n` may be [`ABSENT`]. Not yet checked against the file's
/// end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Corner {
    pub v: u32,
    pub t: u32,
    pub n: u32,
}

/// Number of statements of each kind read so far; negative indices are relative to it.
#[derive(Clone, Copy)]
pub(super) struct Counts {
    pub v: usize,
    pub t: usize,
    pub n: usize,
}

/// Parses one corner.
///
/// # Errors
/// Returns an error for another form, index 0, or a negative index before the first statement.
pub(super) fn corner(word: &[u8], counts: Counts) -> Result<Corner, ObjErrorKind> {
    let mut fields = word.split(|byte| *byte == b'/');
    let v = index(fields.next().unwrap_or_default(), counts.v, "vertex")?;
    let t = optional(fields.next(), counts.t, "texture coordinate")?;
    let n = optional(fields.next(), counts.n, "normal")?;
    if fields.next().is_some() {
        return Err(ObjErrorKind::MalformedCorner);
    }
    Ok(Corner { v, t, n })
}

fn optional(field: Option<&[u8]>, count: usize, what: &'static str) -> Result<u32, ObjErrorKind> {
    match field {
        None | Some([]) => Ok(ABSENT),
        Some(field) => index(field, count, what),
    }
}

fn index(field: &[u8], count: usize, what: &'static str) -> Result<u32, ObjErrorKind> {
    let text = std::str::from_utf8(field).map_err(|_| ObjErrorKind::MalformedCorner)?;
    let digits = text.strip_prefix(['-', '+']).unwrap_or(text);
    if digits.is_empty() || !digits.bytes().all(|byte| byte.is_ascii_digit()) {
        return Err(ObjErrorKind::MalformedCorner);
    }
    let out_of_range = ObjErrorKind::IndexOutOfRange { what };
    // The text is all digits, so parsing fails only by overflow.
    let number: usize = digits.parse().map_err(|_| out_of_range)?;
    if number == 0 {
        return Err(ObjErrorKind::ZeroIndex { what });
    }
    let from_zero = if text.starts_with('-') {
        count.checked_sub(number).ok_or(out_of_range)?
    } else {
        number - 1
    };
    u32::try_from(from_zero).ok().filter(|index| *index != ABSENT).ok_or(out_of_range)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corner_parses_every_form() {
        let counts = Counts { v: 10, t: 5, n: 3 };
        let cases: [(&[u8], [u32; 3]); 7] = [
            (b"1", [0, ABSENT, ABSENT]),
            (b"+7", [6, ABSENT, ABSENT]),
            (b"2/3", [1, 2, ABSENT]),
            (b"2//3", [1, ABSENT, 2]),
            (b"-1/-5/-3", [9, 0, 0]),
            (b"4/", [3, ABSENT, ABSENT]),
            (b"4294967295", [4294967294, ABSENT, ABSENT]),
        ];
        for (word, [v, t, n]) in cases {
            assert_eq!(corner(word, counts), Ok(Corner { v, t, n }), "{}", word.escape_ascii());
        }
    }

    #[test]
    fn corner_is_rejected_when_malformed() {
        let counts = Counts { v: 10, t: 5, n: 3 };
        let out_of_range = |what| ObjErrorKind::IndexOutOfRange { what };
        let cases: [(&[u8], ObjErrorKind); 10] = [
            (b"", ObjErrorKind::MalformedCorner),
            (b"/1", ObjErrorKind::MalformedCorner),
            (b"x", ObjErrorKind::MalformedCorner),
            (b"1.5", ObjErrorKind::MalformedCorner),
            (b"1/2/3/4", ObjErrorKind::MalformedCorner),
            (b"\xff", ObjErrorKind::MalformedCorner),
            (b"0", ObjErrorKind::ZeroIndex { what: "vertex" }),
            (b"1/-0", ObjErrorKind::ZeroIndex { what: "texture coordinate" }),
            (b"1//-4", out_of_range("normal")),
            (b"99999999999999999999999", out_of_range("vertex")),
        ];
        for (word, kind) in cases {
            assert_eq!(corner(word, counts), Err(kind), "{}", word.escape_ascii());
        }
    }
}
