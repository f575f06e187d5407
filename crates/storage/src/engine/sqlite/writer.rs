//! Writer task: owns the write connection and groups write operations into transactions.
//!
//! Operations arrive through a bounded channel. The task takes one, opens a transaction and adds
//! all operations that have arrived until the channel is empty. Each operation has its own
//! savepoint; one commit makes the group durable, and then every operation is answered. Under load,
//! operations that arrive during a commit share the next one; a single operation is committed
//! immediately. No timer is needed in either case. Statements between operations are sent to the
//! connection's thread together, because each round trip waits for a processor.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use tokio::sync::{mpsc, oneshot};

use super::checkpoint::{close_connection, run_checkpoint};
use super::lock::DirectoryLock;
use crate::StorageError;
use crate::error::{FailureScope, Result};
use crate::sql::{Conn, query};
use crate::write::{CommitTimes, Durability, WriteFuture};

/// Capacity of the channel. If it is full, [`StorageError::Busy`] is returned.
const CHANNEL_OPERATIONS: usize = 256;
/// Largest group. It bounds the latency of a group's first operation.
const GROUP_OPERATIONS: usize = 128;
/// Checkpoint when idle: the log contains this many operations and none arrived for
/// `CHECKPOINT_IDLE`.
const CHECKPOINT_OPERATIONS: usize = 8;
const CHECKPOINT_IDLE: Duration = Duration::from_millis(250);
/// Unconditional checkpoint: the log contains this many pages (24 MiB). The next write waits for
/// it, tens of milliseconds on a slow disk; with continuous breeding fewer than 1 in 100 writes do.
const CHECKPOINT_PAGES: i64 = 6144;
/// The length of the log is checked after every durable write, and after this many operations of
/// any kind.
const LOG_CHECK_OPERATIONS: usize = 64;

/// Answers a caller, with the operation's result or with the error of its group.
type Reply = Box<dyn FnOnce(Result<GroupTimes>) + Send>;

/// End times of the stages of a group.
#[derive(Debug, Clone, Copy)]
struct GroupTimes {
    started: Instant,
    written: Instant,
    synced: Instant,
}

/// Operation with the channel for its answer.
struct Pending<T, F> {
    operation: F,
    enqueued: Instant,
    answer: oneshot::Sender<Result<(T, CommitTimes)>>,
}

/// Type-erased [`Pending`].
trait Operation: Send {
    fn run<'c>(self: Box<Self>, conn: &'c mut Conn) -> WriteFuture<'c, Executed>;
    fn reject(self: Box<Self>, error: StorageError);
}

/// Operation that has run but is not committed yet.
struct Executed {
    /// Scope of the failure, if the operation failed.
    failure: Option<FailureScope>,
    reply: Reply,
}

impl<T, F> Operation for Pending<T, F>
where
    T: Send + 'static,
    F: for<'c> FnOnce(&'c mut Conn) -> WriteFuture<'c, Result<T>> + Send + 'static,
{
    fn run<'c>(self: Box<Self>, conn: &'c mut Conn) -> WriteFuture<'c, Executed> {
        Box::pin(async move {
            let result = (self.operation)(conn).await;
            let failure = result.as_ref().err().map(StorageError::failure_scope);
            if let (Some(FailureScope::Transaction | FailureScope::Store), Err(error)) =
                (failure, &result)
            {
                tracing::error!(%error, detail = ?error, "write failed");
            }
            let (answer, enqueued) = (self.answer, self.enqueued);
            let reply = Box::new(move |outcome: Result<GroupTimes>| {
                let committed = |times: GroupTimes| CommitTimes {
                    queued: times.started.saturating_duration_since(enqueued),
                    written: times.written - times.started,
                    synced: times.synced - times.written,
                };
                let answered = outcome.and_then(|times| Ok((result?, committed(times))));
                // The caller may be gone; the write is committed nevertheless.
                let _ = answer.send(answered);
            });
            Executed { failure, reply }
        })
    }

    fn reject(self: Box<Self>, error: StorageError) {
        let _ = self.answer.send(Err(error));
    }
}

/// Operation with the durability that its caller needs.
struct Request {
    durability: Durability,
    operation: Box<dyn Operation>,
}

/// Message to the task.
enum Message {
    Write(Request),
    Close(oneshot::Sender<Result<()>>),
}

/// Sending end of the channel.
#[derive(Debug, Clone)]
pub(crate) struct Writer {
    sender: mpsc::Sender<Message>,
    poisoned: Arc<AtomicBool>,
    /// Number of writes refused since the start.
    refused: Arc<AtomicU64>,
}

impl Writer {
    /// Starts the task. It ends on [`Writer::close`] or when all senders are dropped.
    pub(crate) fn start(
        conn: Conn,
        lock: Option<DirectoryLock>,
    ) -> (Self, tokio::task::JoinHandle<()>) {
        let (sender, receiver) = mpsc::channel(CHANNEL_OPERATIONS);
        let poisoned = Arc::new(AtomicBool::new(false));
        let task = WriterTask {
            conn: Some(conn),
            receiver,
            poisoned: Arc::clone(&poisoned),
            lock,
            synced: true,
            logged: 0,
            checked: 0,
            copied_pages: 0,
        };
        (Self { sender, poisoned, refused: Arc::default() }, tokio::spawn(task.run()))
    }

    /// True if a write to the disk has failed.
    pub(crate) fn is_poisoned(&self) -> bool {
        self.poisoned.load(Ordering::Acquire)
    }

    /// Runs an operation in a transaction, and returns when it is committed.
    pub(crate) async fn write<T, F>(
        &self,
        durability: Durability,
        operation: F,
    ) -> Result<(T, CommitTimes)>
    where
        T: Send + 'static,
        F: for<'c> FnOnce(&'c mut Conn) -> WriteFuture<'c, Result<T>> + Send + 'static,
    {
        let (answer, answered) = oneshot::channel();
        let operation = Box::new(Pending { operation, enqueued: Instant::now(), answer });
        let message = Message::Write(Request { durability, operation });
        use StorageError::{Busy, Full, Gone, Poisoned};
        let written = match self.sender.try_send(message) {
            Ok(()) => answered.await.unwrap_or_else(|_| Err(self.ended())),
            Err(mpsc::error::TrySendError::Full(_)) => Err(Busy),
            Err(mpsc::error::TrySendError::Closed(_)) => Err(self.ended()),
        };
        if matches!(written, Err(Busy | Full | Gone | Poisoned)) {
            self.refused.fetch_add(1, Ordering::Relaxed);
        }
        written
    }

    /// Number of writes refused since the start.
    pub(crate) fn refused(&self) -> u64 {
        self.refused.load(Ordering::Relaxed)
    }

    /// Waits for pending writes, then closes the connection.
    pub(crate) async fn close(&self) -> Result<()> {
        let (answer, answered) = oneshot::channel();
        self.sender.send(Message::Close(answer)).await.map_err(|_| self.ended())?;
        answered.await.unwrap_or_else(|_| Err(self.ended()))
    }

    fn ended(&self) -> StorageError {
        if self.is_poisoned() { StorageError::Poisoned } else { StorageError::Closed }
    }
}

/// State of the task.
struct WriterTask {
    /// `None` once the store is poisoned.
    conn: Option<Conn>,
    receiver: mpsc::Receiver<Message>,
    poisoned: Arc<AtomicBool>,
    lock: Option<DirectoryLock>,
    /// True if the connection flushes to disk at each commit (`synchronous=FULL`).
    synced: bool,
    /// Number of operations committed since the last checkpoint.
    logged: usize,
    /// Value of `logged` when the length of the log was last checked.
    checked: usize,
    /// Number of pages in the log after the last checkpoint. They stay until no reader needs them.
    copied_pages: i64,
}

impl Drop for WriterTask {
    fn drop(&mut self) {
        // A panic in an operation has unwound the task: later writes must not report `Closed`,
        // which means a clean shutdown.
        if std::thread::panicking() {
            self.poisoned.store(true, Ordering::Release);
        }
    }
}

impl WriterTask {
    /// Processes messages until the store is closed or all senders are dropped.
    async fn run(mut self) {
        let mut next = self.receiver.recv().await;
        while let Some(message) = next {
            let deferred = match message {
                Message::Write(first) => self.commit_group(first).await,
                Message::Close(answer) => return self.close(answer).await,
            };
            next = match deferred {
                Some(message) => Some(message),
                None => self.wait().await,
            };
        }
        if let Some(conn) = self.conn.take()
            && let Err(error) = conn.close().await
        {
            tracing::error!(%error, "cannot close the database");
        }
        drop(self.lock.take());
    }

    /// Returns the next message. Checkpoints in idle time.
    async fn wait(&mut self) -> Option<Message> {
        // After a durable write this connection is usually idle, because rendering follows.
        if self.logged > 0 && (self.synced || self.logged >= self.checked + LOG_CHECK_OPERATIONS) {
            self.checked = self.logged;
            let pages = self.log_pages().await;
            if pages < self.copied_pages {
                // The log was restarted.
                self.copied_pages = 0;
            }
            if pages - self.copied_pages >= CHECKPOINT_PAGES {
                self.checkpoint().await;
            }
        }
        if self.logged >= CHECKPOINT_OPERATIONS {
            match tokio::time::timeout(CHECKPOINT_IDLE, self.receiver.recv()).await {
                Ok(message) => return message,
                Err(_) => self.checkpoint().await,
            }
        }
        self.receiver.recv().await
    }

    /// Returns the number of pages in the log. If it is unknown, returns a value that triggers a
    /// checkpoint, which reports the cause.
    async fn log_pages(&mut self) -> i64 {
        let Some(conn) = self.conn.as_mut() else { return 0 };
        run_checkpoint(conn, "PRAGMA wal_checkpoint(NOOP)").await.unwrap_or(i64::MAX)
    }

    /// Copies the log into the database file. SQLite's automatic checkpoint is off: it would run
    /// inside a caller's commit and hide its errors, but a failed flush here may be the only sign
    /// of a failing disk.
    async fn checkpoint(&mut self) {
        (self.logged, self.checked) = (0, 0);
        let Some(conn) = self.conn.as_mut() else { return };
        match run_checkpoint(conn, "PRAGMA wal_checkpoint(PASSIVE)").await {
            Ok(pages) => self.copied_pages = pages,
            // The log keeps everything until there is space.
            Err(error @ (StorageError::Full | StorageError::Busy)) => {
                tracing::warn!(%error, "cannot write the log back into the database yet");
            }
            Err(error) => self.poison(&error),
        }
    }

    /// Commits a group. Returns the message that ended it and is not yet processed.
    async fn commit_group(&mut self, first: Request) -> Option<Message> {
        let Some(conn) = self.conn.as_mut() else {
            first.operation.reject(StorageError::Poisoned);
            return None;
        };
        let durability = first.durability;
        let started = Instant::now();
        if let Err(error) = begin(conn, durability, &mut self.synced).await {
            match error {
                StorageError::Full | StorageError::Busy => first.operation.reject(error),
                error => {
                    first.operation.reject(StorageError::Poisoned);
                    self.poison(&error);
                }
            }
            return None;
        }
        let mut replies = Vec::new();
        let mut operation = first.operation;
        let mut written = started;
        let (end, deferred) = loop {
            let Executed { failure, reply } = operation.run(conn).await;
            replies.push(reply);
            let rollback = match failure {
                None => false,
                Some(FailureScope::Operation) => true,
                Some(FailureScope::Transaction) => break (Err(StorageError::Full), None),
                Some(FailureScope::Store) => break (Err(StorageError::Poisoned), None),
            };
            let full = replies.len() == GROUP_OPERATIONS;
            match if full { None } else { self.receiver.try_recv().ok() } {
                // A durable operation must not join a transaction that is not flushed to disk.
                Some(Message::Write(next)) if is_covered(next.durability, durability) => {
                    if let Err(error) =
                        execute(conn, if rollback { ROLLBACK_TO } else { RELEASE }).await
                    {
                        let full = error.failure_scope() == FailureScope::Transaction;
                        next.operation.reject(group_error(full));
                        break (Err(error), None);
                    }
                    operation = next.operation;
                }
                deferred => {
                    written = Instant::now();
                    let end = if rollback { ROLLBACK_AND_COMMIT } else { RELEASE_AND_COMMIT };
                    break (execute(conn, end).await, deferred);
                }
            }
        };
        // Checked after the commit: what is answered is in the directory.
        let is_gone = self.lock.as_ref().is_some_and(|lock| !lock.is_in_place());
        match if is_gone { Err(StorageError::Gone) } else { end } {
            Ok(()) => {
                self.logged += replies.len();
                let times = GroupTimes { started, written, synced: Instant::now() };
                replies.into_iter().for_each(|reply| reply(Ok(times)));
            }
            Err(error) => self.fail_group(error, replies).await,
        }
        deferred
    }

    /// Fails all operations of a group: rolls back if the disk is full, otherwise poisons the
    /// store.
    async fn fail_group(&mut self, error: StorageError, replies: Vec<Reply>) {
        let full = error.failure_scope() == FailureScope::Transaction;
        if full && let Some(conn) = self.conn.as_mut() {
            // SQLite may have rolled back already, so that there is nothing to roll back.
            if let Err(error) = execute(conn, "ROLLBACK").await {
                tracing::debug!(detail = ?error, "rollback after a full disk failed");
            }
        } else {
            self.poison(&error);
        }
        replies.into_iter().for_each(|reply| reply(Err(group_error(full))));
    }

    /// Rejects all writes until the process ends.
    fn poison(&mut self, error: &StorageError) {
        match error {
            StorageError::Gone => tracing::error!("{error}; the last write may be lost"),
            _ => {
                tracing::error!(%error, detail = ?error, "a write to the disk failed; the store is read-only")
            }
        }
        self.poisoned.store(true, Ordering::Release);
        // Closing the connection could run a checkpoint. It would copy pages that the disk may have
        // lost although the page cache still has them. Only the next start, which reads the disk,
        // may do that.
        std::mem::forget(self.conn.take());
    }

    /// Closes the connection. Rejects the messages that arrived after the request to close.
    async fn close(mut self, answer: oneshot::Sender<Result<()>>) {
        self.receiver.close();
        while let Some(message) = self.receiver.recv().await {
            match message {
                Message::Write(request) => request.operation.reject(StorageError::Closed),
                Message::Close(answer) => {
                    let _ = answer.send(Err(StorageError::Closed));
                }
            }
        }
        let result = match self.conn.take() {
            None if self.lock.as_ref().is_some_and(|lock| !lock.is_in_place()) => {
                Err(StorageError::Gone)
            }
            None => Err(StorageError::Poisoned),
            Some(conn) => close_connection(conn, self.lock.is_some()).await,
        };
        drop(self.lock.take());
        let _ = answer.send(result);
    }
}

/// True if a transaction of durability `given` is durable enough for an operation that needs
/// `wanted`.
fn is_covered(wanted: Durability, given: Durability) -> bool {
    given == Durability::PowerLoss || wanted == Durability::ProcessDeath
}

/// Error returned to every operation of a failed group.
fn group_error(full: bool) -> StorageError {
    if full { StorageError::Full } else { StorageError::Poisoned }
}

// Statements that begin a group, separate its operations and end it. `operation` is the savepoint
// of the current operation.
const BEGIN: &str = "BEGIN IMMEDIATE; SAVEPOINT operation";
// In WAL mode, the later FULL commit also flushes what earlier NORMAL commits have left in the log.
const BEGIN_SYNCED: &str = "PRAGMA synchronous = FULL; BEGIN IMMEDIATE; SAVEPOINT operation";
const BEGIN_UNSYNCED: &str = "PRAGMA synchronous = NORMAL; BEGIN IMMEDIATE; SAVEPOINT operation";
/// Keeps the changes of an operation and opens the savepoint of the next.
const RELEASE: &str = "RELEASE operation; SAVEPOINT operation";
/// The savepoint stays, and the next operation runs in it.
const ROLLBACK_TO: &str = "ROLLBACK TO operation";
// RELEASE is not needed for the commit. It detects an operation that ended its transaction: then it
// fails.
const RELEASE_AND_COMMIT: &str = "RELEASE operation; COMMIT";
const ROLLBACK_AND_COMMIT: &str = "ROLLBACK TO operation; RELEASE operation; COMMIT";

/// Opens a transaction with the requested durability, and the savepoint of its first operation.
async fn begin(conn: &mut Conn, durability: Durability, synced: &mut bool) -> Result<()> {
    let wanted = durability == Durability::PowerLoss;
    let sql = match (*synced == wanted, wanted) {
        (true, _) => BEGIN,
        (false, true) => BEGIN_SYNCED,
        (false, false) => BEGIN_UNSYNCED,
    };
    if !wanted {
        // Reset first: if only the pragma is executed, a durable write would otherwise skip the
        // flush.
        *synced = false;
    }
    execute(conn, sql).await?;
    *synced = wanted;
    Ok(())
}

async fn execute(conn: &mut Conn, sql: &'static str) -> Result<()> {
    query(sql).execute(conn).await?;
    Ok(())
}
