//! Leases of searches and exports, in the rows of the jobs, so that a worker may renew its lease
//! through any server and any server ends the leases that have expired.
//!
//! A lease is valid for one epoch of its job and ends at a time of the database's clock: that of
//! PostgreSQL, or the [steady clock](crate::clock) of the one process that has opened a SQLite
//! file. Clocks of servers and workers are not compared.
//!
//! While the database cannot be written, no lease can be renewed:
//! [`lease_fault`](crate::lease_fault) keeps that from counting as a death of all workers.

use std::time::Duration;

use brood_protocol::JobId;

use crate::clock::steady_ms;
use crate::column::Key;
use crate::error::{LEASE_ENDED, Result, changed};
use crate::lease_fault::{FORGIVEN, RENEWAL};
use crate::row::{Record, record, select, signed};
use crate::sql::{Conn, Query, query};
use crate::write::{WriteFuture, operation};
use crate::{StorageError, Store};

/// A job fails after this many consecutive deaths of its workers without a checkpoint or a file. A
/// long search must not fail because its machine runs out of memory once a day.
const MAX_DEATHS: i64 = 3;

/// Longer than any lease.
const LONGEST_MS: i64 = 120_000;

/// Table of jobs that are leased.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LeasedTable {
    Search,
    Export,
}

impl LeasedTable {
    fn name(self) -> &'static str {
        match self {
            Self::Search => "search",
            Self::Export => "export",
        }
    }
}

record! {
    /// Lease that has ended.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct EndedLease {
        /// Id of the job.
        pub id: JobId,
        /// Epoch of the lease.
        pub epoch: u64,
        /// Name of the worker.
        pub worker: String,
    }
}

/// Selection of leases that end without a report.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LostLeases {
    /// Those that were not renewed in time.
    Expired,
    /// Those of a worker that has died.
    OfWorker(String),
    /// Those of a worker that was stopped, which is no death.
    OfStopped(String),
    /// All leases in a SQLite file, when its process starts or stops; no worker has died. None on
    /// PostgreSQL, where workers may renew them through another server.
    OfProcess,
}

/// Returns SQL for the time by the database's clock, in milliseconds since 1970-01-01 UTC. `number`
/// is that of a value to which [`steady_ms`] is bound; PostgreSQL does not read it.
pub(crate) fn now(number: u8) -> String {
    format!(
        "/*pg: coalesce((extract(epoch FROM clock_timestamp()) * 1000)::BIGINT,*/ ?{number} \
         /*pg: )*/"
    )
}

/// Returns a time to live as it is bound to a statement, in milliseconds.
pub(crate) fn ttl_ms(ttl: Duration) -> i64 {
    i64::try_from(ttl.as_millis()).unwrap_or(i64::MAX)
}

/// Renews a lease.
///
/// # Errors
/// Returns [`StorageError::Conflict`](crate::StorageError::Conflict) if it is not valid any more.
pub(crate) async fn renew(
    store: &Store,
    table: LeasedTable,
    (id, epoch): (JobId, u64),
    ttl: Duration,
) -> Result<()> {
    let sql = format!(
        "UPDATE {} SET lease_until_ms = {} + ?2 WHERE id = ?3 AND epoch = ?4 AND state = 'running'",
        table.name(),
        now(1)
    );
    let renewed = store.write_relaxed(operation!(|conn| {
        let renewal = query(sql).bind(steady_ms()).bind(ttl_ms(ttl));
        let renewal = renewal.bind(id.key()).bind(signed(epoch));
        changed(renewal.execute(conn).await?, LEASE_ENDED)
    }));
    let renewed = renewed.await;
    store.lease_faults().note(&renewed);
    renewed
}

/// Returns a leased job to its queue. It fails instead if its worker has died, as did those of the
/// leases before.
///
/// # Errors
/// Returns [`StorageError::Conflict`](crate::StorageError::Conflict) if the lease is not valid any
/// more.
pub(crate) async fn release(
    conn: &mut Conn,
    table: LeasedTable,
    (id, epoch): (JobId, u64),
    died: bool,
    now_ms: i64,
) -> Result<()> {
    let sql = format!(
        "UPDATE {} SET
             deaths = deaths + ?1,
             epoch = epoch + 1,
             state = CASE WHEN deaths + ?1 >= ?2 THEN 'failed' ELSE 'queued' END,
             reason = CASE WHEN deaths + ?1 >= ?2 THEN 'worker_lost' END,
             ended_ms = CASE WHEN deaths + ?1 >= ?2 THEN ?3 END,
             worker = NULL,
             lease_until_ms = NULL
         WHERE id = ?4 AND epoch = ?5 AND state = 'running'",
        table.name()
    );
    let release = query(sql).bind(i64::from(died)).bind(MAX_DEATHS).bind(now_ms);
    let done = release.bind(id.key()).bind(signed(epoch)).execute(conn).await?;
    changed(done, LEASE_ENDED)
}

/// Reads a job whose lease has just ended, by its id, at a time in milliseconds since 1970-01-01
/// UTC.
pub(crate) type ReadReturned<T> =
    for<'c> fn(&'c mut Conn, JobId, i64) -> WriteFuture<'c, Result<T>>;

/// Returns the jobs of lost leases to their queue, as [`release`] does. Returns the leases and the
/// changed jobs. A worker may renew its lease until the last moment.
pub(crate) async fn end_lost<T: Send + 'static>(
    store: &Store,
    table: LeasedTable,
    lost: LostLeases,
    now_ms: i64,
    read: ReadReturned<T>,
) -> Result<Vec<(EndedLease, T)>> {
    let Some(died) = any_lost(store, table, &lost).await? else { return Ok(Vec::new()) };
    let ended = store.write_relaxed(operation!(|conn| {
        if died && table == LeasedTable::Search {
            // An island that fails ends the others: the row of the first is locked before theirs.
            let first = "SELECT id FROM search WHERE id IN
                 (SELECT parent_id FROM search WHERE state = 'running' AND";
            let first = format!("{first} {}) ORDER BY id /*pg: FOR UPDATE*/", condition(&lost));
            bound(query(first), &lost).fetch_all(conn).await?;
        }
        // Two servers may end leases at the same time.
        let rows =
            selection(table, &lost, "/*pg: FOR UPDATE SKIP LOCKED*/").fetch_all(conn).await?;
        let mut ended = Vec::new();
        for row in &rows {
            let lease = EndedLease::read(row)?;
            match release(conn, table, (lease.id, lease.epoch), died, now_ms).await {
                // An island that failed before it in this list has ended it.
                Err(StorageError::Conflict { .. }) => continue,
                released => released?,
            }
            let job = read(conn, lease.id, now_ms).await?;
            ended.push((lease, job));
        }
        Ok(ended)
    }));
    let ended = ended.await;
    store.lease_faults().note(&ended);
    ended
}

/// Returns `None` if there are no lost leases, or if none may end now; otherwise true if their ends
/// count as deaths of the workers.
async fn any_lost(store: &Store, table: LeasedTable, lost: &LostLeases) -> Result<Option<bool>> {
    let faults = store.lease_faults();
    if *lost == LostLeases::Expired && faults.is_within(RENEWAL) {
        return Ok(None);
    }
    let rows = async { selection(table, lost, "").fetch_all(&mut store.reader().await?).await };
    let rows = rows.await;
    faults.note(&rows);
    if rows?.is_empty() {
        return Ok(None);
    }
    Ok(Some(match lost {
        LostLeases::Expired => !faults.is_within(FORGIVEN),
        LostLeases::OfWorker(_) => true,
        LostLeases::OfStopped(_) | LostLeases::OfProcess => false,
    }))
}

fn selection(table: LeasedTable, lost: &LostLeases, lock: &str) -> Query {
    let select = select::<EndedLease>(&format!(
        "FROM {} WHERE state = 'running' AND {} ORDER BY id {lock}",
        table.name(),
        condition(lost)
    ));
    bound(select, lost)
}

/// Returns SQL for leases that are lost, with the value of [`bound`].
fn condition(lost: &LostLeases) -> String {
    match lost {
        // No lease is that long: the clock was set back after the grant. Leases of earlier versions
        // have no end.
        LostLeases::Expired => format!(
            "coalesce(lease_until_ms, 0) NOT BETWEEN {now} + 1 AND {now} + {LONGEST_MS}",
            now = now(1)
        ),
        LostLeases::OfWorker(_) | LostLeases::OfStopped(_) => "worker = ?1".to_owned(),
        LostLeases::OfProcess => "/*pg: FALSE*//*sqlite*/TRUE/*end*/".to_owned(),
    }
}

/// Binds the value of a [`condition`].
fn bound(query: Query, lost: &LostLeases) -> Query {
    match lost {
        LostLeases::Expired => query.bind(steady_ms()),
        LostLeases::OfWorker(worker) | LostLeases::OfStopped(worker) => query.bind(worker.clone()),
        LostLeases::OfProcess => query,
    }
}
