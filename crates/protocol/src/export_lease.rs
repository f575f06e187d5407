//! Lease protocol of exports: as of searches, with a report for each file.

use serde::{Deserialize, Serialize};

use crate::JobId;

/// Request for an export.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ExportRequest {
    /// Name of the worker.
    pub worker: String,
    /// Longest time that the server may delay its answer if the queue is empty, in milliseconds.
    pub wait_ms: u32,
}

/// Proof of a lease of an export.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct ExportTicket {
    /// Id of the job.
    pub job: JobId,
    /// Epoch of the job; every change of its state increments it.
    pub epoch: u64,
}

/// Export that is leased to a worker.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ExportGrant {
    /// Ticket of the lease.
    pub ticket: ExportTicket,
    /// Time to live: the lease expires unless a heartbeat or report arrives within this time, in
    /// milliseconds.
    pub ttl_ms: u32,
    /// Energy limit; `None` for the default of each format.
    pub energy_limit: Option<bool>,
    /// Canonical bytes of the genomes.
    pub genomes: Vec<Vec<u8>>,
    /// Files to make, in this order.
    pub files: Vec<ExportFile>,
}

/// File to make.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ExportFile {
    /// Number within the archive.
    pub number: u32,
    /// Index of its genome in the grant.
    pub genome: u32,
    /// Name of the format; `brood` for the genome as text.
    pub format: String,
}

/// Report of a worker about its export.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ExportReport {
    /// Ticket of the lease.
    pub ticket: ExportTicket,
    /// File, or end of the export.
    pub update: ExportUpdate,
}

/// Progress or end of an export.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum ExportUpdate {
    /// A file.
    Made {
        /// Number within the archive.
        number: u32,
        /// Content.
        #[serde(with = "crate::lease::octets")]
        bytes: Vec<u8>,
        /// Note of a table.
        note: Option<String>,
    },
    /// Permanent failure: the export must not be retried.
    Failed(String),
}
