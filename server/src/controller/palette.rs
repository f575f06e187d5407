//! Colours of uploaded pictures, with which painted materials are bred.

use axum::Json;
use axum::body::Body;
use brood_eval::{DisplayPicture, decode_display};
use brood_genome::PaintingPalette;
use brood_target::KnownView;
use http::Request;

use super::target::read::{READ_PERMITS, REASON_CHARS, clean, read_blocking};
use crate::extract::read_upload;
use crate::limit;
use crate::problem::ApiError;

/// Returns the colours of a picture by regions, as the `painting` of a breed request.
///
/// Up to 6 regions by hue and saturation, the largest first, each with the mean colours of its
/// darkest tenth, the tenth of middle lightness and its brightest tenth. Transparent pixels are
/// ignored. At most 4096 pixels a side. Stores nothing.
#[utoipa::path(post, path = "/v1/palettes", operation_id = "read_palette", tag = "generations",
    request_body(content((Vec<u8> = "image/png"), (Vec<u8> = "image/jpeg"))),
    responses((status = 200, description = "colours by regions", body = PaintingPalette)))]
pub async fn read(request: Request<Body>) -> Result<Json<PaintingPalette>, ApiError> {
    let types = ["image/png", "image/jpeg"];
    let (_, bytes) = read_upload(request, &types, limit::TARGET_BYTES).await?;
    read_blocking(READ_PERMITS, move || palette(&bytes)).await?.map(Json)
}

/// Decodes a picture and finds its regions.
///
/// # Errors
/// 422 if it cannot be decoded, is too large or is transparent.
fn palette(bytes: &[u8]) -> Result<PaintingPalette, ApiError> {
    let refused = |words: String| ApiError::refused(clean(&words, REASON_CHARS));
    let picture = decode_display(bytes, KnownView::SIDE_MOST);
    let DisplayPicture { width, height, rgba } =
        picture.map_err(|error| refused(error.to_string()))?;
    let palette = PaintingPalette::of_picture(width, height, &rgba);
    palette.map_err(|error| refused(error.to_string()))
}
