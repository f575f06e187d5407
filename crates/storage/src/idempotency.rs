//! Idempotency records: responses stored under the client's key, so that a retry gets the same
//! response and has no second effect. Owner of the table `idempotency`. Independent of the content
//! of responses.

use crate::Store;
use crate::error::{Result, unique_conflict};
use crate::sql::{Conn, query};
use crate::write::operation;

/// Idempotency record, stored in the transaction of the write that it answers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Idempotency {
    /// Key chosen by the client.
    pub key: String,
    /// Route with its ids. Keys of different routes are independent.
    pub route: String,
    /// Hash of the request body.
    pub body_hash: [u8; 32],
    /// Status code of the response.
    pub status: u16,
    /// Response, in the caller's format. Values that are known only after the write (such as a
    /// generation's index) are looked up again by an id in it.
    pub answer: Vec<u8>,
}

/// Result of looking up a request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum IdempotencyLookup {
    /// There is no record: the request is new.
    Fresh,
    /// There is a record with the same body.
    Replay {
        /// Status code of the response.
        status: u16,
        /// Response, in the caller's format.
        body: Vec<u8>,
    },
    /// The key was used with another body.
    OtherBody,
}

impl Store {
    /// Looks up a request.
    ///
    /// # Errors
    /// Returns a `StorageError` if the read fails.
    pub async fn lookup_idempotent(
        &self,
        key: &str,
        route: &str,
        body_hash: [u8; 32],
    ) -> Result<IdempotencyLookup> {
        let row =
            query("SELECT body_hash, status, answer FROM idempotency WHERE key = ? AND route = ?")
                .bind(key)
                .bind(route)
                .fetch_optional(&mut self.reader().await?)
                .await?;
        let Some(row) = row else { return Ok(IdempotencyLookup::Fresh) };
        if row.column::<[u8; 32]>("body_hash")? != body_hash {
            return Ok(IdempotencyLookup::OtherBody);
        }
        Ok(IdempotencyLookup::Replay { status: row.column("status")?, body: row.column("answer")? })
    }

    /// Stores a record on its own, for a write that is idempotent itself.
    ///
    /// # Errors
    /// Returns `StorageError::Conflict` if the key is in use.
    pub async fn store_idempotency(&self, answer: Idempotency, created_ms: i64) -> Result<()> {
        self.write(operation!(|conn| insert(conn, Some(&answer), created_ms).await)).await
    }

    /// Deletes the records created before `before_ms`. Returns their number.
    ///
    /// # Errors
    /// Returns a `StorageError` if the write fails.
    pub async fn prune_idempotency(&self, before_ms: i64) -> Result<u64> {
        self.write(operation!(|conn| {
            let query = query("DELETE FROM idempotency WHERE created_ms < ?");
            query.bind(before_ms).execute(conn).await
        }))
        .await
    }
}

/// Inserts a record if there is one. If the key is in use, this fails the transaction that it
/// belongs to.
pub(crate) async fn insert(
    conn: &mut Conn,
    answer: Option<&Idempotency>,
    created_ms: i64,
) -> Result<()> {
    let Some(answer) = answer else { return Ok(()) };
    query(
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
    .map_err(unique_conflict("the idempotency key is already in use"))?;
    Ok(())
}
