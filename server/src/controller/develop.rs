//! Pictures of linear radiance as browsers can show them, before they are uploaded as targets.

use axum::body::Body;
use axum::response::{IntoResponse, Response};
use brood_eval::{Developed, Gain, LinearPicture, decode_linear, encode_png, picture_size};
use brood_target::KnownView;
use http::{Request, header};

use super::target::read::{READ_PERMITS, REASON_CHARS, clean, read_blocking};
use crate::extract::read_upload;
use crate::limit;
use crate::problem::ApiError;

/// Returns a picture as PNG in its own size: linear radiance at automatic exposure.
///
/// For choosing the crop of an image target whose format a browser cannot show. At most 4096 pixels
/// a side. Stores nothing.
#[utoipa::path(post, path = "/v1/develop.png", operation_id = "develop_picture", tag = "jobs",
    request_body(content((Vec<u8> = "image/x-exr"), (Vec<u8> = "image/vnd.radiance"))),
    responses((status = 200, description = "developed picture as PNG", content_type = "image/png")))]
pub async fn png(request: Request<Body>) -> Result<Response, ApiError> {
    let types = ["image/x-exr", "image/vnd.radiance"];
    let (_, bytes) = read_upload(request, &types, limit::TARGET_BYTES).await?;
    let png = read_blocking(READ_PERMITS, move || develop(&bytes)).await??;
    let headers = [(header::CONTENT_TYPE, "image/png"), (header::CACHE_CONTROL, "no-store")];
    Ok((headers, png).into_response())
}

/// Decodes a picture and develops it at automatic exposure.
///
/// # Errors
/// 422 if it cannot be decoded or is too large.
fn develop(bytes: &[u8]) -> Result<Vec<u8>, ApiError> {
    let refused = |words: String| ApiError::refused(clean(&words, REASON_CHARS));
    let (width, height) = picture_size(bytes).map_err(|error| refused(error.to_string()))?;
    let most = KnownView::SIDE_MOST;
    if width.max(height) > most {
        let words = format!(
            "a picture has at most {most} x {most} pixels; this one has {width} x {height}"
        );
        return Err(refused(words));
    }
    let picture = decode_linear(bytes, most).map_err(|error| refused(error.to_string()))?;
    let LinearPicture { width, height, pixels, .. } = picture;
    let brightest = pixels.iter().map(|pixel| pixel[0].max(pixel[1]).max(pixel[2]));
    let gain = Gain::automatic(brightest.filter(|value| value.is_finite()).collect());
    let rgba = vec![u8::MAX; 4 * pixels.len()];
    let mut shown = Developed { width, height, rgba, exposure_ev: gain.ev };
    for (at, pixel) in pixels.iter().enumerate() {
        shown.put(at, pixel.map(|value| if value.is_finite() { value } else { 0.0 }), gain);
    }
    Ok(encode_png(width, height, &shown.rgba))
}
