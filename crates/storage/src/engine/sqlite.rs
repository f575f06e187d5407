//! The embedded engine: one SQLite file in the data directory of one server.

pub(crate) mod checkpoint;
pub(crate) mod connection;
pub(crate) mod lock;
pub(crate) mod writer;

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use sqlx::sqlite::SqlitePoolOptions;
use sqlx::{ConnectOptions, Connection, SqlitePool};
use tokio::task::JoinHandle;

use crate::StorageError;
use crate::error::Result;
use crate::sql::{Conn, Held};
use crate::write::{Durability, operation};

use lock::{DirectoryLock, keep_private};
use writer::Writer;

const FILE: &str = "brood.db";
/// Number of read connections. Each has its own thread; reads are short.
const READERS: u32 = 4;
const READER_WAIT: Duration = Duration::from_secs(5);

/// Database of one data directory.
#[derive(Debug)]
pub(crate) struct Sqlite {
    /// Runs write operations.
    pub writer: Writer,
    /// Writer task; `None` after [`Sqlite::close`].
    task: Mutex<Option<JoinHandle<()>>>,
    readers: SqlitePool,
    /// Version of the embedded library.
    pub version: String,
    /// Path of the database.
    pub file: PathBuf,
    /// True until the check after an unclean shutdown has passed.
    unchecked: AtomicBool,
    /// Files that stay open until the connections are closed.
    kept: Mutex<Vec<Arc<File>>>,
}

impl Sqlite {
    /// Opens a data directory, without the check after an unclean shutdown.
    ///
    /// # Errors
    /// As [`Store::open`](crate::Store::open).
    pub async fn open_unchecked(dir: &Path) -> Result<Self> {
        let Opened { conn, lock, file, sqlite_version, unclean } = Opened::take(dir).await?;
        Self::start(conn, &file, Some(lock), sqlite_version, unclean).await
    }

    /// Opens a data directory that another process has locked.
    ///
    /// # Errors
    /// As [`Store::open_shared`](crate::Store::open_shared).
    pub async fn open_locked(dir: &Path) -> Result<Self> {
        let file = dir.join(FILE);
        let mut conn = connection::writing(&file, false).connect().await?;
        connection::assert_writing(&mut conn).await?;
        let sqlite_version = connection::sqlite_version(&mut conn).await?;
        connection::assert_migrated(&mut conn).await?;
        Self::start(Conn::own(conn), &file, None, sqlite_version, false).await
    }

    async fn start(
        conn: Conn,
        file: &Path,
        lock: Option<DirectoryLock>,
        version: String,
        unclean: bool,
    ) -> Result<Self> {
        let readers = SqlitePoolOptions::new()
            .max_connections(READERS)
            .acquire_timeout(READER_WAIT)
            .test_before_acquire(false)
            .idle_timeout(None)
            .max_lifetime(None)
            .connect_with(connection::reading(file))
            .await?;
        connection::assert_reading(&mut *readers.acquire().await?).await?;
        let (writer, task) = Writer::start(conn, lock);
        let (task, file) = (Mutex::new(Some(task)), file.to_owned());
        let (unchecked, kept) = (AtomicBool::new(unclean), Mutex::default());
        Ok(Self { writer, task, readers, version, file, unchecked, kept })
    }

    /// True if the last process did not close the database and the check has not passed yet.
    pub fn is_unchecked(&self) -> bool {
        self.unchecked.load(Ordering::Acquire)
    }

    /// Checks the whole file if the last shutdown was not clean.
    ///
    /// # Errors
    /// Returns [`StorageError::Corrupt`] if the file is damaged.
    pub async fn check_after_crash(&self) -> Result<()> {
        if !self.is_unchecked() {
            return Ok(());
        }
        let start = Instant::now();
        // A separate connection: the check takes long, and the pool is for short reads.
        let mut conn = connection::reading(&self.file).connect().await?;
        let checked = connection::check(&mut conn).await;
        conn.close().await?;
        if let Err(error) = checked {
            let words = error.to_string();
            let damaged = self.writer.write::<(), _>(
                Durability::PowerLoss,
                operation!(|_conn| Err(StorageError::Corrupt(words))),
            );
            // The error of the check is the one to report.
            let _ = damaged.await;
            return Err(error);
        }
        let elapsed_ms = start.elapsed().as_millis();
        tracing::info!(elapsed_ms, "the last shutdown was not clean; the database check passed");
        self.unchecked.store(false, Ordering::Release);
        Ok(())
    }

    /// Returns the size of the write-ahead log in bytes.
    pub fn log_bytes(&self) -> u64 {
        self.file.parent().map_or(0, log_bytes)
    }

    /// Closes the read connections alone. The log stays, so that the next start checks again.
    pub async fn close_readers(&self) {
        self.readers.close().await;
    }

    /// Waits for pending writes, empties the log and closes the file.
    ///
    /// # Errors
    /// Returns [`StorageError::Poisoned`] if an earlier write to the disk failed, other variants if
    /// the log cannot be written back.
    pub async fn close(&self) -> Result<()> {
        // Readers first: an active read would prevent the log from being emptied.
        self.readers.close().await;
        let closed = self.writer.close().await;
        let task = self.task.lock().expect("no code panics while holding this lock").take();
        if let Some(task) = task
            && let Err(error) = task.await
        {
            tracing::error!(%error, "the writer task panicked");
            return Err(StorageError::Poisoned);
        }
        closed
    }

    /// Opens a file for reading. It stays open until all connections are closed.
    pub fn open_until_closed(&self, path: &Path) -> Result<Arc<File>> {
        let file = Arc::new(File::open(path).map_err(StorageError::Directory)?);
        let kept = &self.kept;
        kept.lock().expect("no code panics while holding this lock").push(file.clone());
        Ok(file)
    }

    /// Returns a connection for one read.
    pub async fn reader(&self) -> Result<Conn> {
        Ok(Conn::Sqlite(Held::Pooled(self.readers.acquire().await?)))
    }

    /// Returns a connection for several reads of one consistent state.
    pub async fn snapshot(&self) -> Result<Conn> {
        Ok(Conn::Sqlite(Held::Transaction(self.readers.begin().await?)))
    }
}

/// Database that only this process uses, with the current schema.
pub(crate) struct Opened {
    /// Connection that writes.
    pub conn: Conn,
    lock: DirectoryLock,
    file: PathBuf,
    sqlite_version: String,
    /// True if the last shutdown was not clean.
    unclean: bool,
}

impl Opened {
    /// Locks a data directory, creates what is missing in it, and brings it up to date.
    ///
    /// # Errors
    /// As [`Store::open`](crate::Store::open).
    pub async fn take(dir: &Path) -> Result<Self> {
        let lock = DirectoryLock::take(dir)?;
        let file = dir.join(FILE);
        let unclean = log_bytes(dir) > 0;
        if std::fs::metadata(&file).is_ok_and(|known| known.len() == 0) {
            return Err(StorageError::Corrupt(format!(
                "{FILE} is empty; restore a backup, or delete the file to start anew"
            )));
        }
        if !file.try_exists().map_err(StorageError::Directory)? {
            create(dir, &file).await?;
        }
        let mut conn = connection::writing(&file, false).connect().await?;
        for file in parts(&file) {
            unless_missing(keep_private(&file))?;
        }
        connection::assert_writing(&mut conn).await?;
        let sqlite_version = connection::sqlite_version(&mut conn).await?;
        connection::migrate(&mut conn).await?;
        let lock = lock.watching(file.clone())?;
        let conn = Conn::own(conn);
        Ok(Self { conn, lock, file, sqlite_version, unclean })
    }

    /// Returns the size of the database.
    ///
    /// # Errors
    /// Returns [`StorageError::Directory`] if the file cannot be read.
    pub fn bytes(&self) -> Result<u64> {
        Ok(std::fs::metadata(&self.file).map_err(StorageError::Directory)?.len())
    }
}

/// Creates a database under another name and renames it once it is on the disk, so that a power cut
/// leaves a whole database or none.
async fn create(dir: &Path, file: &Path) -> Result<()> {
    // The disk of the database may not be mounted.
    if file.is_symlink() {
        return Err(StorageError::Unsupported(format!(
            "{FILE} is a link to a missing file; mount its disk, or remove the link to start anew"
        )));
    }
    let new = dir.join(format!("{FILE}.new"));
    // Files of an interrupted creation, and the log of a deleted database.
    for rest in parts(&new).into_iter().chain(parts(file)) {
        unless_missing(std::fs::remove_file(rest))?;
    }
    let mut conn = connection::writing(&new, true).connect().await?;
    keep_private(&new).map_err(StorageError::Directory)?;
    connection::assert_writing(&mut conn).await?;
    connection::migrate(&mut conn).await?;
    // Writes the log back and deletes it.
    conn.close().await?;
    let named = std::fs::rename(&new, file).and_then(|()| sync_file(file));
    named.map_err(StorageError::Directory)
}

/// Returns the files of a database: itself, its write-ahead log, and the index of that.
pub(crate) fn parts(file: &Path) -> [PathBuf; 3] {
    ["", "-wal", "-shm"].map(|suffix| beside(file, suffix))
}

/// Path of a file that SQLite keeps beside a database.
pub(crate) fn beside(database: &Path, suffix: &str) -> PathBuf {
    let mut path = database.as_os_str().to_owned();
    path.push(suffix);
    path.into()
}

/// Flushes a file and its directory entry to disk.
pub(crate) fn sync_file(path: &Path) -> std::io::Result<()> {
    File::options().write(true).open(path)?.sync_all()?;
    #[cfg(unix)]
    if let Some(dir) = path.parent() {
        let dir = if dir.as_os_str().is_empty() { Path::new(".") } else { dir };
        File::open(dir)?.sync_all()?;
    }
    Ok(())
}

fn unless_missing(done: std::io::Result<()>) -> Result<()> {
    match done {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(StorageError::Directory(error))
        }
        _ => Ok(()),
    }
}

/// Returns the size of the write-ahead log. It is 0 after a clean shutdown.
fn log_bytes(dir: &Path) -> u64 {
    std::fs::metadata(dir.join(format!("{FILE}-wal"))).map_or(0, |meta| meta.len())
}
