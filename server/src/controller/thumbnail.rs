//! Thumbnails by key: immutable; a request waits while the picture is being rendered.

use axum::extract::State;
use axum::response::Response;
use brood_protocol::{PictureFormat, PictureKey, RENDERER_VERSION};
use http::{HeaderMap, header};

use super::file::{FileHead, IMMUTABLE};
use crate::extract::Path;
use crate::problem::ApiError;
use crate::state::App;

/// Returns a picture by its key; waits while it is being rendered.
#[utoipa::path(get, path = "/v1/thumbnails/{file}", tag = "pictures",
    params(("file" = String, Path, description = "picture key followed by `.png`")),
    responses((status = 200, content_type = "image/png"), (status = 304, description = "unchanged")))]
pub async fn get(
    State(app): State<App>,
    Path(name): Path<String>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let key = name.strip_suffix(".png").and_then(|key| key.parse::<PictureKey>().ok());
    let key = key.ok_or_else(|| {
        ApiError::not_found("a thumbnail's name must be 64 hexadecimal digits followed by .png")
    })?;
    let row = app.pictures.row(key).await?;
    if row.format != PictureFormat::Png {
        return Err(ApiError::not_found("this key belongs to another kind of picture"));
    }
    if row.renderer_version != RENDERER_VERSION {
        let url = app.pictures.present_url(&row).await?;
        let words = format!("the current picture is at {url}");
        return Err(ApiError::gone(words).with_header(header::LOCATION, url));
    }
    let head = FileHead::of_picture(key, "image/png", IMMUTABLE);
    head.made(&headers, app.pictures.get(&row)).await
}
