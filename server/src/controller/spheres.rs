//! Lit spheres of a material, from which the page draws environments live.

use std::sync::Arc;

use axum::body::Body;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use brood_eval::is_prefilterable;
use brood_protocol::{Frame, IndividualId, MeshSource, PictureFormat, SceneId, Subject};
use brood_scene::{Sampling, Scene, SphereLayout};
use http::{HeaderMap, Request, StatusCode, header};
use serde::Deserialize;

use super::file::{FileHead, REVALIDATED};
use super::picture_query::{check_light, content_type};
use super::render::posted::posted_material;
use crate::dispatch::PictureRequest;
use crate::extract::{Path, Query};
use crate::library::Material;
use crate::problem::ApiError;
use crate::state::App;

/// Default texels along the side of a sphere.
const TEXELS: u32 = 48;
/// Least and largest number of texels along the side of a sphere.
const TEXELS_RANGE: std::ops::RangeInclusive<u32> = 16..=128;
/// Least and largest number of turns.
const TURNS_RANGE: std::ops::RangeInclusive<u32> = 1..=24;
/// Most texels of the image.
const PIXELS_MAX: u64 = 9 * 128 * 128;
const FORMAT: PictureFormat = PictureFormat::Spheres;

/// Options of lit spheres of an individual.
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
    /// Number of turns of the environments: 1 to 24, default 1.
    #[param(minimum = 1, maximum = 24, default = 1)]
    turns: Option<u32>,
}

/// Options of lit spheres of a genome.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct PostedSpheresQuery {
    /// Scene with the environments and the camera.
    scene: SceneId,
    /// Light angle on the scene's light circle, in degrees.
    light_deg: Option<f64>,
    /// Texels along the side of a sphere: 16 to 128, default 48.
    #[param(minimum = 16, maximum = 128, default = 48)]
    texels: Option<u32>,
    /// Number of turns of the environments: 1 to 24, default 1.
    #[param(minimum = 1, maximum = 24, default = 1)]
    turns: Option<u32>,
}

/// Returns the radiance of an individual in the environments of a scene, for all normals, seen from
/// nine places of the picture. Only of environments that cast no shadows.
///
/// Little-endian: `broodlit`, u32 version (3), u32 texels along the side of a sphere, u32 turns,
/// f32 unit, then three times as many rows of three times as many texels, the first row at the
/// bottom: the spheres of the corners, middles of the sides and middle. A texel is red, green and
/// blue as 16-bit floats: radiance divided by the unit. The radiance of the environments behind the
/// object follows if they are its backdrop.
///
/// With n turns, n > 1, the rows are as long as one sphere: those of the lower, middle and upper
/// places in the middle column, with the first environment rotated by 0 and the others with it,
/// then with all turned further by 1 / n of a circle, and so on. No backdrop follows.
#[utoipa::path(get, path = "/v1/individuals/{id}/lit-spheres", operation_id = "get_lit_spheres", tag = "pictures",
    params(("id" = IndividualId, Path), SpheresQuery),
    responses((status = 200, description = "radiance in the binary format above",
        content_type = "application/octet-stream"),
        (status = 204, description = "the material is anisotropic, textured or painted, or has bumps"),
        (status = 304)))]
pub async fn get(
    State(app): State<App>,
    Path(id): Path<IndividualId>,
    Query(query): Query<SpheresQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let layout = layout(query.texels, query.turns)?;
    check_light(query.light_deg)?;
    let individual = app.store.individual(id).await?;
    let scene = match query.scene {
        Some(scene) => scene,
        None => app.store.lineage(individual.lineage).await?.scene,
    };
    let scene = lit_scene(&app, scene, query.light_deg).await?;
    let material = app.library.material(individual.hash).await?;
    let Some(request) = request_of(&app, &scene, layout, material) else {
        return Ok(StatusCode::NO_CONTENT.into_response());
    };
    let head = FileHead::of_picture(request.key(), content_type(FORMAT), REVALIDATED);
    head.made(&headers, app.pictures.get(request)).await
}

/// Returns the radiance of a genome in the environments of a scene, without storing the genome: the
/// same file as for an individual.
#[utoipa::path(post, path = "/v1/lit-spheres", operation_id = "post_lit_spheres", tag = "pictures",
    params(PostedSpheresQuery),
    request_body(content((serde_json::Value = "application/json"), (String = "text/x-brood"))),
    responses((status = 200, description = "radiance in the binary format of an individual",
        content_type = "application/octet-stream"),
        (status = 204, description = "the material is anisotropic, textured or painted, or has bumps")))]
pub async fn post(
    State(app): State<App>,
    Query(query): Query<PostedSpheresQuery>,
    request: Request<Body>,
) -> Result<Response, ApiError> {
    let layout = layout(query.texels, query.turns)?;
    check_light(query.light_deg)?;
    let scene = lit_scene(&app, query.scene, query.light_deg).await?;
    let material = posted_material(&app, request).await?;
    let Some(request) = request_of(&app, &scene, layout, material) else {
        return Ok(StatusCode::NO_CONTENT.into_response());
    };
    let spheres = app.pictures.get(request).await?;
    let headers =
        [(header::CONTENT_TYPE, content_type(FORMAT)), (header::CACHE_CONTROL, "no-store")];
    Ok((headers, spheres).into_response())
}

/// Returns the layout of the options.
fn layout(texels: Option<u32>, turns: Option<u32>) -> Result<SphereLayout, ApiError> {
    let (texels, turns) = (texels.unwrap_or(TEXELS), turns.unwrap_or(1));
    for (name, number, range) in [("texels", texels, TEXELS_RANGE), ("turns", turns, TURNS_RANGE)] {
        if !range.contains(&number) {
            let (least, most) = (range.start(), range.end());
            let words = format!("must be {least} to {most}, got {number}");
            return Err(ApiError::bad_parameter(name, words));
        }
    }
    let layout = SphereLayout { texels, turns };
    if layout.size_px().pixels() > PIXELS_MAX {
        let words = format!("must be fewer for {texels} texels: {PIXELS_MAX} texels in all");
        return Err(ApiError::bad_parameter("turns", words));
    }
    Ok(layout)
}

/// Returns a scene whose environments can be prefiltered.
async fn lit_scene(app: &App, id: SceneId, light_deg: Option<f64>) -> Result<Scene, ApiError> {
    let known = app.library.scene(id).await?;
    let scene = match light_deg {
        Some(degrees) => known.scene.with_light_deg(degrees),
        None => known.scene.clone(),
    };
    if !scene.is_prefilterable() {
        let words = "lit spheres need a scene with environments that cast no shadows";
        return Err(ApiError::refused(words));
    }
    Ok(scene)
}

/// Returns the request for the spheres of a material; `None` if it is anisotropic, textured or has
/// bumps.
fn request_of(
    app: &App,
    scene: &Scene,
    layout: SphereLayout,
    material: Arc<Material>,
) -> Option<PictureRequest> {
    if !is_prefilterable(&material.program) || material.program.bumps().is_some() {
        return None;
    }
    let options = (FORMAT, app.backend);
    let scene = scene.for_spheres(layout.turns);
    let (mesh, size_px) = (MeshSource::Builtin, layout.size_px());
    let frame = Frame::new(&scene, mesh, size_px, Sampling::Adaptive, options);
    Some(PictureRequest::own(frame, &Subject::Program(material)))
}
