//! Pictures of a genome that is not stored, for example while it is edited.

use std::sync::Arc;

use axum::body::Body;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use brood_eval::express;
use brood_protocol::{PictureFormat, SceneId, Subject};
use brood_scene::{PixelArea, Sampling};
use http::{Request, header};
use serde::Deserialize;

use super::super::genome;
use super::super::picture_query::{check_light, check_rays, content_type, size};
use crate::control_image;
use crate::dispatch::PictureRequest;
use crate::extract::{Query, read_upload};
use crate::library::{Framing, Material};
use crate::limit;
use crate::problem::ApiError;
use crate::state::App;

/// Options of a picture of a genome.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct PostedQuery {
    /// Scene to render.
    scene: SceneId,
    /// Size in pixels: the side of a square picture, or width and height as in `640x360`; each side
    /// 16 to 2048, default 256.
    #[param(pattern = "^[0-9]+(x[0-9]+)?$")]
    size: Option<String>,
    /// Light angle on the scene's light circle, in degrees.
    light_deg: Option<f64>,
}

/// Returns a picture of a genome as PNG, without storing the genome.
#[utoipa::path(post, path = "/v1/render.png", operation_id = "render_genome_png", tag = "pictures",
    params(PostedQuery),
    request_body(content((serde_json::Value = "application/json"), (String = "text/x-brood"))),
    responses((status = 200, description = "picture as PNG", content_type = "image/png")))]
pub async fn png(
    State(app): State<App>,
    Query(query): Query<PostedQuery>,
    request: Request<Body>,
) -> Result<Response, ApiError> {
    let size_px = size(query.size.as_deref())?;
    let sampling = Sampling::default();
    check_light(query.light_deg)?;
    check_rays(PixelArea::whole(size_px).pixels(), sampling)?;
    let material = posted_material(&app, request).await?;
    let format = PictureFormat::Png;
    let view = Framing {
        scene: query.scene,
        light_deg: query.light_deg,
        size_px,
        sampling,
        area: None,
        format,
        backend: app.backend,
    };
    let framed = app.library.frame(view).await?;
    framed.check(&material.program)?;
    let subject = Subject::Program(material);
    let picture = app.pictures.get(PictureRequest::own(framed.frame.clone(), &subject)).await?;
    let headers =
        [(header::CONTENT_TYPE, content_type(format)), (header::CACHE_CONTROL, "no-store")];
    Ok((headers, picture).into_response())
}

/// Reads the genome of a request, checks its control images, and lowers it.
pub async fn posted_material(app: &App, request: Request<Body>) -> Result<Arc<Material>, ApiError> {
    let types = ["application/json", genome::TEXT];
    let (media_type, bytes) = read_upload(request, &types, limit::JSON_BYTES).await?;
    let is_text = media_type.is(genome::TEXT);
    let express = move || -> Result<Material, ApiError> {
        let genome = genome::parse(&bytes, is_text)?;
        let program = express(&genome);
        Ok(Material { genome, program })
    };
    let material = app.processors.run(express).await??;
    control_image::check(&app.store, &material.genome).await?;
    Ok(Arc::new(material))
}
