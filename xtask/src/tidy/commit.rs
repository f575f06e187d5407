//! Rule for commit subjects: an area, then an imperative, at most 72 characters.
//!
//! Checks commits after the one that introduced the rule, where the tree is a git checkout.

use std::path::Path;
use std::process::Command;

/// Longest subject, in characters.
const SUBJECT_CHARS: usize = 72;
/// Last commit before the rule.
const RULE_BASE: &str = "2f0a4ca55004da0feb4d7588fbed0f974c13877f";

/// Returns every subject that breaks the rule; none outside a git checkout that holds the base
/// commit.
pub fn violations(root: &Path) -> Vec<String> {
    let range = format!("{RULE_BASE}..HEAD");
    let log = Command::new("git")
        .args(["log", "--no-merges", "--format=%h %s", &range])
        .current_dir(root)
        .output();
    let Ok(log) = log else { return Vec::new() };
    if !log.status.success() {
        return Vec::new();
    }
    let text = String::from_utf8_lossy(&log.stdout);
    text.lines()
        .filter_map(|line| {
            let (hash, subject) = line.split_once(' ')?;
            objection(subject).map(|reason| format!("commit {hash}: {reason}: {subject}"))
        })
        .collect()
}

/// Reason why a subject breaks the rule.
fn objection(subject: &str) -> Option<String> {
    let length = subject.chars().count();
    if length > SUBJECT_CHARS {
        return Some(format!("{length} characters, more than {SUBJECT_CHARS}"));
    }
    if subject.ends_with('.') {
        return Some("ends with a full stop".to_owned());
    }
    let Some((_, text)) = subject.split_once(": ") else {
        return Some("has no \"area: \" in front".to_owned());
    };
    let first = text.split_whitespace().next().unwrap_or_default().to_lowercase();
    let past = first.ends_with("ed")
        && !["embed", "feed", "seed", "shed", "need"].contains(&first.as_str());
    let article =
        ["a", "an", "the", "what", "who", "it", "no", "all", "each"].contains(&first.as_str());
    let gerund = first.ends_with("ing") && first != "bring" && first != "string";
    (past || article || gerund).then(|| format!("\"{first}\" is not an imperative"))
}

#[cfg(test)]
mod tests {
    use super::objection;

    #[test]
    fn subject_passes_when_it_is_an_imperative_with_an_area() {
        assert_eq!(objection("storage: order history by birth"), None);
        assert_eq!(objection("docs: seed the glossary"), None);
    }

    #[test]
    fn subject_is_refused_when_it_breaks_a_rule() {
        let long = format!("eval: {}", "x".repeat(70));
        let cases = [
            (long.as_str(), "76 characters"),
            ("eval: skip empty blocks.", "full stop"),
            ("Skip empty blocks", "area"),
            ("eval: the blocks are skipped", "imperative"),
            ("eval: skipped empty blocks", "imperative"),
        ];
        for (subject, part) in cases {
            let found = objection(subject);
            assert!(
                found.as_deref().is_some_and(|found| found.contains(part)),
                "{subject}: {found:?}"
            );
        }
    }
}
