//! Answers remembered under the caller's key, so that a retry gets the same answer and has no second effect. Owns the
//! table `idempotency`; refuses to know what an answer means.

use sqlx::SqliteConnection;

use crate::error::taken;
use crate::row::Columns;
use crate::{StorageError, Store};

/// An answer to be remembered with the write that it answers for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Idempotency {
    /// The caller's key.
    pub key: String,
    /// The route, with its ids: keys of different routes do not meet.
    pub route: String,
    /// Hash of the request's body.
    pub body_hash: [u8; 32],
    /// Status of the answer.
    pub status: u16,
    /// The answer, in whatever form the caller reads: what is only known once the write is done (the index of a
    /// generation) is looked up again by an id that stands here.
    pub answer: Vec<u8>,
}

/// What is remembered of a request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Remembered {
    /// Nothing.
    Fresh,
    /// It was answered so.
    Replay {
        /// Status of the answer.
        status: u16,
        /// The answer, as it was handed over.
        body: Vec<u8>,
    },
    /// The key was used with another body.
    OtherBody,
}

impl Store {
    /// Looks a request up.
    pub async fn lookup_idempotent(
        &self,
        key: &str,
        route: &str,
        body_hash: [u8; 32],
    ) -> Result<Remembered, StorageError> {
        let row = sqlx::query(
            "SELECT body_hash, status, answer FROM idempotency WHERE key = ? AND route = ?",
        )
        .bind(key)
        .bind(route)
        .fetch_optional(&mut *self.reader().await?)
        .await?;
        let Some(row) = row else { return Ok(Remembered::Fresh) };
        if row.hash("body_hash")? != body_hash {
            return Ok(Remembered::OtherBody);
        }
        Ok(Remembered::Replay { status: row.whole("status")?, body: row.blob("answer")? })
    }

    /// Remembers the answer of a write that has the same effect however often it is done.
    pub async fn remember_answer(
        &self,
        answer: Idempotency,
        created_ms: i64,
    ) -> Result<(), StorageError> {
        self.write(move |conn| Box::pin(async move { insert(conn, &answer, created_ms).await }))
            .await
    }

    /// Forgets answers given before a moment; returns how many.
    pub async fn prune_idempotency(&self, before_ms: i64) -> Result<u64, StorageError> {
        self.write(move |conn| {
            Box::pin(async move {
                let query = sqlx::query("DELETE FROM idempotency WHERE created_ms < ?");
                Ok(query.bind(before_ms).execute(conn).await?.rows_affected())
            })
        })
        .await
    }
}

/// Remembers an answer; a key that is taken ends the transaction that the answer is for.
pub(crate) async fn insert(
    conn: &mut SqliteConnection,
    answer: &Idempotency,
    created_ms: i64,
) -> Result<(), StorageError> {
    sqlx::query(
        "INSERT INTO idempotency (key, route, body_hash, status, created_ms, answer)
         VALUES (?, ?, ?, ?, ?, ?)",
    )
    .bind(answer.key.as_str())
    .bind(answer.route.as_str())
    .bind(answer.body_hash.as_slice())
    .bind(answer.status)
    .bind(created_ms)
    .bind(answer.answer.as_slice())
    .execute(conn)
    .await
    .map_err(taken("the idempotency key"))?;
    Ok(())
}
