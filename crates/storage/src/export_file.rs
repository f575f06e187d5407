//! Bytes of exports' files in PostgreSQL, whose servers share no folder. Owner of the table
//! `export_blob`, which SQLite does not have: there, files are in the data directory.
//!
//! Files are stored in parts. A statement with a whole file of 128 MB could need more than the 3 s
//! after which PostgreSQL ends an idle transaction; it is idle until it has received a statement.

use std::collections::HashMap;

use brood_protocol::JobId;

use crate::column::Key;
use crate::error::Result;
use crate::sql::{Conn, query};
use crate::write::operation;
use crate::{StorageError, Store};

/// Most bytes of a part.
pub(crate) const PART_BYTES: usize = 4 << 20;

/// Removes a part of a file that is not recorded: its export was cancelled, has failed or is
/// deleted. No lease of such an export is valid, so its files are not recorded again.
const REMOVE_UNUSED: &str = "DELETE FROM export_blob WHERE (export_id, number, part) = (
    SELECT stored.export_id, stored.number, stored.part FROM export_blob AS stored
    WHERE NOT EXISTS (
        SELECT 1 FROM export_file AS file
        WHERE file.export_id = stored.export_id AND file.number = stored.number
            AND file.bytes IS NOT NULL)
    ORDER BY stored.export_id, stored.number, stored.part LIMIT 1
    /*pg: FOR UPDATE OF stored SKIP LOCKED*/)";

impl Store {
    /// Returns the sizes in bytes of an export's files in PostgreSQL, by number. Empty files are
    /// left out.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn export_file_sizes(&self, id: JobId) -> Result<HashMap<u32, u64>> {
        let sql = "SELECT number, CAST(sum(octet_length(bytes)) AS BIGINT) AS size
            FROM export_blob WHERE export_id = ? GROUP BY number";
        let rows = query(sql).bind(id.key()).fetch_all(&mut self.reader().await?).await?;
        let mut sizes = HashMap::with_capacity(rows.len());
        for row in &rows {
            sizes.insert(row.column("number")?, row.column("size")?);
        }
        Ok(sizes)
    }

    /// Returns a file of an export in PostgreSQL.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if there is no such file of this size.
    pub async fn read_export_file(&self, (id, number): (JobId, u32), size: u64) -> Result<Vec<u8>> {
        let mut conn = self.snapshot().await?;
        let mut file = Vec::new();
        for part in 0_u32.. {
            let sql = "SELECT bytes FROM export_blob
                WHERE export_id = ? AND number = ? AND part = ?";
            let part = query(sql).bind(id.key()).bind(number).bind(part);
            let Some(row) = part.fetch_optional(&mut conn).await? else { break };
            file.extend(row.column::<Vec<u8>>("bytes")?);
        }
        if file.len() as u64 == size { Ok(file) } else { Err(StorageError::NotFound) }
    }

    /// Removes the files in PostgreSQL that are not recorded. Each part is a write of its own:
    /// gigabytes in one statement can take longer than its limit of 30 s.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if a write fails.
    pub async fn remove_unused_export_files(&self) -> Result<()> {
        loop {
            let removed = self
                .write_relaxed(operation!(|conn| query(REMOVE_UNUSED).execute(conn).await))
                .await?;
            if removed == 0 {
                return Ok(());
            }
        }
    }
}

/// Stores a file in PostgreSQL, in place of an earlier one.
pub(crate) async fn put(conn: &mut Conn, (id, number): (JobId, u32), file: &[u8]) -> Result<()> {
    remove(conn, (id, number)).await?;
    for (part, bytes) in (0_u32..).zip(file.chunks(PART_BYTES)) {
        let sql = "INSERT INTO export_blob (export_id, number, part, bytes) VALUES (?, ?, ?, ?)";
        let insert = query(sql).bind(id.key()).bind(number).bind(part).bind(bytes);
        insert.execute(conn).await?;
    }
    Ok(())
}

/// Removes a file from PostgreSQL.
pub(crate) async fn remove(conn: &mut Conn, (id, number): (JobId, u32)) -> Result<()> {
    if let Conn::Sqlite(_) = conn {
        return Ok(());
    }
    let sql = "DELETE FROM export_blob WHERE export_id = ? AND number = ?";
    query(sql).bind(id.key()).bind(number).execute(conn).await?;
    Ok(())
}
