//! What searches are to match, as it is uploaded and answered.

use brood_scene::{Sampling, Scene};
use serde::{Deserialize, Serialize};

use crate::TargetId;
use crate::schema::{PixelSamples, SceneOrId};

/// The part `spec` of an upload.
#[derive(Debug, Clone, PartialEq, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TargetSpec {
    /// `samples` (CSV), `slice` (EXR), `merl`, `rgl`, `cornell` or `image` (EXR or HDR of linear radiance, PNG or JPEG as shown).
    pub kind: String,
    /// What people call it.
    #[serde(default)]
    pub name: String,
    /// What a picture shows: a scene, or the id of a stored one; the default scene unless said. The other kinds have none.
    #[serde(default)]
    #[schema(value_type = Option<SceneOrId>)]
    pub scene: Option<serde_json::Value>,
    /// How the pixels of a picture were sampled: `adaptive`, or 1 to 64 in every pixel; adaptive unless said.
    #[serde(default)]
    #[schema(value_type = Option<PixelSamples>)]
    pub samples: Option<Sampling>,
    /// Whether the brightness of a picture is not known, so that a gain is solved for.
    #[serde(default)]
    pub gain: Option<bool>,
    /// Several pictures, 1 to 16, each in a part of its own; then nothing is said for all of them.
    #[serde(default)]
    pub views: Option<Vec<ViewSpec>>,
}

/// One of several pictures.
#[derive(Debug, Clone, PartialEq, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ViewSpec {
    /// The part that the picture is in.
    pub picture: String,
    /// The part that its mask is in: a picture of the same size, white where it is looked at.
    #[serde(default)]
    pub mask: Option<String>,
    /// What it shows: a scene, or the id of a stored one; the default scene unless said.
    #[serde(default)]
    #[schema(value_type = Option<SceneOrId>)]
    pub scene: Option<serde_json::Value>,
    /// How its pixels were sampled: `adaptive`, or 1 to 64 in every pixel; adaptive unless said.
    #[serde(default)]
    #[schema(value_type = Option<PixelSamples>)]
    pub samples: Option<Sampling>,
    /// Whether its brightness is not known.
    #[serde(default)]
    pub gain: bool,
    /// Whether nothing is fitted to it: it is only compared with what was found.
    #[serde(default)]
    pub held_out: bool,
}

/// An upload as it is sent: `multipart/form-data`. With `views` in the spec the parts have the names that stand there instead of `file`
/// and `mask`.
#[derive(utoipa::ToSchema)]
#[expect(dead_code, reason = "a description of the body, which is read part by part")]
pub struct TargetUpload {
    spec: TargetSpec,
    #[schema(value_type = String, format = Binary)]
    file: Vec<u8>,
    /// Of a picture: white where it is looked at.
    #[schema(value_type = Option<String>, format = Binary)]
    mask: Option<Vec<u8>>,
}

/// A target that was taken in.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct Target {
    /// Its id.
    pub id: TargetId,
    /// `samples`, `slice`, `merl`, `rgl`, `cornell` or `image`.
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
    /// The largest share of the light from one direction that is sent back, where it is known everywhere: above 1 that is more than
    /// what is found may reflect.
    #[serde(default)]
    pub largest_albedo: Option<LargestAlbedo>,
    /// Hash of the file; of pictures, of all that was stored of them.
    pub hash: String,
    /// Bytes of the same.
    pub bytes: u64,
    /// When it was taken in, milliseconds since 1970.
    pub created_ms: i64,
    /// The pictures, in the order of the upload; none of what was measured at directions.
    #[serde(default)]
    pub views: Vec<TargetView>,
}

/// Where most is reflected.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct LargestAlbedo {
    /// Of the channel that reflects most.
    pub albedo: f64,
    /// Of the light, from the normal.
    pub theta_deg: f64,
}

/// A picture of a target, as it was understood.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct TargetView {
    /// Its side.
    pub size_px: u32,
    /// The full scene, every field present.
    pub scene: Scene,
    /// How its pixels were sampled: `adaptive` or a number.
    #[schema(value_type = PixelSamples)]
    pub samples: Sampling,
    /// Whether its brightness is not known, so that a gain is solved for.
    pub gain_solved: bool,
    /// Whether nothing is fitted to it.
    pub held_out: bool,
    /// What became of its pixels.
    pub pixels: TargetPixels,
}

/// How many pixels of a picture say something of the material, and why the others do not.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct TargetPixels {
    /// All of them.
    pub pixels: u64,
    /// Those that are samples.
    pub used: u64,
    /// Left out by the mask.
    pub masked: u64,
    /// Nothing is there.
    pub background: u64,
    /// The edge of the object, or one within it.
    pub edge: u64,
    /// As bright as the picture can show.
    pub clipped: u64,
    /// No light arrives.
    pub unlit: u64,
    /// The edge of light and shadow.
    pub half_lit: u64,
    /// Light of several lamps arrives, which cannot be told apart.
    pub several_lights: u64,
    /// Light or eye is at the horizon.
    pub grazing: u64,
}
