//! Searches as users see them: create, list, pause, resume, cancel.
//!
//! The tables `search` and `search_log` are written only here and in `search_lease`, the workers'
//! side. A change by a user checks the state and updates it in one transaction. It increments the
//! epoch, the version number of a search, which ends a worker's lease: a lease is valid for one
//! epoch only.

use std::collections::BTreeMap;

use brood_protocol::{
    FoundMaterial, JobId, Lineage, LineageId, MaterialSpread, SearchLine, SearchOptions,
    SearchState, TargetId,
};

use crate::column::{Key, optional_key};
use crate::error::{Result, changed};
use crate::lineage;
use crate::row::{Record, record, select};
use crate::sql::{Conn, query};
use crate::write::operation;
use crate::{Idempotency, StorageError, Store, idempotency};

/// Search to be stored.
#[derive(Debug, Clone, PartialEq)]
pub struct NewSearch {
    /// Id of the search, and of its first island.
    pub id: JobId,
    /// Ids of the other islands, in their order; each after that of the search.
    pub islands: Vec<JobId>,
    /// Id of the target.
    pub target: TargetId,
    /// Lineage to which found materials are added.
    pub lineage: LineageId,
    /// Data of `lineage`, if it is to be created together with the search.
    pub new_lineage: Option<Lineage>,
    /// Options of the search.
    pub options: SearchOptions,
    /// Genomes to start from, encoded by the caller; stored as they are.
    pub start: Vec<u8>,
    /// Creation time, in milliseconds since 1970-01-01 UTC.
    pub created_ms: i64,
    /// Idempotency record to be stored with the search.
    pub idempotency: Option<Idempotency>,
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

/// Picture of the materials that match a search's target about as well as the best.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extreme {
    /// 5 % quantile of each pixel.
    Darkest,
    /// 95 % quantile.
    Brightest,
}

record! {
    /// Search, or one of several islands of it, without its checkpoint.
    #[derive(Debug, Clone, PartialEq)]
    pub struct StoredSearch {
        /// Id of the search, or of the island.
        pub id: JobId,
        /// Id of the search, if this is another island than its first.
        pub parent: Option<JobId> = "parent_id",
        /// Number of the island, from 0.
        pub island: u32,
        /// True if this island has ended, and others have not.
        pub is_over: bool = "found IS NOT NULL",
        /// Id of the target.
        pub target: TargetId = "target_id",
        /// Lineage to which found materials are added.
        pub lineage: LineageId = "lineage_id",
        /// State of the search.
        pub state: SearchState,
        /// Epoch: version number, incremented by every change except a step (a worker's report of
        /// progress) that keeps the lease.
        pub epoch: u64,
        /// Consecutive worker deaths since the last checkpoint.
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
        /// E_log of the best candidate on the validation samples: not fitted, but used to select
        /// it.
        pub held: Option<f64>,
        /// Validation error of the best material that is an individual.
        pub recorded: Option<f64>,
        /// Hash of the checkpoint.
        pub population: Option<[u8; 32]>,
        /// Options of the search.
        pub options: SearchOptions = "options_json",
        /// Best material that has been added to the lineage as an individual.
        pub best: Option<FoundMaterial> = "best_json",
        /// Creation time, in milliseconds since 1970-01-01 UTC.
        pub created_ms: i64,
        /// Time of the first lease, in milliseconds since 1970-01-01 UTC.
        pub started_ms: Option<i64>,
        /// Time of the end, in milliseconds since 1970-01-01 UTC.
        pub ended_ms: Option<i64>,
    }
}

impl StoredSearch {
    /// Id of the search of which this is an island.
    #[must_use]
    pub fn search_id(&self) -> JobId {
        self.parent.unwrap_or(self.id)
    }

    /// Id of the search, if it has several islands.
    #[must_use]
    pub fn archipelago(&self) -> Option<JobId> {
        (self.options.islands > 1).then(|| self.search_id())
    }
}

record!(SearchLine {
    generation,
    evaluations,
    fitted,
    held,
    median,
    diversity,
    repeats,
    seconds,
    best = "best_hash",
});

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

impl Store {
    /// Stores a search at the end of the queue.
    ///
    /// # Errors
    /// Returns [`StorageError::QueueFull`] if `max_queued` searches are queued,
    /// [`StorageError::NotFound`] if the target or the lineage does not exist.
    pub async fn create_search(&self, new: NewSearch, max_queued: u32) -> Result<()> {
        self.write(operation!(|conn| insert(conn, new, max_queued).await)).await
    }

    /// Returns the islands of a search, in their order: mostly one, the search itself.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if the search does not exist.
    pub async fn islands(&self, search: JobId) -> Result<Vec<StoredSearch>> {
        let query = select::<StoredSearch>(
            "FROM search WHERE id = ?1 AND parent_id IS NULL OR parent_id = ?1 ORDER BY island",
        );
        let rows = query.bind(search.key()).fetch_all(&mut self.reader().await?).await?;
        if rows.is_empty() {
            return Err(StorageError::NotFound);
        }
        rows.iter().map(StoredSearch::read).collect()
    }

    /// Returns a search, or one of several islands of it.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if it does not exist.
    pub async fn search(&self, id: JobId) -> Result<StoredSearch> {
        fetch(&mut self.reader().await?, id).await
    }

    /// Lists up to `limit` searches, the newest first, with the row of the first island of each. If
    /// given, `before` restricts the list to searches older than it, and `lineage` to searches of
    /// that lineage.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn list_searches(
        &self,
        before: Option<JobId>,
        lineage: Option<LineageId>,
        limit: u32,
    ) -> Result<Vec<StoredSearch>> {
        let query = select::<StoredSearch>(
            "FROM search
             WHERE parent_id IS NULL AND (?1 IS NULL OR id < ?1)
                 AND (?2 IS NULL OR lineage_id = ?2)
             ORDER BY id DESC LIMIT ?3",
        );
        let query = query.bind(optional_key(before)).bind(optional_key(lineage)).bind(limit);
        query.fetch_all(&mut self.reader().await?).await?.iter().map(StoredSearch::read).collect()
    }

    /// Pauses, resumes or cancels a search with all of its islands. Stores the idempotency record
    /// of the request. Returns the changed row of the first island. The inner error is the current
    /// state if it does not allow the change.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if the search does not exist, [`StorageError::Conflict`]
    /// if the idempotency key is in use.
    pub async fn change_search(
        &self,
        id: JobId,
        change: SearchChange,
        idempotency: Option<Idempotency>,
        now_ms: i64,
    ) -> Result<Result<StoredSearch, SearchState>> {
        self.write(operation!(|conn| {
            let present = select::<StoredSearch>(
                "FROM search WHERE id = ? AND parent_id IS NULL /*pg: FOR UPDATE*/",
            );
            let present = StoredSearch::read(&present.bind(id.key()).fetch_one(conn).await?)?;
            let (to, from) = change.transition();
            if !from.contains(&present.state) {
                return Ok(Err(present.state));
            }
            let sql = format!(
                "UPDATE search SET state = ?1, epoch = epoch + 1, worker = NULL,
                     lease_until_ms = NULL, deaths = 0, ended_ms = ?2, turn = {NEXT_TURN}
                 WHERE id = ?3 OR parent_id = ?3"
            );
            query(sql)
                .bind(to.name())
                .bind(to.is_final().then_some(now_ms))
                .bind(id.key())
                .execute(conn)
                .await?;
            if to.is_final() && present.archipelago().is_some() {
                forget_islands(conn, id).await?;
            }
            idempotency::insert(conn, idempotency.as_ref(), now_ms).await?;
            Ok(Ok(fetch(conn, id).await?))
        }))
        .await
    }

    /// Returns the front of a search: the best material, then shorter and less accurate ones. It is
    /// empty until the search has ended.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if the search does not exist.
    pub async fn search_front(&self, id: JobId) -> Result<Vec<FoundMaterial>> {
        let query = query("SELECT front_json FROM search WHERE id = ?").bind(id.key());
        let row = query.fetch_one(&mut self.reader().await?).await?;
        Ok(row.column::<Option<_>>("front_json")?.unwrap_or_default())
    }

    /// Stores the spread of a search, with the darkest and the brightest picture as PNG.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the write fails.
    pub async fn set_search_spread(
        &self,
        id: JobId,
        spread: &MaterialSpread,
        pictures: [&[u8]; 2],
    ) -> Result<()> {
        let json = serde_json::to_string(spread).expect("a spread is plain data");
        let [darkest, brightest] = pictures.map(<[u8]>::to_vec);
        self.write(operation!(|conn| {
            let update = query(
                "UPDATE search SET spread_json = ?, darkest_png = ?, brightest_png = ? WHERE id = ?",
            );
            let update = update.bind(json).bind(darkest).bind(brightest);
            update.bind(id.key()).execute(conn).await?;
            Ok(())
        }))
        .await
    }

    /// Returns the spread of a search; `None` until it has ended, and if its strategy has none.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if the search does not exist.
    pub async fn search_spread(&self, id: JobId) -> Result<Option<MaterialSpread>> {
        let query = query("SELECT spread_json FROM search WHERE id = ?").bind(id.key());
        let row = query.fetch_one(&mut self.reader().await?).await?;
        row.column("spread_json")
    }

    /// Returns the darkest or the brightest that the material of a search could be, as PNG; `None`
    /// if the search has no spread, and if it ended in a version without these pictures.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if the search does not exist.
    pub async fn search_extreme(&self, id: JobId, extreme: Extreme) -> Result<Option<Vec<u8>>> {
        let sql = match extreme {
            Extreme::Darkest => "SELECT darkest_png AS png FROM search WHERE id = ?",
            Extreme::Brightest => "SELECT brightest_png AS png FROM search WHERE id = ?",
        };
        let row = query(sql).bind(id.key()).fetch_one(&mut self.reader().await?).await?;
        row.column("png")
    }

    /// Returns up to `limit` log lines of a search, one per generation, from generation `after` + 1
    /// on.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn search_log(&self, id: JobId, after: u32, limit: u32) -> Result<Vec<SearchLine>> {
        let query = select::<SearchLine>(
            "FROM search_log WHERE search_id = ? AND generation > ? ORDER BY generation LIMIT ?",
        );
        let query = query.bind(id.key()).bind(after).bind(limit);
        query.fetch_all(&mut self.reader().await?).await?.iter().map(SearchLine::read).collect()
    }

    /// Returns the number of searches in each state, by its name.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn search_counts(&self) -> Result<BTreeMap<&'static str, u64>> {
        let states = SearchState::ALL.into_iter().map(SearchState::name);
        let sql = "SELECT state, count(*) AS jobs FROM (
                SELECT coalesce(max(CASE WHEN state = 'running' THEN state END),
                    max(CASE WHEN parent_id IS NULL THEN state END)) AS state
                FROM search GROUP BY coalesce(parent_id, id)) AS searches
            GROUP BY state";
        self.state_counts(sql, states).await
    }

    /// Counts the jobs in each of some states by a query of `state` and `jobs`.
    pub(crate) async fn state_counts(
        &self,
        sql: &'static str,
        states: impl Iterator<Item = &'static str>,
    ) -> Result<BTreeMap<&'static str, u64>> {
        let mut counts: BTreeMap<_, _> = states.map(|state| (state, 0)).collect();
        for row in query(sql).fetch_all(&mut self.reader().await?).await? {
            let state: String = row.column("state")?;
            if let Some(count) = counts.get_mut(state.as_str()) {
                *count = row.column("jobs")?;
            }
        }
        Ok(counts)
    }
}

/// Inserts a search, with its lineage and idempotency record if they are given.
async fn insert(conn: &mut Conn, new: NewSearch, max_queued: u32) -> Result<()> {
    idempotency::insert(conn, new.idempotency.as_ref(), new.created_ms).await?;
    let waiting = "SELECT count(*) FROM search WHERE state = 'queued' AND parent_id IS NULL";
    let waiting = query(waiting);
    let waiting: u32 = waiting.fetch_value(conn).await?;
    if waiting >= max_queued {
        return Err(StorageError::QueueFull);
    }
    if let Some(new_lineage) = &new.new_lineage {
        lineage::insert(conn, new_lineage).await?;
    }
    let options = serde_json::to_string(&new.options).expect("options are plain data");
    let sql = format!(
        "INSERT INTO search (id, target_id, target_kind, target_hash, lineage_id, state, epoch,
             turn, deaths, generation, evaluations, seconds, created_ms, options_json, start,
             parent_id, island, previous_id)
         SELECT ?1, id, kind, file_hash, ?2, 'queued', 0, {NEXT_TURN}, 0, 0, 0, 0.0, ?3, ?4, ?5,
             ?7, ?8, ?9
         FROM target WHERE id = ?6 /*pg: FOR KEY SHARE*/"
    );
    let ids: Vec<JobId> = std::iter::once(new.id).chain(new.islands).collect();
    for (island, id) in (0_u32..).zip(&ids) {
        let previous = ids[(island as usize + ids.len() - 1) % ids.len()];
        let done = query(sql.clone())
            .bind(id.key())
            .bind(new.lineage.key())
            .bind(new.created_ms)
            .bind(options.as_str())
            .bind(new.start.as_slice())
            .bind(new.target.key())
            .bind(optional_key((island > 0).then_some(new.id)))
            .bind(island)
            .bind(optional_key((ids.len() > 1).then_some(previous)))
            .execute(conn)
            .await?;
        changed(done, StorageError::NotFound)?;
    }
    Ok(())
}

/// Reads the search with this id.
pub(crate) async fn fetch(conn: &mut Conn, id: JobId) -> Result<StoredSearch> {
    let query = select::<StoredSearch>("FROM search WHERE id = ?").bind(id.key());
    StoredSearch::read(&query.fetch_one(conn).await?)
}

/// Removes the migrants and the separate fronts of the islands of a search that has ended.
pub(crate) async fn forget_islands(conn: &mut Conn, search: JobId) -> Result<()> {
    for sql in [
        "DELETE FROM migrant WHERE search_id IN
             (SELECT id FROM search WHERE id = ?1 OR parent_id = ?1)",
        "UPDATE search SET found = NULL WHERE (id = ?1 OR parent_id = ?1) AND found IS NOT NULL",
    ] {
        query(sql).bind(search.key()).execute(conn).await?;
    }
    Ok(())
}
