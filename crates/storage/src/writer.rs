//! The one task that writes. Owns the write connection, its transactions and their order; refuses to know what is
//! written.
//!
//! Operations come over a bounded channel. The task takes one, opens a transaction, and keeps taking what has arrived
//! until the channel is empty; each operation runs in a savepoint of its own, one commit makes them all durable, and
//! then all are answered. Under load the operations that arrive while the disk is busy share the next commit, and a
//! lone one is committed at once: no timer is needed for either.

use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

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
const CHECKPOINT_SILENCE: Duration = Duration::from_millis(20);
/// ... and in any case when so many are.
const CHECKPOINT_MOST_OPERATIONS: usize = 64;

/// A future on the write connection.
pub(crate) type Running<'c, T> = Pin<Box<dyn Future<Output = T> + Send + 'c>>;
/// Answers a caller: with the operation's own result, or with what became of the whole group.
type Settle = Box<dyn FnOnce(Result<(), StorageError>) + Send>;

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
    answer: oneshot::Sender<Result<T, StorageError>>,
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
            let answer = self.answer;
            // A caller that has gone away does not matter: the write happened all the same.
            let settle = Box::new(move |fate: Result<(), StorageError>| {
                let _ = answer.send(fate.and(result));
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
    ) -> Result<T, StorageError>
    where
        T: Send + 'static,
        F: for<'c> FnOnce(&'c mut SqliteConnection) -> Running<'c, Result<T, StorageError>>
            + Send
            + 'static,
    {
        let (answer, answered) = oneshot::channel();
        let operation = Box::new(Pending { operation, answer });
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
        if self.logged >= CHECKPOINT_MOST_OPERATIONS {
            self.checkpoint().await;
        } else if self.logged >= CHECKPOINT_OPERATIONS {
            match tokio::time::timeout(CHECKPOINT_SILENCE, self.receiver.recv()).await {
                Ok(message) => return message,
                Err(_) => self.checkpoint().await,
            }
        }
        self.receiver.recv().await
    }

    /// Copies the log into the file. SQLite would do it by itself, inside of somebody's commit, and would keep a
    /// failure to itself; but a flush that fails here may be the only one that tells of a failing disk.
    async fn checkpoint(&mut self) {
        self.logged = 0;
        let Some(conn) = self.conn.as_mut() else { return };
        match execute(conn, "PRAGMA wal_checkpoint(PASSIVE)").await {
            Ok(()) => {}
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
        let mut held = None;
        let mut request = Some(first);
        let mut end = Ok(());
        while let Some(Request { operation, .. }) = request.take() {
            let (settle, ran) = run_in_savepoint(conn, operation).await;
            settles.extend(settle);
            if let Err(error) = ran {
                end = Err(error);
                break;
            }
            if settles.len() == GROUP_OPERATIONS {
                break;
            }
            match self.receiver.try_recv() {
                // A fact must not ride in a transaction that does not wait for the disk.
                Ok(Message::Write(next)) if is_covered(next.durability, durability) => {
                    request = Some(next);
                }
                Ok(message) => held = Some(message),
                Err(_) => {}
            }
        }
        if end.is_ok() {
            end = execute(conn, "COMMIT").await;
        }
        match end {
            Ok(()) => {
                self.logged += settles.len();
                settles.into_iter().for_each(|settle| settle(Ok(())));
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
        let fate = || if full { StorageError::Full } else { StorageError::Poisoned };
        settles.into_iter().for_each(|settle| settle(Err(fate())));
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

/// Opens a transaction that commits with the durability asked for.
async fn begin(
    conn: &mut SqliteConnection,
    durability: Durability,
    synced: &mut bool,
) -> Result<(), StorageError> {
    let wanted = durability == Durability::PowerLoss;
    if *synced != wanted {
        // In WAL mode the later FULL commit also flushes what earlier NORMAL ones have left in the log.
        let pragma =
            if wanted { "PRAGMA synchronous = FULL" } else { "PRAGMA synchronous = NORMAL" };
        execute(conn, pragma).await?;
        *synced = wanted;
    }
    execute(conn, "BEGIN IMMEDIATE").await
}

/// Runs one operation; an error ends the group.
async fn run_in_savepoint(
    conn: &mut SqliteConnection,
    operation: Box<dyn Operation>,
) -> (Option<Settle>, Result<(), StorageError>) {
    if let Err(error) = execute(conn, "SAVEPOINT operation").await {
        let full = error.reach() == Reach::Transaction;
        operation.refuse(if full { StorageError::Full } else { StorageError::Poisoned });
        return (None, Err(error));
    }
    let Ran { failure, settle } = operation.run(conn).await;
    let end = match failure {
        None => execute(conn, "RELEASE operation").await,
        Some(Reach::Operation) => match execute(conn, "ROLLBACK TO operation").await {
            Ok(()) => execute(conn, "RELEASE operation").await,
            Err(error) => Err(error),
        },
        Some(Reach::Transaction) => Err(StorageError::Full),
        Some(Reach::Store) => Err(StorageError::Poisoned),
    };
    // Anything but a full disk that befalls a savepoint means that the transaction is not what it seems.
    let end = end.map_err(|error| match error.reach() {
        Reach::Operation => {
            tracing::error!(detail = ?error, "a savepoint is lost");
            StorageError::Poisoned
        }
        _ => error,
    });
    (Some(settle), end)
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

async fn execute(conn: &mut SqliteConnection, sql: &'static str) -> Result<(), StorageError> {
    sqlx::query(sql).execute(conn).await?;
    Ok(())
}
