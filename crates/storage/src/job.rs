//! The work queue: enqueueing, leasing, finishing. Owns the table `job` and its transitions, each a compare-and-set on
//! id, epoch and state; refuses to know clocks (leases expire elsewhere) and what a payload says.
//!
//! Transitions survive the death of the process but not the loss of power: what a power cut undoes is done again, and
//! doing a job twice stores one result. Jobs written with a generation are as durable as the generation.

use std::collections::BTreeMap;
use std::sync::atomic::Ordering;

use brood_protocol::JobId;
use sqlx::{Row, SqliteConnection};

use crate::row::{Columns, Key, damaged, signed};
use crate::{StorageError, Store};

/// One claim in so many looks at the batch queue first, so that people never starve searches altogether.
const BATCH_TURN: u64 = 8;
/// A job that has seen so many workers die is not given to another one.
const MAX_DEATHS: i64 = 3;
/// Failed and dead jobs are kept for a look at them; this many.
const KEPT_FAILURES: i64 = 100;

macro_rules! words {
    ($(#[$doc:meta])* $name:ident, $column:literal { $($(#[$case_doc:meta])* $case:ident = $word:literal),* $(,)? }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum $name {
            $($(#[$case_doc])* $case,)*
        }

        impl $name {
            /// The word in the table and in metrics.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$case => $word,)*
                }
            }

            fn read(word: &str) -> Result<Self, StorageError> {
                match word {
                    $($word => Ok(Self::$case),)*
                    _ => Err(damaged($column)),
                }
            }
        }
    };
}

words! {
    /// What is to be done.
    JobKind, "kind" {
        /// Pictures of programs.
        Render = "render",
    }
}

words! {
    /// Who waits for it.
    Queue, "queue" {
        /// A person.
        Interactive = "interactive",
        /// A script or a search.
        Batch = "batch",
    }
}

words! {
    /// Where a job stands. A finished render job is not kept.
    JobState, "state" {
        /// Waiting for a worker.
        Queued = "queued",
        /// In a worker's hands.
        Leased = "leased",
        /// It cannot be done.
        Failed = "failed",
        /// Too many workers died of it.
        Dead = "dead",
    }
}

/// The epoch of a job's first lease.
pub const FIRST_EPOCH: u64 = 1;

/// A job to be enqueued.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewJob {
    /// Its id; within a queue, lower ids go first.
    pub id: JobId,
    /// What is to be done.
    pub kind: JobKind,
    /// Who waits for it.
    pub queue: Queue,
    /// The worker that has it from the start, under [`FIRST_EPOCH`]; none where it waits in its queue.
    pub leased_to: Option<String>,
    /// The work, in whatever form the caller reads.
    pub payload: Vec<u8>,
    /// When it was made, milliseconds since 1970.
    pub created_ms: i64,
}

/// A job that was just leased.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClaimedJob {
    /// Its id.
    pub id: JobId,
    /// Counted up by each lease; to be named in every later word about it.
    pub epoch: u64,
    /// What is to be done.
    pub kind: JobKind,
    /// When it was made, milliseconds since 1970.
    pub created_ms: i64,
    /// The work.
    pub payload: Vec<u8>,
}

/// A job without its payload.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct JobRow {
    /// Its id.
    pub id: JobId,
    /// What is to be done.
    pub kind: JobKind,
    /// Who waits for it.
    pub queue: Queue,
    /// Where it stands.
    pub state: JobState,
    /// How often it was leased.
    pub epoch: u64,
    /// How many workers died of it.
    pub deaths: u32,
    /// Who has it.
    pub worker: Option<String>,
    /// Why it failed.
    pub reason: Option<String>,
    /// When it was made, milliseconds since 1970.
    pub created_ms: i64,
}

/// Jobs by queue and state.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct QueueDepth {
    counts: BTreeMap<(Queue, JobState), u64>,
}

impl QueueDepth {
    /// How many jobs of a queue are in a state.
    #[must_use]
    pub fn of(&self, queue: Queue, state: JobState) -> u64 {
        self.counts.get(&(queue, state)).copied().unwrap_or(0)
    }

    /// All that are not 0.
    pub fn iter(&self) -> impl Iterator<Item = (Queue, JobState, u64)> + '_ {
        self.counts.iter().map(|(&(queue, state), &jobs)| (queue, state, jobs))
    }
}

const CLAIM: &str = "UPDATE job SET state = 'leased', epoch = epoch + 1, worker = ?1
    WHERE id = (SELECT id FROM job WHERE state = 'queued' AND queue = ?2 ORDER BY id LIMIT 1)
    RETURNING id, epoch, kind, created_ms, payload";
const RELEASE: &str = "UPDATE job SET
        deaths = deaths + ?1,
        state = CASE WHEN deaths + ?1 >= ?2 THEN 'dead' ELSE 'queued' END,
        reason = CASE WHEN deaths + ?1 >= ?2 THEN 'worker_lost' END,
        worker = NULL
    WHERE id = ?3 AND epoch = ?4 AND state = 'leased'
    RETURNING state";
const FORGET_FAILURES: &str = "DELETE FROM job WHERE state IN ('failed', 'dead') AND id NOT IN (
        SELECT id FROM job WHERE state IN ('failed', 'dead') ORDER BY id DESC LIMIT ?)";

impl Store {
    /// Enqueues a job unless its queue holds `max_queued` that wait: then [`StorageError::QueueFull`].
    pub async fn enqueue(&self, job: NewJob, max_queued: u64) -> Result<(), StorageError> {
        self.write_relaxed(move |conn| {
            Box::pin(async move {
                let waiting: i64 = sqlx::query_scalar(
                    "SELECT count(*) FROM job WHERE state = 'queued' AND queue = ?",
                )
                .bind(job.queue.name())
                .fetch_one(&mut *conn)
                .await?;
                if waiting >= signed(max_queued) {
                    return Err(StorageError::QueueFull);
                }
                insert(conn, &job).await
            })
        })
        .await
    }

    /// Leases the next job: interactive ones first, except that each eighth grant tries the batch queue first.
    pub async fn claim(&self, worker: &str) -> Result<Option<ClaimedJob>, StorageError> {
        let worker = worker.to_owned();
        let turn = self.claims().load(Ordering::Relaxed) % BATCH_TURN;
        let queues = if turn == BATCH_TURN - 1 {
            [Queue::Batch, Queue::Interactive]
        } else {
            [Queue::Interactive, Queue::Batch]
        };
        let claimed = self
            .write_relaxed(move |conn| {
                Box::pin(async move {
                    for queue in queues {
                        let query = sqlx::query(CLAIM).bind(worker.as_str()).bind(queue.name());
                        if let Some(row) = query.fetch_optional(&mut *conn).await? {
                            return Ok(Some(ClaimedJob {
                                id: row.id("id")?,
                                epoch: row.whole("epoch")?,
                                kind: JobKind::read(&row.text("kind")?)?,
                                created_ms: row.integer("created_ms")?,
                                payload: row.blob("payload")?,
                            }));
                        }
                    }
                    Ok(None)
                })
            })
            .await?;
        if claimed.is_some() {
            self.claims().fetch_add(1, Ordering::Relaxed);
        }
        Ok(claimed)
    }

    /// A leased job is done. A stale epoch changes nothing: [`StorageError::Conflict`].
    pub async fn complete(&self, id: JobId, epoch: u64) -> Result<(), StorageError> {
        self.write_relaxed(move |conn| {
            Box::pin(async move {
                let query =
                    sqlx::query("DELETE FROM job WHERE id = ? AND epoch = ? AND state = 'leased'");
                let query = query.bind(id.key()).bind(signed(epoch));
                changed(query.execute(conn).await?.rows_affected())
            })
        })
        .await
    }

    /// A leased job cannot be done. A stale epoch changes nothing: [`StorageError::Conflict`].
    pub async fn fail(&self, id: JobId, epoch: u64, reason: &str) -> Result<(), StorageError> {
        let reason = reason.to_owned();
        self.write_relaxed(move |conn| {
            Box::pin(async move {
                let done = sqlx::query(
                    "UPDATE job SET state = 'failed', reason = ?, worker = NULL
                     WHERE id = ? AND epoch = ? AND state = 'leased'",
                )
                .bind(reason)
                .bind(id.key())
                .bind(signed(epoch))
                .execute(&mut *conn)
                .await?;
                changed(done.rows_affected())?;
                forget_failures(conn).await
            })
        })
        .await
    }

    /// A leased job comes back undone, to the front of its queue. The third worker's death makes it dead. A stale epoch
    /// changes nothing: [`StorageError::Conflict`]. Returns where it stands now.
    pub async fn release(
        &self,
        id: JobId,
        epoch: u64,
        worker_died: bool,
    ) -> Result<JobState, StorageError> {
        self.write_relaxed(move |conn| {
            Box::pin(async move {
                let row = sqlx::query(RELEASE)
                    .bind(i64::from(worker_died))
                    .bind(MAX_DEATHS)
                    .bind(id.key())
                    .bind(signed(epoch))
                    .fetch_optional(&mut *conn)
                    .await?
                    .ok_or(STALE)?;
                forget_failures(conn).await?;
                JobState::read(&row.text("state")?)
            })
        })
        .await
    }

    /// Puts all leased jobs back: for the start, when no lease of the last run holds any more. Returns how many.
    pub async fn requeue_all_leased(&self) -> Result<u64, StorageError> {
        self.write_relaxed(move |conn| {
            Box::pin(async move {
                let sql = "UPDATE job SET state = 'queued', worker = NULL WHERE state = 'leased'";
                Ok(sqlx::query(sql).execute(conn).await?.rows_affected())
            })
        })
        .await
    }

    /// Whether a job waits for a worker. Reading is cheaper than a claim, which writes.
    pub async fn any_queued(&self) -> Result<bool, StorageError> {
        let query = sqlx::query_scalar("SELECT EXISTS (SELECT 1 FROM job WHERE state = 'queued')");
        Ok(query.fetch_one(&mut *self.reader().await?).await?)
    }

    /// When the job that waits longest was made, in milliseconds since 1970.
    pub async fn oldest_queued_ms(&self) -> Result<Option<i64>, StorageError> {
        let query = sqlx::query_scalar("SELECT min(created_ms) FROM job WHERE state = 'queued'");
        Ok(query.fetch_one(&mut *self.reader().await?).await?)
    }

    /// How many jobs there are.
    pub async fn queue_depth(&self) -> Result<QueueDepth, StorageError> {
        let rows =
            sqlx::query("SELECT queue, state, count(*) AS jobs FROM job GROUP BY state, queue")
                .fetch_all(&mut *self.reader().await?)
                .await?;
        let mut counts = BTreeMap::new();
        for row in rows {
            let queue = Queue::read(&row.text("queue")?)?;
            let state = JobState::read(&row.text("state")?)?;
            counts.insert((queue, state), row.whole("jobs")?);
        }
        Ok(QueueDepth { counts })
    }

    /// A job that is not finished.
    pub async fn job(&self, id: JobId) -> Result<JobRow, StorageError> {
        let row = sqlx::query(
            "SELECT id, kind, queue, state, epoch, deaths, worker, reason, created_ms
             FROM job WHERE id = ?",
        )
        .bind(id.key())
        .fetch_one(&mut *self.reader().await?)
        .await?;
        Ok(JobRow {
            id: row.id("id")?,
            kind: JobKind::read(&row.text("kind")?)?,
            queue: Queue::read(&row.text("queue")?)?,
            state: JobState::read(&row.text("state")?)?,
            epoch: row.whole("epoch")?,
            deaths: row.whole("deaths")?,
            worker: row.try_get("worker")?,
            reason: row.try_get("reason")?,
            created_ms: row.integer("created_ms")?,
        })
    }
}

const STALE: StorageError = StorageError::Conflict { what: "the lease" };

fn changed(rows: u64) -> Result<(), StorageError> {
    if rows == 0 { Err(STALE) } else { Ok(()) }
}

/// Stores a job without looking at how many wait.
pub(crate) async fn insert(conn: &mut SqliteConnection, job: &NewJob) -> Result<(), StorageError> {
    let (state, epoch) = match job.leased_to {
        Some(_) => (JobState::Leased, FIRST_EPOCH),
        None => (JobState::Queued, 0),
    };
    sqlx::query(
        "INSERT INTO job (id, kind, queue, state, epoch, worker, created_ms, payload)
         VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
    )
    .bind(job.id.key())
    .bind(job.kind.name())
    .bind(job.queue.name())
    .bind(state.name())
    .bind(signed(epoch))
    .bind(job.leased_to.as_deref())
    .bind(job.created_ms)
    .bind(job.payload.as_slice())
    .execute(conn)
    .await?;
    Ok(())
}

async fn forget_failures(conn: &mut SqliteConnection) -> Result<(), StorageError> {
    sqlx::query(FORGET_FAILURES).bind(KEPT_FAILURES).execute(conn).await?;
    Ok(())
}
