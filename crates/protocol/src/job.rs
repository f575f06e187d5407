//! Responses for render jobs.

use serde::{Deserialize, Serialize};

use crate::schema::RenderKind;
use crate::{JobId, RenderStats};

brood_brdf::named_enum! {
    /// State of a render job or an export.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, utoipa::ToSchema)]
    #[serde(rename_all = "lowercase")]
    pub enum JobStatus {
        /// Waiting for a worker.
        Queued => "queued",
        /// Leased to a worker.
        Running => "running",
        /// Completed.
        Succeeded => "succeeded",
        /// Failed for good: it is not tried again.
        Failed => "failed",
        /// Cancelled by a user; exports only.
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
