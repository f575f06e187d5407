//! Errors of the store, and their classification by the engines' codes. Messages contain no paths.

use sqlx::error::ErrorKind;

/// Error of a store operation.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StorageError {
    /// No record has this id, or the write refers to a record that does not exist.
    #[error("no such record")]
    NotFound,
    /// The write conflicts with an earlier one.
    #[error("{what}")]
    Conflict {
        /// Description of the conflict.
        what: &'static str,
    },
    /// The record has changed since the caller read it.
    #[error("the record has changed: its version is now {current}")]
    StaleVersion {
        /// Current version of the record.
        current: u64,
    },
    /// The disk is full. Nothing was written. Reads still work; writes work again once there is
    /// space.
    #[error("the disk is full")]
    Full,
    /// A write to the disk failed earlier. All writes fail until the process is restarted.
    #[error("the store is read-only since a write to the disk failed; restart the server")]
    Poisoned,
    /// Lock or database are no longer in the data directory. All writes fail until the process is
    /// restarted.
    #[error(
        "brood.db or brood.lock was removed from the data directory, or replaced, while in use"
    )]
    Gone,
    /// Too many writes are waiting, or no read connection became free in time. Nothing was written.
    #[error("the store is busy; try again later")]
    Busy,
    /// The queue has reached its limit. Nothing was written.
    #[error("the queue is full")]
    QueueFull,
    /// Another process has locked the data directory or the database.
    #[error("another brood server is using this data directory")]
    Locked,
    /// The store is closed.
    #[error("the store is closed")]
    Closed,
    /// The file, the SQLite library or a file name is not supported by this build.
    #[error("{0}")]
    Unsupported(String),
    /// The database file is damaged.
    #[error("the database is damaged: {0}")]
    Corrupt(String),
    /// The data directory is not accessible.
    #[error("cannot access the data directory: {}", .0.kind())]
    Directory(#[source] std::io::Error),
    /// The copy of a table differs from it: the database has other rows too.
    #[error(
        "the table {table} differs after copying: the database has other rows, or an earlier copy; use an empty one"
    )]
    Mixed {
        /// Name of the table.
        table: &'static str,
    },
    /// There is no connection to the database. The write may have been stored.
    #[error("cannot reach the database: {0}")]
    Unreachable(String),
    /// The object store of large files refuses a call or does not answer.
    #[error("cannot use the object store {0}")]
    BlobsUnreachable(String),
    /// A file in the object store is missing, or has another content than it was stored with.
    #[error("the file {0} in the object store is missing or damaged")]
    BlobDamaged(String),
    /// Any other error of the database.
    #[error("database error: {0}")]
    Database(#[source] sqlx::Error),
}

/// Result of a store operation.
pub type Result<T, E = StorageError> = std::result::Result<T, E>;

/// Scope of a failure inside a transaction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FailureScope {
    /// Only the operation failed: its savepoint is rolled back.
    Operation,
    /// The transaction failed: it is rolled back, and the next one may succeed.
    Transaction,
    /// The disk failed: no later write can be trusted.
    Store,
}

/// Error for a write under a lease of another epoch.
pub(crate) const LEASE_ENDED: StorageError =
    StorageError::Conflict { what: "the lease is no longer valid" };

const ID_IN_USE: StorageError = StorageError::Conflict { what: "the id is already in use" };

const SQLITE_BUSY: i32 = 5;
const SQLITE_LOCKED: i32 = 6;
const SQLITE_IOERR: i32 = 10;
const SQLITE_CORRUPT: i32 = 11;
const SQLITE_FULL: i32 = 13;
const SQLITE_NOTADB: i32 = 26;
/// Growing the shared index of the log failed. Nothing was written; the usual cause is a full disk.
const SQLITE_IOERR_SHMSIZE: i32 = 4874;

/// Returns the extended result code if the error comes from SQLite.
fn code(error: &sqlx::Error) -> Option<i32> {
    error.as_database_error()?.code()?.parse().ok()
}

impl StorageError {
    /// Returns the scope of this failure when it happens inside a transaction.
    pub(crate) fn failure_scope(&self) -> FailureScope {
        match self {
            Self::Full => FailureScope::Transaction,
            Self::Poisoned | Self::Gone => FailureScope::Store,
            Self::Database(sqlx::Error::Io(_) | sqlx::Error::WorkerCrashed) => FailureScope::Store,
            Self::Database(error) if code(error).is_some_and(|c| c & 0xff == SQLITE_IOERR) => {
                FailureScope::Store
            }
            _ => FailureScope::Operation,
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
                return Self::Corrupt(format!("column {index} has an invalid value"));
            }
            _ => {}
        }
        let kind = error.as_database_error().map(|database| database.kind());
        match (kind, code(&error)) {
            (Some(ErrorKind::ForeignKeyViolation), _) => Self::NotFound,
            (Some(ErrorKind::UniqueViolation), _) => ID_IN_USE,
            (_, Some(SQLITE_IOERR_SHMSIZE)) => Self::Full,
            (_, Some(code)) => match code & 0xff {
                SQLITE_FULL => Self::Full,
                SQLITE_BUSY | SQLITE_LOCKED => Self::Busy,
                SQLITE_CORRUPT => Self::Corrupt("a page is malformed".to_owned()),
                SQLITE_NOTADB => Self::Corrupt("the file is not an SQLite database".to_owned()),
                _ => Self::Database(error),
            },
            _ => Self::Database(error),
        }
    }
}

/// Classifies an error of PostgreSQL by its SQLSTATE.
pub(crate) fn postgres_error(error: sqlx::Error) -> StorageError {
    let Some(database) = error.as_database_error() else {
        return match error {
            sqlx::Error::Io(error) => StorageError::Unreachable(error.to_string()),
            sqlx::Error::Protocol(_) | sqlx::Error::Tls(_) => {
                StorageError::Unreachable(error.to_string())
            }
            error => error.into(),
        };
    };
    let message = database.message().to_owned();
    match database.code().as_deref().unwrap_or_default() {
        "23503" => StorageError::NotFound,
        "23505" => ID_IN_USE,
        // Serialization failure, deadlock, lock or statement timeout, too many connections.
        "40001" | "40P01" | "55P03" | "57014" | "53300" => StorageError::Busy,
        "53100" => StorageError::Full,
        // Shutdown, crash, start; limit of an idle transaction; a standby; access refused; no such
        // database.
        "57P01" | "57P02" | "57P03" | "25P03" | "25006" | "28000" | "28P01" | "3D000" => {
            StorageError::Unreachable(message)
        }
        "XX001" | "XX002" => StorageError::Corrupt(message),
        _ => StorageError::Database(error),
    }
}

/// Returns `otherwise` as the error if a write changed no row.
pub(crate) fn changed(rows: u64, otherwise: StorageError) -> Result<()> {
    if rows == 0 { Err(otherwise) } else { Ok(()) }
}

/// Converts a violated uniqueness constraint into a conflict described by `what`.
pub(crate) fn unique_conflict(what: &'static str) -> impl Fn(StorageError) -> StorageError {
    move |error| match error {
        StorageError::Conflict { .. } => StorageError::Conflict { what },
        other => other,
    }
}
