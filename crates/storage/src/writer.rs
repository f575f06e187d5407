//! The one task that writes. Owns the write connection, its transactions and their order; refuses to know what is
//! written.
//!
//! Operations come over a bounded channel. The task takes one, opens a transaction, and keeps taking what has arrived
//! until the channel is empty; each operation runs in a savepoint of its own, one commit makes them all durable, and
//! then all are answered. Under load the operations that arrive while the disk is busy share the next commit, and a
//! lone one is committed at once: no timer is needed for either. Statements between operations go to the connection's
//! thread together, because each way there and back waits for a processor.

use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use sqlx::{Connection, Row, SqliteConnection};
use tokio::sync::{mpsc, oneshot};

use crate::StorageError;
use crate::error::Reach;
use crate::lock::DirectoryLock;

/// More than this waiting is answered as busy.
const CHANNEL_OPERATIONS: usize = 256;
/// Bounds how long the first of a group waits for the others.
const GROUP_OPERATIONS: usize = 128;
/// The log is copied into the file when so many operations are in it and nothing was asked for a while ...
const CHECKPOINT_OPERATIONS: usize = 8;
const CHECKPOINT_SILENCE: Duration = Duration::from_millis(250);
/// ... and in any case when it has so many pages, 24 MiB of them. Whoever writes next waits for that, tens of
/// milliseconds on a slow disk; among broods without a pause in between it is fewer than one in a hundred.
const CHECKPOINT_PAGES: i64 = 6144;
/// How long the log is, is looked at after each fact, and after so many operations of any kind.
const LOOK_OPERATIONS: usize = 64;

/// A future on the write connection.
pub(crate) type Running<'c, T> = Pin<Box<dyn Future<Output = T> + Send + 'c>>;
/// Answers a caller: with the operation's own result, or with what became of the whole group.
type Settle = Box<dyn FnOnce(Result<Times, StorageError>) + Send>;

/// When the stages of a group ended.
#[derive(Debug, Clone, Copy)]
struct Times {
    begun: Instant,
    written: Instant,
    synced: Instant,
}

/// Where the time of a write went.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Committed {
    /// Waiting for the writes before it.
    pub queued: Duration,
    /// Running the statements of its group.
    pub written: Duration,
    /// Committing: writing the log and waiting for the disk.
    pub synced: Duration,
}

/// What an answered write survives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Durability {
    /// The loss of power: for facts.
    PowerLoss,
    /// The death of the process: for what is made again when it is lost.
    ProcessDeath,
}

/// An operation with the channel that its answer goes to.
struct Pending<T, F> {
    operation: F,
    asked: Instant,
    answer: oneshot::Sender<Result<(T, Committed), StorageError>>,
}

/// [`Pending`] with its types forgotten.
trait Operation: Send {
    fn run<'c>(self: Box<Self>, conn: &'c mut SqliteConnection) -> Running<'c, Ran>;
    fn refuse(self: Box<Self>, error: StorageError);
}

/// An operation that was run but is not committed yet.
struct Ran {
    /// Where it failed, how far that reaches.
    failure: Option<Reach>,
    settle: Settle,
}

impl<T, F> Operation for Pending<T, F>
where
    T: Send + 'static,
    F: for<'c> FnOnce(&'c mut SqliteConnection) -> Running<'c, Result<T, StorageError>>
        + Send
        + 'static,
{
    fn run<'c>(self: Box<Self>, conn: &'c mut SqliteConnection) -> Running<'c, Ran> {
        Box::pin(async move {
            let result = (self.operation)(conn).await;
            let failure = result.as_ref().err().map(StorageError::reach);
            if let (Some(Reach::Transaction | Reach::Store), Err(error)) = (failure, &result) {
                tracing::error!(%error, detail = ?error, "a write failed");
            }
            let (answer, asked) = (self.answer, self.asked);
            let settle = Box::new(move |fate: Result<Times, StorageError>| {
                let committed = |times: Times| Committed {
                    queued: times.begun.saturating_duration_since(asked),
                    written: times.written - times.begun,
                    synced: times.synced - times.written,
                };
                let answered = fate.and_then(|times| Ok((result?, committed(times))));
                // A caller that has gone away does not matter: the write happened all the same.
                let _ = answer.send(answered);
            });
            Ran { failure, settle }
        })
    }

    fn refuse(self: Box<Self>, error: StorageError) {
        let _ = self.answer.send(Err(error));
    }
}

struct Request {
    durability: Durability,
    operation: Box<dyn Operation>,
}

enum Message {
    Write(Request),
    Close(oneshot::Sender<Result<(), StorageError>>),
}

/// The callers' end of the channel.
#[derive(Debug, Clone)]
pub(crate) struct Writer {
    sender: mpsc::Sender<Message>,
    poisoned: Arc<AtomicBool>,
}

impl Writer {
    /// Starts the task. It ends when it is told to close, or when all callers are gone.
    pub(crate) fn start(
        conn: SqliteConnection,
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
            looked: 0,
            copied_pages: 0,
        };
        (Self { sender, poisoned }, tokio::spawn(task.run()))
    }

    /// Whether a write to the disk has failed.
    pub(crate) fn is_poisoned(&self) -> bool {
        self.poisoned.load(Ordering::Acquire)
    }

    /// Runs an operation in a transaction, and returns when it is committed.
    pub(crate) async fn write<T, F>(
        &self,
        durability: Durability,
        operation: F,
    ) -> Result<(T, Committed), StorageError>
    where
        T: Send + 'static,
        F: for<'c> FnOnce(&'c mut SqliteConnection) -> Running<'c, Result<T, StorageError>>
            + Send
            + 'static,
    {
        let (answer, answered) = oneshot::channel();
        let operation = Box::new(Pending { operation, asked: Instant::now(), answer });
        let message = Message::Write(Request { durability, operation });
        match self.sender.try_send(message) {
            Ok(()) => answered.await.unwrap_or_else(|_| Err(self.ended())),
            Err(mpsc::error::TrySendError::Full(_)) => Err(StorageError::Busy),
            Err(mpsc::error::TrySendError::Closed(_)) => Err(self.ended()),
        }
    }

    /// Waits for the writes that were asked for before, then closes the connection.
    pub(crate) async fn close(&self) -> Result<(), StorageError> {
        let (answer, answered) = oneshot::channel();
        self.sender.send(Message::Close(answer)).await.map_err(|_| self.ended())?;
        answered.await.unwrap_or_else(|_| Err(self.ended()))
    }

    fn ended(&self) -> StorageError {
        if self.is_poisoned() { StorageError::Poisoned } else { StorageError::Closed }
    }
}

struct WriterTask {
    /// None once the store is poisoned.
    conn: Option<SqliteConnection>,
    receiver: mpsc::Receiver<Message>,
    poisoned: Arc<AtomicBool>,
    lock: Option<DirectoryLock>,
    /// Whether the connection is set to wait for the disk at each commit.
    synced: bool,
    /// Operations committed since the log was last copied into the file.
    logged: usize,
    /// How many of them there were when the length of the log was last looked at.
    looked: usize,
    /// Pages that were in the log when it was last copied: they stay there until no reader needs them.
    copied_pages: i64,
}

impl Drop for WriterTask {
    fn drop(&mut self) {
        // A bug in an operation has unwound the task: what callers are told must not be that all is well.
        if std::thread::panicking() {
            self.poisoned.store(true, Ordering::Release);
        }
    }
}

impl WriterTask {
    async fn run(mut self) {
        let mut next = self.receiver.recv().await;
        while let Some(message) = next {
            let held = match message {
                Message::Write(first) => self.commit_group(first).await,
                Message::Close(answer) => return self.close(answer).await,
            };
            next = match held {
                Some(message) => Some(message),
                None => self.wait().await,
            };
        }
        if let Some(conn) = self.conn.take()
            && let Err(error) = conn.close().await
        {
            tracing::error!(%error, "closing the database failed");
        }
        drop(self.lock.take());
    }

    /// The next message; silence is used for copying the log into the file.
    async fn wait(&mut self) -> Option<Message> {
        // A fact is followed by work elsewhere, mostly rendering: nobody waits for this connection then.
        if self.logged > 0 && (self.synced || self.logged >= self.looked + LOOK_OPERATIONS) {
            self.looked = self.logged;
            let pages = self.log_pages().await;
            if pages < self.copied_pages {
                // It was begun anew.
                self.copied_pages = 0;
            }
            if pages - self.copied_pages >= CHECKPOINT_PAGES {
                self.checkpoint().await;
            }
        }
        if self.logged >= CHECKPOINT_OPERATIONS {
            match tokio::time::timeout(CHECKPOINT_SILENCE, self.receiver.recv()).await {
                Ok(message) => return message,
                Err(_) => self.checkpoint().await,
            }
        }
        self.receiver.recv().await
    }

    /// Pages in the log. Where it cannot be found out, the next copying will tell why.
    async fn log_pages(&mut self) -> i64 {
        let Some(conn) = self.conn.as_mut() else { return 0 };
        pages_after(conn, "PRAGMA wal_checkpoint(NOOP)").await.unwrap_or(i64::MAX)
    }

    /// Copies the log into the file. SQLite would do it by itself, inside of somebody's commit, and would keep a
    /// failure to itself; but a flush that fails here may be the only one that tells of a failing disk.
    async fn checkpoint(&mut self) {
        (self.logged, self.looked) = (0, 0);
        let Some(conn) = self.conn.as_mut() else { return };
        match pages_after(conn, "PRAGMA wal_checkpoint(PASSIVE)").await {
            Ok(pages) => self.copied_pages = pages,
            // The log keeps everything until there is room for it.
            Err(error @ (StorageError::Full | StorageError::Busy)) => {
                tracing::warn!(%error, "the log cannot be copied into the database yet");
            }
            Err(error) => self.poison(&error),
        }
    }

    /// Writes a group; returns the message that ended it, which is still to be dealt with.
    async fn commit_group(&mut self, first: Request) -> Option<Message> {
        let Some(conn) = self.conn.as_mut() else {
            first.operation.refuse(StorageError::Poisoned);
            return None;
        };
        let durability = first.durability;
        let begun = Instant::now();
        if let Err(error) = begin(conn, durability, &mut self.synced).await {
            match error {
                StorageError::Full | StorageError::Busy => first.operation.refuse(error),
                error => {
                    first.operation.refuse(StorageError::Poisoned);
                    self.poison(&error);
                }
            }
            return None;
        }
        let mut settles = Vec::new();
        let mut operation = first.operation;
        let mut written = begun;
        let (end, held) = loop {
            let Ran { failure, settle } = operation.run(conn).await;
            settles.push(settle);
            let undo = match failure {
                None => false,
                Some(Reach::Operation) => true,
                Some(Reach::Transaction) => break (Err(StorageError::Full), None),
                Some(Reach::Store) => break (Err(StorageError::Poisoned), None),
            };
            let full = settles.len() == GROUP_OPERATIONS;
            match if full { None } else { self.receiver.try_recv().ok() } {
                // A fact must not ride in a transaction that does not wait for the disk.
                Some(Message::Write(next)) if is_covered(next.durability, durability) => {
                    if let Err(error) = execute(conn, if undo { UNDO } else { KEEP }).await {
                        let full = error.reach() == Reach::Transaction;
                        next.operation.refuse(fate(full));
                        break (Err(error), None);
                    }
                    operation = next.operation;
                }
                held => {
                    written = Instant::now();
                    let end = if undo { UNDO_AND_COMMIT } else { KEEP_AND_COMMIT };
                    break (execute(conn, end).await, held);
                }
            }
        };
        match end {
            Ok(()) => {
                self.logged += settles.len();
                let times = Times { begun, written, synced: Instant::now() };
                settles.into_iter().for_each(|settle| settle(Ok(times)));
            }
            Err(error) => self.give_up(error, settles).await,
        }
        held
    }

    /// Rolls the transaction back after a full disk; stops for good after anything else.
    async fn give_up(&mut self, error: StorageError, settles: Vec<Settle>) {
        let full = error.reach() == Reach::Transaction;
        if full && let Some(conn) = self.conn.as_mut() {
            // SQLite may have rolled back by itself already, and then says that there is nothing to roll back.
            if let Err(error) = execute(conn, "ROLLBACK").await {
                tracing::debug!(detail = ?error, "rolling back after a full disk");
            }
        } else {
            self.poison(&error);
        }
        settles.into_iter().for_each(|settle| settle(Err(fate(full))));
    }

    /// Stops writing until the process ends.
    fn poison(&mut self, error: &StorageError) {
        tracing::error!(%error, detail = ?error, "the store takes no more writes");
        self.poisoned.store(true, Ordering::Release);
        // Closing the connection could checkpoint: it would copy pages that the disk may have lost while the page
        // cache still shows them. Only the next start, reading what is really there, may do that.
        std::mem::forget(self.conn.take());
    }

    async fn close(mut self, answer: oneshot::Sender<Result<(), StorageError>>) {
        self.receiver.close();
        while let Some(message) = self.receiver.recv().await {
            match message {
                Message::Write(request) => request.operation.refuse(StorageError::Closed),
                Message::Close(answer) => {
                    let _ = answer.send(Err(StorageError::Closed));
                }
            }
        }
        let result = match self.conn.take() {
            None => Err(StorageError::Poisoned),
            Some(conn) => shut(conn, self.lock.is_some()).await,
        };
        drop(self.lock.take());
        let _ = answer.send(result);
    }
}

fn is_covered(wanted: Durability, given: Durability) -> bool {
    given == Durability::PowerLoss || wanted == Durability::ProcessDeath
}

/// What a group is told that came to nothing.
fn fate(full: bool) -> StorageError {
    if full { StorageError::Full } else { StorageError::Poisoned }
}

const BEGIN: &str = "BEGIN IMMEDIATE; SAVEPOINT operation";
// In WAL mode the later FULL commit also flushes what earlier NORMAL ones have left in the log.
const BEGIN_SYNCED: &str = "PRAGMA synchronous = FULL; BEGIN IMMEDIATE; SAVEPOINT operation";
const BEGIN_UNSYNCED: &str = "PRAGMA synchronous = NORMAL; BEGIN IMMEDIATE; SAVEPOINT operation";
const KEEP: &str = "RELEASE operation; SAVEPOINT operation";
/// The savepoint stays, and the next operation runs in it.
const UNDO: &str = "ROLLBACK TO operation";
// Releasing is not needed for the commit: it fails where an operation has ended the transaction that it ran in.
const KEEP_AND_COMMIT: &str = "RELEASE operation; COMMIT";
const UNDO_AND_COMMIT: &str = "ROLLBACK TO operation; RELEASE operation; COMMIT";

/// Opens a transaction that commits with the durability asked for, and the savepoint of its first operation.
async fn begin(
    conn: &mut SqliteConnection,
    durability: Durability,
    synced: &mut bool,
) -> Result<(), StorageError> {
    let wanted = durability == Durability::PowerLoss;
    let sql = match (*synced == wanted, wanted) {
        (true, _) => BEGIN,
        (false, true) => BEGIN_SYNCED,
        (false, false) => BEGIN_UNSYNCED,
    };
    if !wanted {
        // Not believed to be synced even if only the first statement is done: a fact would not be durable.
        *synced = false;
    }
    execute(conn, sql).await?;
    *synced = wanted;
    Ok(())
}

/// Empties the log into the file and closes. Whoever came second leaves the log to the first.
async fn shut(mut conn: SqliteConnection, owner: bool) -> Result<(), StorageError> {
    if owner {
        match empty_log(&mut conn).await {
            Ok(true) => {}
            Ok(false) => tracing::warn!("a reader kept the log from being emptied"),
            Err(error) => {
                // Closing would try the same again: see `poison`.
                std::mem::forget(conn);
                return Err(error);
            }
        }
    }
    Ok(conn.close().await?)
}

/// Whether nobody stood in the way.
async fn empty_log(conn: &mut SqliteConnection) -> Result<bool, StorageError> {
    let row = sqlx::query("PRAGMA wal_checkpoint(TRUNCATE)").fetch_one(conn).await?;
    Ok(row.try_get::<i64, _>(0)? == 0)
}

/// Runs a checkpoint of some kind; returns how many pages are in the log.
async fn pages_after(conn: &mut SqliteConnection, sql: &'static str) -> Result<i64, StorageError> {
    Ok(sqlx::query(sql).fetch_one(conn).await?.try_get(1)?)
}

async fn execute(conn: &mut SqliteConnection, sql: &'static str) -> Result<(), StorageError> {
    sqlx::query(sql).execute(conn).await?;
    Ok(())
}
