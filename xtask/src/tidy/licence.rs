//! Licences and sources of dependencies. Each dependency comes from crates.io and has a licence of
//! the list, under which brood can be distributed as a binary.

use anyhow::{Context, Result};
use serde_json::Value;

use crate::shell;

/// Licences that ask for no more than their text and the names of the authors.
const ALLOWED: [&str; 12] = [
    "0BSD",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "CC0-1.0",
    "ISC",
    "MIT",
    // libFuzzer, which only `cargo xtask fuzz` links.
    "NCSA",
    "Unicode-3.0",
    "Zlib",
];
const REGISTRY: &str = "registry+https://github.com/rust-lang/crates.io-index";

/// Dependencies with another licence or source.
pub fn violations() -> Result<Vec<String>> {
    Ok(packages()?.iter().filter_map(violation).collect())
}

/// Packages of the workspace and its dependencies, as cargo describes them.
pub fn packages() -> Result<Vec<Value>> {
    let mut cargo = shell::cargo();
    let text = shell::output(cargo.args(["metadata", "--format-version", "1", "--locked"]))?;
    let mut metadata: Value = serde_json::from_str(&text).context("parse cargo metadata")?;
    match metadata["packages"].take() {
        Value::Array(packages) => Ok(packages),
        _ => Ok(Vec::new()),
    }
}

fn violation(package: &Value) -> Option<String> {
    // Crates of the workspace have no source.
    let source = package["source"].as_str()?;
    let name = format!("{} {}", text(package, "name"), text(package, "version"));
    if source != REGISTRY {
        return Some(format!("Cargo.lock: {name} is not from crates.io but {source}"));
    }
    let licence = text(package, "license");
    (!is_allowed(licence)).then(|| format!("Cargo.lock: {name} has the licence {licence:?}"))
}

fn text<'v>(package: &'v Value, field: &str) -> &'v str {
    package[field].as_str().unwrap_or("")
}

/// True if an SPDX expression can be met by allowed licences alone. Older crates write a slash for
/// OR.
fn is_allowed(expression: &str) -> bool {
    let expression = expression.replace('/', " OR ");
    let (mut rest, mut depth) = (Vec::new(), 0);
    // Replaces each bracketed part by a licence that is allowed or not; AND binds tighter than OR.
    let mut plain = String::new();
    for sign in expression.chars() {
        match sign {
            '(' => {
                depth += 1;
                if depth == 1 {
                    rest.push(String::new());
                    continue;
                }
            }
            ')' => {
                depth -= 1;
                if depth == 0 {
                    let inner = rest.pop().unwrap_or_default();
                    plain += if is_allowed(&inner) { "MIT" } else { "refused" };
                    continue;
                }
            }
            _ => {}
        }
        match rest.last_mut() {
            Some(inner) => inner.push(sign),
            None => plain.push(sign),
        }
    }
    let all = |terms: &str| terms.split(" AND ").all(|term| ALLOWED.contains(&term.trim()));
    depth == 0 && plain.split(" OR ").any(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expression_is_allowed_if_one_choice_is() {
        for good in [
            "MIT",
            "MIT/Apache-2.0",
            "Unlicense OR MIT",
            "(MIT OR Apache-2.0) AND Unicode-3.0",
            "MIT OR Apache-2.0 OR LGPL-2.1-or-later",
            "Apache-2.0 WITH LLVM-exception",
            "BSD-3-Clause AND MIT",
        ] {
            assert!(is_allowed(good), "{good}");
        }
        for bad in ["", "GPL-3.0", "MIT AND GPL-3.0", "(GPL-3.0 OR MPL-2.0) AND MIT", "(MIT"] {
            assert!(!is_allowed(bad), "{bad}");
        }
    }

    #[test]
    fn dependency_from_elsewhere_is_refused() {
        let package = |source: &str, licence: &str| {
            let (name, version) = ("x", "1.0.0");
            serde_json::json!({"name": name, "version": version, "source": source, "license": licence})
        };
        assert_eq!(violation(&package(REGISTRY, "MIT")), None);
        assert!(violation(&package("git+https://example.org/x", "MIT")).is_some());
        assert!(violation(&package(REGISTRY, "SSPL-1.0")).is_some());
    }
}
