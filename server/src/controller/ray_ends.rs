//! Ray ends of a scene, from which the page draws clear bodies live.

use std::ops::RangeInclusive;

use axum::extract::State;
use axum::response::Response;
use brood_protocol::{PictureFormat, SceneId, Subject};
use http::HeaderMap;
use serde::Deserialize;

use super::angles::{ANGLE_BYTES, check_side, geometry_of, largest_side};
use super::file::{FileHead, REVALIDATED};
use super::picture_query::content_type;
use crate::dispatch::PictureRequest;
use crate::extract::{Path, Query};
use crate::problem::ApiError;
use crate::state::App;

/// Least and largest index of refraction.
const INDICES: RangeInclusive<f64> = 0.5..=2.0;
/// Number of rays of a pixel; bytes of a pixel and of an end without angles.
const RAYS: usize = 3;
const PIXEL_BYTES: usize = 24;
const END_BYTES: usize = 48;
const FORMAT: PictureFormat = PictureFormat::RayEnds;

/// Options of ray ends.
#[derive(Debug, Clone, Copy, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct RayEndsQuery {
    /// Side of the picture in pixels, 16 to 1024; less with many lights, so that files have at most
    /// 256 MiB.
    #[param(minimum = 16, maximum = 1024)]
    side: u32,
    /// Index of refraction of the subject, 0.5 to 2, rounded to hundredths.
    #[param(minimum = 0.5, maximum = 2.0)]
    index: f64,
}

/// Returns the points in which the rays of a scene's subject end, as a clear body: the mirrored eye
/// ray and at most two ways through it, in a picture with a sample a pixel. Only of scenes without
/// normal maps.
///
/// Little-endian: `broodend`, u32 version (1), u32 side, u32 ends in a row, u32 parts (the subject,
/// the other objects, the ground, the background), u32 sets of angles, and u32 rows of each part.
/// Then, for the pixels row by row from the bottom, four u32 each: the numbers of the ends of the
/// mirrored ray and of both ways, from 1, 0 without a ray; and 0. Then four f16 for each pixel: the
/// lengths of these rays inside the body, in its radii, and the share of the first way. Then, for
/// the ends part after part, each from a new row, five blocks in the frame of the subject: position
/// and 1 (f32), and in f16 what painted materials read (n.e, depth and their gradients), direction
/// against the ray along tangent and n x tangent with the texture position, normal and 1, tangent
/// and 0. The position on the background is that in the picture of a backdrop. Then, for each set
/// of angles, eight u16 for each end: of a scene that has lit angles, those of its lights, then
/// those of its lights as if they shone through the subject.
#[utoipa::path(get, path = "/v1/scenes/{id}/ray-ends", operation_id = "get_ray_ends", tag = "scenes",
    params(("id" = SceneId, Path), RayEndsQuery),
    responses((status = 200, description = "ends of rays in the binary format above",
        content_type = "application/octet-stream"),
        (status = 304)))]
pub async fn get(
    State(app): State<App>,
    Path(id): Path<SceneId>,
    Query(RayEndsQuery { side, index }): Query<RayEndsQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    check_side(side, largest_side(0))?;
    if !INDICES.contains(&index) {
        let words = format!("must be {} to {}, got {index}", INDICES.start(), INDICES.end());
        return Err(ApiError::bad_parameter("index", words));
    }
    let known = app.library.scene(id).await?;
    let words = "ray ends need a scene without normal maps";
    let scene = known.scene.for_ray_ends().ok_or_else(|| ApiError::refused(words))?;
    let sets = if scene.shadows { 2 * scene.lights.len() } else { 0 };
    check_side(side, largest_side(PIXEL_BYTES + RAYS * (END_BYTES + ANGLE_BYTES * sets)))?;
    let frame = geometry_of((&scene, &known), side, (FORMAT, app.backend));
    let hundredths = (100.0 * index).round() as u16;
    let request = PictureRequest::own(frame, &Subject::RayEnds(hundredths));
    let head = FileHead::of_picture(request.key(), content_type(FORMAT), REVALIDATED);
    head.made(&headers, app.pictures.get(request)).await
}
