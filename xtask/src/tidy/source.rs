//! Rules for single files: length, opening paragraph, forbidden words, paths of one machine.
//!
//! Works on text alone; rules that need to parse Rust are clippy's.

use std::path::Path;

use anyhow::{Context, Result};

use super::circle::Circles;
use super::english;
use super::type_name::TypeNames;

/// Largest number of lines of a file.
const MAX_LINES: usize = 500;

/// Names of folders without own text. `target` is one only in the root.
const SKIPPED: [&str; 3] = ["node_modules", ".git", "vendor"];

/// Extensions of files that are read as text.
const TEXT: [&str; 15] = [
    "rs", "toml", "md", "sql", "wgsl", "js", "mjs", "css", "html", "json", "brood", "txt", "sh",
    "yml", "obj",
];

/// Extensions of files with a limited length.
const LIMITED: [&str; 7] = ["rs", "sql", "wgsl", "js", "mjs", "css", "html"];

/// First parts of absolute paths that only mean something on one machine.
const PRIVATE_FOLDERS: [&str; 6] = ["home", "root", "Users", "work", "tmp", "mnt"];

/// Reads the whole tree.
pub fn violations(root: &Path) -> Result<Vec<String>> {
    let mut files = Vec::new();
    gather(root, root, &mut files)?;
    files.sort();
    let mut found = Vec::new();
    let mut types = TypeNames::default();
    let mut circles = Circles::default();
    for name in files {
        let bytes = std::fs::read(root.join(&name)).with_context(|| format!("read {name}"))?;
        match std::str::from_utf8(&bytes) {
            Ok(text) => {
                found.extend(check(&name, text));
                found.extend(english::violations(&name, text));
                if name.ends_with(".rs") {
                    types.add(&name, text);
                    if !is_test_file(&name) {
                        circles.add(&name, text);
                    }
                }
            }
            Err(_) => found.push(format!("{name}: is not UTF-8")),
        }
    }
    found.extend(types.violations());
    found.extend(circles.violations());
    Ok(found)
}

/// All text files below `folder`, named from the root with forward slashes.
fn gather(root: &Path, folder: &Path, files: &mut Vec<String>) -> Result<()> {
    let entries =
        std::fs::read_dir(folder).with_context(|| format!("list {}", folder.display()))?;
    for entry in entries {
        let entry = entry.with_context(|| format!("list {}", folder.display()))?;
        let path = entry.path();
        let name = entry.file_name();
        let kind = entry.file_type().with_context(|| format!("look at {}", path.display()))?;
        if kind.is_dir() {
            let is_built = folder == root && name == "target";
            if !is_built && !SKIPPED.iter().any(|skipped| name == *skipped) {
                gather(root, &path, files)?;
            }
        } else if path.extension().is_some_and(|end| TEXT.iter().any(|text| end == *text)) {
            let inner = path.strip_prefix(root).expect("every entry lies below the root");
            files.push(inner.to_string_lossy().replace('\\', "/"));
        }
    }
    Ok(())
}

/// Violations in one file.
fn check(name: &str, text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let (stem, kind) = name.rsplit_once('.').unwrap_or((name, ""));
    let lines = text.lines().count();
    if LIMITED.contains(&kind) && lines > MAX_LINES {
        found.push(format!("{name}: {lines} lines, more than {MAX_LINES}: split it"));
    }
    if kind == "rs" && !text.starts_with("//!") && !stem.ends_with("/tests") {
        found.push(format!("{name}: does not open with a //! paragraph"));
    }
    if kind == "sql" && !text.starts_with("--") {
        found.push(format!("{name}: does not open with a comment on why"));
    }
    if matches!(kind, "rs" | "wgsl" | "sql" | "js" | "mjs" | "css" | "html") {
        found.extend(unfinished(name, text));
    }
    if kind == "rs" && !is_test_file(name) {
        found.extend(unwraps(name, text));
    }
    found.extend(private_paths(name, text));
    found
}

fn is_test_file(name: &str) -> bool {
    name.ends_with("/tests.rs")
        || name.ends_with("_tests.rs")
        || name.starts_with("tests/")
        || name.contains("/tests/")
}

/// Marks of unfinished work.
fn unfinished(name: &str, text: &str) -> Vec<String> {
    // Put together here so that this file passes its own check.
    let marks = [["TO", "DO"], ["FIX", "ME"], ["todo", "!("], ["unimplemented", "!("]];
    let mut found = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        for mark in &marks {
            let mark = mark.concat();
            if line.contains(&mark) {
                found.push(format!("{name}:{number}: {mark} is unfinished work"));
            }
        }
    }
    found
}

/// `unwrap` outside tests. Tests are at the end of a file, so the first test attribute ends the
/// checked part.
fn unwraps(name: &str, text: &str) -> Vec<String> {
    let code = (1..).zip(text.lines()).take_while(|(_, line)| line.trim() != "#[cfg(test)]");
    code.filter(|(_, line)| !line.trim_start().starts_with("//"))
        .filter(|(_, line)| line.contains(concat!(".unwrap", "()")))
        .map(|(number, _)| format!("{name}:{number}: unwrap outside tests: state the invariant"))
        .collect()
}

/// Absolute paths in a home or scratch folder.
fn private_paths(name: &str, text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        for folder in PRIVATE_FOLDERS {
            let path = format!("/{folder}/");
            let starts_a_path = |at: usize| {
                let before = line[..at].chars().next_back();
                !before.is_some_and(|c| c.is_alphanumeric() || "./_-}~*>".contains(c))
            };
            if line.match_indices(&path).any(|(at, _)| starts_a_path(at)) {
                found.push(format!("{name}:{number}: {path} is a path of one machine"));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::super::tests::assert_refused;
    use super::check;

    #[test]
    fn file_is_refused_when_it_breaks_a_rule() {
        let long = format!("//! Opens well.\n{}", "\n".repeat(500));
        let path = ["let f = \"", "/home", "/me/x\";"].concat();
        let cases = [
            ("crates/a/src/b.rs", "fn f() {}\n".to_owned(), "//! paragraph"),
            ("crates/a/src/b.rs", long, "more than 500"),
            ("crates/a/src/b.rs", ["//! A.\n// TO", "DO later\n"].concat(), "unfinished"),
            ("crates/a/src/b.rs", "//! A.\nfn f() { x.unwrap() }\n".to_owned(), "unwrap outside"),
            ("crates/a/src/b.rs", format!("//! A.\n{path}\n"), "path of one machine"),
            ("migrations/0001_a.sql", "CREATE TABLE a (b);\n".to_owned(), "comment on why"),
        ];
        assert_refused(check, &cases);
    }

    #[test]
    fn file_passes_when_unwrap_stands_in_its_tests_or_in_an_example() {
        let text = "//! ```\n//! f().unwrap();\n//! ```\nfn f() {}\n#[cfg(test)]\nmod t { fn g() { f().unwrap(); } }\n";
        assert_eq!(check("crates/a/src/b.rs", text), Vec::<String>::new());
        assert_eq!(
            check("crates/a/src/tests.rs", "use super::f;\nfn g() { f().unwrap(); }\n").len(),
            0
        );
    }

    #[test]
    fn path_passes_when_it_is_relative_or_a_route() {
        let text = "//! See ../work/x, crates/root/y and `/v1/lineages`.\n";
        assert_eq!(check("crates/a/src/b.rs", text), Vec::<String>::new());
    }
}
