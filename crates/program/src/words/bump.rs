//! Words of bumps: a mask of the slopes whose sign is negative (bit 0: along u, bit 1: along v),
//! then the words of their code.

use brood_genome::Input;

use super::WordsError;
use crate::{Bumps, Meaning, Program};

pub(super) fn write(bumps: &Bumps, words: &mut Vec<u32>) {
    let [along_u, along_v] = bumps.is_negative.map(u32::from);
    words.push(along_u | along_v << 1);
    words.extend(bumps.code.to_words());
}

/// Reads bumps, which are the rest of the words.
pub(super) fn read(words: &[u32], start: usize) -> Result<Bumps, WordsError> {
    let (signs, rest) =
        words.get(start..).and_then(<[u32]>::split_first).ok_or(WordsError::Length)?;
    let invalid = WordsError::Bumps(start);
    let code = Program::from_words(rest).map_err(|_| invalid)?;
    let reads = code.inputs().iter().all(|input| matches!(input, Input::U | Input::V));
    if *signs > 3 || code.meaning != Meaning::Slopes || !reads {
        return Err(invalid);
    }
    Ok(Bumps { code, is_negative: [signs & 1 != 0, signs & 2 != 0] })
}

#[cfg(test)]
mod tests {
    use brood_genome::{BirthKey, Dialect, DialectConstraints, Variation};

    use super::*;

    #[test]
    fn bumps_round_trip_and_broken_ones_are_refused() {
        let constraints = DialectConstraints { bumps: Some(true), ..Default::default() };
        for dialect in [Dialect::default(), Dialect { length: 0, ..Dialect::default() }] {
            let random = Variation::random(dialect).with_constraints(constraints);
            let genome = random.birth(BirthKey { seed: 2, slot: 0, attempt: 0 });
            let program = Program::lower(&genome);
            let words = program.to_words();
            assert_eq!(Program::from_words(&words).as_ref(), Ok(&program));
            let flat = program.clone().without_bumps();
            assert_ne!(program.hash(), flat.hash());
            // The number of layers is a word more than in a program without bumps or layers.
            let start = flat.to_words().len() + usize::from(flat.layers().is_empty());
            let broken = |at: usize, word: u32| {
                let mut words = words.clone();
                words[at] = word;
                Program::from_words(&words)
            };
            let invalid = Err(WordsError::Bumps(start));
            assert_eq!(broken(start, 4), invalid);
            assert_eq!(broken(start + 1, words[0]), invalid);
            assert_eq!(broken(start + 2, words.len() as u32), invalid);
            assert_eq!(Program::from_words(&words[..start]), Err(WordsError::Length));
            for end in start + 1..words.len() {
                assert_eq!(Program::from_words(&words[..end]), invalid);
            }
        }
    }
}
