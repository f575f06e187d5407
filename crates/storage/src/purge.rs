//! Permanent removal of a lineage. It also removes genomes and picture keys without other
//! references. It keeps hashes of parents in other lineages, genomes saved by hand, and pictures of
//! programs that a remaining genome shares.

use brood_protocol::LineageId;
use sqlx::SqliteConnection;

use crate::error::{Result, changed};
use crate::row::Key;
use crate::writer::operation;
use crate::{StorageError, Store};

/// Temporary table of genomes that may lose their last reference. It is dropped with the
/// connection.
const CREATE_CANDIDATES: &str =
    "CREATE TEMP TABLE IF NOT EXISTS purge_candidate (hash BLOB NOT NULL PRIMARY KEY) STRICT";
const CLEAR_CANDIDATES: &str = "DELETE FROM temp.purge_candidate";
const FILL_CANDIDATES: &str = "INSERT INTO temp.purge_candidate
    SELECT genome_hash FROM individual WHERE lineage_id = ?1
    UNION
    SELECT genome_hash FROM generation_parent
        WHERE generation_id IN (SELECT id FROM generation WHERE lineage_id = ?1)";
/// Individuals, generations and their parent rows are deleted by cascade.
const REMOVE_LINEAGE: &str = "DELETE FROM lineage WHERE id = ?";
const KEEP_REFERENCED: &str = "DELETE FROM temp.purge_candidate WHERE
    hash IN (SELECT hash FROM genome WHERE kept = 1)
    OR EXISTS (SELECT 1 FROM individual WHERE genome_hash = purge_candidate.hash)
    OR EXISTS (SELECT 1 FROM generation_parent WHERE genome_hash = purge_candidate.hash)";
/// A picture belongs to a program: assign it to a remaining genome with the same program.
const REASSIGN_PICTURES: &str = "UPDATE picture SET genome_hash = coalesce(
        (SELECT twin.hash FROM genome AS twin
         WHERE twin.program_hash =
                 (SELECT program_hash FROM genome WHERE hash = picture.genome_hash)
             AND twin.hash NOT IN (SELECT hash FROM temp.purge_candidate)
         LIMIT 1),
        genome_hash)
    WHERE genome_hash IN (SELECT hash FROM temp.purge_candidate)";
const REMOVE_GENOMES: &str =
    "DELETE FROM genome WHERE hash IN (SELECT hash FROM temp.purge_candidate)";

impl Store {
    /// Removes a lineage with its generations and individuals, and the genomes and picture keys
    /// without other references. Children of its individuals in other lineages keep the parent's
    /// hash.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if the lineage does not exist.
    pub async fn purge_lineage(&self, id: LineageId) -> Result<()> {
        self.write(operation!(|conn| purge(conn, id).await)).await
    }
}

async fn purge(conn: &mut SqliteConnection, id: LineageId) -> Result<()> {
    for sql in [CREATE_CANDIDATES, CLEAR_CANDIDATES] {
        sqlx::query(sql).execute(&mut *conn).await?;
    }
    sqlx::query(FILL_CANDIDATES).bind(id.key()).execute(&mut *conn).await?;
    let done = sqlx::query(REMOVE_LINEAGE).bind(id.key()).execute(&mut *conn).await?;
    changed(&done, StorageError::NotFound)?;
    for sql in [KEEP_REFERENCED, REASSIGN_PICTURES, REMOVE_GENOMES, CLEAR_CANDIDATES] {
        sqlx::query(sql).execute(&mut *conn).await?;
    }
    Ok(())
}
