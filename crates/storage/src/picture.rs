//! Picture keys and their parameters. Owner of the table `picture`. Pixels are derived and cached
//! elsewhere.

use brood_genome::GenomeHash;
use brood_protocol::{Backend, PictureFormat, PictureKey, PixelArea, Sampling, SceneId};
use sqlx::sqlite::SqliteRow;
use sqlx::{QueryBuilder, Sqlite, SqliteConnection};

use crate::genome::CHUNK_ROWS;
use crate::row::{Columns, Key, corrupt_column, json_set};
use crate::{StorageError, Store};

/// Parameters that are needed to render a picture, with its key.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredPicture {
    /// Key of the picture.
    pub key: PictureKey,
    /// Genome with the picture's program.
    pub genome_hash: GenomeHash,
    /// Id of the scene.
    pub scene: SceneId,
    /// Position of the light on the scene's light circle, in degrees.
    pub light_deg: f64,
    /// Side in pixels.
    pub size_px: u32,
    /// Samples per pixel.
    pub sampling: Sampling,
    /// Area of the picture; `None` for the whole.
    pub area: Option<PixelArea>,
    /// File format.
    pub format: PictureFormat,
    /// Evaluator.
    pub backend: Backend,
    /// Version of the renderer that the key was made for.
    pub renderer_version: u32,
}

/// Picture key to be stored; the same as is read back.
pub type NewPicture = StoredPicture;

impl Store {
    /// Stores keys. Existing keys are unchanged; nothing is written if all exist.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if a genome or scene does not exist.
    pub async fn put_pictures(&self, mut pictures: Vec<NewPicture>) -> Result<(), StorageError> {
        let known = json_set(pictures.iter().map(|picture| picture.key.0.as_slice()));
        let rows = sqlx::query(
            "SELECT key FROM picture WHERE key IN (SELECT unhex(value) FROM json_each(?))",
        )
        .bind(known)
        .fetch_all(&mut *self.reader().await?)
        .await?;
        let mut found = std::collections::HashSet::with_capacity(rows.len());
        for row in rows {
            found.insert(row.hash("key")?);
        }
        pictures.retain(|picture| !found.contains(&picture.key.0));
        if pictures.is_empty() {
            return Ok(());
        }
        self.write(move |conn| Box::pin(async move { insert(conn, &pictures).await })).await
    }

    /// Returns the parameters of a key.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if the key is unknown.
    pub async fn picture(&self, key: PictureKey) -> Result<StoredPicture, StorageError> {
        let row = sqlx::query(
            "SELECT key, genome_hash, scene_id, light_deg, size_px, samples, adaptive, area, format,
                    backend, renderer_version
             FROM picture WHERE key = ?",
        )
        .bind(key.0.as_slice())
        .fetch_one(&mut *self.reader().await?)
        .await?;
        read(&row)
    }
}

/// Inserts keys. Existing keys are unchanged.
pub(crate) async fn insert(
    conn: &mut SqliteConnection,
    pictures: &[NewPicture],
) -> Result<(), StorageError> {
    for chunk in pictures.chunks(CHUNK_ROWS) {
        let mut query = QueryBuilder::<Sqlite>::new(
            "INSERT INTO picture (key, genome_hash, scene_id, light_deg, size_px, samples, adaptive, area, format,
                                  backend, renderer_version) ",
        );
        query.push_values(chunk, |mut row, picture| {
            row.push_bind(picture.key.0.as_slice())
                .push_bind(picture.genome_hash.as_bytes().as_slice())
                .push_bind(picture.scene.key())
                .push_bind(picture.light_deg)
                .push_bind(picture.size_px)
                .push_bind(picture.sampling.min_rays())
                .push_bind(picture.sampling == Sampling::Adaptive)
                .push_bind(picture.area.map_or_else(String::new, |area| area.to_string()))
                .push_bind(format_name(picture.format))
                .push_bind(picture.backend.name())
                .push_bind(picture.renderer_version);
        });
        query.push(" ON CONFLICT (key) DO NOTHING");
        query.build().execute(&mut *conn).await?;
    }
    Ok(())
}

fn read(row: &SqliteRow) -> Result<StoredPicture, StorageError> {
    Ok(StoredPicture {
        key: PictureKey(row.hash("key")?),
        genome_hash: GenomeHash::from_bytes(row.hash("genome_hash")?),
        scene: row.id("scene_id")?,
        light_deg: row.real("light_deg")?,
        size_px: row.whole("size_px")?,
        sampling: match row.flag("adaptive")? {
            true => Sampling::Adaptive,
            false => {
                Sampling::fixed(row.whole("samples")?).map_err(|_| corrupt_column("samples"))?
            }
        },
        area: match row.text("area")?.as_str() {
            "" => None,
            text => Some(text.parse().map_err(|_| corrupt_column("area"))?),
        },
        format: match row.text("format")?.as_str() {
            "png" => PictureFormat::Png,
            "exr" => PictureFormat::Exr,
            _ => return Err(corrupt_column("format")),
        },
        backend: row.text("backend")?.parse().map_err(|_| corrupt_column("backend"))?,
        renderer_version: row.whole("renderer_version")?,
    })
}

fn format_name(format: PictureFormat) -> &'static str {
    match format {
        PictureFormat::Png => "png",
        PictureFormat::Exr => "exr",
    }
}
