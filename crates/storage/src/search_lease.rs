//! Leases of searches: claim, step, end, release. The workers' side of the table `search`; each
//! transition is a compare-and-set on id, epoch and state.
//!
//! Not every step has a checkpoint. The next lease continues from the last one: a claim removes the
//! generations after it, and the worker computes them again. A step without a recorded individual
//! survives the end of the process but not a power loss: a search computes the same sequence of
//! generations every time, so lost steps are repeated. A step that records an individual is as
//! durable as a generation.
//!
//! A checkpoint over 1 MiB may be in the object store ([`crate::blob`]).

use std::time::Duration;

use brood_genome::GenomeHash;
use brood_protocol::{FoundMaterial, GenerationLine, JobId, SearchOptions, SearchState};

use crate::blob::PlacedFile;
use crate::blob_store::BlobKind;
use crate::clock::steady_ms;
use crate::column::{Key, optional_key};
use crate::error::{LEASE_ENDED, Result, changed};
use crate::island::{self, CLAIMABLE, StoredArrival};
use crate::lease::{EndedLease, LeasedTable, LostLeases, ReadReturned};
use crate::row::{Record, insert_rows, record, returning, signed, values};
use crate::search::{self, NEXT_TURN, SearchEnd, StoredSearch};
use crate::sql::{Conn, query};
use crate::write::{Durability, operation};
use crate::{StorageError, Store, lease};

record! {
    /// Search that has just been leased.
    #[derive(Debug, Clone, PartialEq)]
    pub struct ClaimedSearch {
        /// Id of the search, or of the island.
        pub id: JobId,
        /// Epoch of this lease. Every other change of the search increments it.
        pub epoch: u64,
        /// Number of the island, from 0.
        pub island: u32,
        /// Kind of the target's file.
        pub target_kind: String,
        /// Content hash of the target's file.
        pub target_hash: [u8; 32],
        /// Options of the search.
        pub options: SearchOptions = "options_json",
        /// Number of generations up to the checkpoint.
        pub generation: u32,
        /// Search time up to the checkpoint, in seconds.
        pub seconds: f64,
        /// Validation error of the best material, of any island, that is already an individual.
        pub recorded: Option<f64>,
        parent: Option<JobId> = "parent_id",
        /// Generation of the checkpoint, if migrants are to be added to it.
        awaits: Option<u32>,
        /// Genomes to start from, in the caller's format.
        pub start: Vec<u8>,
    } and {
        /// Checkpoint to resume from.
        pub checkpoint: Option<Vec<u8>>,
        /// Name of the object with the checkpoint, if it is missing or damaged.
        pub lost_checkpoint: Option<String>,
        /// Arrival from the island before, if it is to be added to the checkpoint.
        pub arrival: Option<StoredArrival>,
    }
}

/// Progress of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchStep {
    /// Id of the search.
    pub id: JobId,
    /// Epoch of the lease; of a paused search, that of the pause.
    pub epoch: u64,
    /// True if the search was paused, so that this step ends its last lease. It stays paused.
    pub is_paused: bool,
    /// Number of generations before this step.
    pub from: u32,
    /// Generations since the previous step.
    pub lines: Vec<GenerationLine>,
    /// Checkpoint after them, if there is one, and its hash.
    pub checkpoint: Option<(Vec<u8>, [u8; 32])>,
    /// The search, if it has several islands.
    pub archipelago: Option<JobId>,
    /// Programs for the next island, in the caller's format, with a checkpoint. The next lease
    /// begins when those of the island before are there.
    pub emigrants: Option<Vec<u8>>,
    /// Best material, if it becomes an individual with this step.
    pub best: Option<FoundMaterial>,
    /// Genome hash of the best individual before this step.
    pub best_before: Option<GenomeHash>,
    /// Total search time, in seconds.
    pub seconds: f64,
    /// True to give up the lease and move to the end of the queue.
    pub yields: bool,
    /// Time to live of the lease after this step, if the search keeps it.
    pub ttl: Duration,
    /// End of the search, with all of its islands, if it ends with this step.
    pub end: Option<SearchEnd>,
}

/// Checkpoint of a step, on its way into its row.
#[derive(Debug, Clone, Default)]
pub(crate) struct PlacedCheckpoint {
    file: Option<PlacedFile>,
    /// Object of the checkpoint that it replaces.
    before: Option<String>,
}

/// Objects of a checkpoint and of the one that it replaces.
pub(crate) struct CheckpointObjects {
    new: Option<String>,
    before: Option<String>,
}

impl PlacedCheckpoint {
    /// Returns the names of the objects, one of which is left without a row.
    pub fn objects(&self) -> CheckpointObjects {
        let new = self.file.as_ref().and_then(|file| file.object.clone());
        CheckpointObjects { new, before: self.before.clone() }
    }
}

/// Stores the checkpoint of a search.
const SAVE: &str = "INSERT INTO search_checkpoint (search_id, generation, bytes, object)
    VALUES (?, ?, ?, ?)
    ON CONFLICT (search_id) DO UPDATE SET generation = excluded.generation,
        bytes = excluded.bytes, object = excluded.object";
/// Removes the generations after the checkpoint from the log.
const FORGET: &str = "DELETE FROM search_log WHERE search_id = ?1 AND generation > ?2";
/// Sets the progress of a search to that of its checkpoint, in which `?2` is the last generation.
const REWIND: &str = "UPDATE search SET generation = ?2,
        evaluations = coalesce((SELECT evaluations FROM search_log
            WHERE search_id = ?1 AND generation = ?2), 0),
        seconds = coalesce((SELECT seconds FROM search_log
            WHERE search_id = ?1 AND generation = ?2), 0.0),
        fitted = (SELECT fitted FROM search_log WHERE search_id = ?1 AND generation = ?2),
        held = (SELECT held FROM search_log WHERE search_id = ?1 AND generation = ?2)
    WHERE id = ?1";

impl Store {
    /// Leases the queued search with the least turn, for this time unless it is renewed. Returns
    /// `None` if no search is queued.
    ///
    /// # Errors
    /// Returns a `StorageError` if the write fails, or if the object store does not give the
    /// checkpoint. The search is then at the end of the queue, which is no death of its worker.
    pub async fn claim_search(
        &self,
        worker: &str,
        ttl: Duration,
        now_ms: i64,
    ) -> Result<Option<ClaimedSearch>> {
        let sql = format!(
            "UPDATE search SET state = 'running', epoch = epoch + 1, worker = ?2,
                 started_ms = coalesce(started_ms, ?3), lease_until_ms = {} + ?4
             WHERE id = (SELECT id FROM search WHERE state = 'queued' AND {CLAIMABLE}
                 ORDER BY turn, id LIMIT 1 /*pg: FOR UPDATE SKIP LOCKED*/)",
            lease::now(1)
        );
        let worker = worker.to_owned();
        let claimed = self.write_relaxed(operation!(|conn| {
            let claim = returning::<ClaimedSearch>(&sql).bind(steady_ms()).bind(worker);
            let claim = claim.bind(now_ms).bind(lease::ttl_ms(ttl));
            let Some(row) = claim.fetch_optional(conn).await? else { return Ok(None) };
            let mut claimed = ClaimedSearch::read(&row)?;
            let object = resume(conn, &mut claimed).await?;
            if claimed.options.islands > 1 {
                let search = claimed.parent.unwrap_or(claimed.id);
                let least = "SELECT min(recorded) FROM search WHERE id = ?1 OR parent_id = ?1";
                claimed.recorded = query(least).bind(search.key()).fetch_value(conn).await?;
            }
            if let Some(generation) = claimed.awaits {
                claimed.arrival = island::arrival(conn, claimed.id, generation).await?;
            }
            Ok(Some((claimed, object)))
        }));
        let Some((mut claimed, object)) = claimed.await? else { return Ok(None) };
        let Some(object) = object else { return Ok(Some(claimed)) };
        match self.object(&object).await {
            Ok(Some(checkpoint)) => claimed.checkpoint = Some(checkpoint),
            Ok(None) | Err(StorageError::BlobDamaged(_)) => claimed.lost_checkpoint = Some(object),
            Err(error) => {
                tracing::warn!(search = %claimed.id, %error, "a search waits for its checkpoint");
                self.put_back_search(claimed.id, claimed.epoch).await?;
                return Err(error);
            }
        }
        Ok(Some(claimed))
    }

    /// Returns a leased search to the end of the queue. Does nothing if the epoch is stale.
    async fn put_back_search(&self, id: JobId, epoch: u64) -> Result<()> {
        let sql = format!(
            "UPDATE search SET state = 'queued', epoch = epoch + 1, worker = NULL,
                 lease_until_ms = NULL, turn = {NEXT_TURN}
             WHERE id = ? AND epoch = ? AND state = 'running'"
        );
        self.write_relaxed(operation!(|conn| {
            query(sql).bind(id.key()).bind(signed(epoch)).execute(conn).await?;
            Ok(())
        }))
        .await
    }

    /// Takes the checkpoint out of a step, and writes it to the object store if it is large.
    ///
    /// # Errors
    /// Returns a `StorageError` if the object store does not take it.
    pub(crate) async fn place_checkpoint(&self, step: &mut SearchStep) -> Result<PlacedCheckpoint> {
        let Some((bytes, _)) = &mut step.checkpoint else {
            return Ok(PlacedCheckpoint::default());
        };
        let bytes = std::mem::take(bytes);
        let mut before = None;
        if self.blobs().is_some() {
            // Only the holder of the lease stores checkpoints.
            let read = query("SELECT object FROM search_checkpoint WHERE search_id = ?");
            let row = read.bind(step.id.key()).fetch_optional(&mut self.reader().await?).await?;
            before = row.map_or(Ok(None), |row| row.column("object"))?;
        }
        let file = self.place_file(BlobKind::Checkpoint, bytes).await?;
        Ok(PlacedCheckpoint { file: Some(file), before })
    }

    /// Removes the object that is left after the write of a step: that of the checkpoint before, or
    /// the new one if nothing was written.
    pub(crate) fn discard_checkpoint<T>(&self, objects: CheckpointObjects, written: &Result<T>) {
        match written {
            Ok(_) => self.discard_replaced(objects.before),
            Err(StorageError::Conflict { .. } | StorageError::NotFound) => {
                self.discard_object(objects.new);
            }
            // The write may have been committed.
            Err(_) => {}
        }
    }

    /// Renews the lease of a search.
    ///
    /// # Errors
    /// Returns `StorageError::Conflict` if the epoch is stale.
    pub async fn renew_search(&self, id: JobId, epoch: u64, ttl: Duration) -> Result<()> {
        lease::renew(self, LeasedTable::Search, (id, epoch), ttl).await
    }

    /// True if a search is queued that can be leased.
    ///
    /// # Errors
    /// Returns a `StorageError` if the read fails.
    pub async fn any_search_queued(&self) -> Result<bool> {
        let sql =
            format!("SELECT EXISTS (SELECT 1 FROM search WHERE state = 'queued' AND {CLAIMABLE})");
        query(sql).fetch_value(&mut self.reader().await?).await
    }

    /// Stores a step without an individual. For a step with one, see
    /// [`NewGeneration::search`](crate::NewGeneration::search).
    ///
    /// # Errors
    /// Returns `StorageError::Conflict` if the epoch is stale, or if another step was stored.
    pub async fn step_search(&self, mut step: SearchStep) -> Result<StoredSearch> {
        let saved = self.place_checkpoint(&mut step).await?;
        let objects = saved.objects();
        let durability = match step.end {
            Some(_) => Durability::PowerLoss,
            None => Durability::ProcessDeath,
        };
        let write =
            self.write_as(durability, operation!(|conn| step_and_fetch(conn, step, saved).await));
        let written = write.await;
        self.discard_checkpoint(objects, &written);
        Ok(written?.0)
    }

    /// Returns a leased search to its queue. After the third consecutive worker death it fails
    /// instead.
    ///
    /// # Errors
    /// Returns `StorageError::Conflict` if the epoch is stale.
    pub async fn release_search(
        &self,
        id: JobId,
        epoch: u64,
        worker_died: bool,
        now_ms: i64,
    ) -> Result<StoredSearch> {
        self.write_relaxed(operation!(|conn| {
            if worker_died {
                // An island that fails ends the others: the row of the first is locked before.
                let first = "SELECT id FROM search
                    WHERE id = (SELECT parent_id FROM search WHERE id = ?) /*pg: FOR UPDATE*/";
                query(first).bind(id.key()).fetch_all(conn).await?;
            }
            lease::release(conn, LeasedTable::Search, (id, epoch), worker_died, now_ms).await?;
            released(conn, id, now_ms).await
        }))
        .await
    }

    /// Returns the searches of lost leases to their queue, as [`release_search`] does. Returns the
    /// leases and the changed searches.
    ///
    /// [`release_search`]: Self::release_search
    ///
    /// # Errors
    /// Returns a `StorageError` if the read or the write fails.
    pub async fn end_search_leases(
        &self,
        lost: LostLeases,
        now_ms: i64,
    ) -> Result<Vec<(EndedLease, StoredSearch)>> {
        let read: ReadReturned<_> = |conn, id, now_ms| Box::pin(released(conn, id, now_ms));
        lease::end_lost(self, LeasedTable::Search, lost, now_ms, read).await
    }
}

/// Reads the checkpoint of a search and sets its progress to it. Returns the name of the object
/// that has it, if it is not in the row.
async fn resume(conn: &mut Conn, claimed: &mut ClaimedSearch) -> Result<Option<String>> {
    let id = claimed.id.key().to_vec();
    let sql = "SELECT generation, bytes, object FROM search_checkpoint WHERE search_id = ?";
    let (mut generation, mut object) = (0, None);
    if let Some(saved) = query(sql).bind(id.clone()).fetch_optional(conn).await? {
        generation = saved.column("generation")?;
        claimed.checkpoint = saved.column("bytes")?;
        if claimed.checkpoint.is_none() {
            object = Some(saved.column("object")?);
        }
    }
    if generation == claimed.generation {
        return Ok(object);
    }
    for sql in [FORGET, REWIND] {
        query(sql).bind(id.clone()).bind(generation).execute(conn).await?;
    }
    claimed.generation = generation;
    let seconds = query("SELECT seconds FROM search WHERE id = ?").bind(id);
    claimed.seconds = seconds.fetch_value(conn).await?;
    Ok(object)
}

/// Reads a search whose lease has ended. If an island has failed, the others fail too.
async fn released(conn: &mut Conn, id: JobId, now_ms: i64) -> Result<StoredSearch> {
    let released = search::fetch(conn, id).await?;
    if released.state == SearchState::Failed
        && let Some(search) = released.archipelago()
    {
        let end = SearchEnd {
            state: released.state,
            reason: released.reason.clone(),
            front: Vec::new(),
            ended_ms: now_ms,
        };
        island::end_others(conn, search, id, &end).await?;
    }
    Ok(released)
}

async fn step_and_fetch(
    conn: &mut Conn,
    step: SearchStep,
    saved: PlacedCheckpoint,
) -> Result<StoredSearch> {
    apply(conn, &step, saved).await?;
    search::fetch(conn, step.id).await
}

/// Stores a step and its log lines. The epoch is incremented unless the search keeps its lease.
/// `recorded` becomes the validation error of the last line if the step records an individual.
pub(crate) async fn apply(
    conn: &mut Conn,
    step: &SearchStep,
    saved: PlacedCheckpoint,
) -> Result<()> {
    if let (Some(search), Some(_)) = (step.archipelago, &step.end) {
        island::lock_all(conn, search).await?;
    }
    let before = if step.is_paused { SearchState::Paused } else { SearchState::Running };
    let state = match (&step.end, step.yields) {
        (Some(end), _) => end.state,
        (None, true) => SearchState::Queued,
        (None, false) => before,
    };
    let keeps_lease = state == SearchState::Running;
    // A pause has incremented the epoch.
    let keeps_epoch = state == before;
    let last = step.lines.last();
    let json = |best| serde_json::to_string(best).expect("found materials are plain data");
    let front = step.end.as_ref().map(|end| serde_json::to_string(&end.front));
    let front = front.transpose().expect("found materials are plain data");
    let sql = format!(
        "UPDATE search SET state = ?1, deaths = CASE WHEN ?10 IS NULL THEN deaths ELSE 0 END,
             epoch = epoch + (CASE WHEN ?18 THEN 0 ELSE 1 END),
             worker = CASE WHEN ?2 THEN worker END,
             turn = CASE WHEN ?3 THEN {NEXT_TURN} ELSE turn END,
             generation = coalesce(?4, generation), evaluations = coalesce(?5, evaluations),
             seconds = ?6, fitted = coalesce(?7, fitted), held = coalesce(?8, held),
             recorded = CASE WHEN ?9 IS NULL THEN recorded ELSE coalesce(?8, recorded) END,
             best_json = coalesce(?9, best_json),
             population = coalesce(?10, population),
             awaits = CASE WHEN ?10 IS NULL THEN awaits ELSE ?21 END,
             reason = ?11, front_json = ?12, ended_ms = ?13,
             lease_until_ms = CASE WHEN ?2 THEN {} + ?17 END
         WHERE id = ?14 AND epoch = ?15 AND state = ?19 AND generation = ?20",
        lease::now(16)
    );
    let done = query(sql)
        .bind(state.name())
        .bind(keeps_lease)
        .bind(step.yields)
        .bind(last.map(|line| line.generation))
        .bind(last.map(|line| signed(line.evaluations)))
        .bind(step.seconds)
        .bind(last.and_then(|line| finite(line.fitted)))
        .bind(last.and_then(|line| finite(line.held)))
        .bind(step.best.as_ref().map(json))
        .bind(step.checkpoint.as_ref().map(|(_, hash)| hash.as_slice()))
        .bind(step.end.as_ref().and_then(|end| end.reason.as_deref()))
        .bind(front)
        .bind(step.end.as_ref().map(|end| end.ended_ms))
        .bind(step.id.key())
        .bind(signed(step.epoch))
        .bind(steady_ms())
        .bind(lease::ttl_ms(step.ttl))
        .bind(keeps_epoch)
        .bind(before.name())
        .bind(step.from)
        .bind(last.filter(|_| step.emigrants.is_some()).map(|line| line.generation))
        .execute(conn)
        .await?;
    changed(done, LEASE_ENDED)?;
    if let (Some(search), Some(end)) = (step.archipelago, &step.end) {
        island::end_others(conn, search, step.id, end).await?;
    }
    if let (Some(genomes), Some(last)) = (&step.emigrants, last) {
        let send = "INSERT INTO migrant (search_id, generation, genomes) VALUES (?, ?, ?)
            ON CONFLICT (search_id, generation) DO NOTHING";
        let send = query(send).bind(step.id.key()).bind(last.generation);
        send.bind(genomes.as_slice()).execute(conn).await?;
        // This checkpoint includes the migrants of earlier generations.
        let taken = "DELETE FROM migrant WHERE generation < ?
            AND search_id = (SELECT previous_id FROM search WHERE id = ?)";
        query(taken).bind(last.generation).bind(step.id.key()).execute(conn).await?;
    }
    if let Some(file) = saved.file {
        file.admit(conn).await?;
        let generation = last.map_or(step.from, |line| line.generation);
        let save = query(SAVE).bind(step.id.key()).bind(generation);
        save.bind(file.bytes).bind(file.object).execute(conn).await?;
    }
    log(conn, step).await
}

/// Inserts the log lines of a step. The last one has the hash of the new best individual, if there
/// is one; all others have the hash of the best before the step.
async fn log(conn: &mut Conn, step: &SearchStep) -> Result<()> {
    let last = step.lines.last().map(|line| line.generation);
    let new = step.best.as_ref().map(|best| best.hash);
    let head = "INSERT INTO search_log (search_id, generation, evaluations, seconds, fitted, held,
     median, diversity, repeats, best_hash) ";
    insert_rows(conn, (head, ""), &step.lines, |line| {
        let is_last = Some(line.generation) == last;
        let best = new.filter(|_| is_last).or(step.best_before);
        values![
            step.id.key(),
            line.generation,
            signed(line.evaluations),
            line.seconds,
            finite(line.fitted),
            finite(line.held),
            finite(line.median),
            finite(line.diversity),
            signed(line.repeats),
            optional_key(best),
        ]
    })
    .await
}

/// Returns `None` for an infinite error, which SQLite and JSON cannot represent. Errors are
/// infinite before the first candidate.
fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}
