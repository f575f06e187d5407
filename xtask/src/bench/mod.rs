//! `cargo xtask bench peers`: other programs and brood on the same work, in turn, in one run.
//!
//! Owns the options and the order of the work. A peer that cannot be installed is named and left out; the run fails for
//! that only when asked to. How peers come here is the environment's business, what they are held against the
//! comparison's.

mod compare;
mod environment;
mod measure;
mod table;

use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use serde_json::json;

use crate::shell;
use environment::Environment;

/// What the command line says.
#[derive(Debug, PartialEq)]
struct Options {
    /// Where results are written.
    out: PathBuf,
    /// Whether a missing peer is a failure.
    require: bool,
    /// Whether brood is built as it is shipped, instead of with the profile of the tests.
    release: bool,
    /// A brood that is there already, instead of one that is built.
    brood: Option<PathBuf>,
    /// How often everything is run; the best of each counts.
    rounds: u32,
}

impl Options {
    fn parse(words: &[&str]) -> Result<Self> {
        let mut options = Self {
            out: PathBuf::from("target/bench/peers"),
            require: false,
            release: false,
            brood: None,
            rounds: 2,
        };
        let mut words = words.iter();
        while let Some(word) = words.next() {
            match *word {
                "--require" => options.require = true,
                "--release" => options.release = true,
                "--out" => options.out = words.next().context("--out needs a folder")?.into(),
                "--brood" => {
                    let file = words.next().context("--brood needs a file")?;
                    options.brood = Some(std::path::absolute(file).context("find brood")?);
                }
                "--rounds" => {
                    let count = words.next().and_then(|word| word.parse().ok());
                    options.rounds = count
                        .filter(|count| (1..=100).contains(count))
                        .context("--rounds needs a number from 1 to 100")?;
                }
                word => bail!("unknown option {word} of bench peers"),
            }
        }
        Ok(options)
    }
}

/// Runs the comparison with peers.
pub fn peers(words: &[&str]) -> Result<()> {
    let options = Options::parse(words)?;
    let environment = Environment::prepare(&options)?;
    let mut findings = measure::Findings::new(&environment);
    for round in 1..=options.rounds {
        println!("\n== round {round} of {}", options.rounds);
        findings.round(&environment);
    }
    let rows = compare::rows(&findings);
    findings.missing.extend(compare::gaps(&findings));
    let text = table::markdown(&rows, &findings, &environment);
    let report = json!({
        "machine": environment.machine(),
        "rounds": options.rounds,
        "comparisons": rows.iter().map(compare::Row::json).collect::<Vec<_>>(),
        "missing": findings.missing,
        "raw": findings.raw(),
    });
    let folder = shell::root().join(&options.out);
    std::fs::create_dir_all(&folder).with_context(|| format!("make {}", folder.display()))?;
    let write = |name: &str, text: &str| {
        std::fs::write(folder.join(name), text).with_context(|| format!("write {name}"))
    };
    write("peers.json", &format!("{report:#}\n"))?;
    write("peers.md", &text)?;
    println!("\n{text}\nwritten to {}", folder.display());
    if options.require && !findings.missing.is_empty() {
        bail!("not everything could be compared: {}", findings.missing.join("; "));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::Options;

    #[test]
    fn options_are_refused_when_a_word_is_unknown_or_a_value_is_missing() {
        for words in
            [&["--fast"][..], &["--out"], &["--brood"], &["--rounds", "0"], &["--rounds", "many"]]
        {
            assert!(Options::parse(words).is_err(), "{words:?}");
        }
    }

    #[test]
    fn options_are_read_when_given() {
        let options = Options::parse(&["--require", "--out", "x/y", "--rounds", "3"]).unwrap();
        assert!(options.require && !options.release);
        assert_eq!((options.out.to_str(), options.rounds), (Some("x/y"), 3));
    }
}
