//! Removing a lineage for good. Owns what may go with it (genomes and picture keys that nobody else refers to) and what
//! must not (hashes of parents in other lineages, genomes that were saved by hand, twins' pictures).

use brood_protocol::LineageId;
use sqlx::SqliteConnection;

use crate::row::Key;
use crate::{StorageError, Store};

/// Genomes that may be left without anyone who refers to them. Temporary: gone with the connection.
const REMEMBER: &str =
    "CREATE TEMP TABLE IF NOT EXISTS doomed (hash BLOB NOT NULL PRIMARY KEY) STRICT";
const FORGET: &str = "DELETE FROM temp.doomed";
const CANDIDATES: &str = "INSERT INTO temp.doomed
    SELECT genome_hash FROM individual WHERE lineage_id = ?1
    UNION
    SELECT genome_hash FROM generation_parent
        WHERE generation_id IN (SELECT id FROM generation WHERE lineage_id = ?1)";
/// Individuals and generations, and with those their parents' places, go by cascade.
const REMOVE: &str = "DELETE FROM lineage WHERE id = ?";
const SPARE: &str = "DELETE FROM temp.doomed WHERE
    hash IN (SELECT hash FROM genome WHERE kept = 1)
    OR EXISTS (SELECT 1 FROM individual WHERE genome_hash = doomed.hash)
    OR EXISTS (SELECT 1 FROM generation_parent WHERE genome_hash = doomed.hash)";
/// A picture belongs to a program: a surviving genome with the same program takes it over.
const HAND_OVER: &str = "UPDATE picture SET genome_hash = coalesce(
        (SELECT twin.hash FROM genome AS twin
         WHERE twin.program_hash =
                 (SELECT program_hash FROM genome WHERE hash = picture.genome_hash)
             AND twin.hash NOT IN (SELECT hash FROM temp.doomed)
         LIMIT 1),
        genome_hash)
    WHERE genome_hash IN (SELECT hash FROM temp.doomed)";
const REMOVE_GENOMES: &str = "DELETE FROM genome WHERE hash IN (SELECT hash FROM temp.doomed)";

impl Store {
    /// Removes a lineage with its generations, individuals, and the genomes and picture keys that nothing else needs.
    /// Children of its individuals in other lineages keep their parent's hash.
    pub async fn purge_lineage(&self, id: LineageId) -> Result<(), StorageError> {
        self.write(move |conn| Box::pin(async move { purge(conn, id).await })).await
    }
}

async fn purge(conn: &mut SqliteConnection, id: LineageId) -> Result<(), StorageError> {
    for sql in [REMEMBER, FORGET] {
        sqlx::query(sql).execute(&mut *conn).await?;
    }
    sqlx::query(CANDIDATES).bind(id.key()).execute(&mut *conn).await?;
    if sqlx::query(REMOVE).bind(id.key()).execute(&mut *conn).await?.rows_affected() == 0 {
        return Err(StorageError::NotFound);
    }
    for sql in [SPARE, HAND_OVER, REMOVE_GENOMES, FORGET] {
        sqlx::query(sql).execute(&mut *conn).await?;
    }
    Ok(())
}
