//! Jobs as they are answered.

use serde::{Deserialize, Serialize};

use crate::schema::RenderKind;
use crate::{JobId, Work};

/// Where a job stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum JobStatus {
    /// Waiting for a worker.
    Queued,
    /// In a worker's hands.
    Running,
    /// Done.
    Succeeded,
    /// It cannot be done.
    Failed,
}

/// How long a job took.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, utoipa::ToSchema)]
pub struct JobTimes {
    /// From being made to a worker's lease, in microseconds.
    pub queued_us: u64,
    /// From the lease to the results, in microseconds: rendering, and the way to the worker and back.
    pub leased_us: u64,
}

/// Answer of `GET /v1/jobs/{id}`. Render jobs that are done are remembered for a while, and not over a restart.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct JobAnswer {
    /// Its id.
    pub id: JobId,
    /// `render`.
    #[schema(value_type = RenderKind)]
    pub kind: String,
    /// Where it stands.
    pub state: JobStatus,
    /// Why it failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// What it took and what it did not have to do; once it is done.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub work: Option<Work>,
    /// How long it took; once it is done.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub times: Option<JobTimes>,
}
