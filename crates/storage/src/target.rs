//! What searches are to match. Owns the tables `target` and `target_file`; refuses to know what is in a file.

use brood_protocol::{Target, TargetId};
use sqlx::sqlite::SqliteRow;

use crate::row::{Columns, Key, damaged};
use crate::{Idempotency, StorageError, Store, idempotency};

/// A target to be stored.
#[derive(Debug, Clone, PartialEq)]
pub struct NewTarget {
    /// As it is answered.
    pub target: Target,
    /// Hash of its file.
    pub hash: [u8; 32],
    /// Its file; the same bytes are stored once.
    pub bytes: Vec<u8>,
    /// The answer to be remembered.
    pub idempotency: Option<Idempotency>,
}

const BUSY: StorageError = StorageError::Conflict { what: "the target, which a job still uses," };

impl Store {
    /// Stores a target.
    pub async fn create_target(&self, new: NewTarget) -> Result<(), StorageError> {
        self.write(move |conn| {
            Box::pin(async move {
                let NewTarget { target, hash, bytes, idempotency } = new;
                if let Some(answer) = &idempotency {
                    idempotency::insert(conn, answer, target.created_ms).await?;
                }
                sqlx::query(
                    "INSERT INTO target_file (hash, bytes) VALUES (?, ?) ON CONFLICT DO NOTHING",
                )
                .bind(hash.as_slice())
                .bind(bytes)
                .execute(&mut *conn)
                .await?;
                let json = serde_json::to_string(&target).expect("answers are plain data");
                sqlx::query(
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
                Ok(())
            })
        })
        .await
    }

    /// One target.
    pub async fn target(&self, id: TargetId) -> Result<Target, StorageError> {
        let query = sqlx::query("SELECT json FROM target WHERE id = ?").bind(id.key());
        read(&query.fetch_one(&mut *self.reader().await?).await?)
    }

    /// Targets, newest first, before one of them.
    pub async fn list_targets(
        &self,
        before: Option<TargetId>,
        limit: u32,
    ) -> Result<Vec<Target>, StorageError> {
        let sql = "SELECT json FROM target WHERE ?1 IS NULL OR id < ?1 ORDER BY id DESC LIMIT ?2";
        let query = sqlx::query(sql).bind(before.as_ref().map(|id| id.key().to_vec())).bind(limit);
        query.fetch_all(&mut *self.reader().await?).await?.iter().map(read).collect()
    }

    /// A target's file by its hash.
    pub async fn target_file(&self, hash: [u8; 32]) -> Result<Vec<u8>, StorageError> {
        let query = sqlx::query("SELECT bytes FROM target_file WHERE hash = ?");
        let row = query.bind(hash.as_slice()).fetch_one(&mut *self.reader().await?).await?;
        row.blob("bytes")
    }

    /// Removes a target, and its file where no other has it. One that a search is still to match stays:
    /// [`StorageError::Conflict`].
    pub async fn delete_target(&self, id: TargetId) -> Result<(), StorageError> {
        self.write(move |conn| {
            Box::pin(async move {
                let used: i64 = sqlx::query_scalar(
                    "SELECT count(*) FROM search
                     WHERE target_id = ? AND state IN ('queued', 'running', 'paused')",
                )
                .bind(id.key())
                .fetch_one(&mut *conn)
                .await?;
                if used > 0 {
                    return Err(BUSY);
                }
                let sql = "DELETE FROM target WHERE id = ? RETURNING file_hash";
                let row = sqlx::query(sql).bind(id.key()).fetch_one(&mut *conn).await?;
                sqlx::query(
                    "DELETE FROM target_file WHERE hash = ?1
                     AND NOT EXISTS (SELECT 1 FROM target WHERE file_hash = ?1)",
                )
                .bind(row.blob("file_hash")?)
                .execute(conn)
                .await?;
                Ok(())
            })
        })
        .await
    }
}

fn read(row: &SqliteRow) -> Result<Target, StorageError> {
    serde_json::from_str(&row.text("json")?).map_err(|_| damaged("json"))
}
