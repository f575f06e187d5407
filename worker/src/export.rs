//! Worker that makes exports: a leased export from grant to end. Files are made one after another
//! on one thread, each reported once it is made.

use std::time::Duration;

use brood_export::{Exported, Format, Within, export_genome};
use brood_genome::Genome;
use brood_protocol::{
    Directive, ExportFile, ExportGrant, ExportReport, ExportRequest, ExportTicket, ExportUpdate,
    JobId, WorkerClient,
};
use tokio_util::sync::CancellationToken;

use crate::claim::run_jobs;
use crate::lease::{
    HEARTBEAT, Interrupted, JobKind, RetryPolicy, WorkerError, leave_to_others, renew_lease,
    send_with_retry,
};

/// Name of the format that is the genome as text.
const TEXT: &str = "brood";

/// Makes exports until `shutdown` is cancelled. `server` is its URL, `token` has the scope `work`,
/// `name` is for logs.
///
/// # Errors
/// Returns [`WorkerError::Refused`] if the server rejects the token, [`WorkerError::Client`] if the
/// HTTP client cannot be set up.
pub async fn run_exports(
    (server, token, name): (&str, &str, &str),
    shutdown: CancellationToken,
) -> Result<(), WorkerError> {
    let client = WorkerClient::new(server, token).map_err(WorkerError::Client)?;
    let shutdown = shutdown.child_token();
    let context = ExportContext { client: client.clone(), shutdown: shutdown.clone() };
    run_jobs(&client, name, context, shutdown).await
}

/// Resources that a worker shares among its exports.
#[derive(Clone)]
struct ExportContext {
    client: WorkerClient,
    shutdown: CancellationToken,
}

impl JobKind for ExportContext {
    const HEARTBEAT: Duration = HEARTBEAT;
    type Request = ExportRequest;
    type Ticket = ExportTicket;

    fn at(self, client: WorkerClient) -> Self {
        Self { client, ..self }
    }

    fn name(&self) -> &'static str {
        "export"
    }

    fn concurrent(&self) -> usize {
        1
    }

    fn request(&self, worker: &str, wait_ms: u32) -> ExportRequest {
        ExportRequest { worker: worker.to_owned(), wait_ms }
    }

    fn lease(grant: &ExportGrant) -> (JobId, ExportTicket) {
        (grant.ticket.job, grant.ticket)
    }

    async fn run(self, grant: ExportGrant) {
        let (ticket, job) = (grant.ticket, grant.ticket.job);
        let ttl = Duration::from_millis(grant.ttl_ms.into());
        let ended = tokio::select! {
            ended = self.export(grant) => ended,
            () = renew_lease::<Self, _>(ttl, || self.client.heartbeat(&ticket)) => Err(Interrupted::Stale),
            () = self.shutdown.cancelled() => Err(Interrupted::Release("shutting down".to_owned())),
        };
        let mut is_for_others = false;
        let sent = match ended {
            Ok(()) | Err(Interrupted::Stale) => return tracing::debug!(%job, "export ended"),
            Err(Interrupted::Failed(reason)) => {
                tracing::warn!(%job, reason, "export failed");
                let update = ExportUpdate::Failed(reason);
                self.client.report_export(&ExportReport { ticket, update }).await.map(drop)
            }
            Err(Interrupted::Release(reason)) => {
                tracing::info!(%job, reason, "export returned to the queue");
                self.client.release(&ticket).await
            }
            Err(Interrupted::OtherVersion(reason)) => {
                tracing::warn!(%job, reason, "export returned to the queue");
                is_for_others = true;
                self.client.release(&ticket).await
            }
        };
        if let Err(error) = sent {
            tracing::debug!(%job, %error, "cannot return the export; its lease will expire");
        }
        if is_for_others {
            leave_to_others(&self.shutdown).await;
        }
    }
}

impl ExportContext {
    /// Makes the files, until the server answers [`Directive::Stop`].
    async fn export(&self, grant: ExportGrant) -> Result<(), Interrupted> {
        let ExportGrant { ticket, energy_limit, genomes, files, .. } = grant;
        for file in files {
            let ExportFile { number, genome, format } = file;
            let genome = usize::try_from(genome).ok().and_then(|index| genomes.get(index)).cloned();
            let genome = genome.ok_or_else(|| {
                Interrupted::Failed(format!("the grant has no genome of file {number}"))
            })?;
            let made = tokio::task::spawn_blocking(move || made(&genome, &format, energy_limit));
            let made = made.await.map_err(|_| Interrupted::Failed("an export panicked".to_owned()));
            let Exported { bytes, note } = made??;
            let update = ExportUpdate::Made { number, bytes, note };
            if self.report(ticket, update).await? == Directive::Stop {
                return Ok(());
            }
        }
        Ok(())
    }

    /// Sends a report, with retries until it arrives: a full disk or a busy server delays an export
    /// and does not fail it.
    async fn report(
        &self,
        ticket: ExportTicket,
        update: ExportUpdate,
    ) -> Result<Directive, Interrupted> {
        let report = ExportReport { ticket, update };
        let policy = RetryPolicy { limit: None, repeats_server_errors: true };
        let send = || self.client.report_export(&report);
        let sent = send_with_retry(policy, (ticket.job, "report a file"), &self.shutdown, send);
        sent.await.map_err(|error| Interrupted::by("report a file", error))
    }
}

fn made(genome: &[u8], format: &str, energy_limit: Option<bool>) -> Result<Exported, Interrupted> {
    let genome = Genome::from_canonical_bytes(genome);
    let genome = genome.map_err(|error| Interrupted::Failed(error.to_string()))?;
    if format == TEXT {
        return Ok(genome.to_string().into());
    }
    let known: Result<Format, _> = format.parse();
    let format = known.map_err(|_| Interrupted::unknown("format", format))?;
    export_genome(&genome, format, energy_limit, Within::default())
        .map_err(|error| Interrupted::Failed(error.to_string()))
}
