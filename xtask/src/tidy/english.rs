//! Rules for wording: phrases that hide the subject, headless one-line docs, and long lines of
//! prose.
//!
//! Checks comments, string literals and Markdown as text, without parsing any language. A phrase
//! that a line break splits counts as well. Landed migrations and recorded runs are data and are
//! not checked.

use std::sync::LazyLock;

use regex::Regex;

/// Columns of a comment in code.
const COMMENT_COLUMNS: usize = 100;
/// Columns of a line of Markdown.
const MARKDOWN_COLUMNS: usize = 120;

/// Files whose text is fixed: a changed comment changes a migration's checksum, and runs are
/// records.
const FIXED: [&str; 4] = ["migrations/", "docs/bench/runs/", "openapi.json", "web/types.d.ts"];

/// First words of a doc comment that has no subject or verb.
const HEADLESS: [&str; 8] =
    ["Its ", "What ", "Of ", "Whether ", "So ", "How often", "How many", "Who "];

static PHRASES: LazyLock<Vec<(&str, Regex)>> = LazyLock::new(|| {
    let words = [
        "is told",
        "are told",
        "tells of",
        "somebody",
        "nobody",
        "whoever",
        "who is",
        "who has",
        "who asks",
        "so many",
        "as many as there are",
        "gone on with",
        "goes on with",
        "go on with",
        "at hand",
        "what is there",
        "let be",
        "sought",
        "wished",
        "odd about",
        "comes to nothing",
        "in the way",
        "says nothing of",
    ];
    let mut patterns: Vec<(&str, String)> =
        words.iter().map(|words| (*words, words.replace(' ', r"\s+"))).collect();
    patterns.push(("the one ... the other", r"the\s+one\b[^.;:]{0,80}\bthe\s+other".to_owned()));
    patterns
        .into_iter()
        .map(|(name, pattern)| {
            let pattern = format!(r"(?i)\b{pattern}\b");
            (name, Regex::new(&pattern).expect("every phrase is a valid pattern"))
        })
        .collect()
});

/// Returns every breach of the rules in one file, as `name:line: reason`.
pub fn violations(name: &str, text: &str) -> Vec<String> {
    // This file holds the phrases themselves.
    if FIXED.iter().any(|fixed| name.starts_with(fixed)) || name == "xtask/src/tidy/english.rs" {
        return Vec::new();
    }
    let kind = name.rsplit_once('.').map_or("", |(_, kind)| kind);
    let mut found = Vec::new();
    if matches!(kind, "rs" | "js" | "mjs" | "wgsl" | "glsl" | "css" | "html" | "md" | "sh" | "py") {
        found.extend(phrases(name, text));
    }
    if matches!(kind, "rs" | "js" | "mjs" | "wgsl" | "glsl" | "css") {
        found.extend(long_comments(name, text));
        found.extend(headless_docs(name, text));
    }
    if kind == "md" {
        found.extend(long_markdown(name, text));
    }
    found
}

/// Phrases of the list, with the line that each starts in.
fn phrases(name: &str, text: &str) -> Vec<String> {
    // Comment markers become spaces of the same length, so that offsets keep their lines.
    let prose: String = text
        .split_inclusive('\n')
        .map(|line| {
            let body = line.trim_start();
            let marker = ["///", "//!", "//", "/**", "* "]
                .into_iter()
                .find(|marker| body.starts_with(marker))
                .map_or(0, str::len);
            let blank = line.len() - body.len() + marker;
            format!("{}{}", " ".repeat(blank), &line[blank..])
        })
        .collect();
    let mut found = Vec::new();
    for (phrase, pattern) in PHRASES.iter() {
        for hit in pattern.find_iter(&prose) {
            let line = prose[..hit.start()].matches('\n').count() + 1;
            found.push((line, format!("{name}:{line}: avoid \"{phrase}\"")));
        }
    }
    found.sort();
    found.into_iter().map(|(_, violation)| violation).collect()
}

fn long_comments(name: &str, text: &str) -> Vec<String> {
    (1..)
        .zip(text.lines())
        .filter(|(_, line)| {
            let body = line.trim_start();
            ["//", "/*", "* "].iter().any(|marker| body.starts_with(marker))
                && line.chars().count() > COMMENT_COLUMNS
                && body.split_whitespace().count() > 2
        })
        .map(|(number, _)| format!("{name}:{number}: comment beyond {COMMENT_COLUMNS} columns"))
        .collect()
}

/// Rows of tables, and lines that hold one unbreakable word such as an address, may be longer.
fn long_markdown(name: &str, text: &str) -> Vec<String> {
    (1..)
        .zip(text.lines())
        .filter(|(_, line)| {
            line.chars().count() > MARKDOWN_COLUMNS
                && !line.starts_with('|')
                && !line.starts_with("![")
                && line.split_whitespace().count() > 2
        })
        .map(|(number, _)| format!("{name}:{number}: line beyond {MARKDOWN_COLUMNS} columns"))
        .collect()
}

/// Doc comments whose first line begins without a verb or a noun.
fn headless_docs(name: &str, text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut inside = false;
    for (number, line) in (1..).zip(text.lines()) {
        let body = line.trim_start();
        let doc = ["/// ", "//! ", "/** "].iter().find_map(|marker| body.strip_prefix(marker));
        if let Some(doc) = doc
            && !inside
            && let Some(word) = HEADLESS.iter().find(|word| doc.starts_with(**word))
        {
            let word = word.trim();
            found.push(format!("{name}:{number}: doc begins with \"{word}\": name the thing"));
        }
        inside = doc.is_some();
    }
    found
}

#[cfg(test)]
mod tests {
    use super::super::tests::assert_refused;
    use super::violations;

    #[test]
    fn text_is_refused_when_it_breaks_a_rule() {
        let long = format!("//! {}\n", "word ".repeat(30));
        let cases = [
            ("crates/a/src/b.rs", "// The worker is told.\n".to_owned(), ":1: avoid \"is told\""),
            ("crates/a/src/b.rs", "//! A.\n/// Keeps so\n/// many rows.\n".to_owned(), ":2: avoid"),
            ("web/a.js", "/** Whether it moves. */\n".to_owned(), "doc begins with \"Whether\""),
            ("crates/a/src/b.rs", long, "beyond 100 columns"),
            ("docs/a.md", format!("{}\n", "word ".repeat(30)), "beyond 120 columns"),
            ("docs/a.md", "From the one to\nthe other.\n".to_owned(), "the one ... the other"),
        ];
        assert_refused(violations, &cases);
    }

    #[test]
    fn text_passes_when_it_is_fixed_or_a_table_or_continues_a_paragraph() {
        let row = format!("| {} |\n", "word ".repeat(30));
        assert_eq!(violations("docs/a.md", &row), Vec::<String>::new());
        assert_eq!(violations("migrations/0001_a.sql", "-- nobody\n"), Vec::<String>::new());
        let text = "/// Returns the share.\n/// What is above it is cut.\nfn f() {}\n";
        assert_eq!(violations("crates/a/src/b.rs", text), Vec::<String>::new());
        assert_eq!(violations("crates/a/src/b.rs", "// On hardware.\n"), Vec::<String>::new());
    }
}
