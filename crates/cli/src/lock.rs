//! LIST arguments of locks: instructions, constants, channels, layers, effects and parameters of
//! these in one list.

use std::str::FromStr;

use brood_genome::{Channel, EffectKind, EffectLock, Locks, ParameterLock};

/// Locks given on the command line, for example `12,30,C5,r,L0,L1.roughness`.
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
                _ => parse_word(word, &mut locks).ok_or_else(|| {
                    format!(
                        "unknown lock `{word}`: expected an instruction number, a constant as C5, a channel r, g or b, a \
                         layer as L0, a parameter as L0.roughness, an effect as light or its parameter as light.palette, \
                         or bump"
                    )
                })?,
            }
        }
        Ok(Self(locks))
    }
}

/// Adds the lock of a word other than a channel; `None` if the word is not a lock.
fn parse_word(word: &str, locks: &mut Locks) -> Option<()> {
    if let Some(layer) = word.strip_prefix('L') {
        match layer.split_once('.') {
            None => locks.layers.push(layer.parse().ok()?),
            Some((_, "")) => return None,
            Some((layer, name)) => {
                let lock = ParameterLock { layer: layer.parse().ok()?, name: name.to_owned() };
                locks.parameters.push(lock);
            }
        }
    } else if word == "bump" {
        locks.bump = true;
    } else if let Some(digits) = word.strip_prefix('C') {
        locks.constants.push(digits.parse().ok()?);
    } else if let Some(effect) = EffectKind::from_name(word) {
        locks.effects.push(effect);
    } else if let Some((effect, name)) = word.split_once('.') {
        let effect = EffectKind::from_name(effect)?;
        locks.effect_parameters.push(EffectLock { effect, name: name.to_owned() });
    } else {
        locks.instructions.push(word.parse().ok()?);
    }
    Some(())
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
            layers: vec![1],
            parameters: vec![ParameterLock { layer: 0, name: "f0".to_owned() }],
            effects: vec![EffectKind::Silhouette],
            effect_parameters: vec![EffectLock {
                effect: EffectKind::Light,
                name: "palette".to_owned(),
            }],
            bump: true,
        };
        assert_eq!(
            "12, C5,r,0,b,L1,L0.f0,silhouette,light.palette,bump".parse(),
            Ok(LockWords(locks))
        );
        for text in ["", "x", "C", "C300", "-1", "12,,r", "L", "Lx", "L0.", "glow", "glow.to"] {
            let error = text.parse::<LockWords>().unwrap_err();
            assert!(error.contains("unknown lock"), "{text}: {error}");
        }
    }
}
