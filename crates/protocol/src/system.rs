//! What `/v1/system` tells.

use serde::{Deserialize, Serialize};

/// Which evaluator runs, and why.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, utoipa::ToSchema)]
pub struct BackendReport {
    /// `cpu`, `gpu` or `reference`.
    pub name: String,
    /// The adapter or instruction set it runs on.
    pub adapter: String,
    /// Whether it passed the exactness probe.
    pub exact: bool,
    /// Why it was chosen.
    pub reason: String,
}

/// Body of `GET /v1/system`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct SystemAnswer {
    /// Version of the program.
    pub version: String,
    /// Version of the renderer: part of every picture key.
    pub renderer_version: u32,
    /// The evaluator of the worker that reported last; null before the first report.
    pub backend: Option<BackendReport>,
    /// Workers heard of in the last minute.
    pub workers: Vec<String>,
    /// Version of the embedded database.
    pub sqlite_version: String,
    /// Limits by name, in the unit that the name ends in.
    pub limits: std::collections::BTreeMap<String, u64>,
}
