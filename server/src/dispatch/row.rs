//! Rows of pictures, which keep their keys valid across restarts.

use std::sync::Arc;

use brood_genome::GenomeHash;
use brood_program::ProgramHash;
use brood_protocol::PictureKey;
use brood_storage::StoredPicture;

use super::pictures::PictureService;
use super::request::FrameId;
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
        let (view, genome) = (FrameId::of(row).view(), row.genome_hash);
        let program = self.library.material(genome).await?.program.hash();
        Ok(thumbnail_url(self.row_in(view, genome, program).await?.key))
    }

    /// Stores and returns the row of a material's picture in a framing.
    ///
    /// # Errors
    /// [`ApiError`] if the scene cannot be read or the store fails.
    pub async fn row_in(
        &self,
        view: Framing,
        genome: GenomeHash,
        program: ProgramHash,
    ) -> Result<Arc<StoredPicture>, ApiError> {
        let framed = self.library.frame(view).await?;
        self.store_row(framed.row(framed.key(program), genome)).await
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
