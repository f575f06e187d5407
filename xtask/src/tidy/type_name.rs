//! Rule for names: a public type name means one thing in the whole workspace.
//!
//! Reads `pub struct`, `pub enum`, `pub trait` and `pub type` lines as text. Types inside `mod
//! tests` and test files are not public.

use std::collections::BTreeMap;

/// Names that several crates define on purpose, each with the reason.
const SHARED: [(&str, &str); 2] = [
    ("Operand", "operand of an instruction in genome, and of the scalar operation it lowers to"),
    ("TargetError", "error of making a target from samples, in eval and in search"),
];

/// Collects the public types of all files.
#[derive(Default)]
pub struct TypeNames {
    places: BTreeMap<String, Vec<String>>,
}

impl TypeNames {
    /// Adds the public types of one Rust file.
    pub fn add(&mut self, name: &str, text: &str) {
        let library = name.contains("/src/") && !name.starts_with("xtask/");
        if !library || name.ends_with("tests.rs") || name.contains("/tests/") {
            return;
        }
        for (number, line) in (1..).zip(text.lines()) {
            if line.trim() == "#[cfg(test)]" {
                break;
            }
            if let Some(found) = public_type(line) {
                self.places.entry(found.to_owned()).or_default().push(format!("{name}:{number}"));
            }
        }
    }

    /// Returns one violation for each name with several definitions.
    pub fn violations(&self) -> Vec<String> {
        self.places
            .iter()
            .filter(|(name, places)| {
                places.len() > 1 && !SHARED.iter().any(|(shared, _)| shared == name)
            })
            .map(|(name, places)| {
                format!("{}: {name} names several public types", places.join(", "))
            })
            .collect()
    }
}

/// Name of the public type that a line defines.
fn public_type(line: &str) -> Option<&str> {
    let rest = line.strip_prefix("pub ")?;
    let rest = rest.strip_prefix("unsafe ").unwrap_or(rest);
    let rest =
        ["struct ", "enum ", "trait ", "type "].iter().find_map(|kind| rest.strip_prefix(kind))?;
    let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
    Some(&rest[..end])
}

#[cfg(test)]
mod tests {
    use super::TypeNames;

    #[test]
    fn name_is_refused_when_two_public_types_have_it() {
        let mut names = TypeNames::default();
        names.add("crates/a/src/b.rs", "//! A.\npub struct Wanted {\n}\nstruct Room;\n");
        names.add("crates/c/src/d.rs", "pub enum Wanted {\n}\npub struct Room;\n");
        names.add("crates/c/src/tests.rs", "pub struct Room;\n");
        let found = names.violations();
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].contains("b.rs:2, crates/c/src/d.rs:1: Wanted"), "{found:?}");
    }
}
