//! Rows of pictures, which keep their keys valid across restarts.

use std::sync::Arc;

use brood_protocol::PictureKey;
use brood_storage::StoredPicture;

use super::pictures::PictureService;
use crate::library::Framing;
use crate::picture::thumbnail_url;
use crate::problem::ApiError;

impl PictureService {
    /// Returns the picture row of a key.
    ///
    /// # Errors
    /// 404 if the key is unknown.
    pub async fn row(&self, key: PictureKey) -> Result<Arc<StoredPicture>, ApiError> {
        if let Some(row) = self.cache.row(key) {
            return Ok(row);
        }
        let row = Arc::new(self.store.picture(key).await?);
        self.cache.insert_row(&row);
        Ok(row)
    }

    /// Returns the URL of the current renderer's picture for a key of an older renderer.
    ///
    /// # Errors
    /// [`ApiError`] if its scene or genome cannot be read.
    pub async fn present_url(&self, row: &StoredPicture) -> Result<String, ApiError> {
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
        if let Some(known) = self.cache.row(row.key) {
            return Ok(known);
        }
        self.store.put_pictures(vec![row.clone()]).await?;
        let row = Arc::new(row);
        self.cache.insert_row(&row);
        Ok(row)
    }
}
