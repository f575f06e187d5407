//! Source form of printed code: WGSL in which every local declaration has a type. All code of this
//! crate is written in it, by hand or by the functions here; `language` turns it into the languages
//! of exports.

/// Declaration of a local value, on its own line.
pub(crate) fn let_line(of: &str, name: &str, value: &str) -> String {
    format!("  let {name}: {of} = {value};\n")
}

/// Literal that reads back to the same bits. Negative numbers are in parentheses, so that the
/// literal can stand in any expression.
///
/// # Domain
/// Finite numbers. Subnormal numbers are given by their bits, because compilers may read them as 0.
pub(crate) fn number(value: f32) -> String {
    if value.is_subnormal() {
        return format!("bitcast<f32>({:#010x}u)", value.to_bits());
    }
    // Shortest digits that read back; always with a point or an exponent, as GLSL requires.
    let digits = format!("{value:?}");
    match value.is_sign_negative() {
        true => format!("({digits})"),
        false => digits,
    }
}

/// Code with other text for some of its words. Words after a point, which are fields, are kept.
pub(crate) fn with_words(code: &str, other: impl Fn(&str) -> Option<String>) -> String {
    let mut text = String::with_capacity(2 * code.len());
    let mut rest = code;
    while let Some(start) = rest.find(is_of_word) {
        let (before, after) = rest.split_at(start);
        let end = after.find(|c| !is_of_word(c)).unwrap_or(after.len());
        let (word, after) = after.split_at(end);
        text += before;
        match other(word).filter(|_| !before.ends_with('.')) {
            Some(other) => text += &other,
            None => text += word,
        }
        rest = after;
    }
    text + rest
}

/// True for characters of names and numbers.
pub(crate) fn is_of_word(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_to_the_same_bits() {
        let values = [0.0, -0.0, 1.0, -0.1, 65504.0, 1.5e-7, f32::MIN_POSITIVE, 16_777_216.0, 0.1];
        for value in values {
            let text = number(value);
            let bare = text.trim_matches(['(', ')']);
            assert_eq!(bare.parse::<f32>().unwrap().to_bits(), f32::to_bits(value), "{text}");
            assert!(bare.contains(['.', 'e']), "{text} is no floating point number in GLSL");
        }
        assert_eq!(number(f32::from_bits(1)), "bitcast<f32>(0x00000001u)");
    }
}
