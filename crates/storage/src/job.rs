//! Render queue: enqueue, claim, complete, fail, release. Owner of the table `job`; each transition
//! is a compare-and-set on id, epoch and state. It reads no clock (leases expire in the server) and
//! does not interpret payloads.
//!
//! Transitions survive the end of the process but not a power loss: then jobs run again, and a
//! repeated job stores one result. A job inserted with a generation is as durable as the
//! generation.

use std::collections::BTreeMap;

use brood_protocol::{JobId, Queue};
use sqlx::SqliteConnection;

use crate::error::{LEASE_ENDED, Result, changed};
use crate::row::{Columns, Key, Record, columns, record, returning, select, signed};
use crate::writer::operation;
use crate::{StorageError, Store};

/// A job is marked dead after this many workers died while running it.
const MAX_DEATHS: i64 = 3;
/// Number of failed and dead jobs that are kept for inspection.
const MAX_KEPT_FAILURES: i64 = 100;

brood_genome::named_enum! {
    /// State of a job. Completed render jobs are deleted.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
    pub enum JobState {
        /// Waiting for a worker.
        Queued => "queued",
        /// Leased to a worker.
        Leased => "leased",
        /// Failed for good.
        Failed => "failed",
        /// Given up: its workers died repeatedly.
        Dead => "dead",
    }
}

columns! {
    String => JobState: |name| Self::from_name(&name);
}

/// Epoch of a job's first lease.
pub const FIRST_EPOCH: u64 = 1;

/// Job to be enqueued.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewJob {
    /// Id of the job.
    pub id: JobId,
    /// Queue of the job.
    pub queue: Queue,
    /// Place in its queue. Jobs are claimed in this order, jobs of one turn in that of their ids.
    pub turn: u64,
    /// Worker that gets the job immediately, with [`FIRST_EPOCH`]; `None` to enqueue it.
    pub leased_to: Option<String>,
    /// Payload; its format is the caller's.
    pub payload: Vec<u8>,
    /// Creation time, in milliseconds since 1970-01-01 UTC.
    pub created_ms: i64,
}

record! {
    /// Job that has just been leased.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct ClaimedJob {
        /// Id of the job.
        pub id: JobId,
        /// Epoch of this lease. Every later transition must name it.
        pub epoch: u64,
        /// Place that it had in its queue.
        pub turn: u64,
        /// Creation time, in milliseconds since 1970-01-01 UTC.
        pub created_ms: i64,
        /// Payload.
        pub payload: Vec<u8>,
    }
}

record! {
    /// Job without its payload.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct StoredJob {
        /// Id of the job.
        pub id: JobId,
        /// Queue of the job.
        pub queue: Queue,
        /// State of the job.
        pub state: JobState,
        /// Number of leases so far.
        pub epoch: u64,
        /// Number of workers that died while running it.
        pub deaths: u32,
        /// Worker that has the lease.
        pub worker: Option<String>,
        /// Reason of a failure.
        pub reason: Option<String>,
        /// Creation time, in milliseconds since 1970-01-01 UTC.
        pub created_ms: i64,
    }
}

/// Number of jobs by queue and state.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct QueueDepth {
    counts: BTreeMap<(Queue, JobState), u64>,
}

impl QueueDepth {
    /// Returns the number of jobs of a queue in a state.
    #[must_use]
    pub fn of(&self, queue: Queue, state: JobState) -> u64 {
        self.counts.get(&(queue, state)).copied().unwrap_or(0)
    }

    /// Returns all numbers that are not 0.
    pub fn iter(&self) -> impl Iterator<Item = (Queue, JobState, u64)> + '_ {
        self.counts.iter().map(|(&(queue, state), &jobs)| (queue, state, jobs))
    }
}

/// Leases the first job of a queue.
const CLAIM: &str = "UPDATE job SET state = 'leased', epoch = epoch + 1, worker = ?1
    WHERE id = (SELECT id FROM job WHERE state = 'queued' AND queue = ?2
                ORDER BY turn, id LIMIT 1)";
/// Parameters: 1 if the worker died, else 0; limit of deaths; id; epoch.
const RELEASE: &str = "UPDATE job SET
        deaths = deaths + ?1,
        state = CASE WHEN deaths + ?1 >= ?2 THEN 'dead' ELSE 'queued' END,
        reason = CASE WHEN deaths + ?1 >= ?2 THEN 'worker_lost' END,
        worker = NULL
    WHERE id = ?3 AND epoch = ?4 AND state = 'leased'
    RETURNING state";
const PRUNE_FAILURES: &str = "DELETE FROM job WHERE state IN ('failed', 'dead') AND id NOT IN (
        SELECT id FROM job WHERE state IN ('failed', 'dead') ORDER BY id DESC LIMIT ?)";

impl Store {
    /// Enqueues a job.
    ///
    /// # Errors
    /// Returns [`StorageError::QueueFull`] if `max_queued` jobs are waiting in its queue.
    pub async fn enqueue(&self, job: NewJob, max_queued: u64) -> Result<()> {
        self.write_relaxed(operation!(|conn| {
            let waiting: i64 =
                sqlx::query_scalar("SELECT count(*) FROM job WHERE state = 'queued' AND queue = ?")
                    .bind(job.queue.name())
                    .fetch_one(&mut *conn)
                    .await?;
            if waiting >= signed(max_queued) {
                return Err(StorageError::QueueFull);
            }
            insert(conn, &job).await
        }))
        .await
    }

    /// Leases the next job of a queue. Returns `None` if none is queued.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the write fails.
    pub async fn claim(&self, worker: &str, queue: Queue) -> Result<Option<ClaimedJob>> {
        let worker = worker.to_owned();
        self.write_relaxed(operation!(|conn| {
            let query = returning::<ClaimedJob>(CLAIM).bind(worker).bind(queue.name());
            query.fetch_optional(conn).await?.map(|row| ClaimedJob::read(&row)).transpose()
        }))
        .await
    }

    /// Completes a leased job and deletes it.
    ///
    /// # Errors
    /// Returns [`StorageError::Conflict`] if the epoch is stale.
    pub async fn complete(&self, id: JobId, epoch: u64) -> Result<()> {
        self.write_relaxed(operation!(|conn| {
            let query =
                sqlx::query("DELETE FROM job WHERE id = ? AND epoch = ? AND state = 'leased'");
            let query = query.bind(id.key()).bind(signed(epoch));
            changed(&query.execute(conn).await?, LEASE_ENDED)
        }))
        .await
    }

    /// Marks a leased job as failed.
    ///
    /// # Errors
    /// Returns [`StorageError::Conflict`] if the epoch is stale.
    pub async fn fail(&self, id: JobId, epoch: u64, reason: &str) -> Result<()> {
        let reason = reason.to_owned();
        self.write_relaxed(operation!(|conn| {
            let done = sqlx::query(
                "UPDATE job SET state = 'failed', reason = ?, worker = NULL
                 WHERE id = ? AND epoch = ? AND state = 'leased'",
            )
            .bind(reason)
            .bind(id.key())
            .bind(signed(epoch))
            .execute(&mut *conn)
            .await?;
            changed(&done, LEASE_ENDED)?;
            prune_failures(conn).await
        }))
        .await
    }

    /// Returns a leased job to the front of its queue. After the death of the third worker it
    /// becomes dead instead. Returns the new state.
    ///
    /// # Errors
    /// Returns [`StorageError::Conflict`] if the epoch is stale.
    pub async fn release(&self, id: JobId, epoch: u64, worker_died: bool) -> Result<JobState> {
        self.write_relaxed(operation!(|conn| {
            let row = sqlx::query(RELEASE)
                .bind(i64::from(worker_died))
                .bind(MAX_DEATHS)
                .bind(id.key())
                .bind(signed(epoch))
                .fetch_optional(&mut *conn)
                .await?
                .ok_or(LEASE_ENDED)?;
            prune_failures(conn).await?;
            row.column("state")
        }))
        .await
    }

    /// Returns all leased jobs to their queues, at the start of the server, when all leases of the
    /// previous run are void, and lets the jobs of all clients begin with the same turn. Returns
    /// the number of jobs that were leased.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the write fails.
    pub async fn requeue_all_leased(&self) -> Result<u64> {
        self.write_relaxed(operation!(|conn| {
            sqlx::query("UPDATE job SET turn = 0 WHERE turn > 0").execute(&mut *conn).await?;
            let sql = "UPDATE job SET state = 'queued', worker = NULL WHERE state = 'leased'";
            Ok(sqlx::query(sql).execute(conn).await?.rows_affected())
        }))
        .await
    }

    /// True if a job waits in a queue. Cheaper than a claim, which writes.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn any_queued(&self, queue: Queue) -> Result<bool> {
        let sql = "SELECT EXISTS (SELECT 1 FROM job WHERE state = 'queued' AND queue = ?)";
        let query = sqlx::query_scalar(sql).bind(queue.name());
        Ok(query.fetch_one(&mut *self.reader().await?).await?)
    }

    /// True if at least `most` jobs of a queue wait for a worker.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn is_queue_full(&self, queue: Queue, most: u64) -> Result<bool> {
        let sql = "SELECT EXISTS (SELECT 1 FROM job WHERE state = 'queued' AND queue = ? \
                   LIMIT 1 OFFSET ?)";
        let query = sqlx::query_scalar(sql).bind(queue.name()).bind(signed(most) - 1);
        Ok(query.fetch_one(&mut *self.reader().await?).await?)
    }

    /// Returns the creation time of the oldest job that waits in a queue, in milliseconds since
    /// 1970-01-01 UTC.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn oldest_queued_ms(&self, queue: Queue) -> Result<Option<i64>> {
        let sql = "SELECT min(created_ms) FROM job WHERE state = 'queued' AND queue = ?";
        let query = sqlx::query_scalar(sql).bind(queue.name());
        Ok(query.fetch_one(&mut *self.reader().await?).await?)
    }

    /// Returns the number of jobs by queue and state.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn queue_depth(&self) -> Result<QueueDepth> {
        let rows =
            sqlx::query("SELECT queue, state, count(*) AS jobs FROM job GROUP BY state, queue")
                .fetch_all(&mut *self.reader().await?)
                .await?;
        let mut counts = BTreeMap::new();
        for row in rows {
            counts.insert((row.column("queue")?, row.column("state")?), row.column("jobs")?);
        }
        Ok(QueueDepth { counts })
    }

    /// Returns a job.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if there is no such job or it has completed.
    pub async fn job(&self, id: JobId) -> Result<StoredJob> {
        let query = select::<StoredJob>("FROM job WHERE id = ?").bind(id.key());
        StoredJob::read(&query.fetch_one(&mut *self.reader().await?).await?)
    }
}

/// Inserts a job without checking the length of the queue.
pub(crate) async fn insert(conn: &mut SqliteConnection, job: &NewJob) -> Result<()> {
    let (state, epoch) = match job.leased_to {
        Some(_) => (JobState::Leased, FIRST_EPOCH),
        None => (JobState::Queued, 0),
    };
    sqlx::query(
        "INSERT INTO job (id, kind, queue, turn, state, epoch, worker, created_ms, payload)
         VALUES (?, 'render', ?, ?, ?, ?, ?, ?, ?)",
    )
    .bind(job.id.key())
    .bind(job.queue.name())
    .bind(signed(job.turn))
    .bind(state.name())
    .bind(signed(epoch))
    .bind(job.leased_to.as_deref())
    .bind(job.created_ms)
    .bind(job.payload.as_slice())
    .execute(conn)
    .await?;
    Ok(())
}

/// Deletes all failed and dead jobs except the newest [`MAX_KEPT_FAILURES`].
async fn prune_failures(conn: &mut SqliteConnection) -> Result<()> {
    sqlx::query(PRUNE_FAILURES).bind(MAX_KEPT_FAILURES).execute(conn).await?;
    Ok(())
}
