//! Parser of `--dialect`: the words of the `.dialect` line of a genome's text form, each optional.

use std::iter::Peekable;
use std::str::{FromStr, SplitWhitespace};

use brood_genome::{Dialect, OpcodeSet, Parametrisation};

/// Dialect given on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DialectWords(pub Dialect);

impl FromStr for DialectWords {
    type Err = String;

    /// Parses `[paper|extended] [smooth|paper] [registers N] [length N] [isotropic] [homogeneous]`.
    /// A single `paper` is the parametrisation, because the paper's opcodes are the default.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut words = text.split_whitespace().peekable();
        let mut dialect = Dialect::default();
        let first = words.next_if(|word| matches!(*word, "paper" | "extended" | "smooth"));
        let second = words.next_if(|word| matches!(*word, "paper" | "smooth"));
        match (first, second) {
            (Some("smooth"), Some(_)) => {
                return Err(
                    "the opcode set must come before the parametrisation, as in 'extended smooth'"
                        .into(),
                );
            }
            (Some("extended"), _) => dialect = extended(dialect),
            _ => {}
        }
        if second.or(first) == Some("paper") {
            dialect.parametrisation = Parametrisation::Paper;
        }
        while let Some(word) = words.next() {
            match word {
                "registers" => dialect.registers = number(&mut words, "registers")?,
                "length" => dialect.length = number(&mut words, "length")?,
                "isotropic" => dialect.isotropic = true,
                "homogeneous" => dialect.homogeneous = true,
                _ => {
                    return Err(format!(
                        "unknown word `{word}`; expected paper, extended, smooth, registers N, length N, isotropic or homogeneous"
                    ));
                }
            }
        }
        dialect.validate().map_err(|error| error.to_string())?;
        Ok(Self(dialect))
    }
}

/// Returns the dialect with the extended opcodes and their default number of registers.
fn extended(dialect: Dialect) -> Dialect {
    Dialect { opcodes: OpcodeSet::Extended, registers: 10, ..dialect }
}

fn number<T: FromStr>(words: &mut Peekable<SplitWhitespace<'_>>, name: &str) -> Result<T, String> {
    words
        .next()
        .and_then(|word| word.parse().ok())
        .ok_or(format!("`{name}` must be followed by a number"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Dialect, String> {
        text.parse::<DialectWords>().map(|words| words.0)
    }

    #[test]
    fn words_select_the_dialect() {
        let default = Dialect::default();
        assert_eq!(parse(""), Ok(default));
        assert_eq!(parse("smooth registers 7"), Ok(default));
        assert_eq!(parse("paper smooth registers 7"), Ok(default));
        let paper = Dialect { parametrisation: Parametrisation::Paper, ..default };
        assert_eq!(parse("paper"), Ok(paper));
        assert_eq!(parse("paper paper length 30").map(|d| (d.parametrisation, d.length)), {
            Ok((Parametrisation::Paper, 30))
        });
        assert_eq!(parse("length 0").map(|d| d.length), Ok(0), "models only");
        let wide = Dialect { isotropic: true, ..extended(default) };
        assert_eq!(parse("extended isotropic"), Ok(wide));
        assert_eq!(parse("extended paper registers 12").map(|d| d.registers), Ok(12));
    }

    #[test]
    fn words_are_rejected_when_they_are_not_a_dialect() {
        for text in
            ["registers", "registers x", "smooth extended", "registers 3", "length 1025", "foo"]
        {
            assert!(parse(text).is_err(), "{text}");
        }
    }
}
