//! Export formats: names, file extensions and media types.

use std::str::FromStr;

use crate::language::Language;

/// Export format of a material.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// Functions for WebGL 2 and OpenGL ES 3.
    GlslEs300,
    /// Functions for desktop OpenGL and Vulkan.
    Glsl410,
    /// Functions for WebGPU.
    Wgsl,
}

/// Error of parsing the name of a format.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("unknown format; known formats: {}", Format::ALL.map(Format::name).join(", "))]
pub struct FormatError;

impl Format {
    /// All formats.
    pub const ALL: [Self; 3] = [Self::GlslEs300, Self::Glsl410, Self::Wgsl];

    /// Name in requests and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::GlslEs300 => "glsl-es-300",
            Self::Glsl410 => "glsl-410",
            Self::Wgsl => "wgsl",
        }
    }

    /// Label for people.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::GlslEs300 => "GLSL ES 3.00 functions (WebGL 2, OpenGL ES 3)",
            Self::Glsl410 => "GLSL 4.10 functions (OpenGL, Vulkan)",
            Self::Wgsl => "WGSL functions (WebGPU)",
        }
    }

    /// Ending of file names, without the first dot; different for each format.
    #[must_use]
    pub fn extension(self) -> &'static str {
        match self {
            Self::GlslEs300 => "es300.glsl",
            Self::Glsl410 => "410.glsl",
            Self::Wgsl => "wgsl",
        }
    }

    /// Value of `Content-Type`.
    #[must_use]
    pub fn media_type(self) -> &'static str {
        match self {
            Self::GlslEs300 | Self::Glsl410 => "text/plain; charset=utf-8",
            Self::Wgsl => "text/wgsl; charset=utf-8",
        }
    }

    pub(crate) fn language(self) -> Language {
        match self {
            Self::GlslEs300 | Self::Glsl410 => Language::Glsl,
            Self::Wgsl => Language::Wgsl,
        }
    }
}

impl FromStr for Format {
    type Err = FormatError;

    fn from_str(name: &str) -> Result<Self, FormatError> {
        Self::ALL.into_iter().find(|format| format.name() == name).ok_or(FormatError)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn format_names_round_trip_and_others_are_rejected_with_the_list() {
        for format in Format::ALL {
            assert_eq!(format.name().parse(), Ok(format));
        }
        let error = "hlsl".parse::<Format>().unwrap_err();
        assert_eq!(error.to_string(), "unknown format; known formats: glsl-es-300, glsl-410, wgsl");
    }
}
