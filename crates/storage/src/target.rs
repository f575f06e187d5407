//! Search targets. Owner of the tables `target` and `target_file`. Independent of the content of
//! files.

use brood_protocol::{CorrectedScene, Target, TargetId};

use crate::blob_store::BlobKind;
use crate::column::{Key, optional_key};
use crate::error::Result;
use crate::sql::query;
use crate::write::operation;
use crate::{Idempotency, StorageError, Store, idempotency};

/// Target to be stored.
#[derive(Debug, Clone, PartialEq)]
pub struct NewTarget {
    /// The target, as the API returns it.
    pub target: Target,
    /// Content hash of the file.
    pub hash: [u8; 32],
    /// Contents of the file. Equal files are stored once.
    pub bytes: Vec<u8>,
    /// Idempotency record to be stored with it.
    pub idempotency: Option<Idempotency>,
}

const IN_USE: StorageError =
    StorageError::Conflict { what: "an unfinished search uses the target" };

impl Store {
    /// Stores a target.
    ///
    /// # Errors
    /// Returns [`StorageError::Conflict`] if the id or the idempotency key is in use.
    pub async fn create_target(&self, new: NewTarget) -> Result<()> {
        let NewTarget { target, hash, bytes, idempotency } = new;
        let file = self.place_file(BlobKind::Target, bytes).await?;
        let object = file.object.clone();
        let is_new = self.write(operation!(|conn| {
            file.admit(conn).await?;
            idempotency::insert(conn, idempotency.as_ref(), target.created_ms).await?;
            let insert = "INSERT INTO target_file (hash, bytes, object) VALUES (?, ?, ?)
                 ON CONFLICT (hash) DO UPDATE SET bytes = excluded.bytes, object = excluded.object
                     WHERE target_file.object IS NOT NULL";
            let insert = query(insert).bind(hash.as_slice()).bind(file.bytes).bind(file.object);
            let inserted = insert.execute(conn).await?;
            let json = serde_json::to_string(&target).expect("a target is plain data");
            query(
                "INSERT INTO target (id, kind, file_hash, created_ms, json)
                 VALUES (?, ?, ?, ?, ?)",
            )
            .bind(target.id.key())
            .bind(target.kind)
            .bind(hash.as_slice())
            .bind(target.created_ms)
            .bind(json)
            .execute(conn)
            .await?;
            Ok(inserted > 0)
        }));
        if !is_new.await? {
            self.discard_object(object);
        }
        Ok(())
    }

    /// Returns a target.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if it does not exist.
    pub async fn target(&self, id: TargetId) -> Result<Target> {
        let query = query("SELECT json FROM target WHERE id = ?").bind(id.key());
        query.fetch_one(&mut self.reader().await?).await?.column("json")
    }

    /// Sets the corrected scenes of a target's images. Does nothing if the target was deleted.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the write fails.
    ///
    /// # Panics
    /// If there are not as many scenes as images.
    pub async fn correct_target(
        &self,
        id: TargetId,
        corrected: Vec<Option<CorrectedScene>>,
    ) -> Result<()> {
        self.write(operation!(|conn| {
            let read = query("SELECT json FROM target WHERE id = ?").bind(id.key());
            let Some(row) = read.fetch_optional(conn).await? else { return Ok(()) };
            let mut target: Target = row.column("json")?;
            assert_eq!(target.views.len(), corrected.len(), "every image has a scene");
            for (view, corrected) in target.views.iter_mut().zip(corrected) {
                view.corrected = corrected;
            }
            let json = serde_json::to_string(&target).expect("a target is plain data");
            let update = query("UPDATE target SET json = ? WHERE id = ?").bind(json);
            update.bind(id.key()).execute(conn).await?;
            Ok(())
        }))
        .await
    }

    /// Lists targets, the newest first, those before `before`.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn list_targets(&self, before: Option<TargetId>, limit: u32) -> Result<Vec<Target>> {
        let sql = "SELECT json FROM target WHERE ?1 IS NULL OR id < ?1 ORDER BY id DESC LIMIT ?2";
        let query = query(sql).bind(optional_key(before)).bind(limit);
        let rows = query.fetch_all(&mut self.reader().await?).await?;
        rows.iter().map(|row| row.column("json")).collect()
    }

    /// Returns a target's file by its content hash.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if it does not exist.
    pub async fn target_file(&self, hash: [u8; 32]) -> Result<Vec<u8>> {
        let sql = "SELECT bytes AS file, object FROM target_file WHERE hash = ?";
        let read = self.read_file(|| query(sql).bind(hash.as_slice()));
        Ok(read.await?.1)
    }

    /// Deletes a target, and its file unless another target has the same. The sweep removes the
    /// object.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if it does not exist, [`StorageError::Conflict`] if an
    /// unfinished search uses it.
    pub async fn delete_target(&self, id: TargetId) -> Result<()> {
        self.write(operation!(|conn| {
            // No search with it is made meanwhile.
            let lock = query("SELECT id FROM target WHERE id = ? /*pg: FOR UPDATE*/");
            lock.bind(id.key()).fetch_one(conn).await?;
            let used: i64 = query(
                "SELECT count(*) FROM search
                 WHERE target_id = ? AND state IN ('queued', 'running', 'paused')",
            )
            .bind(id.key())
            .fetch_value(conn)
            .await?;
            if used > 0 {
                return Err(IN_USE);
            }
            let sql = "DELETE FROM target WHERE id = ? RETURNING file_hash";
            let row = query(sql).bind(id.key()).fetch_one(conn).await?;
            query(
                "DELETE FROM target_file WHERE hash = ?1
                 AND NOT EXISTS (SELECT 1 FROM target WHERE file_hash = ?1)",
            )
            .bind(row.column::<Vec<u8>>("file_hash")?)
            .execute(conn)
            .await?;
            Ok(())
        }))
        .await
    }
}
