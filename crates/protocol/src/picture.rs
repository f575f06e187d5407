//! Picture keys. A picture is a pure function of its key.

use std::fmt;
use std::str::FromStr;

use brood_program::ProgramHash;
use serde::{Deserialize, Serialize};

use crate::Subject;

/// Version of the renderer. Increment it whenever the pixels of an existing key would change: of
/// programs and targets, of their pixel statuses, and of what a target's file decodes to.
pub const RENDERER_VERSION: u32 = 13;

brood_brdf::named_enum! {
    /// Requested evaluator.
    #[derive(
        Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize, utoipa::ToSchema,
    )]
    #[serde(rename_all = "lowercase")]
    pub enum Backend {
        /// Fastest evaluator among the bit-exact ones.
        #[default]
        Auto => "auto",
        /// Canonical f32 evaluator on the CPU.
        Cpu => "cpu",
        /// GPU, if it is bit-exact.
        Gpu => "gpu",
        /// f64 reference: slow, for measuring errors.
        Reference => "reference",
    }
}

/// Evaluators of one class compute the same bits, so they share pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum ExactnessClass {
    /// Canonical f32.
    Exact,
    /// f64, rounded at the end.
    Reference,
}

impl Backend {
    /// Returns the exactness class of the evaluator's pictures.
    #[must_use]
    pub fn exactness_class(self) -> ExactnessClass {
        match self {
            Self::Auto | Self::Cpu | Self::Gpu => ExactnessClass::Exact,
            Self::Reference => ExactnessClass::Reference,
        }
    }
}

impl FromStr for Backend {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::from_name(text)
            .ok_or_else(|| "the backend must be auto, cpu, gpu or reference".to_owned())
    }
}

brood_brdf::named_enum! {
    /// File format of a picture.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
    pub enum PictureFormat {
        /// PNG: developed, 8-bit sRGB with alpha.
        Png => "png",
        /// OpenEXR: linear radiance, 32-bit float.
        Exr => "exr",
        /// Lit spheres of a material in environments (see `brood_eval::LitSpheres`).
        Spheres => "spheres",
        /// Angles at which point lights reach the points of a scene (`brood_eval::encode_angles`).
        Angles => "angles",
        /// Ends of the rays of a clear subject (`brood_eval::encode_ray_ends`).
        RayEnds => "ray-ends",
    }
}

/// Identity of a picture: hash of the subject, frame, renderer version and exactness class.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct PictureKey(pub [u8; 32]);

impl PictureKey {
    /// Returns the key of a subject's picture in the frame with this [`crate::Frame::identity`].
    #[must_use]
    pub fn of(subject: &Subject<ProgramHash>, frame: &blake3::Hash) -> Self {
        let mut hasher = blake3::Hasher::new();
        hasher.update(b"brood picture\n");
        hasher.update(&RENDERER_VERSION.to_le_bytes());
        hasher.update(&subject.identity());
        hasher.update(frame.as_bytes());
        Self(*hasher.finalize().as_bytes())
    }
}

impl fmt::Display for PictureKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // One write: a brood has dozens of keys, and formatting byte by byte shows in profiles.
        f.write_str(&blake3::Hash::from_bytes(self.0).to_hex())
    }
}

impl FromStr for PictureKey {
    type Err = blake3::HexError;

    fn from_str(text: &str) -> Result<Self, blake3::HexError> {
        blake3::Hash::from_hex(text).map(|hash| Self(*hash.as_bytes()))
    }
}
