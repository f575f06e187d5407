//! Messages to the other servers.

use brood_protocol::{JobId, LineageId};
use serde::{Deserialize, Serialize};

/// Subject of an event stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Topic {
    /// Events of a lineage.
    Lineage(LineageId),
    /// Events of a search.
    Job(JobId),
}

impl From<LineageId> for Topic {
    fn from(id: LineageId) -> Self {
        Self::Lineage(id)
    }
}

impl From<JobId> for Topic {
    fn from(id: JobId) -> Self {
        Self::Job(id)
    }
}

/// Message to the other servers. A server of an earlier version that does not know a message does
/// what a loss of messages needs; it ignores fields that it does not know.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum Message {
    /// Event of a stream.
    Event {
        /// Stream.
        topic: Topic,
        /// Event type.
        name: String,
        /// Event data as JSON.
        data: String,
    },
    /// Event of a stream that is too long for the bus.
    Missed(Topic),
    /// A search waits for a worker.
    SearchWaits,
    /// An export waits for a worker.
    ExportWaits,
    /// Genomes were removed.
    GenomesRemoved,
}
