//! Rule for references in Markdown: relative links, their anchors, and paths in backticks lead to
//! something in the tree.
//!
//! Code moves more often than the documents that name it. Recorded runs describe the tree of their
//! day and are not checked.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::Path;
use std::sync::LazyLock;

use anyhow::{Context, Result};
use regex::Regex;

/// Names of folders that hold no sources. `target` is one only in the root.
const SKIPPED: [&str; 2] = ["node_modules", ".git"];

/// First part of the paths of records, which are never edited.
const RECORDS: &str = "docs/bench/runs/";

/// Folders of the root. Text in backticks that begins with one of them is a path.
const FOLDERS: [&str; 8] =
    ["crates/", "server/", "worker/", "web/", "tests/", "xtask/", "docs/", "migrations/"];

/// Target of `[text](target)`; an optional title follows it.
static LINK: LazyLock<Regex> = LazyLock::new(|| pattern(r#"\]\(\s*<?([^\s<>)]+)>?(?:\s[^)]*)?\)"#));
/// End of a link, from the bracket after its text.
static LINK_END: LazyLock<Regex> = LazyLock::new(|| pattern(r"\]\([^)]*\)"));
/// Text in backticks, within a paragraph.
static CODE: LazyLock<Regex> = LazyLock::new(|| pattern(r"`((?:[^`\n]|\n[^`\n])+)`"));
/// Parts of a path that stand for others: `*`, `<name>`, `{name}` and `{one,other}`.
static WILDCARD: LazyLock<Regex> = LazyLock::new(|| pattern(r"\*+|<[^>]*>|\{[^}]*\}"));

fn pattern(text: &str) -> Regex {
    Regex::new(text).expect("every pattern of this file is valid")
}

/// Returns every reference that leads nowhere, as `name:line: reason`.
pub fn violations(root: &Path) -> Result<Vec<String>> {
    let mut tree = Tree::default();
    tree.gather(root, root)?;
    Ok(tree.violations())
}

/// Paths of files and folders from the root, and the text of Markdown files.
#[derive(Default)]
struct Tree {
    paths: BTreeSet<String>,
    documents: BTreeMap<String, String>,
}

impl Tree {
    fn gather(&mut self, root: &Path, folder: &Path) -> Result<()> {
        let entries =
            std::fs::read_dir(folder).with_context(|| format!("list {}", folder.display()))?;
        for entry in entries {
            let entry = entry.with_context(|| format!("list {}", folder.display()))?;
            let path = entry.path();
            let inner = path.strip_prefix(root).expect("every entry lies below the root");
            let name = inner.to_string_lossy().replace('\\', "/");
            if SKIPPED.iter().any(|skipped| path.ends_with(skipped)) || name == "target" {
                continue;
            }
            let kind = entry.file_type().with_context(|| format!("look at {name}"))?;
            if kind.is_dir() {
                self.gather(root, &path)?;
            } else if name.ends_with(".md") {
                let text =
                    std::fs::read_to_string(&path).with_context(|| format!("read {name}"))?;
                self.documents.insert(name.clone(), text);
            }
            self.paths.insert(name);
        }
        Ok(())
    }

    fn violations(&self) -> Vec<String> {
        let checked = self.documents.iter().filter(|(name, _)| !name.starts_with(RECORDS));
        checked.flat_map(|(name, text)| self.check(name, text)).collect()
    }

    /// Violations in one document.
    fn check(&self, name: &str, text: &str) -> Vec<String> {
        let prose = without_fences(text);
        let mut found = Vec::new();
        for code in CODE.captures_iter(&prose) {
            if is_path(&code[1]) && !self.holds(&code[1]) {
                found.push((line_at(&prose, &code), format!("no file `{}`", &code[1])));
            }
        }
        // A link inside code is an example.
        let linked = CODE.replace_all(&prose, |code: &regex::Captures<'_>| blank(&code[0]));
        for link in LINK.captures_iter(&linked) {
            if let Some(reason) = self.broken(name, &link[1]) {
                found.push((line_at(&linked, &link), reason));
            }
        }
        found.sort();
        found.into_iter().map(|(line, reason)| format!("{name}:{line}: {reason}")).collect()
    }

    /// Reason why a link leads nowhere; `None` if it is fine or leaves the tree by an address.
    fn broken(&self, name: &str, target: &str) -> Option<String> {
        if target.contains("://") || target.starts_with("mailto:") {
            return None;
        }
        let (file, anchor) = target.split_once('#').map_or((target, None), |(a, b)| (a, Some(b)));
        let path = if file.is_empty() { name.to_owned() } else { resolve(name, file) };
        if !self.paths.contains(&path) && !path.is_empty() {
            return Some(format!("the link {target} leads to no file"));
        }
        let (text, anchor) = self.documents.get(&path).zip(anchor)?;
        let missing = !anchors(text).contains(anchor);
        missing.then(|| format!("the link {target} leads to no heading of {path}"))
    }

    /// True if something in the tree has this path, with or without wildcards.
    fn holds(&self, path: &str) -> bool {
        let path = path.trim_end_matches('/');
        if !WILDCARD.is_match(path) {
            return self.paths.contains(path);
        }
        let mut expression = String::from("^");
        let mut end = 0;
        for wildcard in WILDCARD.find_iter(path) {
            expression += &regex::escape(&path[end..wildcard.start()]);
            expression += &match wildcard.as_str() {
                "**" => ".*".to_owned(),
                braces if braces.contains(',') => {
                    let choices = braces.trim_matches(['{', '}']).split(',').map(regex::escape);
                    format!("(?:{})", choices.collect::<Vec<_>>().join("|"))
                }
                _ => "[^/]+".to_owned(),
            };
            end = wildcard.end();
        }
        expression += &regex::escape(&path[end..]);
        expression.push('$');
        let expression = Regex::new(&expression).expect("everything but wildcards is escaped");
        self.paths.iter().any(|path| expression.is_match(path))
    }
}

fn is_path(code: &str) -> bool {
    FOLDERS.iter().any(|folder| code.starts_with(folder)) && !code.contains(char::is_whitespace)
}

/// Path from the root of a target that is relative to the document `name`.
fn resolve(name: &str, target: &str) -> String {
    let mut parts: Vec<&str> = name.split('/').collect();
    parts.pop();
    if target.starts_with('/') {
        parts.clear();
    }
    for part in target.split('/') {
        match part {
            "" | "." => {}
            ".." if parts.last().is_some_and(|last| *last != "..") => {
                parts.pop();
            }
            part => parts.push(part),
        }
    }
    parts.join("/")
}

/// Text whose fenced blocks are blank, with all line breaks kept.
fn without_fences(text: &str) -> String {
    let mut prose = String::with_capacity(text.len());
    let mut inside = false;
    for line in text.split_inclusive('\n') {
        let fence = line.trim_start().starts_with("```");
        prose += if fence || inside { "\n" } else { line };
        inside ^= fence;
    }
    prose
}

/// Spaces of the same length, with all line breaks kept.
fn blank(text: &str) -> String {
    text.chars().map(|c| if c == '\n' { c } else { ' ' }).collect()
}

fn line_at(text: &str, hit: &regex::Captures<'_>) -> usize {
    let start = hit.get(1).map_or(0, |group| group.start());
    text[..start].matches('\n').count() + 1
}

/// Anchors of the headings of a document, by the rules of GitHub: lower case without punctuation,
/// hyphens for spaces, and a number for repeated headings.
fn anchors(text: &str) -> BTreeSet<String> {
    let mut repeats: HashMap<String, usize> = HashMap::new();
    let mut anchors = BTreeSet::new();
    for line in without_fences(text).lines() {
        let heading = line.trim_start_matches('#');
        let level = line.len() - heading.len();
        if !(1..=6).contains(&level) || !heading.starts_with(' ') {
            continue;
        }
        let shown = LINK_END.replace_all(heading.trim(), "]").to_lowercase();
        let kept = shown.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        let slug: String = kept.map(|c| if c == ' ' { '-' } else { c }).collect();
        let repeat = repeats.entry(slug.clone()).or_default();
        anchors.insert(if *repeat == 0 { slug } else { format!("{slug}-{repeat}") });
        *repeat += 1;
    }
    anchors
}

#[cfg(test)]
mod tests {
    use super::{Tree, anchors};

    fn tree(document: &str) -> Tree {
        let guide = "# Guide\n\n## Your own `f`, at 2 %\n\n## Models\n\n## Models\n";
        let documents = [("docs/a.md", document), ("docs/guide.md", guide)];
        let others = ["README.md", "docs", "crates", "crates/a/src/b.rs", "docs/c.png"];
        Tree {
            paths: documents
                .iter()
                .map(|(name, _)| *name)
                .chain(others)
                .map(str::to_owned)
                .collect(),
            documents: documents.map(|(name, text)| (name.to_owned(), text.to_owned())).into(),
        }
    }

    #[test]
    fn reference_is_refused_when_it_leads_nowhere() {
        let cases = [
            ("See [x](gone.md).\n", ":1: the link gone.md leads to no file"),
            ("One.\nSee [x](../docs/guide.md#gone).\n", ":2: the link ../docs/guide.md#gone leads"),
            ("See [x](#gone).\n", "no heading of docs/a.md"),
            ("![x](d.png \"title\")\n", "the link d.png"),
            ("See `crates/a/src/gone.rs`.\n", "no file `crates/a/src/gone.rs`"),
            ("See `crates/*/src/<name>.md`.\n", "no file"),
            ("See `crates/a/src/{c,d}.rs`.\n", "no file"),
            ("See [x](../../docs/c.png).\n", "leads to no file"),
        ];
        for (text, part) in cases {
            let found = tree(text).violations();
            assert_eq!(found.len(), 1, "{text}: {found:?}");
            assert!(found[0].contains(part), "{part}: {found:?}");
        }
    }

    #[test]
    fn reference_passes_when_it_exists_or_is_no_reference() {
        let cases = [
            "See [x](guide.md#your-own-f-at-2-), [y](guide.md#models-1), [z](../README.md), ![](c.png).\n",
            "# Head\n[x](#head) [y](https://example.org/gone.md) [z](/docs/guide.md) [](..)\n",
            "`crates/a/src/b.rs` `crates/*/src/{b,c}.rs` `crates/<name>/**/b.rs` `docs/`\n",
            "`[x](gone.md)` `target/gone` `docs/gone --flag`\n```\n`docs/gone.md` [x](gone.md)\n```\n",
        ];
        for text in cases {
            assert_eq!(tree(text).violations(), Vec::<String>::new());
        }
    }

    #[test]
    fn records_are_not_checked() {
        let mut tree = tree("");
        tree.documents.insert("docs/bench/runs/a/README.md".to_owned(), "[x](gone)".to_owned());
        assert_eq!(tree.violations(), Vec::<String>::new());
    }

    #[test]
    fn anchors_follow_the_rules_of_github() {
        let text = "# A [link](b.md) & f_o, 3.1\n```\n# no heading\n```\n#no heading\n";
        assert_eq!(anchors(text).into_iter().collect::<Vec<_>>(), ["a-link--f_o-31"]);
    }
}
