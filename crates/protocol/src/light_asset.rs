//! Uploaded files that lights and painted materials refer to: responses to clients, and transfers
//! to workers.

use serde::{Deserialize, Serialize};

brood_brdf::named_enum! {
    /// Kind of an uploaded file.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
    #[serde(rename_all = "lowercase")]
    pub enum LightAssetKind {
        /// Luminaire profile: an IES file.
        Profile => "profile",
        /// Environment map: a Radiance HDR or EXR file.
        Environment => "environment",
        /// Control image of painted materials: a PNG or JPEG file.
        Image => "image",
    }
}

/// Uploaded profile, environment map or control image.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct LightAssetAnswer {
    /// Id, to be used as a light's `profile` or `image`, or in an effect: the hash of the file.
    pub id: String,
    /// Kind of the asset.
    pub kind: LightAssetKind,
    /// Luminous flux of a profile, integrated over its candela values, in lumens.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lumens: Option<f64>,
    /// Largest luminous intensity of a profile, in candela.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_candela: Option<f64>,
    /// Mean radiance of an environment map over all directions: red, green, blue.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_radiance: Option<[f64; 3]>,
    /// Width of a control image in pixels.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub width: Option<u32>,
    /// Height of a control image in pixels.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height: Option<u32>,
}

/// Uploaded file, as it is sent to a worker.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LightAssetFile {
    /// Kind of the asset.
    pub kind: LightAssetKind,
    /// Contents of the uploaded file.
    pub bytes: Vec<u8>,
}
