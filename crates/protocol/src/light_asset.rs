//! Uploaded files that lights refer to, as they are answered and as workers get them.

use serde::{Deserialize, Serialize};

/// What a light can refer to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum LightAssetKind {
    /// An IES file.
    Profile,
    /// A picture of an environment, Radiance HDR or EXR.
    Environment,
}

impl LightAssetKind {
    /// Its word.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Profile => "profile",
            Self::Environment => "environment",
        }
    }

    /// The kind of that word.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::Profile, Self::Environment].into_iter().find(|kind| kind.name() == name)
    }
}

/// A profile or an environment that was uploaded.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct LightAssetAnswer {
    /// Its id, to be put into a light's `profile` or `image`: the hash of the file.
    pub id: String,
    /// What it is.
    pub kind: LightAssetKind,
    /// Luminous flux of a profile, integrated over its candelas, lm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lumens: Option<f64>,
    /// Largest luminous intensity of a profile, cd.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_candela: Option<f64>,
    /// Mean radiance of an environment over all directions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_radiance: Option<[f64; 3]>,
}

/// A file for a worker.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LightAssetFile {
    /// What it is.
    pub kind: LightAssetKind,
    /// As it was uploaded.
    pub bytes: Vec<u8>,
}
