//! Exports: claims and reports.
//!
//! Workers make the files one by one. A file is stored before it is recorded, or together with its
//! record, so that an export continues with the next file after any end of server or worker. The
//! bytes of all exports are bounded: the oldest that have ended give way.

mod files;
#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::sync::Arc;

use brood_protocol::{
    Directive, ExportAnswer, ExportFile, ExportGrant, ExportReport, ExportTicket, ExportUpdate,
    JobId, JobStatus,
};
use brood_storage::{
    ClaimedExport, EndedLease, Idempotency, LostLeases, StorageError, Store, StoredExport,
    StoredExportFile,
};
use bytes::Bytes;
use http::StatusCode;
use serde_json::json;
use tokio::sync::Mutex;

use self::files::ExportFiles;
use super::kind::{JobKind, Jobs, Lane, PendingGrant};
use super::lease::{lease_ms, shortened, stale, stale_or};
use crate::clock::now_ms;
use crate::event::Events;
use crate::export_folder::ExportFolder;
use crate::library::Library;
use crate::limit;
use crate::problem::ApiError;

/// Serves exports: their leases, reports, files and events. Also the kind of exports.
pub struct Exports {
    /// Database.
    pub store: Store,
    /// Tasks of exports.
    pub jobs: Jobs,
    /// Waiting workers.
    pub lane: Lane<Self>,
    /// Genomes.
    pub library: Arc<Library>,
    /// Files, if they are on disk.
    pub folder: ExportFolder,
    /// Event streams.
    pub events: Arc<Events>,
    /// Held while space is made and used, so that the bound holds.
    pub space: Mutex<()>,
    /// Most bytes of all files.
    pub most_bytes: u64,
}

impl JobKind for Exports {
    const NAME: &'static str = "export";
    type Ticket = ExportTicket;
    type Queue = ();
    type Grant = ExportGrant;

    fn jobs(&self) -> &Jobs {
        &self.jobs
    }

    fn lane(&self, (): ()) -> &Lane<Self> {
        &self.lane
    }

    async fn any_queued(&self, (): ()) -> Result<bool, StorageError> {
        self.store.any_export_queued().await
    }

    async fn claim(
        self: &Arc<Self>,
        worker: &str,
        (): (),
    ) -> Result<Option<PendingGrant<Self>>, ApiError> {
        while let Some(claimed) = self.store.claim_export(worker, limit::LEASE, now_ms()).await? {
            let ticket = ExportTicket { job: claimed.id, epoch: claimed.epoch };
            match self.grant(ticket, claimed).await {
                Ok(grant) => {
                    let pending = PendingGrant::new(self, ticket, grant);
                    self.publish_state(&self.store.export(ticket.job).await?);
                    return Ok(Some(pending));
                }
                Err(error) if error.status() == StatusCode::SERVICE_UNAVAILABLE => {
                    // The database does not answer. If it still does not, the lease expires.
                    let _ = self.give_back(&ticket).await;
                    return Err(error);
                }
                Err(error) => {
                    let reason = format!("cannot read a genome: {}", error.problem().detail);
                    self.fail(&ticket, reason).await?;
                }
            }
        }
        Ok(None)
    }

    async fn give_back(&self, ticket: &ExportTicket) -> Result<(), ApiError> {
        let lease = (ticket.job, ticket.epoch);
        let released = self.store.release_export(lease, false, now_ms()).await;
        self.requeued(&released.map_err(stale_or)?).await;
        Ok(())
    }

    async fn end_lost(&self, lost: LostLeases) -> Result<Vec<EndedLease>, ApiError> {
        let mut leases = Vec::new();
        for (lease, export) in self.store.end_export_leases(lost, now_ms()).await? {
            self.requeued(&export).await;
            leases.push(lease);
        }
        Ok(leases)
    }
}

impl Exports {
    /// Place of the files.
    fn files(&self) -> ExportFiles {
        if !self.store.is_shared() {
            return ExportFiles::Folder(self.folder.clone());
        }
        let (tasks, stopping) = (self.jobs.tasks.clone(), self.jobs.stopping.clone());
        ExportFiles::Rows { store: self.store.clone(), tasks, stopping }
    }

    /// Publishes an export that was returned to its queue, or has failed instead.
    async fn requeued(&self, export: &StoredExport) {
        let job = export.id;
        if export.state == JobStatus::Failed {
            tracing::error!(%job, "an export has failed: too many workers died while making it");
            self.files().remove(job).await;
        }
        self.publish_state(export);
        self.wake();
    }

    /// Wakes a worker that waits, since a job is queued.
    pub fn wake(&self) {
        self.lane.notify.notify_one();
        self.events.peers().tell_export();
    }

    /// Renews a lease.
    ///
    /// # Errors
    /// 409 if the lease is not valid any more.
    pub async fn renew(&self, ticket: &ExportTicket) -> Result<(), ApiError> {
        let renewed = self.store.renew_export(ticket.job, ticket.epoch, limit::LEASE).await;
        renewed.map_err(stale_or)
    }

    async fn grant(
        &self,
        ticket: ExportTicket,
        claimed: ClaimedExport,
    ) -> Result<ExportGrant, ApiError> {
        let (mut genomes, mut indices) = (Vec::new(), HashMap::new());
        let mut files = Vec::with_capacity(claimed.missing.len());
        for file in claimed.missing {
            let genome = match indices.get(&file.genome) {
                Some(&index) => index,
                None => {
                    let material = self.library.material(file.genome).await?;
                    let index = u32::try_from(genomes.len()).unwrap_or(u32::MAX);
                    genomes.push(material.genome.canonical_bytes());
                    indices.insert(file.genome, index);
                    index
                }
            };
            files.push(ExportFile { number: file.number, genome, format: file.format });
        }
        let energy_limit = claimed.energy_limit;
        Ok(ExportGrant { ticket, ttl_ms: lease_ms(limit::LEASE), energy_limit, genomes, files })
    }

    /// Takes a worker's report and returns its directive.
    ///
    /// # Errors
    /// 409 if the lease is not valid any more, 507 if the disk is full.
    pub async fn report(self: &Arc<Self>, report: ExportReport) -> Result<Directive, ApiError> {
        let ExportReport { ticket, update } = report;
        self.renew(&ticket).await?;
        // Runs in a separate task: what was written must be published even if the worker
        // disconnects.
        let own = self.clone();
        let taken = self.jobs.tasks.spawn(async move {
            match update {
                ExportUpdate::Made { number, bytes, note } => {
                    own.take_file(&ticket, number, bytes, note).await
                }
                ExportUpdate::Failed(reason) => own.fail(&ticket, shortened(&reason)).await,
            }
        });
        let export = taken.await.map_err(|error| ApiError::internal(error.to_string()))??;
        if export.state == JobStatus::Running {
            return Ok(Directive::Continue);
        }
        self.wake();
        Ok(Directive::Stop)
    }

    async fn take_file(
        &self,
        ticket: &ExportTicket,
        number: u32,
        bytes: Vec<u8>,
        note: Option<String>,
    ) -> Result<StoredExport, ApiError> {
        let (job, size) = (ticket.job, bytes.len() as u64);
        let export = {
            let _space = self.space.lock().await;
            if !self.make_space(job, size).await? {
                let most = self.most_bytes >> 20;
                let words = format!(
                    "the files of exports may have {most} MiB together; export fewer or smaller \
                     tables at a time"
                );
                return self.fail(ticket, words).await;
            }
            let content = self.files().write(job, number, bytes).await?;
            let file = StoredExportFile { number, bytes: size, note };
            self.store
                .record_export_file((job, ticket.epoch), file, content, (limit::LEASE, now_ms()))
                .await
        };
        match export {
            Ok(export) => {
                self.publish_progress(&export);
                if export.state.is_final() {
                    self.publish_state(&export);
                }
                Ok(export)
            }
            Err(StorageError::Conflict { .. } | StorageError::NotFound) => {
                // Cancelled while the file was written; another lease keeps the files.
                let state = self.store.export(job).await.map(|export| export.state);
                if !matches!(
                    state,
                    Ok(JobStatus::Queued | JobStatus::Running | JobStatus::Succeeded)
                ) {
                    self.files().remove(job).await;
                }
                Err(stale())
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Deletes the oldest exports that have ended until `bytes` more fit. Returns false if they do
    /// not fit even then. Other servers may make space at the same time: then an export more than
    /// necessary is deleted, or each of them exceeds the bound by a file.
    async fn make_space(&self, job: JobId, bytes: u64) -> Result<bool, ApiError> {
        loop {
            let exports = self.store.exports().await?;
            let used: u64 = exports.iter().map(|export| export.bytes).sum();
            if used + bytes <= self.most_bytes {
                return Ok(true);
            }
            let mut ended = exports.iter().filter(|export| export.state.is_final());
            let oldest = ended.find(|export| export.id != job && export.bytes > 0);
            let Some(oldest) = oldest else { return Ok(false) };
            self.delete(oldest.id).await?;
        }
    }

    async fn fail(&self, ticket: &ExportTicket, reason: String) -> Result<StoredExport, ApiError> {
        let job = ticket.job;
        tracing::warn!(%job, reason, "an export failed");
        let failed = self.store.fail_export((job, ticket.epoch), reason, now_ms()).await;
        let export = failed.map_err(stale_or)?;
        self.files().remove(job).await;
        self.publish_state(&export);
        Ok(export)
    }

    /// Cancels an export, with the idempotency record of the request, and deletes its files.
    ///
    /// # Errors
    /// 404 if there is no such export, 409 if it has ended.
    pub async fn cancel(
        &self,
        id: JobId,
        idempotency: Option<Idempotency>,
    ) -> Result<StoredExport, ApiError> {
        let cancelled = self.store.cancel_export(id, idempotency, now_ms()).await?;
        let export = cancelled.map_err(|state| {
            ApiError::conflict(format!("the job has already ended: it is {}", state.name()))
        })?;
        self.files().remove(id).await;
        self.wake();
        self.publish_state(&export);
        Ok(export)
    }

    /// Checks the files of an export that has succeeded. If some are lost, they are made again.
    ///
    /// # Errors
    /// 409 if the export has not succeeded, or is made again.
    pub async fn check_files(&self, id: JobId, files: &[StoredExportFile]) -> Result<(), ApiError> {
        let export = self.store.export(id).await?;
        if export.state != JobStatus::Succeeded {
            let state = export.state.name();
            return Err(ApiError::conflict(format!("there is no archive: the job is {state}")));
        }
        let lost = self.files().lost(id, files).await?;
        if lost.is_empty() {
            return Ok(());
        }
        tracing::warn!(job = %id, files = lost.len(), "files of an export are lost; making them again");
        self.store.forget_export_files((id, export.epoch), lost).await?;
        self.wake();
        self.publish_state(&self.store.export(id).await?);
        Err(ApiError::conflict("files of the archive were lost; they are being made again"))
    }

    /// Reads a file of an export.
    ///
    /// # Errors
    /// [`ApiError`] if it is lost.
    pub async fn read_file(&self, id: JobId, file: &StoredExportFile) -> Result<Bytes, ApiError> {
        self.files().read(id, file).await
    }

    /// Deletes the exports that ended more than [`limit::EXPORT_TTL`] ago.
    ///
    /// # Errors
    /// [`ApiError`] if the store fails.
    pub async fn prune(&self) -> Result<(), ApiError> {
        let now = now_ms();
        for export in self.store.exports().await? {
            if expires_ms(&export).is_some_and(|expires| expires <= now) {
                self.delete(export.id).await?;
            }
        }
        self.files().remove_unused();
        Ok(())
    }

    /// Deletes an export that has ended, with its files.
    async fn delete(&self, id: JobId) -> Result<(), ApiError> {
        match self.store.delete_export(id).await {
            Ok(()) => self.files().remove(id).await,
            // Another server has deleted it, or lost files of it are being made again.
            Err(StorageError::NotFound) => {}
            Err(error) => return Err(error.into()),
        }
        Ok(())
    }

    /// Publishes an export's state.
    pub fn publish_state(&self, export: &StoredExport) {
        let data = json!({ "id": export.id, "state": export.state, "reason": export.reason });
        self.events.job(export.id, "state", &data);
    }

    fn publish_progress(&self, export: &StoredExport) {
        let ExportAnswer { id, progress, files, made, bytes, .. } = export_json(export.clone());
        let data = json!({
            "id": id, "progress": progress, "files": files, "made": made, "bytes": bytes,
        });
        self.events.job(id, "progress", &data);
    }
}

/// Converts an export to its answer.
pub fn export_json(export: StoredExport) -> ExportAnswer {
    let is_done = export.state == JobStatus::Succeeded;
    let share = f64::from(export.made) / f64::from(export.files.max(1));
    ExportAnswer {
        id: export.id,
        kind: "export".to_owned(),
        state: export.state,
        progress: if is_done { 1.0 } else { share },
        files: export.files,
        made: export.made,
        bytes: export.bytes,
        archive: is_done.then(|| format!("/v1/jobs/{}/archive.zip", export.id)),
        created_ms: export.created_ms,
        started_ms: export.started_ms,
        ended_ms: export.ended_ms,
        expires_ms: expires_ms(&export),
        reason: export.reason,
    }
}

fn expires_ms(export: &StoredExport) -> Option<i64> {
    let ttl = i64::try_from(limit::EXPORT_TTL.as_millis()).unwrap_or(i64::MAX);
    export.ended_ms.map(|ended| ended.saturating_add(ttl))
}
