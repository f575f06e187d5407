//! Write operations, as the tables' modules give them to an engine.

use std::pin::Pin;
use std::time::Duration;

/// Future of an operation, on its connection.
pub(crate) type WriteFuture<'c, T> = Pin<Box<dyn Future<Output = T> + Send + 'c>>;
/// Operation of a [`WriteFuture`]; the body awaits on the connection `$conn`.
macro_rules! operation {
    (|$conn:ident| $body:expr) => {
        move |$conn| Box::pin(async move { $body })
    };
}
pub(crate) use operation;

/// Durations of the stages of a write.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CommitTimes {
    /// Waiting for earlier writes.
    pub queued: Duration,
    /// Running the statements of the group.
    pub written: Duration,
    /// Committing: writing the log and flushing it to disk.
    pub synced: Duration,
}

/// Failure that an answered write survives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Durability {
    /// Power loss: for data that cannot be computed again.
    PowerLoss,
    /// End of the process: for work that is repeated if it is lost.
    ProcessDeath,
}
