//! Permanent removal of a lineage. It also removes genomes and picture keys without other
//! references. It keeps hashes of parents in other lineages, genomes saved by hand, and pictures of
//! programs that a remaining genome shares.
//!
//! Removes the youngest generations first, in slices. The lineage is unfinished from the first one:
//! lists leave it out. If the process ends between two slices, the next start or another server
//! removes the rest.

use std::time::{Duration, Instant};

use brood_genome::GenomeHash;
use brood_protocol::LineageId;

use crate::column::Key;
use crate::error::{Result, changed};
use crate::lineage::{self, Unfinished};
use crate::slice::Pace;
use crate::sql::{Conn, GenomeUse, query};
use crate::write::{Durability, operation};
use crate::{StorageError, Store, genome};

/// Number of generations in the first transaction, and the most.
const GENERATIONS: u32 = 4;
const GENERATIONS_MAX: u32 = 1024;

/// Temporary tables of generations that are removed, and of genomes that may lose their last
/// reference. They are dropped with the connection.
const CREATE: [&str; 2] = [
    "CREATE TEMP TABLE IF NOT EXISTS purged_generation
         (id /*sqlite*/ BLOB /*end*/ /*pg: BYTEA*/ NOT NULL PRIMARY KEY)
         /*sqlite*/ STRICT /*end*/ /*pg: ON COMMIT DELETE ROWS*/",
    "CREATE TEMP TABLE IF NOT EXISTS purge_candidate
         (hash /*sqlite*/ BLOB /*end*/ /*pg: BYTEA*/ NOT NULL PRIMARY KEY)
         /*sqlite*/ STRICT /*end*/ /*pg: ON COMMIT DELETE ROWS*/",
];
const CLEAR: [&str; 2] = ["DELETE FROM purged_generation", "DELETE FROM purge_candidate"];
const CHOOSE_GENERATIONS: &str = "INSERT INTO purged_generation
    SELECT id FROM generation WHERE lineage_id = ? ORDER BY position DESC LIMIT ?";
const FILL_CANDIDATES: &str = "INSERT INTO purge_candidate
    SELECT genome_hash FROM individual
        WHERE generation_id IN (SELECT id FROM purged_generation)
    UNION
    SELECT genome_hash FROM generation_parent
        WHERE generation_id IN (SELECT id FROM purged_generation)";
/// Individuals and parent rows are deleted by cascade.
const REMOVE_GENERATIONS: &str =
    "DELETE FROM generation WHERE id IN (SELECT id FROM purged_generation)";
/// Returns the genomes that remain.
const KEEP_REFERENCED: &str = "DELETE FROM purge_candidate WHERE
    hash IN (SELECT hash FROM genome WHERE kept)
    OR EXISTS (SELECT 1 FROM individual WHERE genome_hash = purge_candidate.hash)
    OR EXISTS (SELECT 1 FROM generation_parent WHERE genome_hash = purge_candidate.hash)
    RETURNING hash";
/// A picture belongs to a program: assign it to a remaining genome with the same program.
const REASSIGN_PICTURES: &str = "UPDATE picture SET genome_hash = coalesce(
        (SELECT twin.hash FROM genome AS twin
         WHERE twin.program_hash =
                 (SELECT program_hash FROM genome WHERE hash = picture.genome_hash)
             AND twin.hash NOT IN (SELECT hash FROM purge_candidate)
         LIMIT 1),
        genome_hash)
    WHERE genome_hash IN (SELECT hash FROM purge_candidate)";
const REMOVE_GENOMES: &str = "DELETE FROM genome WHERE hash IN (SELECT hash FROM purge_candidate)";
const REMOVE_LINEAGE: &str = "DELETE FROM lineage WHERE id = ?";

/// Result of one transaction.
struct Slice {
    generations: u64,
    elapsed: Duration,
}

impl Store {
    /// Removes a lineage with its generations and individuals, and the genomes and picture keys
    /// without other references. Children of its individuals in other lineages keep the parent's
    /// hash. Lists leave it out at once, and it is removed even if the caller does not wait for the
    /// end.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if the lineage does not exist.
    pub async fn purge_lineage(&self, id: LineageId) -> Result<()> {
        self.write(operation!(|conn| lineage::set_unfinished(conn, id, Unfinished::Removal).await))
            .await?;
        let store = self.clone();
        let removal = tokio::spawn(async move { store.remove_lineage(id).await });
        removal.await.unwrap_or(Err(StorageError::Closed))
    }

    /// Removes an unfinished lineage.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if it does not exist any more.
    pub async fn remove_lineage(&self, id: LineageId) -> Result<()> {
        let mut pace = Pace::new(GENERATIONS, GENERATIONS_MAX);
        loop {
            let count = pace.size();
            // The last write makes all of them durable.
            let slice = self
                .write_slice(Durability::ProcessDeath, || {
                    operation!(|conn| {
                        begin_removal(conn, id).await?;
                        remove_slice(conn, id, count).await
                    })
                })
                .await?;
            if slice.generations < u64::from(count) {
                break;
            }
            pace.adapt(slice.elapsed);
        }
        self.write_slice(Durability::PowerLoss, || {
            operation!(|conn| {
                begin_removal(conn, id).await?;
                // Generations that were born in the meantime.
                while remove_slice(conn, id, GENERATIONS).await?.generations > 0 {}
                let done = query(REMOVE_LINEAGE).bind(id.key()).execute(conn).await?;
                changed(done, StorageError::NotFound)
            })
        })
        .await
    }
}

/// Begins a slice of a removal: locks the genomes, then the lineage, in the order of births.
async fn begin_removal(conn: &mut Conn, id: LineageId) -> Result<()> {
    conn.lock_genomes(GenomeUse::Removal).await?;
    lineage::renew_unfinished(conn, id, Unfinished::Removal).await
}

/// Removes the youngest generations, at most `count`. The genomes must be locked.
async fn remove_slice(conn: &mut Conn, id: LineageId, count: u32) -> Result<Slice> {
    let start = Instant::now();
    for sql in CREATE.into_iter().chain(CLEAR) {
        query(sql).execute(conn).await?;
    }
    query(CHOOSE_GENERATIONS).bind(id.key()).bind(count).execute(conn).await?;
    query(FILL_CANDIDATES).execute(conn).await?;
    let removed = query(REMOVE_GENERATIONS).execute(conn).await?;
    let remaining = query(KEEP_REFERENCED).fetch_all(conn).await?;
    let remaining = remaining.iter().map(|row| row.column("hash"));
    let remaining: Vec<GenomeHash> = remaining.collect::<Result<_>>()?;
    // The genomes that they are packed against may be removed below, or by a later purge.
    genome::pack_alone(conn, &remaining).await?;
    for sql in [REASSIGN_PICTURES, REMOVE_GENOMES].into_iter().chain(CLEAR) {
        query(sql).execute(conn).await?;
    }
    Ok(Slice { generations: removed, elapsed: start.elapsed() })
}
