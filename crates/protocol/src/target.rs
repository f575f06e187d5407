//! Requests and responses for search targets.

use brood_scene::{ClipFrom, PictureSize, Refine, Sampling, Scene};
use serde::{Deserialize, Serialize};

use crate::TargetId;
use crate::schema::{ClipCode, PixelSamples, SceneOrId};

/// Part `spec` of a target upload.
#[derive(Debug, Clone, PartialEq, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TargetSpec {
    /// Kind of the file: `samples` (CSV), `slice` (EXR), `merl`, `rgl`, `cornell`, or `image` (EXR
    /// or HDR with linear radiance, PNG or JPEG as displayed).
    pub kind: String,
    /// Display name, up to 200 characters. Default: empty.
    #[serde(default)]
    pub name: String,
    /// Scene of an image, or the id of a stored scene. Default: the default scene. Only for the
    /// kind `image`.
    #[serde(default)]
    #[schema(value_type = Option<SceneOrId>)]
    pub scene: Option<serde_json::Value>,
    /// Sampling of an image's pixels: `adaptive`, or 1 to 64 samples in every pixel. Default:
    /// `adaptive`.
    #[serde(default)]
    #[schema(value_type = Option<PixelSamples>)]
    pub samples: Option<Sampling>,
    /// True if the brightness of an image is unknown, so that a gain is solved for. Default: false.
    #[serde(default)]
    pub gain: Option<bool>,
    /// Code from which a channel of an image counts as clipped: `auto`, `off` or 1 to 255. Default:
    /// `auto`, which finds it from the plateaus of the image, also after noise and compression.
    #[serde(default)]
    #[schema(value_type = Option<ClipCode>)]
    pub clip_from: Option<ClipFrom>,
    /// Part of an image to use: its first column and row, width and height in pixels. The scene
    /// describes this part, with its own width and height; a mask has the size of the whole image.
    /// Default: the whole image.
    #[serde(default)]
    pub crop: Option<[u32; 4]>,
    /// Uncertainties within which searches correct the scene of an image. Default: none.
    #[serde(default)]
    pub refine: Option<Refine>,
    /// Several images, 1 to 16, each in its own part of the upload. Excludes `scene`, `samples`,
    /// `gain`, `clip_from`, `crop` and `refine`.
    #[serde(default)]
    pub views: Option<Vec<ViewSpec>>,
}

/// One of several images.
#[derive(Debug, Clone, PartialEq, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ViewSpec {
    /// Name of the part with the image.
    pub picture: String,
    /// Name of the part with the mask: an image of the same size, white where pixels are used.
    #[serde(default)]
    pub mask: Option<String>,
    /// Scene of the image, or the id of a stored scene. Default: the default scene.
    #[serde(default)]
    #[schema(value_type = Option<SceneOrId>)]
    pub scene: Option<serde_json::Value>,
    /// Sampling of the pixels: `adaptive`, or 1 to 64 samples in every pixel. Default: `adaptive`.
    #[serde(default)]
    #[schema(value_type = Option<PixelSamples>)]
    pub samples: Option<Sampling>,
    /// True if the brightness is unknown, so that a gain is solved for. Default: false.
    #[serde(default)]
    pub gain: bool,
    /// Code from which a channel counts as clipped: `auto`, `off` or 1 to 255. Default: `auto`,
    /// which finds it from the plateaus of the image, also after noise and compression.
    #[serde(default)]
    #[schema(value_type = Option<ClipCode>)]
    pub clip_from: Option<ClipFrom>,
    /// Part of the image to use: its first column and row, width and height in pixels. The scene
    /// describes this part, with its own width and height; a mask has the size of the whole image.
    /// Default: the whole image.
    #[serde(default)]
    pub crop: Option<[u32; 4]>,
    /// True to hold the image out: it is not fitted, only compared with the results. Default:
    /// false.
    #[serde(default)]
    pub held_out: bool,
    /// Uncertainties within which searches correct the scene. Images for which the same camera or
    /// light is stated share its correction. Default: none.
    #[serde(default)]
    pub refine: Option<Refine>,
}

/// Target upload: `multipart/form-data`. If the spec has `views`, the parts have the names given
/// there instead of `file` and `mask`.
#[derive(utoipa::ToSchema)]
#[expect(dead_code, reason = "description of the body, which the server reads part by part")]
pub struct TargetUpload {
    spec: TargetSpec,
    #[schema(value_type = String, format = Binary)]
    file: Vec<u8>,
    /// Mask of an image: white where pixels are used.
    #[schema(value_type = Option<String>, format = Binary)]
    mask: Option<Vec<u8>>,
}

/// Target of searches.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct Target {
    /// Id of the target.
    pub id: TargetId,
    /// Kind of the file: `samples`, `slice`, `merl`, `rgl`, `cornell` or `image`.
    pub kind: String,
    /// Display name.
    pub name: String,
    /// Number of samples: fitted and held out.
    pub samples: u64,
    /// Number of samples that searches fit.
    pub fitted_samples: u64,
    /// Number of held-out samples, which are not fitted: errors are measured on them, and the best
    /// result of a measurement is the one of least error.
    pub held_out_samples: u64,
    /// Number of samples in the file that were skipped because a direction is below the surface; 0
    /// for measurements that cover all directions.
    pub skipped_samples: u64,
    /// Largest fitted reflectance f, per steradian.
    pub largest_f: f64,
    /// Lowest E_log of a reciprocal isotropic material on f as measured: on the held-out samples in
    /// both orders of light and eye if the measurement covers all directions, otherwise on all
    /// given pairs. Null if no pair is given in both orders or repeated. Searches of measurements
    /// that cover all directions fit the mean of both orders, so their errors can be lower.
    pub reciprocal_floor: Option<f64>,
    /// Largest directional albedo, for measurements that cover all directions. If it is above 1,
    /// found materials reflect less than the measurement.
    #[serde(default)]
    pub largest_albedo: Option<LargestAlbedo>,
    /// Content hash: of the file, or of the bundle of all images.
    pub hash: String,
    /// Size of the same, in bytes.
    pub bytes: u64,
    /// Creation time, in milliseconds since 1970-01-01 UTC.
    pub created_ms: i64,
    /// Images, in the order of the upload; empty for other kinds.
    #[serde(default)]
    pub views: Vec<TargetView>,
}

/// Largest directional albedo of a measurement.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct LargestAlbedo {
    /// Albedo of the channel that reflects most.
    pub albedo: f64,
    /// Angle of the light from the normal, in degrees.
    pub theta_deg: f64,
}

/// Image of a target, as the server has interpreted it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct TargetView {
    /// Size of the image, or of its crop.
    pub size_px: PictureSize,
    /// Part of the uploaded image that is used: its first column and row, width and height in
    /// pixels. Null for the whole image.
    #[serde(default)]
    pub crop: Option<[u32; 4]>,
    /// The scene with every field present.
    pub scene: Scene,
    /// Sampling of the pixels: `adaptive` or a number of samples.
    #[schema(value_type = PixelSamples)]
    pub samples: Sampling,
    /// True if the brightness is unknown, so that a gain is solved for.
    pub gain_solved: bool,
    /// Setting from which code a channel counts as clipped. 255 for targets of versions without it.
    #[serde(default = "largest_code")]
    #[schema(value_type = ClipCode)]
    pub clip_from: ClipFrom,
    /// Code from which red, green and blue are clipped, null for a channel that is not; in images
    /// of linear radiance 255 is the value 1. Null for targets of versions without it.
    #[serde(default)]
    #[schema(value_type = Option<Vec<Option<u8>>>)]
    pub clipped_from: Option<[Option<u8>; 3]>,
    /// True if the image is held out: it is not fitted.
    pub held_out: bool,
    /// Number of pixels by status, in the scene as stated.
    pub pixels: TargetPixels,
    /// Uncertainties within which searches correct the scene.
    #[serde(default)]
    pub refine: Refine,
    /// Correction of the scene: null until a search has begun, and without `refine`.
    #[serde(default)]
    pub corrected: Option<CorrectedScene>,
}

/// Correction of an image's scene, found by a search.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct CorrectedScene {
    /// The corrected scene.
    pub scene: Scene,
    /// Numbers that were corrected.
    pub corrections: Vec<SceneCorrection>,
}

/// Number of a scene that was corrected.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct SceneCorrection {
    /// Name. Turns in degrees: `lights/0/right_deg` and `lights/0/up_deg` (of the first light, as
    /// seen from the centre of the mesh), `camera/right_deg` and `camera/up_deg` (about the centre
    /// of the mesh), `camera/aim_right_deg`, `camera/aim_up_deg` and `camera/roll_deg` (about the
    /// eye). Factors: `lights/0/distance`, `camera/distance`, `camera/fov`, and of the image's
    /// brightness `gain`, `gain/red`, `gain/green` and `gain/blue`.
    pub name: String,
    /// Value.
    pub value: f64,
    /// Standard deviation before the fit: as stated.
    pub stated_deviation: f64,
    /// Standard deviation after the fit.
    pub deviation: f64,
}

fn largest_code() -> ClipFrom {
    ClipFrom::LARGEST
}

/// Numbers of pixels by status: used as a sample, or the reason for not being used.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct TargetPixels {
    /// All pixels.
    pub pixels: u64,
    /// Used as samples.
    pub used: u64,
    /// Excluded by the mask.
    pub masked: u64,
    /// Background: the mesh does not cover the pixel.
    pub background: u64,
    /// On a silhouette, or on a crease or depth edge within the object.
    pub edge: u64,
    /// Clipped: as bright as the image can show, or beside such pixels.
    pub clipped: u64,
    /// Unlit.
    pub unlit: u64,
    /// At the edge of a shadow.
    pub half_lit: u64,
    /// Lit from several directions: by several lights, a light with an area or an environment.
    /// Models are fitted to them (strategy `analytic`).
    pub several_lights: u64,
    /// Grazing: the cosine of the light or view direction is below 0.01.
    pub grazing: u64,
    /// Outliers: differ from their neighbours by more than noise does, as dust, scratches and hot
    /// pixels do.
    #[serde(default)]
    pub outlier: u64,
}
