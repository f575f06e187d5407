//! The store: opening, closing, row counts, and access to the read and write connections.
//! The methods for each kind of record are in the other modules.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use sqlx::sqlite::SqlitePoolOptions;
use sqlx::{ConnectOptions, Connection, SqlitePool};
use tokio::task::JoinHandle;

use crate::error::Result;
use crate::lock::{DirectoryLock, keep_private};
use crate::row::{Record, record, select};
use crate::sql::{Conn, Held};
use crate::writer::{CommitTimes, Durability, WriteFuture, Writer, operation};
use crate::{StorageError, connection};

const FILE: &str = "brood.db";
/// Number of read connections. Each has its own thread; reads are short.
const READERS: u32 = 4;
const READER_WAIT: Duration = Duration::from_secs(5);

/// Store of one data directory. Clones share it.
#[derive(Debug, Clone)]
pub struct Store {
    inner: Arc<Inner>,
}

#[derive(Debug)]
struct Inner {
    writer: Writer,
    /// Writer task; `None` after [`Store::close`].
    task: Mutex<Option<JoinHandle<()>>>,
    readers: SqlitePool,
    sqlite_version: String,
    file: PathBuf,
    /// True until the check after an unclean shutdown has passed.
    unchecked: AtomicBool,
    /// Files that stay open until the connections are closed.
    kept: Mutex<Vec<Arc<File>>>,
}

record! {
    /// Number of rows by table.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub struct StoreCounts {
        /// Lineages, including hidden ones.
        pub lineages: u64 = "(SELECT count(*) FROM lineage)",
        /// Generations.
        pub generations: u64 = "(SELECT count(*) FROM generation)",
        /// Individuals.
        pub individuals: u64 = "(SELECT count(*) FROM individual)",
        /// Genomes.
        pub genomes: u64 = "(SELECT count(*) FROM genome)",
        /// Scenes.
        pub scenes: u64 = "(SELECT count(*) FROM scene)",
        /// Uploaded meshes.
        pub meshes: u64 = "(SELECT count(*) FROM mesh)",
        /// Uploaded light assets.
        pub light_assets: u64 = "(SELECT count(*) FROM light_asset)",
        /// Picture keys.
        pub pictures: u64 = "(SELECT count(*) FROM picture)",
        /// Idempotency records.
        pub idempotency: u64 = "(SELECT count(*) FROM idempotency)",
        /// Tokens.
        pub tokens: u64 = "(SELECT count(*) FROM token)",
    }
}

impl Store {
    /// Opens a data directory, creates what is missing in it, and locks it against other servers.
    ///
    /// If the last process did not call [`Store::close`], the whole file is checked first.
    ///
    /// # Errors
    /// Returns [`StorageError::Locked`] if another server uses the directory,
    /// [`StorageError::Unsupported`] if it belongs to another version, [`StorageError::Corrupt`] if
    /// the check fails, [`StorageError::Directory`] if it is not accessible.
    pub async fn open(dir: &Path) -> Result<Self> {
        let store = Self::open_unchecked(dir).await?;
        if let Err(error) = store.check_after_crash().await {
            // Without closing: the log stays, so that the next start checks again.
            store.inner.readers.close().await;
            return Err(error);
        }
        Ok(store)
    }

    /// As [`Store::open`], but leaves the check to [`Store::check_after_crash`], so that the store
    /// can be used meanwhile.
    ///
    /// # Errors
    /// As [`Store::open`].
    pub async fn open_unchecked(dir: &Path) -> Result<Self> {
        let Opened { conn, lock, file, sqlite_version, unclean } = Opened::take(dir).await?;
        let store = Self::start(conn, &file, Some(lock), sqlite_version).await?;
        store.inner.unchecked.store(unclean, Ordering::Release);
        Ok(store)
    }

    /// True if the last process did not call [`Store::close`] and the check has not passed yet.
    #[must_use]
    pub fn is_unchecked(&self) -> bool {
        self.inner.unchecked.load(Ordering::Acquire)
    }

    /// Checks the whole file if the last shutdown was not clean. If it is damaged, all writes fail
    /// from then on, and the next start checks again.
    ///
    /// # Errors
    /// Returns [`StorageError::Corrupt`] if the file is damaged.
    pub async fn check_after_crash(&self) -> Result<()> {
        if !self.is_unchecked() {
            return Ok(());
        }
        let start = Instant::now();
        // A separate connection: the check takes long, and the pool is for short reads.
        let mut conn = connection::reading(&self.inner.file).connect().await?;
        let checked = connection::check(&mut conn).await;
        conn.close().await?;
        if let Err(error) = checked {
            let words = error.to_string();
            let failed = self.write::<(), _>(operation!(|_conn| Err(StorageError::Corrupt(words))));
            // The error of the check is the one to report.
            let _ = failed.await;
            return Err(error);
        }
        let elapsed_ms = start.elapsed().as_millis();
        tracing::info!(elapsed_ms, "the last shutdown was not clean; the database check passed");
        self.inner.unchecked.store(false, Ordering::Release);
        Ok(())
    }

    /// Opens a data directory for a short command, also while a server is using it.
    ///
    /// While a server is running, the directory must have been created by the same version;
    /// SQLite's locks then order the writes of the two processes.
    ///
    /// # Errors
    /// As [`Store::open`], except [`StorageError::Locked`].
    pub async fn open_shared(dir: &Path) -> Result<Self> {
        match Self::open(dir).await {
            Err(StorageError::Locked) => {}
            other => return other,
        }
        let file = dir.join(FILE);
        let mut conn = connection::writing(&file, false).connect().await?;
        connection::assert_writing(&mut conn).await?;
        let sqlite_version = connection::sqlite_version(&mut conn).await?;
        connection::assert_migrated(&mut conn).await?;
        Self::start(Conn::own(conn), &file, None, sqlite_version).await
    }

    async fn start(
        conn: Conn,
        file: &Path,
        lock: Option<DirectoryLock>,
        sqlite_version: String,
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
        let (unchecked, kept) = (AtomicBool::new(false), Mutex::default());
        let inner = Inner { writer, task, readers, sqlite_version, file, unchecked, kept };
        Ok(Self { inner: Arc::new(inner) })
    }

    /// Returns the size of the write-ahead log in bytes.
    #[must_use]
    pub fn log_bytes(&self) -> u64 {
        self.inner.file.parent().map_or(0, log_bytes)
    }

    /// Returns the number of writes that were refused since the start: the disk was full or had
    /// failed, or too many writes were waiting.
    #[must_use]
    pub fn refused_writes(&self) -> u64 {
        self.inner.writer.refused()
    }

    /// Returns the version of the embedded SQLite library.
    #[must_use]
    pub fn sqlite_version(&self) -> &str {
        &self.inner.sqlite_version
    }

    /// True if a write to the disk has failed, so that all writes fail until the process is
    /// restarted.
    #[must_use]
    pub fn is_poisoned(&self) -> bool {
        self.inner.writer.is_poisoned()
    }

    /// Waits for pending writes, empties the log and closes the file. Other clones then return
    /// [`StorageError::Closed`].
    ///
    /// # Errors
    /// Returns [`StorageError::Poisoned`] if an earlier write to the disk failed, other variants if
    /// the log cannot be written back.
    pub async fn close(self) -> Result<()> {
        // Readers first: an active read would prevent the log from being emptied.
        self.inner.readers.close().await;
        let closed = self.inner.writer.close().await;
        let task = self.inner.task.lock().expect("no code panics while holding this lock").take();
        if let Some(task) = task
            && let Err(error) = task.await
        {
            tracing::error!(%error, "the writer task panicked");
            return Err(StorageError::Poisoned);
        }
        closed
    }

    /// Path of the database.
    pub(crate) fn file(&self) -> &Path {
        &self.inner.file
    }

    /// Opens a file for reading. It stays open until all connections are closed.
    pub(crate) fn open_until_closed(&self, path: &Path) -> Result<Arc<File>> {
        let file = Arc::new(File::open(path).map_err(StorageError::Directory)?);
        let kept = &self.inner.kept;
        kept.lock().expect("no code panics while holding this lock").push(file.clone());
        Ok(file)
    }

    /// Counts the rows of each table, for monitoring.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn counts(&self) -> Result<StoreCounts> {
        let query = select::<StoreCounts>("");
        StoreCounts::read(&query.fetch_one(&mut self.reader().await?).await?)
    }

    /// Returns a connection for one read.
    pub(crate) async fn reader(&self) -> Result<Conn> {
        Ok(Conn::Sqlite(Held::Pooled(self.inner.readers.acquire().await?)))
    }

    /// Returns a connection for several reads of one consistent state.
    pub(crate) async fn snapshot(&self) -> Result<Conn> {
        Ok(Conn::Sqlite(Held::Snapshot(self.inner.readers.begin().await?)))
    }

    /// Runs a write that is durable against power loss when this returns.
    pub(crate) async fn write<T, F>(&self, operation: F) -> Result<T>
    where
        T: Send + 'static,
        F: for<'c> FnOnce(&'c mut Conn) -> WriteFuture<'c, Result<T>> + Send + 'static,
    {
        Ok(self.write_timed(operation).await?.0)
    }

    /// Like [`Store::write`], and returns the times of the commit.
    pub(crate) async fn write_timed<T, F>(&self, operation: F) -> Result<(T, CommitTimes)>
    where
        T: Send + 'static,
        F: for<'c> FnOnce(&'c mut Conn) -> WriteFuture<'c, Result<T>> + Send + 'static,
    {
        self.inner.writer.write(Durability::PowerLoss, operation).await
    }

    /// Runs a write that survives the end of the process but not a power loss.
    pub(crate) async fn write_relaxed<T, F>(&self, operation: F) -> Result<T>
    where
        T: Send + 'static,
        F: for<'c> FnOnce(&'c mut Conn) -> WriteFuture<'c, Result<T>> + Send + 'static,
    {
        Ok(self.inner.writer.write(Durability::ProcessDeath, operation).await?.0)
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
    /// As [`Store::open`].
    pub async fn take(dir: &Path) -> Result<Self> {
        let lock = DirectoryLock::take(dir)?;
        let file = dir.join(FILE);
        let unclean = log_bytes(dir) > 0;
        if std::fs::metadata(&file).is_ok_and(|known| known.len() == 0) {
            return Err(StorageError::Corrupt(format!(
                "{FILE} is empty; restore a backup, or delete the file to start anew"
            )));
        }
        let mut conn = connection::writing(&file, true).connect().await?;
        for name in [FILE.to_owned(), format!("{FILE}-wal"), format!("{FILE}-shm")] {
            match keep_private(&dir.join(name)) {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                    return Err(StorageError::Directory(error));
                }
                _ => {}
            }
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

/// Returns the size of the write-ahead log. It is 0 after a clean shutdown.
fn log_bytes(dir: &Path) -> u64 {
    std::fs::metadata(dir.join(format!("{FILE}-wal"))).map_or(0, |meta| meta.len())
}
