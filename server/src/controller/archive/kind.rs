//! Formats of the files of an archive: genome text, pictures, and exports.

use std::fmt;

use brood_export::Format;
use brood_protocol::PictureFormat;
use serde::{Deserialize, Serialize};

use crate::problem::quote;

/// Format of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Kind {
    /// Genome as text.
    Brood,
    /// Picture.
    Picture(PictureFormat),
    /// Export.
    Source(Format),
}

impl Kind {
    /// Parses names, each kept once.
    ///
    /// # Errors
    /// Words about the first unknown name.
    pub fn list<'a>(names: impl Iterator<Item = &'a str>) -> Result<Vec<Self>, String> {
        let mut kinds = Vec::new();
        for name in names {
            let kind = Self::try_from(name.to_owned())?;
            if !kinds.contains(&kind) {
                kinds.push(kind);
            }
        }
        Ok(kinds)
    }

    /// Returns the name of a file.
    pub fn file_name(self, stem: &str) -> String {
        match self {
            Self::Source(format) => format.file_name(stem),
            Self::Brood | Self::Picture(_) => format!("{stem}.{self}"),
        }
    }

    /// True for tables of 1 to 52 MB.
    pub fn is_binary_table(self) -> bool {
        matches!(self, Self::Source(format) if format.is_binary())
    }

    /// True for pictures.
    pub fn is_picture(self) -> bool {
        matches!(self, Self::Picture(_))
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Brood => "brood",
            Self::Picture(format) => format.name(),
            Self::Source(format) => format.name(),
        })
    }
}

impl From<Kind> for String {
    fn from(kind: Kind) -> Self {
        kind.to_string()
    }
}

impl TryFrom<String> for Kind {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        match name.as_str() {
            "brood" => Ok(Self::Brood),
            "png" => Ok(Self::Picture(PictureFormat::Png)),
            "exr" => Ok(Self::Picture(PictureFormat::Exr)),
            other => other.parse().map(Self::Source).map_err(|_| {
                let known = Format::ALL.map(Format::name).join(", ");
                format!("must be names among brood, png, exr, {known}, got {}", quote(other))
            }),
        }
    }
}
