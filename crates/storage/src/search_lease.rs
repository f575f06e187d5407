//! Searches in workers' hands: claimed, brought forward, ended, given back. The workers' side of the table `search`; every
//! movement is a compare-and-set on id, epoch and state.
//!
//! What a worker tells between two recorded individuals survives the death of the process but not the loss of power: the
//! search is the same sequence of generations every time, so what a power cut undoes is done again. What is recorded is as
//! durable as a birth.

use brood_genome::GenomeHash;
use brood_protocol::{FoundMaterial, GenerationLine, JobId, SearchOptions, SearchState};
use sqlx::{QueryBuilder, Row, Sqlite, SqliteConnection};

use crate::row::{Columns, Key, signed};
use crate::search::{self, LAST_TURN, StoredSearch};
use crate::{StorageError, Store};

/// So many workers in a row die over one search before it is given up. One that comes forward in between starts afresh: a long
/// search must not fail because its machine was short of memory once a day.
const MAX_DEATHS: i64 = 3;
/// Lines that are written by one statement.
const CHUNK_LINES: usize = 100;

/// A search that was just leased.
#[derive(Debug, Clone, PartialEq)]
pub struct ClaimedSearch {
    /// Its id.
    pub id: JobId,
    /// Counted up by whatever happens to it.
    pub epoch: u64,
    /// What kind of file the target is.
    pub target_kind: String,
    /// The target's file.
    pub target_hash: [u8; 32],
    /// How it goes about it.
    pub options: SearchOptions,
    /// Time searched before.
    pub seconds: f64,
    /// Error, where it is held back, of the best that was made an individual.
    pub recorded: Option<f64>,
    /// The genomes that it starts from, as they were handed over.
    pub start: Vec<u8>,
    /// The state to go on from.
    pub checkpoint: Option<Vec<u8>>,
}

/// How far a worker has brought a search.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchStep {
    /// The search.
    pub id: JobId,
    /// Its epoch.
    pub epoch: u64,
    /// The generations since the step before.
    pub lines: Vec<GenerationLine>,
    /// The state after them, and its hash.
    pub checkpoint: Option<(Vec<u8>, [u8; 32])>,
    /// The best that becomes an individual with this step.
    pub best: Option<FoundMaterial>,
    /// The hash of the best before this step.
    pub best_before: Option<GenomeHash>,
    /// Time searched in all.
    pub seconds: f64,
    /// Whether it goes behind the others that wait.
    pub yields: bool,
    /// How it ends, where it does.
    pub end: Option<SearchEnd>,
}

/// How a search ends.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchEnd {
    /// Where it stands from now on.
    pub state: SearchState,
    /// Why, where it failed.
    pub reason: Option<String>,
    /// What it found.
    pub front: Vec<FoundMaterial>,
    /// When, milliseconds since 1970.
    pub ended_ms: i64,
}

const CLAIM: &str = "UPDATE search SET state = 'running', epoch = epoch + 1, worker = ?1,
        started_ms = coalesce(started_ms, ?2)
    WHERE id = (SELECT id FROM search WHERE state = 'queued' ORDER BY turn, id LIMIT 1)
    RETURNING id, epoch, target_kind, target_hash, options_json, seconds, recorded, start, checkpoint";
const RELEASE: &str = "UPDATE search SET
        deaths = deaths + ?1,
        epoch = epoch + 1,
        state = CASE WHEN deaths + ?1 >= ?2 THEN 'failed' ELSE 'queued' END,
        reason = CASE WHEN deaths + ?1 >= ?2 THEN 'worker_lost' END,
        ended_ms = CASE WHEN deaths + ?1 >= ?2 THEN ?3 END,
        worker = NULL
    WHERE id = ?4 AND epoch = ?5 AND state = 'running'";

const STALE: StorageError = StorageError::Conflict { what: "the lease" };

impl Store {
    /// Leases the search whose turn it is.
    pub async fn claim_search(
        &self,
        worker: &str,
        now_ms: i64,
    ) -> Result<Option<ClaimedSearch>, StorageError> {
        let worker = worker.to_owned();
        self.write_relaxed(move |conn| {
            Box::pin(async move {
                let query = sqlx::query(CLAIM).bind(worker).bind(now_ms);
                let Some(row) = query.fetch_optional(conn).await? else { return Ok(None) };
                Ok(Some(ClaimedSearch {
                    id: row.id("id")?,
                    epoch: row.whole("epoch")?,
                    target_kind: row.text("target_kind")?,
                    target_hash: row.hash("target_hash")?,
                    options: search::options(&row)?,
                    seconds: row.real("seconds")?,
                    recorded: row.try_get("recorded")?,
                    start: row.blob("start")?,
                    checkpoint: row.optional_blob("checkpoint")?,
                }))
            })
        })
        .await
    }

    /// Whether a search waits for a worker.
    pub async fn any_search_queued(&self) -> Result<bool, StorageError> {
        let sql = "SELECT EXISTS (SELECT 1 FROM search WHERE state = 'queued')";
        Ok(sqlx::query_scalar(sql).fetch_one(&mut *self.reader().await?).await?)
    }

    /// Writes a step that brings forth no individual. A stale epoch changes nothing: [`StorageError::Conflict`].
    pub async fn step_search(&self, step: SearchStep) -> Result<StoredSearch, StorageError> {
        if step.end.is_some() {
            return self
                .write(move |conn| Box::pin(async move { step_and_fetch(conn, step).await }))
                .await;
        }
        self.write_relaxed(move |conn| Box::pin(async move { step_and_fetch(conn, step).await }))
            .await
    }

    /// A leased search comes back to its queue, or is given up where workers died over it again and again. A stale epoch
    /// changes nothing: [`StorageError::Conflict`].
    pub async fn release_search(
        &self,
        id: JobId,
        epoch: u64,
        worker_died: bool,
        now_ms: i64,
    ) -> Result<StoredSearch, StorageError> {
        self.write_relaxed(move |conn| {
            Box::pin(async move {
                let done = sqlx::query(RELEASE)
                    .bind(i64::from(worker_died))
                    .bind(MAX_DEATHS)
                    .bind(now_ms)
                    .bind(id.key())
                    .bind(signed(epoch))
                    .execute(&mut *conn)
                    .await?;
                if done.rows_affected() == 0 {
                    return Err(STALE);
                }
                search::fetch(conn, id).await
            })
        })
        .await
    }

    /// Puts all leased searches back: for the start, when no lease of the last run holds any more. Returns how many.
    pub async fn requeue_all_searches(&self) -> Result<u64, StorageError> {
        self.write_relaxed(move |conn| {
            Box::pin(async move {
                let sql = "UPDATE search SET state = 'queued', epoch = epoch + 1, worker = NULL
                           WHERE state = 'running'";
                Ok(sqlx::query(sql).execute(conn).await?.rows_affected())
            })
        })
        .await
    }
}

async fn step_and_fetch(
    conn: &mut SqliteConnection,
    step: SearchStep,
) -> Result<StoredSearch, StorageError> {
    apply(conn, &step).await?;
    search::fetch(conn, step.id).await
}

/// Writes a step.
pub(crate) async fn apply(
    conn: &mut SqliteConnection,
    step: &SearchStep,
) -> Result<(), StorageError> {
    let state = match (&step.end, step.yields) {
        (Some(end), _) => end.state,
        (None, true) => SearchState::Queued,
        (None, false) => SearchState::Running,
    };
    let goes_on = state == SearchState::Running;
    let last = step.lines.last();
    let json = |best| serde_json::to_string(best).expect("what was found is plain data");
    let front = step.end.as_ref().map(|end| serde_json::to_string(&end.front));
    let front = front.transpose().expect("what was found is plain data");
    let sql = format!(
        "UPDATE search SET state = ?1, deaths = 0,
             epoch = epoch + (CASE WHEN ?2 THEN 0 ELSE 1 END),
             worker = CASE WHEN ?2 THEN worker END,
             turn = CASE WHEN ?3 THEN {LAST_TURN} ELSE turn END,
             generation = coalesce(?4, generation), evaluations = coalesce(?5, evaluations),
             seconds = ?6, fitted = coalesce(?7, fitted), held = coalesce(?8, held),
             recorded = CASE WHEN ?9 IS NULL THEN recorded ELSE coalesce(?8, recorded) END,
             best_json = coalesce(?9, best_json),
             checkpoint = coalesce(?10, checkpoint), population = coalesce(?11, population),
             reason = ?12, front_json = ?13, ended_ms = ?14
         WHERE id = ?15 AND epoch = ?16 AND state = 'running'"
    );
    let done = sqlx::query(sqlx::AssertSqlSafe(sql))
        .bind(state.name())
        .bind(goes_on)
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
        .execute(&mut *conn)
        .await?;
    if done.rows_affected() == 0 {
        return Err(STALE);
    }
    log(conn, step).await
}

async fn log(conn: &mut SqliteConnection, step: &SearchStep) -> Result<(), StorageError> {
    let last = step.lines.last().map(|line| line.generation);
    let new = step.best.as_ref().map(|best| best.hash);
    for chunk in step.lines.chunks(CHUNK_LINES) {
        let mut query = QueryBuilder::<Sqlite>::new(
            "INSERT INTO search_log (search_id, generation, evaluations, seconds, fitted, held,
                                     median, diversity, repeats, best_hash) ",
        );
        query.push_values(chunk, |mut row, line| {
            let is_last = Some(line.generation) == last;
            let best = new.filter(|_| is_last).or(step.best_before);
            row.push_bind(step.id.key())
                .push_bind(line.generation)
                .push_bind(signed(line.evaluations))
                .push_bind(line.seconds)
                .push_bind(finite(line.fitted))
                .push_bind(finite(line.held))
                .push_bind(finite(line.median))
                .push_bind(finite(line.diversity))
                .push_bind(signed(line.repeats))
                .push_bind(best.map(|hash| hash.as_bytes().to_vec()));
        });
        query.build().execute(&mut *conn).await?;
    }
    Ok(())
}

/// Errors before there is anything are infinite, which neither the table nor JSON has a word for.
fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}
