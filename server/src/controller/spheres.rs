//! Lit spheres of an individual, from which the page draws environments live.

use axum::extract::State;
use axum::response::{IntoResponse, Response};
use brood_eval::is_prefilterable;
use brood_protocol::{Frame, IndividualId, MeshSource, PictureFormat, SceneId, Subject};
use brood_scene::{SPHERES_ACROSS, Sampling};
use http::{HeaderMap, StatusCode};
use serde::Deserialize;

use super::file::{FileHead, REVALIDATED};
use super::picture_query::{check_light, content_type};
use crate::dispatch::PictureRequest;
use crate::extract::{Path, Query};
use crate::problem::ApiError;
use crate::state::App;

/// Default texels along the side of a sphere.
const TEXELS: u32 = 48;
/// Least and largest number of texels along the side of a sphere.
const TEXELS_RANGE: std::ops::RangeInclusive<u32> = 16..=128;

/// Options of lit spheres.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct SpheresQuery {
    /// Scene with the environments and the camera; default: the lineage's scene.
    scene: Option<SceneId>,
    /// Light angle on the scene's light circle, in degrees.
    light_deg: Option<f64>,
    /// Texels along the side of a sphere: 16 to 128, default 48.
    #[param(minimum = 16, maximum = 128, default = 48)]
    texels: Option<u32>,
}

/// Returns the radiance of an individual in the environments of a scene, for all normals, seen from
/// nine places of the picture. Only in scenes without shadows.
///
/// Little-endian: `broodlit`, u32 version (1), u32 texels along the side of a sphere, f32 unit,
/// then three times as many rows of three times as many texels, the first row at the bottom: the
/// spheres of the corners, middles of the sides and middle. A texel is red, green and blue as
/// 16-bit floats: radiance divided by the unit.
#[utoipa::path(get, path = "/v1/individuals/{id}/lit-spheres", tag = "pictures",
    params(("id" = IndividualId, Path), SpheresQuery),
    responses((status = 200, content_type = "application/octet-stream"),
        (status = 204, description = "the material is anisotropic or textured"),
        (status = 304, description = "unchanged")))]
pub async fn get(
    State(app): State<App>,
    Path(id): Path<IndividualId>,
    Query(query): Query<SpheresQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let texels = query.texels.unwrap_or(TEXELS);
    if !TEXELS_RANGE.contains(&texels) {
        let (least, most) = (TEXELS_RANGE.start(), TEXELS_RANGE.end());
        return Err(ApiError::bad_parameter(
            "texels",
            format!("must be {least} to {most}, got {texels}"),
        ));
    }
    check_light(query.light_deg)?;
    let individual = app.store.individual(id).await?;
    let scene = match query.scene {
        Some(scene) => scene,
        None => app.store.lineage(individual.lineage).await?.scene,
    };
    let known = app.library.scene(scene).await?;
    let scene = match query.light_deg {
        Some(degrees) => known.scene.with_light_deg(degrees),
        None => known.scene.clone(),
    };
    if !scene.is_prefilterable() {
        let words = "lit spheres need a scene with an environment and without shadows";
        return Err(ApiError::refused(words));
    }
    let material = app.library.material(individual.hash).await?;
    if !is_prefilterable(&material.program) {
        return Ok(StatusCode::NO_CONTENT.into_response());
    }
    let scene = scene.for_spheres();
    let (mesh, format) = (MeshSource::Builtin, PictureFormat::Spheres);
    let frame = Frame::new(
        &scene,
        mesh,
        SPHERES_ACROSS * texels,
        Sampling::Adaptive,
        (format, app.backend),
    );
    let request = PictureRequest::own(frame, &Subject::Program(material));
    let head = FileHead::of_picture(request.key(), content_type(format), REVALIDATED);
    head.made(&headers, app.pictures.get(request)).await
}
