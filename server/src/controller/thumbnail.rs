//! Thumbnails by key: immutable; a request waits while the picture is being rendered.

use axum::extract::State;
use axum::response::Response;
use brood_protocol::{PictureFormat, PictureKey, RENDERER_VERSION};
use http::{HeaderMap, header};

use super::file::{FileHead, IMMUTABLE};
use crate::extract::Path;
use crate::picture::webp_of_png;
use crate::problem::ApiError;
use crate::state::App;

/// Returns a picture by its key; waits while it is being rendered.
///
/// `.webp` is lossy, with a sixth of the bytes, for clients far from the server.
#[utoipa::path(get, path = "/v1/thumbnails/{file}", operation_id = "get_thumbnail", tag = "pictures",
    params(("file" = String, Path, description = "picture key followed by `.png` or `.webp`")),
    responses((status = 200, description = "picture as PNG or WebP",
        content((Vec<u8> = "image/png"), (Vec<u8> = "image/webp"))),
        (status = 304)))]
pub async fn get(
    State(app): State<App>,
    Path(name): Path<String>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let (key, ending) = name.split_once('.').unwrap_or_default();
    let key = key.parse::<PictureKey>().ok().filter(|_| ["png", "webp"].contains(&ending));
    let key = key.ok_or_else(|| {
        let words = "a thumbnail's name must be 64 hexadecimal digits followed by .png or .webp";
        ApiError::not_found(words)
    })?;
    let row = app.pictures.row(key).await?;
    if row.format != PictureFormat::Png {
        return Err(ApiError::not_found("this key belongs to another kind of picture"));
    }
    if row.renderer_version != RENDERER_VERSION {
        let url = app.pictures.present_url(&row).await?.replace("png", ending);
        let words = format!("the current picture is at {url}");
        return Err(ApiError::gone(words).with_header(header::LOCATION, url));
    }
    if ending == "webp" {
        let head = FileHead {
            etag: format!("\"{key}-webp\""),
            content_type: "image/webp",
            cache: IMMUTABLE,
        };
        let make = async {
            let png = app.pictures.get(&row).await?;
            let made = app.processors.run(move || webp_of_png(&png)).await?;
            made.map_err(|error| ApiError::internal(format!("a picture is not encoded: {error}")))
        };
        return head.made(&headers, make).await;
    }
    let head = FileHead::of_picture(key, "image/png", IMMUTABLE);
    head.made(&headers, app.pictures.get(&row)).await
}
