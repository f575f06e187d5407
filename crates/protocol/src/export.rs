//! Requests and responses for exports that are made as jobs.

use serde::{Deserialize, Serialize};

use crate::schema::ExportKind;
use crate::{GenerationId, IndividualId, JobId, JobStatus, PictureSize};

/// Body of `POST /v1/exports`. Exactly one of `individuals`, `generation` and `job` must be given.
#[derive(Debug, Clone, PartialEq, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CreateExport {
    /// Individuals to export, at most 256.
    pub individuals: Option<Vec<IndividualId>>,
    /// Generation whose children are exported, a whole brood.
    pub generation: Option<GenerationId>,
    /// Search whose front is exported.
    pub job: Option<JobId>,
    /// Formats: `brood`, `png`, `exr`, and names from `GET /v1/exports`.
    pub formats: Vec<String>,
    /// Size of the pictures in pixels: the side of a square, or width and height; each side 16 to
    /// 2048, default 256.
    pub size: Option<PictureSize>,
    /// True to apply the energy limit to exports; default: true for formats that path tracers read,
    /// as in the genome for others.
    pub energy_limit: Option<bool>,
}

/// Export that is made as a job.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct ExportAnswer {
    /// Id of the job.
    pub id: JobId,
    /// Always `export`.
    #[schema(value_type = ExportKind)]
    pub kind: String,
    /// State of the job.
    pub state: JobStatus,
    /// Reason of a failure. `worker_lost`: its workers died repeatedly.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Share of the files that are made, 0 to 1.
    pub progress: f64,
    /// Number of files that workers make; pictures, which are made while the archive is sent, and
    /// the manifest are not counted.
    pub files: u32,
    /// Number of those that are made.
    pub made: u32,
    /// Size of the made files in bytes, before compression.
    pub bytes: u64,
    /// Path of the archive, once the job has succeeded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub archive: Option<String>,
    /// Creation time, in milliseconds since 1970-01-01 UTC.
    pub created_ms: i64,
    /// Time of the first lease, in milliseconds since 1970-01-01 UTC.
    pub started_ms: Option<i64>,
    /// Time of the end, in milliseconds since 1970-01-01 UTC.
    pub ended_ms: Option<i64>,
    /// Time at which the job and its files are deleted, in milliseconds since 1970-01-01 UTC;
    /// earlier if later exports need the space. Null until the job has ended.
    pub expires_ms: Option<i64>,
}
