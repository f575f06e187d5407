//! Comparisons: materials in one scene at one exposure, with their distance from the first and
//! their optical properties.
//!
//! Workers render the pictures; this module only compares them.

mod picture;
mod request;

use std::sync::Arc;

use axum::extract::State;
use axum::response::Response;
use brood_inspect::{CurvePoint, OTHER_LIGHT_DEG, Phenomena, curves};
use brood_protocol::{ParentRef, PictureFormat, SceneId, Subject};
use http::HeaderMap;
use serde::Serialize;

use self::picture::{exposed, linear, row};
pub use self::request::ComparisonQuery;
use self::request::{ComparisonRequest, RequestedMaterial, specimen};
use super::file::{FileHead, REVALIDATED};
use crate::deferred::{AnswerProgress, in_time};
use crate::dispatch::PictureRequest;
use crate::extract::Query;
use crate::library::{Framing, Optics};
use crate::picture::thumbnail_url;
use crate::problem::ApiError;
use crate::state::App;

/// Comparison of materials.
#[derive(Debug, Clone, Serialize, utoipa::ToSchema)]
pub struct Comparison {
    /// Scene of the pictures: the requested one with a fixed exposure.
    scene: SceneId,
    /// Exposure of all pictures in EV: the scene's, or the automatic exposure of the first
    /// material.
    exposure_ev: f64,
    /// Side of the pictures in pixels.
    size_px: u32,
    /// Angle in degrees by which the other light is further along its circle.
    other_light_deg: f64,
    /// Materials in the order requested.
    materials: Vec<Compared>,
}

/// Material in a comparison.
#[derive(Debug, Clone, Serialize, utoipa::ToSchema)]
pub struct Compared {
    /// Individual id or genome hash, as requested.
    material: ParentRef,
    /// Content hash of the genome.
    hash: String,
    /// Names of the genome's models.
    layers: Vec<String>,
    /// URL of the picture.
    picture: String,
    /// URL of the picture under the other light.
    other_light: String,
    /// Distance from the first material; null for the first itself.
    difference: Option<Difference>,
    /// Directional albedo and mirror reflection over the angle of incidence.
    curves: Vec<CurvePoint>,
    /// Summary values of the optical behaviour.
    phenomena: Phenomena,
}

/// Distance of a picture from the first one.
#[derive(Debug, Clone, Serialize, utoipa::ToSchema)]
pub struct Difference {
    /// URL of the picture of absolute differences of exposed linear values.
    picture: String,
    /// Root mean square of the differences.
    rmse: f64,
    /// Mean FLIP error of the developed pictures.
    flip: f64,
}

/// Compares two to six materials.
#[utoipa::path(get, path = "/v1/comparison", operation_id = "compare_materials", tag = "individuals",
    params(ComparisonQuery),
    responses((status = 200, description = "figures of each material and of each pair", body = Comparison),
        (status = 304)))]
pub async fn get(
    State(app): State<App>,
    Query(query): Query<ComparisonQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let request = ComparisonRequest::find(&app, query).await?;
    let etag = request.etag();
    let head = FileHead { etag, content_type: "application/json", cache: REVALIDATED };
    let make = async {
        let compared = in_time(compare(&app, request)).await?;
        Ok(serde_json::to_vec(&compared).expect("a comparison is plain data"))
    };
    head.made(&headers, make).await
}

/// Returns the picture of absolute differences of two materials, in exposed linear values.
#[utoipa::path(get, path = "/v1/comparison/difference.png", operation_id = "get_difference", tag = "pictures",
    params(ComparisonQuery),
    responses((status = 200, description = "picture of the differences as PNG", content_type = "image/png"),
        (status = 304)))]
pub async fn difference(
    State(app): State<App>,
    Query(query): Query<ComparisonQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let request = ComparisonRequest::find(&app, query).await?;
    if request.materials.len() != 2 {
        return Err(ApiError::bad_parameter("materials", "must be exactly 2"));
    }
    let etag = request.etag();
    let head = FileHead { etag, content_type: "image/png", cache: REVALIDATED };
    let make = async {
        let (scene, _) = exposed(&app, &request).await?;
        let framed = app.library.frame(request.view(&app, scene, PictureFormat::Png)).await?;
        let pair = [0, 1].map(|index: usize| request.materials[index].material.clone());
        let difference = Subject::Difference(pair);
        app.pictures.get(PictureRequest::own(framed.frame.clone(), &difference)).await
    };
    head.made(&headers, make).await
}

async fn compare(app: &App, request: ComparisonRequest) -> Result<Comparison, ApiError> {
    let (scene, exposure_ev) = exposed(app, &request).await?;
    AnswerProgress::expect(request.materials.len());
    let pictures = linear(app, &request, (scene, exposure_ev)).await?;
    let apart = move || -> Vec<(f64, f64)> {
        let (first, others) =
            pictures.split_first().expect("at least two materials were requested");
        others.iter().map(|other| (first.rmse(other), first.flip(other))).collect()
    };
    let mut apart = app.processors.run(apart).await?.into_iter();
    let first = request.materials[0].hash;
    let light_deg = app.library.scene(scene).await?.scene.light_deg;
    let mut materials = Vec::with_capacity(request.materials.len());
    for (index, one) in request.materials.iter().enumerate() {
        let optics = optics(app, one, request.scene).await?;
        let view = request.view(app, scene, PictureFormat::Png);
        let other = Framing { light_deg: Some(light_deg + OTHER_LIGHT_DEG), ..view };
        let difference = (index > 0).then(|| apart.next()).flatten();
        let (hash, size) = (one.hash, request.size_px);
        materials.push(Compared {
            material: one.named,
            hash: hash.to_string(),
            layers: one.material.genome.layers().iter().map(|it| it.kind().name().into()).collect(),
            picture: thumbnail_url(row(app, one, view).await?.key),
            other_light: thumbnail_url(row(app, one, other).await?.key),
            difference: difference.map(|(rmse, flip)| Difference {
                picture: format!(
                    "/v1/comparison/difference.png?materials={first},{hash}&scene={scene}&size={size}"
                ),
                rmse,
                flip,
            }),
            curves: optics.curves.clone(),
            phenomena: optics.phenomena.clone(),
        });
    }
    let (size_px, other_light_deg) = (request.size_px, OTHER_LIGHT_DEG);
    Ok(Comparison { scene, exposure_ev, size_px, other_light_deg, materials })
}

async fn optics(
    app: &App,
    one: &RequestedMaterial,
    scene: SceneId,
) -> Result<Arc<Optics>, ApiError> {
    let circle = app.library.light_circle(scene).await?;
    let (key, material, app2) = ((one.hash, scene), one.material.clone(), app.clone());
    let look = move || {
        app2.library.optics(key, || {
            let specimen = specimen(&material);
            let curves = curves(&specimen);
            let phenomena = Phenomena::of(&specimen, &curves, &circle);
            Optics { curves, phenomena }
        })
    };
    app.processors.run(look).await
}
