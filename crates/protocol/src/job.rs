//! Responses for render jobs.

use serde::{Deserialize, Serialize};

use crate::schema::{AnswerKind, RenderKind};
use crate::{JobId, RenderStats};

brood_brdf::named_enum! {
    /// State of a render job, an export or a deferred answer.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, utoipa::ToSchema)]
    #[serde(rename_all = "lowercase")]
    pub enum JobStatus {
        /// Waiting for a worker.
        Queued => "queued",
        /// Leased to a worker; of a deferred answer: its request is being handled.
        Running => "running",
        /// Completed.
        Succeeded => "succeeded",
        /// Failed for good: it is not tried again.
        Failed => "failed",
        /// Cancelled by a user; exports and deferred answers only.
        Cancelled => "cancelled",
    }
}

impl JobStatus {
    /// True if the job has ended for good.
    #[must_use]
    pub fn is_final(self) -> bool {
        matches!(self, Self::Succeeded | Self::Failed | Self::Cancelled)
    }
}

/// Durations of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, utoipa::ToSchema)]
pub struct JobTimes {
    /// Time in the queue, from creation to the lease, in microseconds.
    pub queued_us: u64,
    /// Time from the lease to the results, in microseconds: rendering and the transfers in both
    /// directions.
    pub leased_us: u64,
}

/// Render job. Completed render jobs are kept in memory for a limited time and are lost when the
/// server restarts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct JobAnswer {
    /// Id of the job.
    pub id: JobId,
    /// Always `render`.
    #[schema(value_type = RenderKind)]
    pub kind: String,
    /// State of the job.
    pub state: JobStatus,
    /// Reason of a failure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Render counters; present once the job has completed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub work: Option<RenderStats>,
    /// Durations; present once the job has completed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub times: Option<JobTimes>,
}

/// Answer to a request with `Prefer: respond-async` that was not ready in time. It is kept in
/// memory for a limited time and is lost when the server restarts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct DeferredAnswer {
    /// Id of the job.
    pub id: JobId,
    /// Always `answer`.
    #[schema(value_type = AnswerKind)]
    pub kind: String,
    /// State of the job: `running`, `succeeded`, `failed` or `cancelled`.
    pub state: JobStatus,
    /// Reason of a failure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Share of its pictures that are rendered, or of its children that are made, 0 to 1;
    /// approximate within a picture.
    pub progress: f64,
    /// Method of the request.
    pub method: String,
    /// Path and query of the request.
    pub request: String,
    /// Status of the answer, once it is ready: 4xx or 5xx if the job has failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub status: Option<u16>,
    /// Path of the answer, once it is ready.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub answer: Option<String>,
    /// Time of the request, in milliseconds since 1970-01-01 UTC.
    pub created_ms: i64,
    /// Time of the end, in milliseconds since 1970-01-01 UTC.
    pub ended_ms: Option<i64>,
    /// Time at which the answer is deleted, in milliseconds since 1970-01-01 UTC; earlier if later
    /// answers need the space. Null until the job has ended.
    pub expires_ms: Option<i64>,
}
