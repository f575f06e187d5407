//! Facts about formats for people and programs that choose one.

use crate::format::Format;
use crate::language::Language;

brood_brdf::named_enum! {
    /// How a format carries a material.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum Exactness {
        /// As code: the same function up to rounding.
        Exact => "exact",
        /// As numbers at places between which is interpolated.
        Table => "table",
        /// As the nearest of the format's own materials.
        Fit => "fit",
    }
}

/// Materials that a format has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Carries {
    Brdfs,
    Painted,
    Both,
}

/// Facts of a format.
struct Facts {
    /// Name in requests and on the command line.
    name: &'static str,
    label: &'static str,
    extension: &'static str,
    media_type: &'static str,
    exactness: Exactness,
    /// Error, as measured in the program that opens it.
    error: &'static str,
    opened_by: &'static str,
    commands: &'static [&'static str],
    carries: Carries,
    /// True if path tracers read the format.
    is_for_path_tracers: bool,
    /// True if files are not text.
    is_binary: bool,
}

/// Facts that most formats share.
const TEXT: Facts = Facts {
    name: "",
    label: "",
    extension: "",
    media_type: "text/plain; charset=utf-8",
    exactness: Exactness::Exact,
    error: "programs: the same bits if the compiler rounds each operation",
    opened_by: "",
    commands: &[],
    carries: Carries::Brdfs,
    is_for_path_tracers: false,
    is_binary: false,
};

/// As [`TEXT`], for functions in a shading language.
const CODE: Facts = Facts { carries: Carries::Both, ..TEXT };

/// As [`TEXT`], for sums of lobes in path tracers.
const FIT: Facts = Facts {
    exactness: Exactness::Fit,
    error: "median 8 % (presets, models), 56 % (random programs); stated in the file",
    is_for_path_tracers: true,
    ..TEXT
};

impl Format {
    fn facts(self) -> &'static Facts {
        match self {
            Self::GlslEs300 => &Facts {
                name: "glsl-es-300",
                label: "GLSL ES 3.00 functions (WebGL 2, OpenGL ES 3)",
                extension: "es300.glsl",
                opened_by: "WebGL 2, OpenGL ES 3",
                ..CODE
            },
            Self::Glsl410 => &Facts {
                name: "glsl-410",
                label: "GLSL 4.10 functions (OpenGL, Vulkan)",
                extension: "410.glsl",
                opened_by: "OpenGL 4.1, Vulkan",
                ..CODE
            },
            Self::Wgsl => &Facts {
                name: "wgsl",
                label: "WGSL functions (WebGPU)",
                extension: "wgsl",
                media_type: "text/wgsl; charset=utf-8",
                opened_by: "WebGPU",
                ..CODE
            },
            Self::Hlsl => &Facts {
                name: "hlsl",
                label: "HLSL functions (Direct3D, Slang)",
                extension: "hlsl",
                opened_by: "Direct3D, Slang, engines",
                ..CODE
            },
            Self::DisneyBrdf => &Facts {
                name: "disney-brdf",
                label: "Disney BRDF Explorer material (.brdf)",
                extension: "brdf",
                opened_by: "Disney BRDF Explorer",
                ..TEXT
            },
            Self::ThreePage => &Facts {
                name: "three-page",
                label: "Web page with three.js (HTML)",
                extension: "html",
                media_type: "text/html; charset=utf-8",
                error: "within 1e-5, or twice the rounding of directions to 32 bits",
                opened_by: "browsers with WebGL 2 and a network connection",
                ..TEXT
            },
            Self::ThreeTsl => &Facts {
                name: "three-tsl",
                label: "three.js material for WebGPURenderer (JavaScript)",
                extension: "three.js",
                media_type: "text/javascript; charset=utf-8",
                error: "median 3e-6, with three's own arithmetic of lights",
                opened_by: "three.js 0.187, WebGPURenderer",
                ..TEXT
            },
            Self::Mtoon => &Facts {
                name: "vrm-mtoon",
                label: "VRM toon material (glTF JSON)",
                extension: "mtoon.json",
                media_type: "application/json",
                exactness: Exactness::Fit,
                error: "shading only; other styles are refused",
                opened_by: "VRM viewers",
                carries: Carries::Painted,
                ..TEXT
            },
            Self::Mitsuba => &Facts {
                name: "mitsuba",
                label: "Mitsuba 3 plugin (Python)",
                extension: "py",
                media_type: "text/x-python; charset=utf-8",
                error: "within 1e-5, or twice the rounding of directions to 32 bits (LLVM variants)",
                opened_by: "Mitsuba 3, variants with LLVM or CUDA",
                commands: &[
                    "pip install mitsuba",
                    "curl -f -o FILE 'URL'",
                    "python FILE picture.png",
                ],
                is_for_path_tracers: true,
                ..TEXT
            },
            Self::RglBsdf => &Facts {
                name: "rgl-bsdf",
                label: "RGL .bsdf table (Mitsuba's measured BSDF)",
                extension: "bsdf",
                media_type: "application/octet-stream",
                exactness: Exactness::Table,
                error: "median 0.06 to 2 %, more for narrow spikes; stated in the file",
                opened_by: "Mitsuba 3 (BSDF measured, RGB variants), readers of RGL's database",
                is_for_path_tracers: true,
                is_binary: true,
                ..TEXT
            },
            Self::Merl => &Facts {
                name: "merl",
                label: "MERL .binary table (isotropic)",
                extension: "binary",
                media_type: "application/octet-stream",
                exactness: Exactness::Table,
                error: "median 0.1 to 1.4 %; highlights narrower than a cell are lost",
                opened_by: "Disney BRDF Explorer, readers of MERL's database",
                is_for_path_tracers: true,
                is_binary: true,
                ..TEXT
            },
            Self::SamplesCsv => &Facts {
                name: "samples-csv",
                label: "Samples of the BRDF (CSV)",
                extension: "csv",
                media_type: "text/csv; charset=utf-8",
                exactness: Exactness::Table,
                error: "exact at the samples",
                opened_by: "spreadsheets, scripts, targets of brood",
                ..TEXT
            },
            Self::MaterialX => &Facts {
                name: "materialx",
                label: "MaterialX node (GLSL, ESSL, Vulkan) as ZIP",
                extension: "mtlx.zip",
                media_type: "application/zip",
                error: "within 1e-5, or four times the rounding of directions to 32 bits",
                opened_by: "renderers with MaterialX's generators of GLSL, ESSL or Vulkan",
                is_binary: true,
                ..TEXT
            },
            Self::Godot3 => &Facts {
                name: "godot-3",
                label: "Godot 3 shader",
                extension: "shader",
                error: "within 1e-3, as pixels of 16 bits show it",
                opened_by: "Godot 3, renderer GLES3",
                ..TEXT
            },
            Self::Blender => &Facts {
                name: "blender",
                label: "Blender material of plain nodes (script that makes a .blend)",
                extension: "blender.py",
                media_type: "text/x-python; charset=utf-8",
                opened_by: "Blender 4.2 and later (Cycles)",
                commands: &[
                    "pip install bpy",
                    "curl -f -o FILE 'URL'",
                    "python FILE material.blend",
                    "python FILE picture.png",
                ],
                ..FIT
            },
            Self::BlenderOsl => &Facts {
                name: "blender-osl",
                label: "OSL shader of Blender's Cycles",
                extension: "osl",
                opened_by: "Blender 4.2 and later (Cycles with Open Shading Language)",
                ..FIT
            },
            Self::Gltf => &Facts {
                name: "gltf",
                label: "glTF preview: a sphere with the nearest material of glTF",
                extension: "glb",
                media_type: "model/gltf-binary",
                error: "median 23 % (models), 42 % (presets), 79 % (random programs); stated in the file",
                opened_by: "viewers of glTF, engines",
                is_binary: true,
                ..FIT
            },
        }
    }

    /// Name in requests and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.facts().name
    }

    /// Label for people.
    #[must_use]
    pub fn label(self) -> &'static str {
        self.facts().label
    }

    /// Ending of file names, without the first dot; different for each format.
    #[must_use]
    pub fn extension(self) -> &'static str {
        self.facts().extension
    }

    /// Value of `Content-Type`.
    #[must_use]
    pub fn media_type(self) -> &'static str {
        self.facts().media_type
    }

    /// How the format carries a material.
    #[must_use]
    pub fn exactness(self) -> Exactness {
        self.facts().exactness
    }

    /// Error of the format, as measured in the program that opens it; docs/export.md has the runs.
    #[must_use]
    pub fn error(self) -> &'static str {
        self.facts().error
    }

    /// Programs that open the format.
    #[must_use]
    pub fn opened_by(self) -> &'static str {
        self.facts().opened_by
    }

    /// Shell commands from nothing to a picture, in which FILE is the name of the file and URL its
    /// address. Empty if the format needs a program of the user.
    #[must_use]
    pub fn commands(self) -> &'static [&'static str] {
        self.facts().commands
    }

    /// True if the format has painted materials only.
    #[must_use]
    pub fn is_of_painted(self) -> bool {
        self.facts().carries == Carries::Painted
    }

    /// True if the format has BRDFs only.
    #[must_use]
    pub fn is_of_brdfs(self) -> bool {
        self.facts().carries == Carries::Brdfs
    }

    /// True if path tracers read the format. Light is reflected again and again in them, so the
    /// energy limit is applied unless it is turned off.
    #[must_use]
    pub fn is_for_path_tracers(self) -> bool {
        self.facts().is_for_path_tracers
    }

    /// True if the format holds values of f, so that measured materials have it too.
    #[must_use]
    pub fn is_table(self) -> bool {
        self.exactness() == Exactness::Table
    }

    /// True if the format holds the nearest of other BRDFs.
    #[must_use]
    pub fn is_fit(self) -> bool {
        self.exactness() == Exactness::Fit && !self.is_of_painted()
    }

    /// True if files are not text.
    #[must_use]
    pub fn is_binary(self) -> bool {
        self.facts().is_binary
    }

    /// Shading language; `None` if the format is another one.
    pub(crate) fn language(self) -> Option<Language> {
        match self {
            Self::GlslEs300 | Self::Glsl410 => Some(Language::Glsl),
            Self::Wgsl => Some(Language::Wgsl),
            Self::Hlsl => Some(Language::Hlsl),
            _ => None,
        }
    }
}
