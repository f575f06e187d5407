//! What can go wrong in the store. Owns the reading of SQLite's result codes; refuses to know status codes, and names
//! no path in any message.

use sqlx::error::ErrorKind;

/// Why the store could not do what was asked.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StorageError {
    /// Nothing has that id, or something that the write refers to does not exist.
    #[error("there is no such thing")]
    NotFound,
    /// Another write was there first.
    #[error("{what} is taken or has changed")]
    Conflict {
        /// What the two writes meet in.
        what: &'static str,
    },
    /// The thing has changed since the caller read it.
    #[error("the version is {current} by now")]
    StaleVersion {
        /// Its present version.
        current: u64,
    },
    /// The disk is full. Nothing was written; reads go on, and writes work again when there is room.
    #[error("the disk is full")]
    Full,
    /// A write to the disk failed earlier. Nothing is written until the process is started again.
    #[error("an earlier write to the disk failed; the store takes no more writes")]
    Poisoned,
    /// More is waiting than the store takes on; nothing was written.
    #[error("the store is busy")]
    Busy,
    /// The work queue holds as many jobs as it may; nothing was written.
    #[error("the work queue is full")]
    QueueFull,
    /// Another process has the data directory.
    #[error("another brood server uses this data directory")]
    Locked,
    /// The store was closed.
    #[error("the store is closed")]
    Closed,
    /// The file, the library or a name is not one that this build can work with.
    #[error("{0}")]
    Unsupported(String),
    /// The file is damaged or holds what was never written.
    #[error("the database is damaged: {0}")]
    Corrupt(String),
    /// The data directory cannot be used.
    #[error("the data directory cannot be used: {}", .0.kind())]
    Directory(#[source] std::io::Error),
    /// Anything else that SQLite said.
    #[error("the database failed")]
    Database(#[source] sqlx::Error),
}

/// How far a failure inside a transaction reaches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Reach {
    /// The operation alone: its savepoint is rolled back.
    Operation,
    /// The transaction: it is rolled back, and the next one may work.
    Transaction,
    /// The disk cannot be trusted any more.
    Store,
}

const SQLITE_BUSY: i32 = 5;
const SQLITE_LOCKED: i32 = 6;
const SQLITE_IOERR: i32 = 10;
const SQLITE_CORRUPT: i32 = 11;
const SQLITE_FULL: i32 = 13;
const SQLITE_NOTADB: i32 = 26;
/// Growing the shared index of the log failed. Nothing was written, and the one usual cause is a full disk.
const SQLITE_IOERR_SHMSIZE: i32 = 4874;

/// The extended result code, where the error comes from SQLite itself.
fn code(error: &sqlx::Error) -> Option<i32> {
    error.as_database_error()?.code()?.parse().ok()
}

impl StorageError {
    /// How far this failure reaches when it happens in the middle of a transaction.
    pub(crate) fn reach(&self) -> Reach {
        match self {
            Self::Full => Reach::Transaction,
            Self::Poisoned => Reach::Store,
            Self::Database(sqlx::Error::Io(_) | sqlx::Error::WorkerCrashed) => Reach::Store,
            Self::Database(error) if code(error).is_some_and(|c| c & 0xff == SQLITE_IOERR) => {
                Reach::Store
            }
            _ => Reach::Operation,
        }
    }
}

impl From<sqlx::Error> for StorageError {
    fn from(error: sqlx::Error) -> Self {
        match &error {
            sqlx::Error::RowNotFound => return Self::NotFound,
            sqlx::Error::PoolTimedOut => return Self::Busy,
            sqlx::Error::PoolClosed => return Self::Closed,
            sqlx::Error::ColumnDecode { index, .. } => {
                return Self::Corrupt(format!("column {index} holds what was never written"));
            }
            _ => {}
        }
        let kind = error.as_database_error().map(|database| database.kind());
        match (kind, code(&error)) {
            (Some(ErrorKind::ForeignKeyViolation), _) => Self::NotFound,
            (Some(ErrorKind::UniqueViolation), _) => Self::Conflict { what: "the id" },
            (_, Some(SQLITE_IOERR_SHMSIZE)) => Self::Full,
            (_, Some(code)) => match code & 0xff {
                SQLITE_FULL => Self::Full,
                SQLITE_BUSY | SQLITE_LOCKED => Self::Busy,
                SQLITE_CORRUPT => Self::Corrupt("a page is malformed".to_owned()),
                SQLITE_NOTADB => Self::Corrupt("the file is no SQLite database".to_owned()),
                _ => Self::Database(error),
            },
            _ => Self::Database(error),
        }
    }
}

/// Reads a broken uniqueness as a conflict over `what`.
pub(crate) fn taken(what: &'static str) -> impl Fn(sqlx::Error) -> StorageError {
    move |error| match StorageError::from(error) {
        StorageError::Conflict { .. } => StorageError::Conflict { what },
        other => other,
    }
}
