//! Islands of a search: its other rows, the programs that migrate among them, and their end.
//!
//! Each island is a row with a lease of its own; the id of the first island is that of the search.
//! At a generation of migration, an island stores a checkpoint and its programs for the next
//! island. It can be leased again once the previous island has stored its programs of that
//! generation, or has ended and stored its front. Changes by users and the end of the search
//! change all rows in one transaction, which locks the row of the first island first.

use brood_protocol::JobId;

use crate::Store;
use crate::column::Key;
use crate::error::{LEASE_ENDED, Result, changed};
use crate::row::signed;
use crate::search::{self, SearchEnd, StoredSearch};
use crate::sql::{Conn, SqlRow, query};
use crate::write::operation;

/// Programs or front that the island before has stored, in the caller's format.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StoredArrival {
    /// Programs of the same generation.
    Migrants(Vec<u8>),
    /// Front of the island, if it has ended before that generation.
    Front(Vec<u8>),
}

/// End of an island.
#[derive(Debug, Clone, PartialEq)]
pub struct IslandEnd {
    /// Id of the island.
    pub id: JobId,
    /// Epoch of the lease.
    pub epoch: u64,
    /// Number of its generations.
    pub generation: u32,
    /// Total search time, in seconds.
    pub seconds: f64,
    /// Front of the island, in the caller's format.
    pub front: Vec<u8>,
}

/// Result of the end of an island.
#[derive(Debug, Clone, PartialEq)]
pub enum IslandEnded {
    /// Others go on.
    Stored(Box<StoredSearch>),
    /// All others have ended, with these fronts in the order of the islands, and their numbers.
    Last(Vec<(u32, Vec<u8>)>),
}

/// Condition for a queued search that can be leased: neither over, nor waiting for migrants.
pub(crate) const CLAIMABLE: &str = "found IS NULL AND (awaits IS NULL
     OR EXISTS (SELECT 1 FROM migrant
         WHERE search_id = search.previous_id AND generation = search.awaits)
     OR EXISTS (SELECT 1 FROM search AS previous
         WHERE previous.id = search.previous_id AND previous.found IS NOT NULL))";

impl Store {
    /// Returns the programs of the previous island of a generation, or its front if it has ended
    /// before; `None` if neither is stored yet.
    ///
    /// # Errors
    /// Returns a `StorageError` if the read fails.
    pub async fn search_arrival(
        &self,
        island: JobId,
        generation: u32,
    ) -> Result<Option<StoredArrival>> {
        arrival(&mut self.reader().await?, island, generation).await
    }

    /// Ends a leased island of a search, while others go on, and stores its front, in the caller's
    /// format. If all others have ended, it stores nothing and returns the fronts of these: the
    /// caller merges them, and ends the search.
    ///
    /// # Errors
    /// Returns `StorageError::Conflict` if the epoch is stale, unless all others have ended.
    pub async fn end_island(&self, search: JobId, end: IslandEnd) -> Result<IslandEnded> {
        self.write(operation!(|conn| {
            lock_all(conn, search).await?;
            let fronts = query(
                "SELECT island, found FROM search
                 WHERE (id = ?1 OR parent_id = ?1) AND id <> ?2 AND found IS NOT NULL
                 ORDER BY island",
            );
            let fronts = fronts.bind(search.key()).bind(end.id.key()).fetch_all(conn).await?;
            let others = query("SELECT count(*) FROM search WHERE parent_id = ?");
            let others: u32 = others.bind(search.key()).fetch_value(conn).await?;
            if fronts.len() >= others as usize {
                let one = |row: &SqlRow| Ok((row.column("island")?, row.column("found")?));
                return Ok(IslandEnded::Last(fronts.iter().map(one).collect::<Result<_>>()?));
            }
            let sql = "UPDATE search SET state = 'queued', epoch = epoch + 1, worker = NULL,
                    lease_until_ms = NULL, deaths = 0, seconds = ?, found = ?
                WHERE id = ? AND epoch = ? AND state = 'running' AND generation = ?";
            let own = query(sql).bind(end.seconds).bind(end.front).bind(end.id.key());
            let own = own.bind(signed(end.epoch)).bind(end.generation);
            changed(own.execute(conn).await?, LEASE_ENDED)?;
            Ok(IslandEnded::Stored(Box::new(search::fetch(conn, end.id).await?)))
        }))
        .await
    }
}

/// Ends the other islands of a search. The front is in the row of the first island.
pub(crate) async fn end_others(
    conn: &mut Conn,
    search: JobId,
    own: JobId,
    end: &SearchEnd,
) -> Result<()> {
    let front = serde_json::to_string(&end.front).expect("found materials are plain data");
    let best = end.front.first().map(serde_json::to_string).transpose();
    let best = best.expect("found materials are plain data");
    let sql = "UPDATE search SET state = ?1, reason = ?2, ended_ms = ?3, epoch = epoch + 1,
            worker = NULL, lease_until_ms = NULL
        WHERE (id = ?4 OR parent_id = ?4) AND id <> ?5";
    let end_all = query(sql).bind(end.state.name()).bind(end.reason.as_deref()).bind(end.ended_ms);
    end_all.bind(search.key()).bind(own.key()).execute(conn).await?;
    let sql = "UPDATE search SET front_json = ?1, best_json = coalesce(?2, best_json)
        WHERE id = ?3";
    query(sql).bind(front).bind(best).bind(search.key()).execute(conn).await?;
    search::forget_islands(conn, search).await
}

/// Locks the rows of all islands, the first before the others, as changes by users do.
pub(crate) async fn lock_all(conn: &mut Conn, search: JobId) -> Result<()> {
    for sql in [
        "SELECT id FROM search WHERE id = ? /*pg: FOR UPDATE*/",
        "SELECT id FROM search WHERE parent_id = ? ORDER BY island /*pg: FOR UPDATE*/",
    ] {
        query(sql).bind(search.key()).fetch_all(conn).await?;
    }
    Ok(())
}

/// Returns the programs of the previous island of a generation, or its front if it has ended
/// before.
pub(crate) async fn arrival(
    conn: &mut Conn,
    island: JobId,
    generation: u32,
) -> Result<Option<StoredArrival>> {
    let sql = "SELECT genomes FROM migrant JOIN search ON migrant.search_id = search.previous_id
        WHERE search.id = ? AND migrant.generation = ?";
    let migrants = query(sql).bind(island.key()).bind(generation);
    if let Some(row) = migrants.fetch_optional(conn).await? {
        return Ok(Some(StoredArrival::Migrants(row.column("genomes")?)));
    }
    let sql = "SELECT previous.found AS found FROM search AS previous
        JOIN search ON previous.id = search.previous_id
        WHERE search.id = ? AND previous.found IS NOT NULL";
    let Some(row) = query(sql).bind(island.key()).fetch_optional(conn).await? else {
        return Ok(None);
    };
    Ok(Some(StoredArrival::Front(row.column("found")?)))
}
