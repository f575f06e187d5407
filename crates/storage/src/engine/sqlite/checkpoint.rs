//! The write-ahead log: copying it into the database, and closing the connection that writes it.

use crate::StorageError;
use crate::error::Result;
use crate::sql::{Conn, query};

/// Closes the connection. The owner of the data directory also writes the log back.
pub(crate) async fn close_connection(mut conn: Conn, owner: bool) -> Result<()> {
    if owner {
        match truncate_log(&mut conn).await {
            Ok(true) => {}
            Ok(false) => tracing::warn!("the log was not truncated because of an active reader"),
            Err(error) => {
                // Closing would try to write the log again: see `poison`.
                std::mem::forget(conn);
                if matches!(error, StorageError::Full) {
                    // Nothing is lost: the next start reads the log.
                    tracing::warn!("the disk is full, so the log was not written back");
                    return Ok(());
                }
                return Err(error);
            }
        }
    }
    conn.close().await
}

/// Writes the log back and truncates it. Returns true if no reader blocked the checkpoint.
async fn truncate_log(conn: &mut Conn) -> Result<bool> {
    let checkpoint = query("PRAGMA wal_checkpoint(TRUNCATE)");
    Ok(checkpoint.fetch_value::<i64>(conn).await? == 0)
}

/// Runs a checkpoint pragma. Returns the number of pages in the log.
pub(crate) async fn run_checkpoint(conn: &mut Conn, sql: &'static str) -> Result<i64> {
    query(sql).fetch_one(conn).await?.column(1)
}
