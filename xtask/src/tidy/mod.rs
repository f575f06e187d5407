//! Rules of the source tree that no compiler checks, as code.
//!
//! Each rule has its own file. Nothing is repaired, except that `--update-duplicates` writes the
//! list of duplicate dependencies.

mod arrow;
mod circle;
mod commit;
mod duplicate;
mod english;
mod link;
mod source;
mod type_name;

use anyhow::{Result, bail};

use crate::shell;

/// Checks the whole tree and prints every violation; with `prefixes`, only those in files whose
/// path begins so.
pub fn run(prefixes: &[&str]) -> Result<()> {
    let mut violations = violations()?;
    if !prefixes.is_empty() {
        violations.retain(|line| prefixes.iter().any(|prefix| line.starts_with(prefix)));
    }
    for violation in &violations {
        eprintln!("tidy: {violation}");
    }
    if violations.is_empty() {
        println!("tidy: no violations");
        Ok(())
    } else {
        bail!("tidy: {} violations", violations.len())
    }
}

/// Writes the list of duplicate dependencies as it is now.
pub fn update_duplicates() -> Result<()> {
    duplicate::update(&shell::root())
}

fn violations() -> Result<Vec<String>> {
    let root = shell::root();
    let mut found = arrow::violations()?;
    found.extend(source::violations(&root)?);
    found.extend(link::violations(&root)?);
    found.extend(duplicate::violations(&root)?);
    found.extend(commit::violations(&root));
    Ok(found)
}

#[cfg(test)]
mod tests {
    /// Asserts that a rule finds one violation, with these words, in each file.
    pub(super) fn assert_refused(
        rule: fn(&str, &str) -> Vec<String>,
        files: &[(&str, String, &str)],
    ) {
        for (name, text, words) in files {
            let found = rule(name, text);
            assert_eq!(found.len(), 1, "{name} {words}: {found:?}");
            assert!(found[0].contains(words), "{words}: {found:?}");
        }
    }

    #[test]
    fn repository_is_tidy() {
        let violations = super::violations().unwrap();
        assert!(violations.is_empty(), "{}", violations.join("\n"));
    }
}
