//! Lineages: create, list, change, hide. Owner of the table `lineage`. See `purge` for permanent
//! removal.

use std::fmt;
use std::str::FromStr;

use brood_protocol::{Lineage, LineageId, PatchLineage};
use sqlx::SqliteConnection;

use crate::error::{Result, changed};
use crate::idempotency::{self, Idempotency};
use crate::row::{Key, Record, optional_key, record, select, signed};
use crate::writer::operation;
use crate::{StorageError, Store};

/// Position in the list of lineages: after the lineage it names, even if that has been removed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LineageCursor {
    /// Creation time of the lineage, in milliseconds since 1970-01-01 UTC.
    pub created_ms: i64,
    /// Id of the lineage.
    pub id: LineageId,
}

/// Error of parsing a [`LineageCursor`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the cursor must be the `next` of an earlier page")]
pub struct InvalidCursor;

impl LineageCursor {
    /// Returns the position of a lineage.
    #[must_use]
    pub fn of(lineage: &Lineage) -> Self {
        Self { created_ms: lineage.created_ms, id: lineage.id }
    }
}

impl fmt::Display for LineageCursor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.created_ms, self.id)
    }
}

impl FromStr for LineageCursor {
    type Err = InvalidCursor;

    fn from_str(text: &str) -> Result<Self, InvalidCursor> {
        let (created_ms, id) = text.split_once('.').ok_or(InvalidCursor)?;
        let created_ms = created_ms.parse().map_err(|_| InvalidCursor)?;
        Ok(Self { created_ms, id: id.parse().map_err(|_| InvalidCursor)? })
    }
}

record!(Lineage {
    id,
    name,
    notes,
    scene = "scene_id",
    thumbnail_px,
    start,
    dialect = "dialect_json",
    saturation,
    energy_limit,
    generations = "(SELECT count(*) FROM generation WHERE lineage_id = lineage.id)",
    created_ms,
    version,
});

impl Store {
    /// Stores a new lineage and returns it as stored. Its `generations` and `version` are not read.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if the scene does not exist, [`StorageError::Conflict`]
    /// if the id or the idempotency key is in use.
    pub async fn create_lineage(
        &self,
        new: Lineage,
        idempotency: Option<Idempotency>,
    ) -> Result<Lineage> {
        self.write(operation!(|conn| {
            idempotency::insert(conn, idempotency.as_ref(), new.created_ms).await?;
            insert(conn, &new).await?;
            fetch(conn, new.id).await
        }))
        .await
    }

    /// Lists lineages, the newest first, after the cursor.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn list_lineages(
        &self,
        cursor: Option<LineageCursor>,
        limit: u32,
        include_hidden: bool,
    ) -> Result<Vec<Lineage>> {
        // Two statements, so that SQLite starts at the cursor in the index.
        let after = if cursor.is_some() { "AND (created_ms, id) < (?3, ?4)" } else { "" };
        let mut query = select::<Lineage>(&format!(
            "FROM lineage WHERE (hidden = 0 OR ?1) {after}
             ORDER BY created_ms DESC, id DESC LIMIT ?2"
        ));
        query = query.bind(include_hidden).bind(limit);
        if let Some(LineageCursor { created_ms, id }) = cursor {
            query = query.bind(created_ms).bind(id.key().to_vec());
        }
        query.fetch_all(&mut *self.reader().await?).await?.iter().map(Lineage::read).collect()
    }

    /// Returns a lineage, hidden or not.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if it does not exist.
    pub async fn lineage(&self, id: LineageId) -> Result<Lineage> {
        fetch(&mut *self.reader().await?, id).await
    }

    /// Changes a lineage.
    ///
    /// # Errors
    /// Returns [`StorageError::StaleVersion`] if its version is not `expected_version`,
    /// [`StorageError::NotFound`] if it or the new scene does not exist.
    pub async fn patch_lineage(
        &self,
        id: LineageId,
        expected_version: u64,
        patch: PatchLineage,
    ) -> Result<Lineage> {
        self.write(operation!(|conn| {
            let done = sqlx::query(
                "UPDATE lineage SET name = coalesce(?, name), notes = coalesce(?, notes),
                     scene_id = coalesce(?, scene_id), saturation = coalesce(?, saturation),
                     energy_limit = coalesce(?, energy_limit),
                     version = version + 1
                 WHERE id = ? AND version = ?",
            )
            .bind(patch.name)
            .bind(patch.notes)
            .bind(optional_key(patch.scene))
            .bind(patch.saturation)
            .bind(patch.energy_limit)
            .bind(id.key())
            .bind(signed(expected_version))
            .execute(&mut *conn)
            .await?;
            let lineage = fetch(conn, id).await?;
            changed(&done, StorageError::StaleVersion { current: lineage.version })?;
            Ok(lineage)
        }))
        .await
    }

    /// Hides a lineage from lists. It is kept, and links to it still work.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if it does not exist.
    pub async fn hide_lineage(&self, id: LineageId) -> Result<()> {
        self.write(operation!(|conn| {
            let query = sqlx::query("UPDATE lineage SET hidden = 1 WHERE id = ?");
            changed(&query.bind(id.key()).execute(conn).await?, StorageError::NotFound)
        }))
        .await
    }
}

/// Inserts a lineage.
pub(crate) async fn insert(conn: &mut SqliteConnection, new: &Lineage) -> Result<()> {
    let dialect = serde_json::to_string(&new.dialect).expect("a dialect is plain data");
    sqlx::query(
        "INSERT INTO lineage
             (id, name, notes, scene_id, thumbnail_px, start, dialect_json, saturation,
              energy_limit, created_ms)
         VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
    )
    .bind(new.id.key())
    .bind(new.name.as_str())
    .bind(new.notes.as_str())
    .bind(new.scene.key())
    .bind(new.thumbnail_px)
    .bind(new.start.name())
    .bind(dialect)
    .bind(new.saturation)
    .bind(new.energy_limit)
    .bind(new.created_ms)
    .execute(conn)
    .await?;
    Ok(())
}

/// Reads a lineage.
pub(crate) async fn fetch(conn: &mut SqliteConnection, id: LineageId) -> Result<Lineage> {
    let query = select::<Lineage>("FROM lineage WHERE id = ?").bind(id.key());
    Lineage::read(&query.fetch_one(conn).await?)
}
