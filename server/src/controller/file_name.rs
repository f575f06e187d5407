//! Names of files in archives, as the page names single downloads (`web/page/file_name.js`).

use unicode_normalization::UnicodeNormalization;

/// Longest part of a name that is taken over, in characters.
const MOST: usize = 40;

/// Returns a name as part of a file name: letters and digits of any script, lower case, joined by
/// hyphens.
pub fn slug(name: &str) -> String {
    let mut slug = String::new();
    let folded: String = name.nfkc().collect::<String>().to_lowercase();
    for letter in folded.chars() {
        if letter.is_alphanumeric() {
            slug.push(letter);
        } else if !slug.ends_with('-') {
            slug.push('-');
        }
    }
    let cut: String = slug.chars().take(MOST).collect();
    match cut.trim_matches('-') {
        "" => "material".to_owned(),
        cut => cut.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slug_has_letters_and_digits_of_any_script() {
        for (name, expected) in [
            ("Untitled 1", "untitled-1"),
            ("  Gold / Étude №2 ", "gold-étude-no2"),
            ("金属", "金属"),
            ("../..", "material"),
            ("🐄", "material"),
        ] {
            assert_eq!(slug(name), expected);
        }
        assert_eq!(slug(&"a".repeat(50)).len(), 40);
    }
}
