//! Facts about formats for people who choose one.

use crate::format::Format;

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

impl Format {
    /// How the format carries a material.
    #[must_use]
    pub fn exactness(self) -> Exactness {
        match self {
            Self::GlslEs300 | Self::Glsl410 | Self::Wgsl | Self::Hlsl | Self::DisneyBrdf => {
                Exactness::Exact
            }
            Self::Mitsuba => Exactness::Exact,
            Self::RglBsdf | Self::Merl | Self::SamplesCsv => Exactness::Table,
            Self::Mtoon => Exactness::Fit,
        }
    }

    /// Error of the format, as measured in the program that opens it; docs/export.md has the runs.
    #[must_use]
    pub fn error(self) -> &'static str {
        match self {
            Self::GlslEs300 | Self::Glsl410 | Self::Wgsl | Self::Hlsl | Self::DisneyBrdf => {
                "programs: the same bits if the compiler rounds each operation"
            }
            Self::Mitsuba => {
                "within 1e-5, or twice the rounding of directions to 32 bits (LLVM variants)"
            }
            Self::RglBsdf => "median 0.06 to 2 %, more for narrow spikes; stated in the file",
            Self::Merl => "median 0.1 to 1.4 %; highlights narrower than a cell are lost",
            Self::SamplesCsv => "exact at the samples",
            Self::Mtoon => "shading only; other styles are refused",
        }
    }

    /// Programs that open the format.
    #[must_use]
    pub fn opened_by(self) -> &'static str {
        match self {
            Self::GlslEs300 => "WebGL 2, OpenGL ES 3",
            Self::Glsl410 => "OpenGL 4.1, Vulkan",
            Self::Wgsl => "WebGPU",
            Self::Hlsl => "Direct3D, Slang, engines",
            Self::DisneyBrdf => "Disney BRDF Explorer",
            Self::Mtoon => "VRM viewers",
            Self::Mitsuba => "Mitsuba 3, variants with LLVM or CUDA",
            Self::RglBsdf => "Mitsuba 3 (BSDF measured, RGB variants), readers of RGL's database",
            Self::Merl => "Disney BRDF Explorer, readers of MERL's database",
            Self::SamplesCsv => "spreadsheets, scripts, targets of brood",
        }
    }

    /// Shell commands from nothing to a picture, in which FILE is the name of the file and URL its
    /// address. Empty if the format needs a program of the user.
    #[must_use]
    pub fn commands(self) -> &'static [&'static str] {
        match self {
            Self::Mitsuba => {
                &["pip install mitsuba", "curl -f -o FILE 'URL'", "python FILE picture.png"]
            }
            _ => &[],
        }
    }

    /// True if the format has painted materials only.
    #[must_use]
    pub fn is_of_painted(self) -> bool {
        matches!(self, Self::Mtoon)
    }

    /// True if the format has BRDFs only.
    #[must_use]
    pub fn is_of_brdfs(self) -> bool {
        self.language().is_none() && !self.is_of_painted()
    }
}
