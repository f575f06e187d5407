//! Exports as jobs: create, read, cancel, expire, and the workers' side: claim, file, failure,
//! release. Owner of the tables `export` and `export_file`; each transition is a compare-and-set on
//! id, epoch and state.
//!
//! On SQLite the caller keeps the files on disk, and a row gets the size of its file once that is
//! on disk. On PostgreSQL the module `export_file` stores the files.

use std::collections::BTreeMap;
use std::time::Duration;

use brood_genome::GenomeHash;
use brood_protocol::{JobId, JobStatus};

use crate::clock::steady_ms;
use crate::column::Key;
use crate::error::{LEASE_ENDED, Result, changed};
use crate::lease::{EndedLease, LeasedTable, LostLeases, ReadReturned};
use crate::row::{Record, insert_rows, record, returning, select, signed, values};
use crate::sql::{Conn, query};
use crate::write::operation;
use crate::{Idempotency, StorageError, Store, export_file, idempotency, lease};

/// Export to be stored.
#[derive(Debug, Clone, PartialEq)]
pub struct NewExport {
    /// Id of the job.
    pub id: JobId,
    /// Energy limit, if chosen.
    pub energy_limit: Option<bool>,
    /// Files that workers make.
    pub files: Vec<NewExportFile>,
    /// Plan of the archive, in the caller's format.
    pub plan: String,
    /// Creation time, in milliseconds since 1970-01-01 UTC.
    pub created_ms: i64,
    /// Idempotency record to be stored with the export.
    pub idempotency: Option<Idempotency>,
}

record! {
    /// File that a worker makes.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct NewExportFile {
        /// Number within the archive.
        pub number: u32,
        /// Genome to export.
        pub genome: GenomeHash = "genome_hash",
        /// Name of the format.
        pub format: String,
    }
}

record! {
    /// Export without its plan.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct StoredExport {
        /// Id of the job.
        pub id: JobId,
        /// State.
        pub state: JobStatus,
        /// Epoch: incremented by every change except a file that keeps the lease.
        pub epoch: u64,
        /// Reason of a failure.
        pub reason: Option<String>,
        /// Number of files that workers make.
        pub files: u32 = "(SELECT count(*) FROM export_file WHERE export_id = export.id)",
        /// Number of those that are made.
        pub made: u32 = "(SELECT count(bytes) FROM export_file WHERE export_id = export.id)",
        /// Size of the files so far, in bytes.
        pub bytes: u64 =
            "(SELECT CAST(coalesce(sum(bytes), 0) AS BIGINT) FROM export_file WHERE export_id = export.id)",
        /// Creation time, in milliseconds since 1970-01-01 UTC.
        pub created_ms: i64,
        /// Time of the first lease, in milliseconds since 1970-01-01 UTC.
        pub started_ms: Option<i64>,
        /// Time of the end, in milliseconds since 1970-01-01 UTC.
        pub ended_ms: Option<i64>,
    }
}

record! {
    /// File that is made.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct StoredExportFile {
        /// Number within the archive.
        pub number: u32,
        /// Size in bytes.
        pub bytes: u64,
        /// Note of a table.
        pub note: Option<String>,
    }
}

record! {
    /// Export that has just been leased.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct ClaimedExport {
        /// Id of the job.
        pub id: JobId,
        /// Epoch of this lease.
        pub epoch: u64,
        /// Energy limit, if chosen.
        pub energy_limit: Option<bool>,
    } and {
        /// Files that are not made yet.
        pub missing: Vec<NewExportFile>,
    }
}

/// Ends a lease without a result. Parameters: state; reason; time; id; epoch or NULL for any.
const END: &str = "UPDATE export SET state = ?1, reason = ?2, ended_ms = ?3, epoch = epoch + 1,
        worker = NULL, lease_until_ms = NULL
    WHERE id = ?4 AND (?5 IS NULL OR epoch = ?5) AND state IN ('queued', 'running')";
const SUCCEED: &str = "UPDATE export SET state = 'succeeded', ended_ms = ?1, epoch = epoch + 1,
        worker = NULL, lease_until_ms = NULL
    WHERE id = ?2 AND NOT EXISTS (
        SELECT 1 FROM export_file WHERE export_id = ?2 AND bytes IS NULL)";

impl Store {
    /// Stores an export at the end of the queue.
    ///
    /// # Errors
    /// Returns [`StorageError::QueueFull`] if `max_queued` exports are queued.
    pub async fn create_export(&self, new: NewExport, max_queued: u32) -> Result<()> {
        self.write(operation!(|conn| insert(conn, new, max_queued).await)).await
    }

    /// Returns an export.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if it does not exist.
    pub async fn export(&self, id: JobId) -> Result<StoredExport> {
        fetch(&mut self.reader().await?, id).await
    }

    /// Returns the plan of an export and its files that are made, by number.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if it does not exist.
    pub async fn export_plan(&self, id: JobId) -> Result<(String, Vec<StoredExportFile>)> {
        let mut conn = self.snapshot().await?;
        let plan = query("SELECT plan_json FROM export WHERE id = ?").bind(id.key());
        let plan = plan.fetch_value(&mut conn).await?;
        let files = select::<StoredExportFile>(
            "FROM export_file WHERE export_id = ? AND bytes IS NOT NULL ORDER BY number",
        );
        let files = files.bind(id.key()).fetch_all(&mut conn).await?;
        let files: Result<_> = files.iter().map(StoredExportFile::read).collect();
        Ok((plan, files?))
    }

    /// Returns all exports, the oldest first.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn exports(&self) -> Result<Vec<StoredExport>> {
        let rows = select::<StoredExport>("FROM export ORDER BY id");
        let rows = rows.fetch_all(&mut self.reader().await?).await?;
        rows.iter().map(StoredExport::read).collect()
    }

    /// True if an export is queued.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn any_export_queued(&self) -> Result<bool> {
        let sql = "SELECT EXISTS (SELECT 1 FROM export WHERE state = 'queued')";
        query(sql).fetch_value(&mut self.reader().await?).await
    }

    /// Returns the number of exports in each state, by its name.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn export_counts(&self) -> Result<BTreeMap<&'static str, u64>> {
        let states = JobStatus::ALL.into_iter().map(JobStatus::name);
        self.state_counts("SELECT state, count(*) AS jobs FROM export GROUP BY state", states).await
    }

    /// Leases the oldest queued export, for this time unless it is renewed. Returns `None` if there
    /// is none.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the write fails.
    pub async fn claim_export(
        &self,
        worker: &str,
        ttl: Duration,
        now_ms: i64,
    ) -> Result<Option<ClaimedExport>> {
        let sql = format!(
            "UPDATE export SET state = 'running', epoch = epoch + 1, worker = ?2,
                 started_ms = coalesce(started_ms, ?3), lease_until_ms = {} + ?4
             WHERE id = (SELECT id FROM export WHERE state = 'queued' ORDER BY id LIMIT 1
                 /*pg: FOR UPDATE SKIP LOCKED*/)",
            lease::now(1)
        );
        let claim = returning::<ClaimedExport>(&sql).bind(steady_ms()).bind(worker.to_owned());
        let claim = claim.bind(now_ms).bind(lease::ttl_ms(ttl));
        self.write_relaxed(operation!(|conn| {
            let Some(row) = claim.fetch_optional(conn).await? else { return Ok(None) };
            let mut claimed = ClaimedExport::read(&row)?;
            let missing = select::<NewExportFile>(
                "FROM export_file WHERE export_id = ? AND bytes IS NULL ORDER BY number",
            );
            let rows = missing.bind(claimed.id.key()).fetch_all(conn).await?;
            let missing: Result<_> = rows.iter().map(NewExportFile::read).collect();
            claimed.missing = missing?;
            Ok(Some(claimed))
        }))
        .await
    }

    /// Renews the lease of an export.
    ///
    /// # Errors
    /// Returns [`StorageError::Conflict`] if the epoch is stale.
    pub async fn renew_export(&self, id: JobId, epoch: u64, ttl: Duration) -> Result<()> {
        lease::renew(self, LeasedTable::Export, (id, epoch), ttl).await
    }

    /// Records a file that is on disk, or stores `content` as the file. Renews the lease for `ttl`.
    /// The last file ends the export with success.
    ///
    /// # Errors
    /// Returns [`StorageError::Conflict`] if the epoch is stale, [`StorageError::NotFound`] if the
    /// export has no such file.
    pub async fn record_export_file(
        &self,
        (id, epoch): (JobId, u64),
        file: StoredExportFile,
        content: Option<Vec<u8>>,
        (ttl, now_ms): (Duration, i64),
    ) -> Result<StoredExport> {
        let held = format!(
            "UPDATE export SET deaths = 0, lease_until_ms = {} + ?2
             WHERE id = ?3 AND epoch = ?4 AND state = 'running'",
            lease::now(1)
        );
        self.write(operation!(|conn| {
            // Before the row is locked: a large file takes long, in which the lease is renewed.
            if let Some(content) = &content {
                export_file::put(conn, (id, file.number), content).await?;
            }
            let held = query(held).bind(steady_ms()).bind(lease::ttl_ms(ttl));
            let held = held.bind(id.key()).bind(signed(epoch));
            changed(held.execute(conn).await?, LEASE_ENDED)?;
            let made = "UPDATE export_file SET bytes = ?, note = ?
                WHERE export_id = ? AND number = ?";
            let made = query(made)
                .bind(signed(file.bytes))
                .bind(file.note)
                .bind(id.key())
                .bind(file.number)
                .execute(conn)
                .await?;
            changed(made, StorageError::NotFound)?;
            query(SUCCEED).bind(now_ms).bind(id.key()).execute(conn).await?;
            fetch(conn, id).await
        }))
        .await
    }

    /// Marks an export as failed, and forgets its files. `epoch` is that of the lease.
    ///
    /// # Errors
    /// Returns [`StorageError::Conflict`] if the epoch is stale.
    pub async fn fail_export(
        &self,
        (id, epoch): (JobId, u64),
        reason: String,
        now_ms: i64,
    ) -> Result<StoredExport> {
        self.write(operation!(|conn| {
            let failed = (JobStatus::Failed, Some(reason));
            changed(end(conn, (id, Some(epoch)), failed, now_ms).await?, LEASE_ENDED)?;
            fetch(conn, id).await
        }))
        .await
    }

    /// Cancels a queued or running export and forgets its files. Stores the idempotency record of
    /// the request. Returns the changed export. The inner error is the state of an export that has
    /// ended.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if it does not exist, [`StorageError::Conflict`] if the
    /// idempotency key is in use.
    pub async fn cancel_export(
        &self,
        id: JobId,
        idempotency: Option<Idempotency>,
        now_ms: i64,
    ) -> Result<Result<StoredExport, JobStatus>> {
        self.write(operation!(|conn| {
            let cancelled = (JobStatus::Cancelled, None);
            let done = end(conn, (id, None), cancelled, now_ms).await?;
            let export = fetch(conn, id).await?;
            if done == 0 {
                return Ok(Err(export.state));
            }
            idempotency::insert(conn, idempotency.as_ref(), now_ms).await?;
            Ok(Ok(export))
        }))
        .await
    }

    /// Returns a leased export to the queue. After the third consecutive worker death it fails
    /// instead.
    ///
    /// # Errors
    /// Returns [`StorageError::Conflict`] if the epoch is stale.
    pub async fn release_export(
        &self,
        (id, epoch): (JobId, u64),
        worker_died: bool,
        now_ms: i64,
    ) -> Result<StoredExport> {
        self.write_relaxed(operation!(|conn| {
            lease::release(conn, LeasedTable::Export, (id, epoch), worker_died, now_ms).await?;
            fetch_returned(conn, id).await
        }))
        .await
    }

    /// Returns the exports of lost leases to their queue, as [`release_export`] does. Returns the
    /// leases and the changed exports.
    ///
    /// [`release_export`]: Self::release_export
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read or the write fails.
    pub async fn end_export_leases(
        &self,
        lost: LostLeases,
        now_ms: i64,
    ) -> Result<Vec<(EndedLease, StoredExport)>> {
        let read: ReadReturned<_> = |conn, id, _| Box::pin(fetch_returned(conn, id));
        lease::end_lost(self, LeasedTable::Export, lost, now_ms, read).await
    }

    /// Deletes an export that has ended. The caller deletes its files.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if there is no such export, or it has not ended.
    pub async fn delete_export(&self, id: JobId) -> Result<()> {
        self.write(operation!(|conn| {
            let sql = "DELETE FROM export WHERE id = ? AND state NOT IN ('queued', 'running')";
            changed(query(sql).bind(id.key()).execute(conn).await?, StorageError::NotFound)
        }))
        .await
    }

    /// Forgets lost files of an export that has succeeded, so that they are made again. Changes
    /// nothing if the export has another epoch.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the write fails.
    pub async fn forget_export_files(
        &self,
        (id, epoch): (JobId, u64),
        numbers: Vec<u32>,
    ) -> Result<()> {
        self.write(operation!(|conn| {
            let sql = "UPDATE export SET state = 'queued', epoch = epoch + 1, ended_ms = NULL
                WHERE id = ? AND epoch = ? AND state = 'succeeded'";
            if query(sql).bind(id.key()).bind(signed(epoch)).execute(conn).await? == 0 {
                return Ok(());
            }
            for number in numbers {
                let sql = "UPDATE export_file SET bytes = NULL, note = NULL
                    WHERE export_id = ? AND number = ?";
                query(sql).bind(id.key()).bind(number).execute(conn).await?;
                export_file::remove(conn, (id, number)).await?;
            }
            Ok(())
        }))
        .await
    }
}

async fn insert(conn: &mut Conn, new: NewExport, max_queued: u32) -> Result<()> {
    idempotency::insert(conn, new.idempotency.as_ref(), new.created_ms).await?;
    let waiting = query("SELECT count(*) FROM export WHERE state = 'queued'");
    let waiting: u32 = waiting.fetch_value(conn).await?;
    if waiting >= max_queued {
        return Err(StorageError::QueueFull);
    }
    query(
        "INSERT INTO export (id, state, epoch, deaths, energy_limit, created_ms, plan_json)
         VALUES (?, 'queued', 0, 0, ?, ?, ?)",
    )
    .bind(new.id.key())
    .bind(new.energy_limit)
    .bind(new.created_ms)
    .bind(new.plan)
    .execute(conn)
    .await?;
    let head = "INSERT INTO export_file (export_id, number, genome_hash, format) ";
    insert_rows(conn, (head, ""), &new.files, |file| {
        values![
            new.id.key().to_vec(),
            file.number,
            file.genome.key().to_vec(),
            file.format.clone(),
        ]
    })
    .await
}

/// Ends a queued or running export without a result, and forgets its files.
async fn end(
    conn: &mut Conn,
    (id, epoch): (JobId, Option<u64>),
    (state, reason): (JobStatus, Option<String>),
    now_ms: i64,
) -> Result<u64> {
    let done = query(END)
        .bind(state.name())
        .bind(reason)
        .bind(now_ms)
        .bind(id.key())
        .bind(epoch.map(signed))
        .execute(conn)
        .await?;
    if done > 0 {
        forget_all(conn, id).await?;
    }
    Ok(done)
}

async fn forget_all(conn: &mut Conn, id: JobId) -> Result<()> {
    let sql = "UPDATE export_file SET bytes = NULL, note = NULL WHERE export_id = ?";
    query(sql).bind(id.key()).execute(conn).await?;
    Ok(())
}

/// Reads an export that was returned to its queue. If it has failed instead, its files are
/// forgotten.
async fn fetch_returned(conn: &mut Conn, id: JobId) -> Result<StoredExport> {
    let export = fetch(conn, id).await?;
    if export.state == JobStatus::Failed {
        forget_all(conn, id).await?;
    }
    Ok(export)
}

async fn fetch(conn: &mut Conn, id: JobId) -> Result<StoredExport> {
    let query = select::<StoredExport>("FROM export WHERE id = ?").bind(id.key());
    StoredExport::read(&query.fetch_one(conn).await?)
}
