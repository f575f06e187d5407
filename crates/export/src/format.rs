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
    /// Parameters of VRM's toon material; of simple painted materials only.
    Mtoon,
}

/// Error of parsing the name of a format.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("unknown format; known formats: {}", Format::ALL.map(Format::name).join(", "))]
pub struct FormatError;

impl Format {
    /// All formats.
    pub const ALL: [Self; 4] = [Self::GlslEs300, Self::Glsl410, Self::Wgsl, Self::Mtoon];

    /// Name in requests and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::GlslEs300 => "glsl-es-300",
            Self::Glsl410 => "glsl-410",
            Self::Wgsl => "wgsl",
            Self::Mtoon => "vrm-mtoon",
        }
    }

    /// Label for people.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::GlslEs300 => "GLSL ES 3.00 functions (WebGL 2, OpenGL ES 3)",
            Self::Glsl410 => "GLSL 4.10 functions (OpenGL, Vulkan)",
            Self::Wgsl => "WGSL functions (WebGPU)",
            Self::Mtoon => "VRM toon material (glTF JSON)",
        }
    }

    /// Ending of file names, without the first dot; different for each format.
    #[must_use]
    pub fn extension(self) -> &'static str {
        match self {
            Self::GlslEs300 => "es300.glsl",
            Self::Glsl410 => "410.glsl",
            Self::Wgsl => "wgsl",
            Self::Mtoon => "mtoon.json",
        }
    }

    /// Value of `Content-Type`.
    #[must_use]
    pub fn media_type(self) -> &'static str {
        match self {
            Self::GlslEs300 | Self::Glsl410 => "text/plain; charset=utf-8",
            Self::Wgsl => "text/wgsl; charset=utf-8",
            Self::Mtoon => "application/json",
        }
    }

    /// True if the format has painted materials only.
    #[must_use]
    pub fn is_of_painted(self) -> bool {
        self.language().is_none()
    }

    /// Language of source code; `None` if the format is not source code.
    pub(crate) fn language(self) -> Option<Language> {
        match self {
            Self::GlslEs300 | Self::Glsl410 => Some(Language::Glsl),
            Self::Wgsl => Some(Language::Wgsl),
            Self::Mtoon => None,
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
        let known = "unknown format; known formats: glsl-es-300, glsl-410, wgsl, vrm-mtoon";
        assert_eq!(error.to_string(), known);
    }
}
