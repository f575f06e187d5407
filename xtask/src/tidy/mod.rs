//! Rules of the source tree that no compiler checks, as code.
//!
//! Owns which rules there are and how a violation is shown; each rule lives in its own file. Refuses to repair
//! anything but the committed list of duplicate dependencies, and that only when asked.

mod arrow;
mod duplicate;
mod source;

use anyhow::{Result, bail};

use crate::shell;

/// Checks everything, and names every violation.
pub fn run() -> Result<()> {
    let violations = violations()?;
    for violation in &violations {
        eprintln!("tidy: {violation}");
    }
    if violations.is_empty() {
        println!("tidy: nothing to object to");
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
    found.extend(duplicate::violations(&root)?);
    Ok(found)
}

#[cfg(test)]
mod tests {
    #[test]
    fn repository_is_tidy() {
        let violations = super::violations().unwrap();
        assert!(violations.is_empty(), "{}", violations.join("\n"));
    }
}
