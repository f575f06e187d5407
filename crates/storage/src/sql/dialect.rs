//! Text of a statement for PostgreSQL. SQLite reads it as it is.
//!
//! Differences stand in comments: `/*pg: text*/` is for PostgreSQL alone, the text between
//! `/*sqlite*/` and `/*end*/` for SQLite alone. Sets of keys become arrays.

/// Membership in a set of keys, before and after its number.
const IN_KEYS: (&str, &str) = ("IN (SELECT unhex(value) FROM json_each(", "))");

/// Returns the text for PostgreSQL: `?` and `?1` become `$1`. As in SQLite, `?` has the number
/// after the largest so far.
pub(crate) fn postgres(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 16);
    let mut largest = 0;
    let mut rest = text;
    while let Some(start) = rest.find(['?', '\'', '/', 'I']) {
        out.push_str(&rest[..start]);
        rest = &rest[start..];
        if let Some(set) = rest.strip_prefix(IN_KEYS.0) {
            let set = set.strip_prefix('?').expect("a set of keys is a value");
            out.push_str("= ANY(");
            rest = number(set, &mut largest, &mut out).strip_prefix(IN_KEYS.1).expect(IN_KEYS.1);
            out.push(')');
        } else if let Some(value) = rest.strip_prefix('?') {
            rest = number(value, &mut largest, &mut out);
        } else if let Some(own) = rest.strip_prefix("/*pg: ") {
            let (own, after) = own.split_once("*/").expect("the comment ends");
            out.push_str(own);
            rest = after;
        } else if rest.starts_with("/*sqlite*/") {
            rest = rest.split_once("/*end*/").expect("the text for SQLite ends").1;
        } else if let Some(literal) = rest.strip_prefix('\'') {
            let end = literal.find('\'').expect("the literal ends") + 2;
            out.push_str(&rest[..end]);
            rest = &rest[end..];
        } else {
            out.push_str(&rest[..1]);
            rest = &rest[1..];
        }
    }
    out.push_str(rest);
    out
}

/// Adds the number of a value, which may stand at the start of `rest`. Returns what follows it.
fn number<'t>(rest: &'t str, largest: &mut u32, out: &mut String) -> &'t str {
    let end = rest.find(|sign: char| !sign.is_ascii_digit()).unwrap_or(rest.len());
    let number = rest[..end].parse().unwrap_or(*largest + 1);
    *largest = number.max(*largest);
    out.push('$');
    out.push_str(&number.to_string());
    &rest[end..]
}

#[cfg(test)]
mod tests {
    use super::postgres;

    #[test]
    fn values_are_numbered_as_sqlite_does() {
        assert_eq!(postgres("a = ? AND b = ?"), "a = $1 AND b = $2");
        assert_eq!(postgres("a = ?2 AND b = ?1 AND c = ?"), "a = $2 AND b = $1 AND c = $3");
        assert_eq!(postgres("VALUES (?, ?12)"), "VALUES ($1, $12)");
    }

    #[test]
    fn sets_become_arrays() {
        let text = "id IN (SELECT unhex(value) FROM json_each(?1)) AND I IN (SELECT 1)";
        assert_eq!(postgres(text), "id = ANY($1) AND I IN (SELECT 1)");
    }

    #[test]
    fn literals_stay_and_comments_choose() {
        assert_eq!(postgres("a = 'what? /*pg: x*/' / ?"), "a = 'what? /*pg: x*/' / $1");
        let text = "a /*sqlite*/ = 1 /*end*/ LIMIT 1 /*pg: FOR UPDATE SKIP LOCKED*/;";
        assert_eq!(postgres(text), "a  LIMIT 1 FOR UPDATE SKIP LOCKED;");
    }
}
