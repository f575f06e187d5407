//! Leases of searches: claim, step, end, release. The workers' side of the table `search`; each
//! transition is a compare-and-set on id, epoch and state.
//!
//! A step without a recorded individual survives the end of the process but not a power loss: a
//! search computes the same sequence of generations every time, so lost steps are repeated. A step
//! that records an individual is as durable as a generation.

use brood_genome::GenomeHash;
use brood_protocol::{FoundMaterial, GenerationLine, JobId, SearchOptions, SearchState};

use crate::Store;
use crate::column::{Key, optional_key};
use crate::error::{LEASE_ENDED, Result, changed};
use crate::row::{Record, insert_rows, record, returning, signed, values};
use crate::search::{self, NEXT_TURN, StoredSearch};
use crate::sql::{Conn, query};
use crate::write::operation;

/// A search fails after this many consecutive worker deaths without progress. Every step resets the
/// count: a long search must not fail because its machine runs out of memory once a day.
const MAX_DEATHS: i64 = 3;

record! {
    /// Search that has just been leased.
    #[derive(Debug, Clone, PartialEq)]
    pub struct ClaimedSearch {
        /// Id of the search.
        pub id: JobId,
        /// Epoch of this lease. Every other change of the search increments it.
        pub epoch: u64,
        /// Kind of the target's file.
        pub target_kind: String,
        /// Content hash of the target's file.
        pub target_hash: [u8; 32],
        /// Options of the search.
        pub options: SearchOptions = "options_json",
        /// Search time so far, in seconds.
        pub seconds: f64,
        /// Validation error of the best material that is already an individual.
        pub recorded: Option<f64>,
        /// Genomes to start from, in the caller's format.
        pub start: Vec<u8>,
        /// Checkpoint to resume from.
        pub checkpoint: Option<Vec<u8>>,
    }
}

/// Progress of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchStep {
    /// Id of the search.
    pub id: JobId,
    /// Epoch of the lease.
    pub epoch: u64,
    /// Generations since the previous step.
    pub lines: Vec<GenerationLine>,
    /// Checkpoint after them, and its hash.
    pub checkpoint: Option<(Vec<u8>, [u8; 32])>,
    /// Best material, if it becomes an individual with this step.
    pub best: Option<FoundMaterial>,
    /// Genome hash of the best individual before this step.
    pub best_before: Option<GenomeHash>,
    /// Total search time, in seconds.
    pub seconds: f64,
    /// True to give up the lease and move to the end of the queue.
    pub yields: bool,
    /// End of the search, if it ends with this step.
    pub end: Option<SearchEnd>,
}

/// End of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchEnd {
    /// Final state.
    pub state: SearchState,
    /// Reason of a failure.
    pub reason: Option<String>,
    /// Materials of the front.
    pub front: Vec<FoundMaterial>,
    /// Time of the end, in milliseconds since 1970-01-01 UTC.
    pub ended_ms: i64,
}

/// Leases the queued search with the least turn.
const CLAIM: &str = "UPDATE search SET state = 'running', epoch = epoch + 1, worker = ?1,
        started_ms = coalesce(started_ms, ?2)
    WHERE id = (SELECT id FROM search WHERE state = 'queued' ORDER BY turn, id LIMIT 1
        /*pg: FOR UPDATE SKIP LOCKED*/)";
/// Parameters: 1 if the worker died, else 0; limit of deaths; time; id; epoch.
const RELEASE: &str = "UPDATE search SET
        deaths = deaths + ?1,
        epoch = epoch + 1,
        state = CASE WHEN deaths + ?1 >= ?2 THEN 'failed' ELSE 'queued' END,
        reason = CASE WHEN deaths + ?1 >= ?2 THEN 'worker_lost' END,
        ended_ms = CASE WHEN deaths + ?1 >= ?2 THEN ?3 END,
        worker = NULL
    WHERE id = ?4 AND epoch = ?5 AND state = 'running'";

impl Store {
    /// Leases the first search of the queue. Returns `None` if no search is queued.
    ///
    /// # Errors
    /// Returns a `StorageError` if the write fails.
    pub async fn claim_search(&self, worker: &str, now_ms: i64) -> Result<Option<ClaimedSearch>> {
        let worker = worker.to_owned();
        self.write_relaxed(operation!(|conn| {
            let query = returning::<ClaimedSearch>(CLAIM).bind(worker).bind(now_ms);
            query.fetch_optional(conn).await?.as_ref().map(ClaimedSearch::read).transpose()
        }))
        .await
    }

    /// True if a search is queued.
    ///
    /// # Errors
    /// Returns a `StorageError` if the read fails.
    pub async fn any_search_queued(&self) -> Result<bool> {
        let sql = "SELECT EXISTS (SELECT 1 FROM search WHERE state = 'queued')";
        query(sql).fetch_value(&mut self.reader().await?).await
    }

    /// Stores a step without an individual. For a step with one, see
    /// [`NewGeneration::search`](crate::NewGeneration::search).
    ///
    /// # Errors
    /// Returns `StorageError::Conflict` if the epoch is stale.
    pub async fn step_search(&self, step: SearchStep) -> Result<StoredSearch> {
        if step.end.is_some() {
            return self.write(operation!(|conn| step_and_fetch(conn, step).await)).await;
        }
        self.write_relaxed(operation!(|conn| step_and_fetch(conn, step).await)).await
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
            let done = query(RELEASE)
                .bind(i64::from(worker_died))
                .bind(MAX_DEATHS)
                .bind(now_ms)
                .bind(id.key())
                .bind(signed(epoch))
                .execute(conn)
                .await?;
            changed(done, LEASE_ENDED)?;
            search::fetch(conn, id).await
        }))
        .await
    }

    /// Returns all leased searches to the queue, at the start of the server, when all leases of the
    /// previous run are void. Returns the number of searches.
    ///
    /// # Errors
    /// Returns a `StorageError` if the write fails.
    pub async fn requeue_all_searches(&self) -> Result<u64> {
        self.write_relaxed(operation!(|conn| {
            let sql = "UPDATE search SET state = 'queued', epoch = epoch + 1, worker = NULL
                           WHERE state = 'running'";
            query(sql).execute(conn).await
        }))
        .await
    }
}

async fn step_and_fetch(conn: &mut Conn, step: SearchStep) -> Result<StoredSearch> {
    apply(conn, &step).await?;
    search::fetch(conn, step.id).await
}

/// Stores a step and its log lines. The epoch is incremented unless the search keeps its lease.
/// `recorded` becomes the validation error of the last line if the step records an individual.
pub(crate) async fn apply(conn: &mut Conn, step: &SearchStep) -> Result<()> {
    let state = match (&step.end, step.yields) {
        (Some(end), _) => end.state,
        (None, true) => SearchState::Queued,
        (None, false) => SearchState::Running,
    };
    let keeps_lease = state == SearchState::Running;
    let last = step.lines.last();
    let json = |best| serde_json::to_string(best).expect("found materials are plain data");
    let front = step.end.as_ref().map(|end| serde_json::to_string(&end.front));
    let front = front.transpose().expect("found materials are plain data");
    let sql = format!(
        "UPDATE search SET state = ?1, deaths = 0,
             epoch = epoch + (CASE WHEN ?2 THEN 0 ELSE 1 END),
             worker = CASE WHEN ?2 THEN worker END,
             turn = CASE WHEN ?3 THEN {NEXT_TURN} ELSE turn END,
             generation = coalesce(?4, generation), evaluations = coalesce(?5, evaluations),
             seconds = ?6, fitted = coalesce(?7, fitted), held = coalesce(?8, held),
             recorded = CASE WHEN ?9 IS NULL THEN recorded ELSE coalesce(?8, recorded) END,
             best_json = coalesce(?9, best_json),
             checkpoint = coalesce(?10, checkpoint), population = coalesce(?11, population),
             reason = ?12, front_json = ?13, ended_ms = ?14
         WHERE id = ?15 AND epoch = ?16 AND state = 'running'"
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
        .bind(step.checkpoint.as_ref().map(|(bytes, _)| bytes.as_slice()))
        .bind(step.checkpoint.as_ref().map(|(_, hash)| hash.as_slice()))
        .bind(step.end.as_ref().and_then(|end| end.reason.as_deref()))
        .bind(front)
        .bind(step.end.as_ref().map(|end| end.ended_ms))
        .bind(step.id.key())
        .bind(signed(step.epoch))
        .execute(conn)
        .await?;
    changed(done, LEASE_ENDED)?;
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
