//! What picture keys stand for. Owns the table `picture`; refuses to know pixels, which are derived and kept elsewhere.

use brood_genome::GenomeHash;
use brood_protocol::{Backend, PictureFormat, PictureKey, PixelArea, Sampling, SceneId};
use sqlx::sqlite::SqliteRow;
use sqlx::{QueryBuilder, Sqlite, SqliteConnection};

use crate::genome::CHUNK_ROWS;
use crate::row::{Columns, Key, damaged, set};
use crate::{StorageError, Store};

/// All that is needed to render a picture, under its key.
#[derive(Debug, Clone, PartialEq)]
pub struct PictureRow {
    /// The key.
    pub key: PictureKey,
    /// A genome whose program it shows.
    pub genome_hash: GenomeHash,
    /// The scene.
    pub scene: SceneId,
    /// Position of the light on the scene's light circle, in degrees.
    pub light_deg: f64,
    /// Side in pixels.
    pub size_px: u32,
    /// Samples per pixel.
    pub sampling: Sampling,
    /// The part that it shows; all of it if absent.
    pub area: Option<PixelArea>,
    /// The file.
    pub format: PictureFormat,
    /// The evaluator.
    pub backend: Backend,
    /// The renderer that the key was made for.
    pub renderer_version: u32,
}

/// A picture key to be stored: the same facts as are read back.
pub type NewPicture = PictureRow;

impl Store {
    /// Stores keys; those that are there already stay as they are. Writes nothing where all are.
    pub async fn put_pictures(&self, mut pictures: Vec<NewPicture>) -> Result<(), StorageError> {
        let known = set(pictures.iter().map(|picture| picture.key.0.as_slice()));
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

    /// What a key stands for.
    pub async fn picture(&self, key: PictureKey) -> Result<PictureRow, StorageError> {
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

/// Stores keys; those that are there already stay as they are.
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
                .push_bind(picture.sampling.least())
                .push_bind(picture.sampling == Sampling::Adaptive)
                .push_bind(picture.area.map_or_else(String::new, |area| area.to_string()))
                .push_bind(format_word(picture.format))
                .push_bind(picture.backend.name())
                .push_bind(picture.renderer_version);
        });
        query.push(" ON CONFLICT (key) DO NOTHING");
        query.build().execute(&mut *conn).await?;
    }
    Ok(())
}

fn read(row: &SqliteRow) -> Result<PictureRow, StorageError> {
    Ok(PictureRow {
        key: PictureKey(row.hash("key")?),
        genome_hash: GenomeHash::from_bytes(row.hash("genome_hash")?),
        scene: row.id("scene_id")?,
        light_deg: row.real("light_deg")?,
        size_px: row.whole("size_px")?,
        sampling: match row.flag("adaptive")? {
            true => Sampling::Adaptive,
            false => Sampling::fixed(row.whole("samples")?).map_err(|_| damaged("samples"))?,
        },
        area: match row.text("area")?.as_str() {
            "" => None,
            text => Some(text.parse().map_err(|_| damaged("area"))?),
        },
        format: match row.text("format")?.as_str() {
            "png" => PictureFormat::Png,
            "exr" => PictureFormat::Exr,
            _ => return Err(damaged("format")),
        },
        backend: row.text("backend")?.parse().map_err(|_| damaged("backend"))?,
        renderer_version: row.whole("renderer_version")?,
    })
}

fn format_word(format: PictureFormat) -> &'static str {
    match format {
        PictureFormat::Png => "png",
        PictureFormat::Exr => "exr",
    }
}
