//! Searches as users see them: create, list, pause, resume, cancel.
//!
//! The tables `search` and `search_log` are written only here and in `search_lease`, the workers'
//! side. A change by a user checks the state and updates it in one transaction. It increments the
//! epoch, the version number of a search, which ends a worker's lease: a lease is valid for one
//! epoch only.

use std::collections::BTreeMap;

use brood_genome::GenomeHash;
use brood_protocol::{
    FoundMaterial, JobId, LineageId, SearchLine, SearchOptions, SearchState, TargetId,
};
use sqlx::sqlite::SqliteRow;
use sqlx::{Row, SqliteConnection};

use crate::lineage::{self, NewLineage};
use crate::row::{Columns, Key, corrupt_column};
use crate::{Idempotency, StorageError, Store, idempotency};

/// Search to be stored.
#[derive(Debug, Clone, PartialEq)]
pub struct NewSearch {
    /// Id of the search.
    pub id: JobId,
    /// Id of the target.
    pub target: TargetId,
    /// Lineage to which found materials are added.
    pub lineage: LineageId,
    /// Data of `lineage`, if it is to be created together with the search.
    pub new_lineage: Option<NewLineage>,
    /// Options of the search.
    pub options: SearchOptions,
    /// Genomes to start from, encoded by the caller; stored as they are.
    pub start: Vec<u8>,
    /// Creation time, in milliseconds since 1970-01-01 UTC.
    pub created_ms: i64,
    /// Idempotency record to be stored with the search.
    pub idempotency: Option<Idempotency>,
}

/// Search without its checkpoint.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredSearch {
    /// Id of the search.
    pub id: JobId,
    /// Id of the target.
    pub target: TargetId,
    /// Lineage to which found materials are added.
    pub lineage: LineageId,
    /// State of the search.
    pub state: SearchState,
    /// Epoch: version number, incremented by every change except a step (a worker's report of
    /// progress) that keeps the lease.
    pub epoch: u64,
    /// Consecutive worker deaths since the last step.
    pub deaths: u32,
    /// Name of the worker that has the lease.
    pub worker: Option<String>,
    /// Reason, if the search has failed.
    pub reason: Option<String>,
    /// Number of generations so far.
    pub generation: u32,
    /// Number of evaluated candidates so far.
    pub evaluations: u64,
    /// Search time so far, in seconds.
    pub seconds: f64,
    /// E_log of the best candidate on the fitted samples.
    pub fitted: Option<f64>,
    /// E_log of the best candidate on the validation samples: not fitted, but used to select it.
    pub held: Option<f64>,
    /// Hash of the checkpoint.
    pub population: Option<[u8; 32]>,
    /// Options of the search.
    pub options: SearchOptions,
    /// Best material that has been added to the lineage as an individual.
    pub best: Option<FoundMaterial>,
    /// Creation time, in milliseconds since 1970-01-01 UTC.
    pub created_ms: i64,
    /// Time of the first lease, in milliseconds since 1970-01-01 UTC.
    pub started_ms: Option<i64>,
    /// Time of the end, in milliseconds since 1970-01-01 UTC.
    pub ended_ms: Option<i64>,
}

/// Change of a search's state by a user.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SearchChange {
    /// Stops a queued or running search until it is resumed.
    Pause,
    /// Returns a paused search to the queue.
    Resume,
    /// Ends a search.
    Cancel,
}

impl SearchChange {
    /// Returns the new state and the states from which the change is allowed.
    fn transition(self) -> (SearchState, &'static [SearchState]) {
        use SearchState::{Cancelled, Paused, Queued, Running};
        match self {
            Self::Pause => (Paused, &[Queued, Running]),
            Self::Resume => (Queued, &[Paused]),
            Self::Cancel => (Cancelled, &[Queued, Running, Paused]),
        }
    }
}

/// SQL for the turn at the end of the queue: one more than any other. The least turn is next.
pub(crate) const NEXT_TURN: &str = "(SELECT coalesce(max(turn), 0) + 1 FROM search)";

/// Query for the columns that `read` needs; the argument is its end, from WHERE on.
macro_rules! select {
    ($rest:literal) => {
        concat!(
            "SELECT id, target_id, lineage_id, state, epoch, deaths, worker, reason, generation,
                    evaluations, seconds, fitted, held, population, options_json, best_json,
                    created_ms, started_ms, ended_ms
             FROM search ",
            $rest
        )
    };
}

const BY_ID: &str = select!("WHERE id = ?");
const NEWEST: &str = select!(
    "WHERE (?1 IS NULL OR id < ?1) AND (?2 IS NULL OR lineage_id = ?2)
     ORDER BY id DESC LIMIT ?3"
);

impl Store {
    /// Stores a search at the end of the queue.
    ///
    /// # Errors
    /// Returns [`StorageError::QueueFull`] if `max_queued` searches are queued,
    /// [`StorageError::NotFound`] if the target or the lineage does not exist.
    pub async fn create_search(&self, new: NewSearch, max_queued: u32) -> Result<(), StorageError> {
        self.write(move |conn| Box::pin(async move { insert(conn, new, max_queued).await })).await
    }

    /// Returns a search.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if it does not exist.
    pub async fn search(&self, id: JobId) -> Result<StoredSearch, StorageError> {
        fetch(&mut *self.reader().await?, id).await
    }

    /// Lists up to `limit` searches, the newest first. If given, `before` restricts the list to
    /// searches older than it, and `lineage` to searches of that lineage.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn list_searches(
        &self,
        before: Option<JobId>,
        lineage: Option<LineageId>,
        limit: u32,
    ) -> Result<Vec<StoredSearch>, StorageError> {
        let before = before.as_ref().map(|id| id.key().to_vec());
        let lineage = lineage.as_ref().map(|id| id.key().to_vec());
        let query = sqlx::query(NEWEST).bind(before).bind(lineage).bind(limit);
        query.fetch_all(&mut *self.reader().await?).await?.iter().map(read).collect()
    }

    /// Pauses, resumes or cancels a search. Returns the changed search; as the inner error the
    /// current state, if it does not allow the change.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if the search does not exist.
    pub async fn change_search(
        &self,
        id: JobId,
        change: SearchChange,
        now_ms: i64,
    ) -> Result<Result<StoredSearch, SearchState>, StorageError> {
        self.write(move |conn| {
            Box::pin(async move {
                let present = fetch(conn, id).await?;
                let (to, from) = change.transition();
                if !from.contains(&present.state) {
                    return Ok(Err(present.state));
                }
                let sql = format!(
                    "UPDATE search SET state = ?1, epoch = epoch + 1, worker = NULL, deaths = 0,
                         ended_ms = ?2, turn = {NEXT_TURN}
                     WHERE id = ?3"
                );
                sqlx::query(sqlx::AssertSqlSafe(sql))
                    .bind(to.name())
                    .bind(to.is_final().then_some(now_ms))
                    .bind(id.key())
                    .execute(&mut *conn)
                    .await?;
                Ok(Ok(fetch(conn, id).await?))
            })
        })
        .await
    }

    /// Returns the front of a search: the best material, then shorter and less accurate ones. It is
    /// empty until the search has ended.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if the search does not exist.
    pub async fn search_front(&self, id: JobId) -> Result<Vec<FoundMaterial>, StorageError> {
        let query = sqlx::query("SELECT front_json FROM search WHERE id = ?").bind(id.key());
        let row = query.fetch_one(&mut *self.reader().await?).await?;
        let json = row.optional_text("front_json")?;
        json.map_or(Ok(Vec::new()), |json| {
            serde_json::from_str(&json).map_err(|_| corrupt_column("front_json"))
        })
    }

    /// Returns up to `limit` log lines of a search, one per generation, from generation `after` + 1
    /// on.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn search_log(
        &self,
        id: JobId,
        after: u32,
        limit: u32,
    ) -> Result<Vec<SearchLine>, StorageError> {
        let rows = sqlx::query(
            "SELECT generation, evaluations, seconds, fitted, held, median, diversity, repeats, best_hash
             FROM search_log WHERE search_id = ? AND generation > ? ORDER BY generation LIMIT ?",
        )
        .bind(id.key())
        .bind(after)
        .bind(limit)
        .fetch_all(&mut *self.reader().await?)
        .await?;
        let line = |row: &SqliteRow| {
            Ok(SearchLine {
                generation: row.whole("generation")?,
                evaluations: row.whole("evaluations")?,
                fitted: row.try_get("fitted")?,
                held: row.try_get("held")?,
                median: row.try_get("median")?,
                diversity: row.try_get("diversity")?,
                repeats: row
                    .try_get::<Option<i64>, _>("repeats")?
                    .and_then(|n| u64::try_from(n).ok()),
                seconds: row.real("seconds")?,
                best: match row.optional_blob("best_hash")? {
                    Some(_) => Some(GenomeHash::from_bytes(row.hash("best_hash")?)),
                    None => None,
                },
            })
        };
        rows.iter().map(line).collect()
    }

    /// Returns the number of searches in each state, by its name.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn search_counts(&self) -> Result<BTreeMap<&'static str, u64>, StorageError> {
        let sql = "SELECT state, count(*) AS searches FROM search GROUP BY state";
        let rows = sqlx::query(sql).fetch_all(&mut *self.reader().await?).await?;
        let mut counts: BTreeMap<_, _> =
            SearchState::ALL.into_iter().map(|state| (state.name(), 0)).collect();
        for row in rows {
            counts.insert(state(&row)?.name(), row.whole("searches")?);
        }
        Ok(counts)
    }
}

/// Inserts a search, with its lineage and idempotency record if they are given.
async fn insert(
    conn: &mut SqliteConnection,
    new: NewSearch,
    max_queued: u32,
) -> Result<(), StorageError> {
    if let Some(answer) = &new.idempotency {
        idempotency::insert(conn, answer, new.created_ms).await?;
    }
    let waiting: u32 = sqlx::query_scalar("SELECT count(*) FROM search WHERE state = 'queued'")
        .fetch_one(&mut *conn)
        .await?;
    if waiting >= max_queued {
        return Err(StorageError::QueueFull);
    }
    if let Some(new_lineage) = &new.new_lineage {
        lineage::insert(conn, new_lineage).await?;
    }
    let options = serde_json::to_string(&new.options).expect("options are plain data");
    let sql = format!(
        "INSERT INTO search (id, target_id, target_kind, target_hash, lineage_id, state, epoch,
             turn, deaths, generation, evaluations, seconds, created_ms, options_json, start)
         SELECT ?1, id, kind, file_hash, ?2, 'queued', 0, {NEXT_TURN}, 0, 0, 0, 0.0, ?3, ?4, ?5
         FROM target WHERE id = ?6"
    );
    let done = sqlx::query(sqlx::AssertSqlSafe(sql))
        .bind(new.id.key())
        .bind(new.lineage.key())
        .bind(new.created_ms)
        .bind(options)
        .bind(new.start)
        .bind(new.target.key())
        .execute(conn)
        .await?;
    if done.rows_affected() == 0 { Err(StorageError::NotFound) } else { Ok(()) }
}

/// Reads the search with this id.
pub(crate) async fn fetch(
    conn: &mut SqliteConnection,
    id: JobId,
) -> Result<StoredSearch, StorageError> {
    read(&sqlx::query(BY_ID).bind(id.key()).fetch_one(conn).await?)
}

/// Makes a search from its row.
fn read(row: &SqliteRow) -> Result<StoredSearch, StorageError> {
    let best = row.optional_text("best_json")?;
    let best = best.map(|json| serde_json::from_str(&json)).transpose();
    Ok(StoredSearch {
        id: row.id("id")?,
        target: row.id("target_id")?,
        lineage: row.id("lineage_id")?,
        state: state(row)?,
        epoch: row.whole("epoch")?,
        deaths: row.whole("deaths")?,
        worker: row.optional_text("worker")?,
        reason: row.optional_text("reason")?,
        generation: row.whole("generation")?,
        evaluations: row.whole("evaluations")?,
        seconds: row.real("seconds")?,
        fitted: row.try_get("fitted")?,
        held: row.try_get("held")?,
        population: match row.optional_blob("population")? {
            Some(_) => Some(row.hash("population")?),
            None => None,
        },
        options: options(row)?,
        best: best.map_err(|_| corrupt_column("best_json"))?,
        created_ms: row.integer("created_ms")?,
        started_ms: row.try_get("started_ms")?,
        ended_ms: row.try_get("ended_ms")?,
    })
}

/// Reads the options from the row of a search.
pub(crate) fn options(row: &SqliteRow) -> Result<SearchOptions, StorageError> {
    serde_json::from_str(&row.text("options_json")?).map_err(|_| corrupt_column("options_json"))
}

fn state(row: &SqliteRow) -> Result<SearchState, StorageError> {
    SearchState::from_name(&row.text("state")?).ok_or_else(|| corrupt_column("state"))
}
