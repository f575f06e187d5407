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
    /// Functions for Direct3D, Slang and engines that take HLSL.
    Hlsl,
    /// Material of Disney's BRDF Explorer.
    DisneyBrdf,
    /// Parameters of VRM's toon material; of simple painted materials only.
    Mtoon,
    /// Plugin for the path tracer Mitsuba 3.
    Mitsuba,
    /// RGL's table of a measured material, as Mitsuba's BSDF `measured` reads it.
    RglBsdf,
    /// MERL's table of an isotropic measured material.
    Merl,
    /// Samples of f as CSV.
    SamplesCsv,
}

/// Error of parsing the name of a format.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("unknown format; known formats: {}", Format::ALL.map(Format::name).join(", "))]
pub struct FormatError;

impl Format {
    /// All formats.
    pub const ALL: [Self; 10] = [
        Self::GlslEs300,
        Self::Glsl410,
        Self::Wgsl,
        Self::Hlsl,
        Self::DisneyBrdf,
        Self::Mtoon,
        Self::Mitsuba,
        Self::RglBsdf,
        Self::Merl,
        Self::SamplesCsv,
    ];

    /// Name in requests and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::GlslEs300 => "glsl-es-300",
            Self::Glsl410 => "glsl-410",
            Self::Wgsl => "wgsl",
            Self::Hlsl => "hlsl",
            Self::DisneyBrdf => "disney-brdf",
            Self::Mtoon => "vrm-mtoon",
            Self::Mitsuba => "mitsuba",
            Self::RglBsdf => "rgl-bsdf",
            Self::Merl => "merl",
            Self::SamplesCsv => "samples-csv",
        }
    }

    /// Label for people.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::GlslEs300 => "GLSL ES 3.00 functions (WebGL 2, OpenGL ES 3)",
            Self::Glsl410 => "GLSL 4.10 functions (OpenGL, Vulkan)",
            Self::Wgsl => "WGSL functions (WebGPU)",
            Self::Hlsl => "HLSL functions (Direct3D, Slang)",
            Self::DisneyBrdf => "Disney BRDF Explorer material (.brdf)",
            Self::Mtoon => "VRM toon material (glTF JSON)",
            Self::Mitsuba => "Mitsuba 3 plugin (Python)",
            Self::RglBsdf => "RGL .bsdf table (Mitsuba's measured BSDF)",
            Self::Merl => "MERL .binary table (isotropic)",
            Self::SamplesCsv => "Samples of the BRDF (CSV)",
        }
    }

    /// Ending of file names, without the first dot; different for each format.
    #[must_use]
    pub fn extension(self) -> &'static str {
        match self {
            Self::GlslEs300 => "es300.glsl",
            Self::Glsl410 => "410.glsl",
            Self::Wgsl => "wgsl",
            Self::Hlsl => "hlsl",
            Self::DisneyBrdf => "brdf",
            Self::Mtoon => "mtoon.json",
            Self::Mitsuba => "py",
            Self::RglBsdf => "bsdf",
            Self::Merl => "binary",
            Self::SamplesCsv => "csv",
        }
    }

    /// Value of `Content-Type`.
    #[must_use]
    pub fn media_type(self) -> &'static str {
        match self {
            Self::GlslEs300 | Self::Glsl410 | Self::Hlsl | Self::DisneyBrdf => {
                "text/plain; charset=utf-8"
            }
            Self::Wgsl => "text/wgsl; charset=utf-8",
            Self::Mtoon => "application/json",
            Self::Mitsuba => "text/x-python; charset=utf-8",
            Self::RglBsdf | Self::Merl => "application/octet-stream",
            Self::SamplesCsv => "text/csv; charset=utf-8",
        }
    }

    /// Name of a file for a stem such as `brood-1a2b3c4d`. Files of Python have names that Python
    /// can import.
    #[must_use]
    pub fn file_name(self, stem: &str) -> String {
        match self {
            Self::Mitsuba => format!("{}.{}", stem.replace('-', "_"), self.extension()),
            _ => format!("{stem}.{}", self.extension()),
        }
    }

    /// True if path tracers read the format. Light is reflected again and again in them, so the
    /// energy limit is applied unless it is turned off.
    #[must_use]
    pub fn is_for_path_tracers(self) -> bool {
        matches!(self, Self::Mitsuba | Self::RglBsdf | Self::Merl)
    }

    /// True if the format holds values of f, so that measured materials have it too.
    #[must_use]
    pub fn is_table(self) -> bool {
        matches!(self, Self::RglBsdf | Self::Merl | Self::SamplesCsv)
    }

    /// True if files are not text.
    #[must_use]
    pub fn is_binary(self) -> bool {
        matches!(self, Self::RglBsdf | Self::Merl)
    }

    /// Shading language; `None` if the format is another one.
    pub(crate) fn language(self) -> Option<Language> {
        match self {
            Self::GlslEs300 | Self::Glsl410 => Some(Language::Glsl),
            Self::Wgsl => Some(Language::Wgsl),
            Self::Hlsl => Some(Language::Hlsl),
            Self::DisneyBrdf
            | Self::Mtoon
            | Self::Mitsuba
            | Self::RglBsdf
            | Self::Merl
            | Self::SamplesCsv => None,
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
        let error = "cg".parse::<Format>().unwrap_err();
        let known = "unknown format; known formats: glsl-es-300, glsl-410, wgsl, hlsl, disney-brdf, vrm-mtoon, \
                     mitsuba, rgl-bsdf, merl, samples-csv";
        assert_eq!(error.to_string(), known);
    }
}
