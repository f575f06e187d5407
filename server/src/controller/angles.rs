//! Lit angles of a scene, from which the page draws shadows live.

use std::ops::RangeInclusive;

use axum::extract::State;
use axum::response::Response;
use brood_protocol::{Backend, Frame, ObjectSource, PictureFormat, SceneId, Subject};
use brood_scene::{Sampling, Scene};
use http::HeaderMap;
use serde::Deserialize;

use super::file::{FileHead, REVALIDATED};
use super::picture_query::content_type;
use crate::dispatch::PictureRequest;
use crate::extract::{Path, Query};
use crate::library::KnownScene;
use crate::problem::ApiError;
use crate::state::App;

/// Least and largest side of the picture in pixels.
const SIDES: RangeInclusive<u32> = 16..=1024;
/// Largest size of a file; results of workers may be twice as large.
const MOST_BYTES: usize = 256 << 20;
/// Bytes of the angles of a light at a pixel.
pub(super) const ANGLE_BYTES: usize = 16;
const FORMAT: PictureFormat = PictureFormat::Angles;

/// Options of lit angles.
#[derive(Debug, Clone, Copy, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct AnglesQuery {
    /// Side of the picture in pixels, 16 to 1024; less with many lights, so that files have at most
    /// 256 MiB.
    #[param(minimum = 16, maximum = 1024)]
    side: u32,
    /// True to append the angles of all lights as if they shone through the subject. Default:
    /// false.
    #[serde(default)]
    clear: bool,
}

/// Returns the angles on the light circle at which the point, spot and directional lights of a
/// scene reach the points of its picture, on the nearest object. Only of scenes with shadows and no
/// other lights.
///
/// Little-endian: `broodang`, u32 version (1), u32 side, u32 lights (with `clear` twice as many),
/// then for each light the pixels row by row from the bottom. A pixel is eight u16 in ascending
/// order: the angles at which the light begins to reach the point and ceases in turn, in 1/65535 of
/// a circle of `light_deg`; 65535 where there are fewer.
#[utoipa::path(get, path = "/v1/scenes/{id}/lit-angles", operation_id = "get_lit_angles", tag = "scenes",
    params(("id" = SceneId, Path), AnglesQuery),
    responses((status = 200, description = "angles in the binary format above",
        content_type = "application/octet-stream"),
        (status = 304)))]
pub async fn get(
    State(app): State<App>,
    Path(id): Path<SceneId>,
    Query(AnglesQuery { side, clear }): Query<AnglesQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    check_side(side, *SIDES.end())?;
    let known = app.library.scene(id).await?;
    let words = "lit angles need a scene with shadows, and point, spot or directional lights alone";
    let scene = known.scene.for_angles().ok_or_else(|| ApiError::refused(words))?;
    let kinds = if clear { 2 } else { 1 };
    check_side(side, largest_side(ANGLE_BYTES * kinds * scene.lights.len()))?;
    let frame = geometry_of((&scene, &known), side, (FORMAT, app.backend));
    let subject = if clear { Subject::ClearScene } else { Subject::Scene };
    let request = PictureRequest::own(frame, &subject);
    let head = FileHead::of_picture(request.key(), content_type(FORMAT), REVALIDATED);
    head.made(&headers, app.pictures.get(request)).await
}

/// Returns the largest side of a picture with this number of bytes for each pixel.
pub(super) fn largest_side(pixel_bytes: usize) -> u32 {
    (MOST_BYTES / pixel_bytes.max(1)).isqrt().try_into().unwrap_or(u32::MAX).min(*SIDES.end())
}

/// Checks the side of a picture in pixels.
pub(super) fn check_side(side: u32, most: u32) -> Result<(), ApiError> {
    let least = SIDES.start();
    let words = || format!("must be {least} to {most}, got {side}");
    let is_valid = (*least..=most).contains(&side);
    if is_valid { Ok(()) } else { Err(ApiError::bad_parameter("side", words())) }
}

/// Returns the frame of a scene's objects without their materials, with a sample a pixel.
pub(super) fn geometry_of(
    (scene, known): (&Scene, &KnownScene),
    side: u32,
    output: (PictureFormat, Backend),
) -> Frame {
    let plain = |object: &ObjectSource| ObjectSource { mesh: object.mesh, words: Vec::new() };
    let objects = known.objects.iter().map(plain).collect();
    Frame::new(scene, known.mesh, side, Sampling::Fixed(1), output).with_objects(objects)
}
