//! Response of `GET /v1/system`.

use serde::{Deserialize, Serialize};

/// Evaluator that a worker uses.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, utoipa::ToSchema)]
pub struct BackendReport {
    /// Kind of evaluator: `cpu`, `gpu` or `reference`.
    pub name: String,
    /// Name of the GPU adapter, or instruction set of the CPU.
    pub adapter: String,
    /// True if the evaluator passed the bit-exactness check.
    pub exact: bool,
    /// Reason for this choice.
    pub reason: String,
}

/// Response of `GET /v1/system`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct SystemAnswer {
    /// Version of the server.
    pub version: String,
    /// Version of the renderer. It is part of every picture key.
    pub renderer_version: u32,
    /// Evaluator of the worker that reported last; null before the first report.
    pub backend: Option<BackendReport>,
    /// Names of the workers that were active in the last minute.
    pub workers: Vec<String>,
    /// Engine of the database with its version, such as `SQLite 3.51.3` or `PostgreSQL 15.18`.
    pub database: String,
    /// Limits of the server by name. The last word of a name is its unit.
    pub limits: std::collections::BTreeMap<String, u64>,
}
