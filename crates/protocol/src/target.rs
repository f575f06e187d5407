//! What searches are to match, as it is uploaded and answered.

use serde::{Deserialize, Serialize};

use crate::TargetId;

/// The part `spec` of an upload.
#[derive(Debug, Clone, PartialEq, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TargetSpec {
    /// `samples` (CSV), `slice` (EXR), `merl`, `rgl` or `cornell`.
    pub kind: String,
    /// What people call it.
    #[serde(default)]
    pub name: String,
    /// What a picture shows; the other kinds have none.
    #[serde(default)]
    #[schema(value_type = Option<Object>)]
    pub scene: Option<serde_json::Value>,
}

/// An upload as it is sent: `multipart/form-data`.
#[derive(utoipa::ToSchema)]
#[expect(dead_code, reason = "a description of the body, which is read part by part")]
pub struct TargetUpload {
    spec: TargetSpec,
    #[schema(value_type = String, format = Binary)]
    file: Vec<u8>,
}

/// A target that was taken in.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct Target {
    /// Its id.
    pub id: TargetId,
    /// `samples`, `slice`, `merl`, `rgl` or `cornell`.
    pub kind: String,
    /// What people call it.
    pub name: String,
    /// Samples that are fitted or held out, in all.
    pub samples: u64,
    /// Samples that a search fits.
    pub fitted_samples: u64,
    /// Samples that are held out, to measure by.
    pub held_out_samples: u64,
    /// Samples of the file that are not above the surface; 0 where it is known everywhere.
    pub skipped_samples: u64,
    /// The largest reflectance that is fitted.
    pub largest_f: f64,
    /// E_log below which no reciprocal material comes; null where only one of a pair and its exchange was measured.
    pub reciprocal_floor: Option<f64>,
    /// Hash of the file.
    pub hash: String,
    /// Bytes of the file.
    pub bytes: u64,
    /// When it was taken in, milliseconds since 1970.
    pub created_ms: i64,
}
