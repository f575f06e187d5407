//! Backup: a consistent copy of the database in one file, also while a server writes.
//!
//! The files are copied inside a read transaction. Until it ends, checkpoints do not write newer
//! pages into the database, and the log is not restarted. The log therefore grows only while files
//! are copied, and not while SQLite copies row by row (`VACUUM INTO`).

use std::fs::File;
use std::io;
use std::path::Path;

use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode};
use sqlx::{ConnectOptions, Connection};

use crate::engine::sqlite::lock::keep_private;
use crate::engine::sqlite::{beside, connection, parts, sync_file};
use crate::error::Result;
use crate::{StorageError, Store};

impl Store {
    /// Writes a consistent copy of the database into a new file, and checks it.
    ///
    /// # Errors
    /// Returns [`StorageError::Conflict`] if the file exists, [`StorageError::Directory`] if it
    /// cannot be written, [`StorageError::Corrupt`] if the copy is damaged.
    pub async fn backup(&self, file: &Path) -> Result<()> {
        self.embedded("a backup")?;
        // Created first, so that no existing file is overwritten.
        let claimed = File::options().write(true).create_new(true).open(file);
        let claimed = claimed.and_then(|claimed| keep_private(file).map(|()| claimed));
        let claimed = claimed.map_err(|error| match error.kind() {
            io::ErrorKind::AlreadyExists => {
                StorageError::Conflict { what: "the backup file already exists" }
            }
            _ => StorageError::Directory(error),
        })?;
        let result = match self.copy_into(file, claimed).await {
            Ok(()) => complete(file).await,
            failed => failed,
        };
        if result.is_ok() {
            return sync_file(file).map_err(StorageError::Directory);
        }
        for part in parts(file) {
            match std::fs::remove_file(part) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => {
                    tracing::warn!(%error, "cannot remove an incomplete backup");
                }
                _ => {}
            }
        }
        result
    }

    /// Copies database and log.
    async fn copy_into(&self, file: &Path, mut to: File) -> Result<()> {
        let engine = self.embedded("a backup")?;
        let from = engine.file.as_path();
        // A separate connection: copying takes long, and the pool is for short reads.
        let mut conn = connection::reading(from).connect().await?;
        let mut read = conn.begin().await?;
        // The transaction begins with its first read.
        sqlx::query("SELECT count(*) FROM sqlite_schema").fetch_one(&mut *read).await?;
        // Closing a file gives up all locks that this process has on it, those of SQLite too.
        let database = engine.open_until_closed(from)?;
        let source = engine.open_until_closed(&beside(from, "-wal"))?;
        let log = beside(file, "-wal");
        let copied = tokio::task::spawn_blocking(move || -> io::Result<()> {
            io::copy(&mut &*database, &mut to)?;
            let mut target = File::options().write(true).create_new(true).open(&log)?;
            keep_private(&log)?;
            io::copy(&mut &*source, &mut target).map(drop)
        });
        let copied = copied.await.map_err(io::Error::other).and_then(|copied| copied);
        copied.map_err(StorageError::Directory)?;
        read.rollback().await?;
        Ok(conn.close().await?)
    }
}

/// Writes the log of a copy back, so that it is one file, and checks it.
async fn complete(file: &Path) -> Result<()> {
    let options = SqliteConnectOptions::new().filename(file).disable_statement_logging();
    let mut conn = options.journal_mode(SqliteJournalMode::Delete).connect().await?;
    connection::check(&mut conn).await?;
    Ok(conn.close().await?)
}
