//! Goals of the measurements.

use std::fmt::Write;

use anyhow::Result;

/// Least value that is a goal, with the measured one.
pub struct Goal {
    /// Description of the value.
    pub what: String,
    /// Least value.
    pub goal: f64,
    /// Measured value.
    pub found: f64,
}

/// Table of goals.
pub fn markdown(goals: &[Goal]) -> Result<String> {
    let mut text =
        String::from("\n## Goals\n\n| value | goal | measured | |\n|---|---:|---:|---|\n");
    for Goal { what, goal, found } in goals {
        let word = if found >= goal { "met" } else { "missed" };
        writeln!(text, "| {what} | {:.0} % | {:.1} % | {word} |", 100.0 * goal, 100.0 * found)?;
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::{Goal, markdown};

    #[test]
    fn goals_are_met_or_missed() {
        let goal = |found| Goal { what: "share".to_owned(), goal: 0.95, found };
        let text = markdown(&[goal(0.95), goal(0.9), goal(f64::NAN)]).unwrap();
        let words: Vec<_> =
            text.lines().rev().take(3).filter(|line| line.ends_with("missed |")).collect();
        assert!(text.contains("| share | 95 % | 95.0 % | met |") && words.len() == 2, "{text}");
    }
}
