//! Picture keys: a picture is a pure function of its key.

use std::fmt;
use std::str::FromStr;

use brood_program::{Program, ProgramHash};
use serde::{Deserialize, Serialize};

use crate::lease::Frame;

/// Counted up whenever the same key would give other pixels.
pub const RENDERER_VERSION: u32 = 6;

/// Which evaluator is wanted.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize, utoipa::ToSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum Backend {
    /// Whatever is fastest among the bit-exact ones.
    #[default]
    Auto,
    /// The canonical evaluator on the CPU.
    Cpu,
    /// The GPU, where it is bit-exact.
    Gpu,
    /// The f64 reference: slow, for looking at error.
    Reference,
}

/// Evaluators of one class give the same bits and share pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum ExactnessClass {
    /// Canonical f32.
    Exact,
    /// f64, rounded at the end.
    Reference,
}

impl Backend {
    /// The class its pictures belong to.
    #[must_use]
    pub fn exactness_class(self) -> ExactnessClass {
        match self {
            Self::Auto | Self::Cpu | Self::Gpu => ExactnessClass::Exact,
            Self::Reference => ExactnessClass::Reference,
        }
    }

    /// The word on the command line and in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Cpu => "cpu",
            Self::Gpu => "gpu",
            Self::Reference => "reference",
        }
    }
}

impl FromStr for Backend {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        [Self::Auto, Self::Cpu, Self::Gpu, Self::Reference]
            .into_iter()
            .find(|backend| backend.name() == text)
            .ok_or_else(|| "a backend is auto, cpu, gpu or reference".to_owned())
    }
}

/// The file a picture comes as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum PictureFormat {
    /// Developed, 8-bit sRGB with alpha.
    Png,
    /// Linear radiance, 32-bit float.
    Exr,
}

/// Identity of a picture: hash of program, frame, renderer version and exactness class.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct PictureKey(pub [u8; 32]);

impl PictureKey {
    /// The key of a program's picture in a frame.
    #[must_use]
    pub fn new(program: &Program, frame: &Frame) -> Self {
        Self::of(&program.hash(), &frame.identity())
    }

    /// The same key from the program's hash and the frame's [`Frame::identity`], for those who have many of both.
    #[must_use]
    pub fn of(program: &ProgramHash, frame: &blake3::Hash) -> Self {
        let mut hasher = blake3::Hasher::new();
        hasher.update(b"brood picture\n");
        hasher.update(&RENDERER_VERSION.to_le_bytes());
        hasher.update(program.as_bytes());
        hasher.update(frame.as_bytes());
        Self(*hasher.finalize().as_bytes())
    }
}

impl fmt::Display for PictureKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // At once: keys are written by the dozen for each brood, and formatting bytes one by one shows in profiles.
        f.write_str(&blake3::Hash::from_bytes(self.0).to_hex())
    }
}

impl FromStr for PictureKey {
    type Err = blake3::HexError;

    fn from_str(text: &str) -> Result<Self, blake3::HexError> {
        blake3::Hash::from_hex(text).map(|hash| Self(*hash.as_bytes()))
    }
}
