//! Export formats by name.

use std::str::FromStr;

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
    /// Page that draws the material with three.js.
    ThreePage,
    /// Module with a material for three.js's WebGPURenderer.
    ThreeTsl,
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
    /// Node of MaterialX for renderers that take custom GLSL, as an archive.
    MaterialX,
    /// Shader of the engine Godot 3.
    Godot3,
    /// Script that makes a material of Blender's nodes.
    Blender,
    /// Shader for the Script node of Blender's Cycles.
    BlenderOsl,
    /// glTF's own material on a sphere.
    Gltf,
}

/// Error of parsing the name of a format.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("unknown format; known formats: {}", Format::ALL.map(Format::name).join(", "))]
pub struct FormatError;

impl Format {
    /// All formats.
    pub const ALL: [Self; 17] = [
        Self::GlslEs300,
        Self::Glsl410,
        Self::Wgsl,
        Self::Hlsl,
        Self::DisneyBrdf,
        Self::ThreePage,
        Self::ThreeTsl,
        Self::Mtoon,
        Self::Mitsuba,
        Self::RglBsdf,
        Self::Merl,
        Self::SamplesCsv,
        Self::MaterialX,
        Self::Godot3,
        Self::Blender,
        Self::BlenderOsl,
        Self::Gltf,
    ];

    /// Name of a file for a stem such as `brood-1a2b3c4d`. Files of Python have names that Python
    /// can import.
    #[must_use]
    pub fn file_name(self, stem: &str) -> String {
        match self.extension() {
            "py" => format!("{}.py", stem.replace('-', "_")),
            extension => format!("{stem}.{extension}"),
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
        let known = "unknown format; known formats: glsl-es-300, glsl-410, wgsl, hlsl, disney-brdf, three-page, \
                     three-tsl, vrm-mtoon, mitsuba, rgl-bsdf, merl, samples-csv, materialx, godot-3, blender, blender-osl, gltf";
        assert_eq!(error.to_string(), known);
    }
}
