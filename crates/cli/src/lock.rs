//! LIST arguments of locks: numbers of instructions, constants and channels in one list.

use std::str::FromStr;

use brood_genome::{Channel, Locks};

/// Locks as they are written on the command line: `12,30,C5,r`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LockWords(pub Locks);

impl FromStr for LockWords {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut locks = Locks::default();
        for word in text.split(',').map(str::trim) {
            match word {
                "r" => locks.channels.push(Channel::Red),
                "g" => locks.channels.push(Channel::Green),
                "b" => locks.channels.push(Channel::Blue),
                _ => match word.strip_prefix('C').map_or_else(
                    || word.parse().map(|index| locks.instructions.push(index)),
                    |digits| digits.parse().map(|index| locks.constants.push(index)),
                ) {
                    Ok(()) => {}
                    Err(_) => {
                        return Err(format!(
                            "`{word}` is neither the number of an instruction, nor a constant as C5, nor r, g or b"
                        ));
                    }
                },
            }
        }
        Ok(Self(locks))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_name_instructions_constants_and_channels() {
        let locks = Locks {
            instructions: vec![12, 0],
            constants: vec![5],
            channels: vec![Channel::Red, Channel::Blue],
        };
        assert_eq!("12, C5,r,0,b".parse(), Ok(LockWords(locks)));
        for text in ["", "x", "C", "C300", "-1", "12,,r"] {
            let error = text.parse::<LockWords>().unwrap_err();
            assert!(error.contains("neither the number of an instruction"), "{text}: {error}");
        }
    }
}
