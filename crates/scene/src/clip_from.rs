//! Setting from which code on a channel of a picture counts as clipped.

use std::fmt;
use std::str::FromStr;

use serde::de::{Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Code from which a channel of a picture of display codes counts as clipped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum ClipFrom {
    /// Found from the plateaus of the picture. Code 255 is always clipped.
    #[default]
    Auto,
    /// This code of 8 bits and above, 1 to 255.
    Code(u8),
    /// Nothing is clipped.
    Off,
}

/// Error if text or a number is not such a setting.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("clip_from must be \"auto\", \"off\" or a code from 1 to 255; 256 is \"off\"")]
pub struct ClipFromError;

impl ClipFrom {
    /// Largest code only.
    pub const LARGEST: Self = Self::Code(u8::MAX);

    /// Makes the setting from a code; 256 is [`ClipFrom::Off`].
    ///
    /// # Errors
    /// Returns [`ClipFromError`] if `code` is not in 1..=256.
    pub fn code(code: u64) -> Result<Self, ClipFromError> {
        match code {
            256 => Ok(Self::Off),
            1..=255 => Ok(Self::Code(u8::try_from(code).map_err(|_| ClipFromError)?)),
            _ => Err(ClipFromError),
        }
    }
}

impl fmt::Display for ClipFrom {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Code(code) => code.fmt(f),
            Self::Off => f.write_str("off"),
        }
    }
}

impl FromStr for ClipFrom {
    type Err = ClipFromError;

    fn from_str(text: &str) -> Result<Self, ClipFromError> {
        match text {
            "auto" => Ok(Self::Auto),
            "off" => Ok(Self::Off),
            _ => text.parse().map_err(|_| ClipFromError).and_then(Self::code),
        }
    }
}

impl Serialize for ClipFrom {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match (serializer.is_human_readable(), self) {
            (true, Self::Auto) => serializer.serialize_str("auto"),
            (true, Self::Off) => serializer.serialize_str("off"),
            (false, Self::Auto) => serializer.serialize_u16(0),
            (false, Self::Off) => serializer.serialize_u16(256),
            (_, Self::Code(code)) => serializer.serialize_u16(u16::from(*code)),
        }
    }
}

impl<'de> Deserialize<'de> for ClipFrom {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        if deserializer.is_human_readable() {
            return deserializer.deserialize_any(ClipFromVisitor);
        }
        match u16::deserialize(deserializer)? {
            0 => Ok(Self::Auto),
            code => Self::code(code.into()).map_err(serde::de::Error::custom),
        }
    }
}

struct ClipFromVisitor;

impl Visitor<'_> for ClipFromVisitor {
    type Value = ClipFrom;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("\"auto\", \"off\" or a code from 1 to 255")
    }

    fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<ClipFrom, E> {
        text.parse().map_err(|_| E::invalid_value(Unexpected::Other("another word"), &self))
    }

    fn visit_u64<E: serde::de::Error>(self, code: u64) -> Result<ClipFrom, E> {
        ClipFrom::code(code).map_err(E::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_round_trip_as_text_json_and_bytes() {
        for (text, json, setting) in [
            ("auto", "\"auto\"", ClipFrom::Auto),
            ("off", "\"off\"", ClipFrom::Off),
            ("250", "250", ClipFrom::Code(250)),
        ] {
            assert_eq!((text.parse(), setting.to_string()), (Ok(setting), text.to_owned()));
            assert_eq!(serde_json::to_string(&setting).unwrap(), json);
            assert_eq!(serde_json::from_str::<ClipFrom>(json).unwrap(), setting);
            let bytes = postcard::to_stdvec(&setting).unwrap();
            assert_eq!(postcard::from_bytes::<ClipFrom>(&bytes).unwrap(), setting);
        }
        assert_eq!("256".parse(), Ok(ClipFrom::Off));
        for wrong in ["0", "257", "-1", "Auto", ""] {
            assert_eq!(wrong.parse::<ClipFrom>(), Err(ClipFromError), "{wrong}");
        }
        for wrong in ["0", "257", "-1", "1.5", "\"on\"", "null"] {
            assert!(serde_json::from_str::<ClipFrom>(wrong).is_err(), "{wrong}");
        }
    }
}
