//! Picture keys and their parameters. Owner of the table `picture`. Pixels are derived and cached
//! elsewhere.

use std::collections::HashSet;

use brood_genome::GenomeHash;
use brood_protocol::{
    Backend, PictureFormat, PictureKey, PictureSize, PixelArea, Sampling, SceneId,
};

use crate::Store;
use crate::column::{Key, columns};
use crate::error::Result;
use crate::row::{Record, insert_rows, key_set, record, select, values};
use crate::sql::{Conn, query};
use crate::write::operation;

record! {
    /// Parameters that are needed to render a picture, with its key.
    #[derive(Debug, Clone, PartialEq)]
    pub struct StoredPicture {
        /// Key of the picture.
        pub key: PictureKey,
        /// Genome with the picture's program.
        pub genome_hash: GenomeHash,
        /// Id of the scene.
        pub scene: SceneId = "scene_id",
        /// Position of the scene's lights on the light orbit, in degrees.
        pub light_deg: f64,
        /// Size of the whole picture.
        pub size_px: PictureSize = "size_px || coalesce('x' || height_px, '')",
        /// Samples per pixel.
        pub sampling: Sampling = "CASE WHEN NOT adaptive THEN samples END",
        /// Area of the picture; `None` for the whole.
        pub area: Option<PixelArea> = "nullif(area, '')",
        /// File format.
        pub format: PictureFormat,
        /// Evaluator.
        pub backend: Backend,
        /// Version of the renderer that the key was made for.
        pub renderer_version: u32,
    }
}

columns! {
    String => PictureSize: |text| text.parse().ok();
    Vec<u8> => PictureKey: |bytes| bytes.try_into().ok().map(Self);
    Option<i64> => Sampling: |samples| match samples {
        Some(samples) => Self::fixed(samples.try_into().ok()?).ok(),
        None => Some(Self::Adaptive),
    };
}

/// Picture key to be stored; the same as is read back.
pub type NewPicture = StoredPicture;

impl Store {
    /// Stores keys. Existing keys are unchanged; nothing is written if all exist.
    ///
    /// # Errors
    /// Returns `StorageError::NotFound` if a genome or scene does not exist.
    pub async fn put_pictures(&self, mut pictures: Vec<NewPicture>) -> Result<()> {
        let known = key_set(pictures.iter().map(|picture| &picture.key));
        let rows =
            query("SELECT key FROM picture WHERE key IN (SELECT unhex(value) FROM json_each(?))")
                .bind(known)
                .fetch_all(&mut self.reader().await?)
                .await?;
        let found = rows.iter().map(|row| row.column("key"));
        let found = found.collect::<Result<HashSet<PictureKey>, _>>()?;
        pictures.retain(|picture| !found.contains(&picture.key));
        if pictures.is_empty() {
            return Ok(());
        }
        self.write(operation!(|conn| insert(conn, &pictures).await)).await
    }

    /// Returns the parameters of a key.
    ///
    /// # Errors
    /// Returns `StorageError::NotFound` if the key is unknown.
    pub async fn picture(&self, key: PictureKey) -> Result<StoredPicture> {
        let query = select::<StoredPicture>("FROM picture WHERE key = ?").bind(key.key());
        StoredPicture::read(&query.fetch_one(&mut self.reader().await?).await?)
    }
}

/// Inserts keys. Existing keys are unchanged.
pub(crate) async fn insert(conn: &mut Conn, pictures: &[NewPicture]) -> Result<()> {
    // Sorted, so that two transactions with the same keys cannot wait for each other.
    let mut sorted: Vec<_> = pictures.iter().collect();
    sorted.sort_by_key(|picture| picture.key.0);
    let head = "INSERT INTO picture (key, genome_hash, scene_id, light_deg, size_px, height_px, samples, adaptive, area, format,
     backend, renderer_version) ";
    insert_rows(conn, (head, " ON CONFLICT (key) DO NOTHING"), &sorted, |picture| {
        let PictureSize { width, height } = picture.size_px;
        values![
            picture.key.key(),
            picture.genome_hash.key(),
            picture.scene.key(),
            picture.light_deg,
            width,
            Some(height).filter(|height| *height != width),
            picture.sampling.min_rays(),
            picture.sampling == Sampling::Adaptive,
            picture.area.map_or_else(String::new, |area| area.to_string()),
            picture.format.name(),
            picture.backend.name(),
            picture.renderer_version,
        ]
    })
    .await
}
