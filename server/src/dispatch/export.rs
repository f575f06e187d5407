//! Exports: claims and reports.
//!
//! Workers make the files one by one. A file is written to disk before it is recorded, so that an
//! export continues with the next file after any end of server or worker. The disk space of all
//! exports is bounded: the oldest that have ended give way.

#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::sync::Arc;

use brood_protocol::{
    Directive, ExportAnswer, ExportFile, ExportGrant, ExportReport, ExportTicket, ExportUpdate,
    JobId, JobStatus,
};
use brood_storage::{ClaimedExport, StorageError, Store, StoredExport, StoredExportFile};
use serde_json::json;
use tokio::sync::Mutex;

use super::kind::{JobKind, Jobs, Lane, LeaseOf, PendingGrant, Returned};
use super::lease::{lease_ms, renew_lease, shortened, stale};
use crate::clock::now_ms;
use crate::event::Events;
use crate::export_folder::ExportFolder;
use crate::library::Library;
use crate::limit;
use crate::problem::ApiError;
use crate::processors::run_blocking;

/// Serves exports: their leases, reports, files and events. Also the kind of exports.
pub struct Exports {
    /// Database.
    pub store: Store,
    /// Leases of exports.
    pub jobs: Jobs<Self>,
    /// Waiting workers.
    pub lane: Lane<Self>,
    /// Genomes.
    pub library: Arc<Library>,
    /// Files.
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
    type Payload = ();
    type Queue = ();
    type Grant = ExportGrant;

    fn jobs(&self) -> &Jobs<Self> {
        &self.jobs
    }

    fn job(lease: &LeaseOf<Self>) -> JobId {
        lease.ticket.job
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
        while let Some(claimed) = self.store.claim_export(worker, now_ms()).await? {
            let ticket = ExportTicket { job: claimed.id, epoch: claimed.epoch };
            self.jobs.leases.grant(ticket, worker, (), limit::LEASE);
            match self.grant(ticket, claimed).await {
                Ok(grant) => {
                    let pending = PendingGrant::new(self, ticket, grant);
                    self.publish_state(&self.store.export(ticket.job).await?);
                    return Ok(Some(pending));
                }
                Err(error) => {
                    let reason = format!("cannot read a genome: {}", error.problem().detail);
                    self.fail(&ticket, reason).await?;
                    self.jobs.leases.end(&ticket);
                }
            }
        }
        Ok(None)
    }

    async fn on_returned(&self, lease: LeaseOf<Self>, returned: Returned) {
        let ExportTicket { job, epoch } = lease.ticket;
        match self.store.release_export((job, epoch), returned.is_loss(), now_ms()).await {
            Ok(export) => {
                if export.state == JobStatus::Failed {
                    tracing::error!(%job, "an export has failed: too many workers died while making it");
                    self.remove_files(job).await;
                }
                self.publish_state(&export);
                self.lane.notify.notify_one();
            }
            // Cancelled meanwhile.
            Err(StorageError::Conflict { .. } | StorageError::NotFound) => {}
            Err(error) => tracing::error!(%job, %error, "cannot requeue an export"),
        }
    }
}

impl Exports {
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
        renew_lease(&**self, &ticket)?;
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
        self.jobs.leases.end(&ticket);
        self.lane.notify.notify_one();
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
            let folder = self.folder.clone();
            run_blocking(move || folder.write(job, number, &bytes)).await?.map_err(disk)?;
            let file = StoredExportFile { number, bytes: size, note };
            self.store.record_export_file((job, ticket.epoch), file, now_ms()).await
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
                    self.remove_files(job).await;
                }
                Err(stale())
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Deletes the oldest exports that have ended until `bytes` more fit. Returns false if they do
    /// not fit even then.
    async fn make_space(&self, job: JobId, bytes: u64) -> Result<bool, ApiError> {
        let exports = self.store.exports().await?;
        let mut used: u64 = exports.iter().map(|export| export.bytes).sum();
        let ended = exports.iter().filter(|export| export.state.is_final() && export.id != job);
        for export in ended.filter(|export| export.bytes > 0) {
            if used + bytes <= self.most_bytes {
                break;
            }
            self.delete(export.id).await?;
            used -= export.bytes;
        }
        Ok(used + bytes <= self.most_bytes)
    }

    async fn fail(&self, ticket: &ExportTicket, reason: String) -> Result<StoredExport, ApiError> {
        let job = ticket.job;
        tracing::warn!(%job, reason, "an export failed");
        let failed = self.store.fail_export((job, ticket.epoch), reason, now_ms()).await;
        let export = match failed {
            Err(StorageError::Conflict { .. }) => return Err(stale()),
            other => other?,
        };
        self.remove_files(job).await;
        self.publish_state(&export);
        Ok(export)
    }

    /// Cancels an export, and deletes its files.
    ///
    /// # Errors
    /// 404 if there is no such export, 409 if it has ended.
    pub async fn cancel(&self, id: JobId) -> Result<StoredExport, ApiError> {
        let export = self.store.cancel_export(id, now_ms()).await?.map_err(|state| {
            ApiError::conflict(format!("the job has already ended: it is {}", state.name()))
        })?;
        self.jobs.leases.remove(id);
        self.remove_files(id).await;
        self.lane.notify.notify_one();
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
        let lost = files.iter().filter(|file| !self.folder.has(id, file.number, file.bytes));
        let lost: Vec<_> = lost.map(|file| file.number).collect();
        if lost.is_empty() {
            return Ok(());
        }
        tracing::warn!(job = %id, files = lost.len(), "files of an export are lost; making them again");
        self.store.forget_export_files(id, lost).await?;
        self.lane.notify.notify_one();
        self.publish_state(&self.store.export(id).await?);
        Err(ApiError::conflict("files of the archive were lost; they are being made again"))
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
        Ok(())
    }

    async fn delete(&self, id: JobId) -> Result<(), ApiError> {
        match self.store.delete_export(id).await {
            Ok(()) | Err(StorageError::NotFound) => {}
            Err(error) => return Err(error.into()),
        }
        self.remove_files(id).await;
        Ok(())
    }

    /// Deletes the files of an export. What cannot be deleted is deleted at the next start.
    async fn remove_files(&self, id: JobId) {
        let folder = self.folder.clone();
        let removed = run_blocking(move || folder.remove(id)).await;
        if !matches!(removed, Ok(Ok(()))) {
            tracing::warn!(job = %id, "files of an export cannot be deleted");
        }
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

fn disk(error: std::io::Error) -> ApiError {
    match error.kind() {
        std::io::ErrorKind::StorageFull | std::io::ErrorKind::QuotaExceeded => {
            ApiError::disk_full("an export needs more space").with_inner(error.to_string())
        }
        _ => ApiError::internal(error.to_string()),
    }
}
