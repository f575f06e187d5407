//! Thumbnails by key: immutable; a request waits while the picture is being rendered.

use std::sync::Arc;

use axum::extract::State;
use axum::response::Response;
use brood_protocol::{PictureFormat, PictureKey, RENDERER_VERSION};
use brood_storage::StoredPicture;
use http::{HeaderMap, header};

use super::file::{FileHead, IMMUTABLE};
use crate::extract::{NoQuery, Path};
use crate::library::Framing;
use crate::presenter::thumbnail_url;
use crate::problem::ApiError;
use crate::state::{App, AppState};

/// Returns a picture by its key; waits while it is being rendered.
#[utoipa::path(get, path = "/v1/thumbnails/{file}", tag = "pictures",
    params(("file" = String, Path, description = "picture key followed by `.png`")),
    responses((status = 200, content_type = "image/png"), (status = 304, description = "unchanged")))]
pub async fn get(
    State(app): State<App>,
    NoQuery: NoQuery,
    Path(name): Path<String>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let key = name.strip_suffix(".png").and_then(|key| key.parse::<PictureKey>().ok());
    let key = key.ok_or_else(|| {
        ApiError::not_found("a thumbnail's name must be 64 hexadecimal digits followed by .png")
    })?;
    let row = app.row(key).await?;
    if row.format != PictureFormat::Png {
        return Err(ApiError::not_found("this key belongs to another kind of picture"));
    }
    if row.renderer_version != RENDERER_VERSION {
        let url = app.present_url(&row).await?;
        let words = format!("the current picture is at {url}");
        return Err(ApiError::gone(words).with_header(header::LOCATION, url));
    }
    let head = FileHead::of_picture(key, "image/png", IMMUTABLE);
    head.made(&headers, app.picture(&row)).await
}

impl AppState {
    /// Returns the picture row of a key.
    async fn row(&self, key: PictureKey) -> Result<Arc<StoredPicture>, ApiError> {
        if let Some(row) = self.picture_cache.row(key) {
            return Ok(row);
        }
        let row = Arc::new(self.store.picture(key).await?);
        self.picture_cache.insert_row(&row);
        Ok(row)
    }

    /// Returns the URL of the current renderer's picture for a key of an older renderer.
    async fn present_url(&self, row: &StoredPicture) -> Result<String, ApiError> {
        let view = Framing {
            scene: row.scene,
            light_deg: Some(row.light_deg),
            size_px: row.size_px,
            sampling: row.sampling,
            area: row.area,
            format: row.format,
            backend: row.backend,
        };
        let framed = self.library.frame(view).await?;
        let material = self.library.material(row.genome_hash).await?;
        let key = framed.key(material.program.hash());
        self.store_row(framed.row(key, row.genome_hash)).await?;
        Ok(thumbnail_url(key))
    }

    /// Stores a picture row, so that its key stays valid across restarts.
    ///
    /// # Errors
    /// [`ApiError`] if the store fails.
    pub async fn store_row(&self, row: StoredPicture) -> Result<Arc<StoredPicture>, ApiError> {
        if let Some(known) = self.picture_cache.row(row.key) {
            return Ok(known);
        }
        self.store.put_pictures(vec![row.clone()]).await?;
        let row = Arc::new(row);
        self.picture_cache.insert_row(&row);
        Ok(row)
    }
}
