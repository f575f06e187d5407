//! Searches as people see them: asked for, listed, paused, resumed, cancelled. Owns the tables `search` and `search_log`
//! together with `search_lease`, which is the workers' side. Every change is a compare-and-set on the state, and counts the epoch
//! up, so that a worker which still has the search is told to leave it.

use std::collections::BTreeMap;

use brood_genome::GenomeHash;
use brood_protocol::{
    FoundMaterial, JobId, LineageId, SearchLine, SearchOptions, SearchState, TargetId,
};
use sqlx::sqlite::SqliteRow;
use sqlx::{Row, SqliteConnection};

use crate::lineage::{self, NewLineage};
use crate::row::{Columns, Key, damaged};
use crate::{Idempotency, StorageError, Store, idempotency};

/// A search to be stored.
#[derive(Debug, Clone, PartialEq)]
pub struct NewSearch {
    /// Its id.
    pub id: JobId,
    /// What is to be matched.
    pub target: TargetId,
    /// Where its results are born.
    pub lineage: LineageId,
    /// That lineage, where it is to be made.
    pub new_lineage: Option<NewLineage>,
    /// How it goes about it.
    pub options: SearchOptions,
    /// The genomes that it starts from, in whatever form the caller reads.
    pub start: Vec<u8>,
    /// When it was asked for, milliseconds since 1970.
    pub created_ms: i64,
    /// The answer to be remembered.
    pub idempotency: Option<Idempotency>,
}

/// A search without its checkpoint.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredSearch {
    /// Its id.
    pub id: JobId,
    /// What is to be matched.
    pub target: TargetId,
    /// Where its results are born.
    pub lineage: LineageId,
    /// Where it stands.
    pub state: SearchState,
    /// Counted up by whatever happens to it.
    pub epoch: u64,
    /// Workers that died over it since it last came forward.
    pub deaths: u32,
    /// Who has it.
    pub worker: Option<String>,
    /// Why it failed.
    pub reason: Option<String>,
    /// Generations so far.
    pub generation: u32,
    /// How often a material has been held against samples.
    pub evaluations: u64,
    /// Time searched.
    pub seconds: f64,
    /// Error of the best where it is fitted.
    pub fitted: Option<f64>,
    /// Error of the best where it is held back.
    pub held: Option<f64>,
    /// Hash of its checkpoint.
    pub population: Option<[u8; 32]>,
    /// How it goes about it.
    pub options: SearchOptions,
    /// The best that was made an individual.
    pub best: Option<FoundMaterial>,
    /// When it was asked for, milliseconds since 1970.
    pub created_ms: i64,
    /// When a worker first had it.
    pub started_ms: Option<i64>,
    /// When it ended.
    pub ended_ms: Option<i64>,
}

/// What somebody wants of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SearchChange {
    /// To wait.
    Pause,
    /// To go on.
    Resume,
    /// To end.
    Cancel,
}

impl SearchChange {
    /// Where it leads, and from where.
    fn way(self) -> (SearchState, &'static [SearchState]) {
        use SearchState::{Cancelled, Paused, Queued, Running};
        match self {
            Self::Pause => (Paused, &[Queued, Running]),
            Self::Resume => (Queued, &[Paused]),
            Self::Cancel => (Cancelled, &[Queued, Running, Paused]),
        }
    }
}

/// The place behind all others.
pub(crate) const LAST_TURN: &str = "(SELECT coalesce(max(turn), 0) + 1 FROM search)";

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
    /// Stores a search that waits for a worker, unless so many wait already: [`StorageError::QueueFull`]. A target or a
    /// lineage that does not exist: [`StorageError::NotFound`].
    pub async fn create_search(&self, new: NewSearch, max_queued: u32) -> Result<(), StorageError> {
        self.write(move |conn| Box::pin(async move { insert(conn, new, max_queued).await })).await
    }

    /// One search.
    pub async fn search(&self, id: JobId) -> Result<StoredSearch, StorageError> {
        fetch(&mut *self.reader().await?, id).await
    }

    /// Searches, newest first, before one of them; only those of a lineage where one is named.
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

    /// Pauses, resumes or cancels a search; where it stands, if it cannot be done from there.
    pub async fn change_search(
        &self,
        id: JobId,
        change: SearchChange,
        now_ms: i64,
    ) -> Result<Result<StoredSearch, SearchState>, StorageError> {
        self.write(move |conn| {
            Box::pin(async move {
                let present = fetch(conn, id).await?;
                let (to, from) = change.way();
                if !from.contains(&present.state) {
                    return Ok(Err(present.state));
                }
                let sql = format!(
                    "UPDATE search SET state = ?1, epoch = epoch + 1, worker = NULL, deaths = 0,
                         ended_ms = ?2, turn = {LAST_TURN}
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

    /// The front of a search that has ended; empty before.
    pub async fn search_front(&self, id: JobId) -> Result<Vec<FoundMaterial>, StorageError> {
        let query = sqlx::query("SELECT front_json FROM search WHERE id = ?").bind(id.key());
        let row = query.fetch_one(&mut *self.reader().await?).await?;
        let json = row.optional_text("front_json")?;
        json.map_or(Ok(Vec::new()), |json| {
            serde_json::from_str(&json).map_err(|_| damaged("front_json"))
        })
    }

    /// Lines of a search's log after a generation, in order.
    pub async fn search_log(
        &self,
        id: JobId,
        after: u32,
        limit: u32,
    ) -> Result<Vec<SearchLine>, StorageError> {
        let rows = sqlx::query(
            "SELECT generation, evaluations, seconds, fitted, held, best_hash FROM search_log
             WHERE search_id = ? AND generation > ? ORDER BY generation LIMIT ?",
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
                seconds: row.real("seconds")?,
                best: match row.optional_blob("best_hash")? {
                    Some(_) => Some(GenomeHash::from_bytes(row.hash("best_hash")?)),
                    None => None,
                },
            })
        };
        rows.iter().map(line).collect()
    }

    /// How many searches there are, by state.
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
         SELECT ?1, id, kind, file_hash, ?2, 'queued', 0, {LAST_TURN}, 0, 0, 0, 0.0, ?3, ?4, ?5
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

/// One search.
pub(crate) async fn fetch(
    conn: &mut SqliteConnection,
    id: JobId,
) -> Result<StoredSearch, StorageError> {
    read(&sqlx::query(BY_ID).bind(id.key()).fetch_one(conn).await?)
}

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
        best: best.map_err(|_| damaged("best_json"))?,
        created_ms: row.integer("created_ms")?,
        started_ms: row.try_get("started_ms")?,
        ended_ms: row.try_get("ended_ms")?,
    })
}

/// How a search goes about it.
pub(crate) fn options(row: &SqliteRow) -> Result<SearchOptions, StorageError> {
    serde_json::from_str(&row.text("options_json")?).map_err(|_| damaged("options_json"))
}

fn state(row: &SqliteRow) -> Result<SearchState, StorageError> {
    SearchState::from_name(&row.text("state")?).ok_or_else(|| damaged("state"))
}
