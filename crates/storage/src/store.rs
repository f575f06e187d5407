//! The store as a whole: opening, closing, backup, counts. Owns the directory's layout and who may be in it; the
//! aggregates add their own methods in files of their own.

use std::path::Path;
use std::sync::atomic::AtomicU64;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use sqlx::pool::PoolConnection;
use sqlx::sqlite::{SqliteConnectOptions, SqlitePoolOptions};
use sqlx::{ConnectOptions, Connection, Sqlite, SqliteConnection, SqlitePool, Transaction};
use tokio::task::JoinHandle;

use crate::lock::DirectoryLock;
use crate::row::Columns;
use crate::writer::{Committed, Durability, Running, Writer};
use crate::{StorageError, connection};

const FILE: &str = "brood.db";
/// Each has a thread of its own; reads are short.
const READERS: u32 = 4;
const READER_WAIT: Duration = Duration::from_secs(5);

/// The data directory of one server. Clones share it.
#[derive(Debug, Clone)]
pub struct Store {
    inner: Arc<Inner>,
}

#[derive(Debug)]
struct Inner {
    writer: Writer,
    task: Mutex<Option<JoinHandle<()>>>,
    readers: SqlitePool,
    backup: SqliteConnectOptions,
    sqlite_version: String,
    claims: AtomicU64,
}

/// Rows by table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StoreCounts {
    /// Lineages, hidden ones too.
    pub lineages: u64,
    /// Generations.
    pub generations: u64,
    /// Individuals.
    pub individuals: u64,
    /// Genomes.
    pub genomes: u64,
    /// Scenes.
    pub scenes: u64,
    /// Uploaded meshes.
    pub meshes: u64,
    /// Uploaded profiles and environments.
    pub light_assets: u64,
    /// Picture keys.
    pub pictures: u64,
    /// Jobs in any state.
    pub jobs: u64,
    /// Remembered answers.
    pub idempotency: u64,
    /// Tokens.
    pub tokens: u64,
}

impl Store {
    /// Opens a data directory, makes what is missing in it, and keeps other servers off it.
    ///
    /// After an end without [`Store::close`] the whole file is checked first.
    pub async fn open(dir: &Path) -> Result<Self, StorageError> {
        let lock = DirectoryLock::take(dir)?;
        let file = dir.join(FILE);
        let unclean = log_bytes(dir) > 0;
        let mut conn = connection::writing(&file, true).connect().await?;
        connection::assert_writing(&mut conn).await?;
        let sqlite_version = connection::sqlite_version(&mut conn).await?;
        if unclean {
            let start = Instant::now();
            connection::check(&mut conn).await?;
            let elapsed_ms = start.elapsed().as_millis();
            tracing::info!(elapsed_ms, "the last end was unclean; the database is sound");
        }
        connection::migrate(&mut conn).await?;
        Self::start(conn, &file, Some(lock), sqlite_version).await
    }

    /// Opens a data directory for one short command, beside a running server or alone.
    ///
    /// Beside a server the directory must have been made by the same version, and SQLite's own locks order the writes
    /// of the two processes.
    pub async fn open_beside(dir: &Path) -> Result<Self, StorageError> {
        match Self::open(dir).await {
            Err(StorageError::Locked) => {}
            other => return other,
        }
        let file = dir.join(FILE);
        let mut conn = connection::writing(&file, false).connect().await?;
        connection::assert_writing(&mut conn).await?;
        let sqlite_version = connection::sqlite_version(&mut conn).await?;
        connection::assert_migrated(&mut conn).await?;
        Self::start(conn, &file, None, sqlite_version).await
    }

    async fn start(
        conn: SqliteConnection,
        file: &Path,
        lock: Option<DirectoryLock>,
        sqlite_version: String,
    ) -> Result<Self, StorageError> {
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
        let backup = connection::reading(file).pragma("query_only", "OFF");
        let task = Mutex::new(Some(task));
        let claims = AtomicU64::new(0);
        let inner = Inner { writer, task, readers, backup, sqlite_version, claims };
        Ok(Self { inner: Arc::new(inner) })
    }

    /// Version of the embedded database.
    #[must_use]
    pub fn sqlite_version(&self) -> &str {
        &self.inner.sqlite_version
    }

    /// Whether a write to the disk has failed, so that all writes are refused until the process is started again.
    #[must_use]
    pub fn is_poisoned(&self) -> bool {
        self.inner.writer.is_poisoned()
    }

    /// Waits for the writes that were asked for, empties the log and closes the file. Other clones answer
    /// [`StorageError::Closed`] from then on.
    pub async fn close(self) -> Result<(), StorageError> {
        // Readers go first: one that is in the middle of a read would keep the log from being emptied.
        self.inner.readers.close().await;
        let closed = self.inner.writer.close().await;
        let task = self.inner.task.lock().expect("nothing panics under this lock").take();
        if let Some(task) = task
            && let Err(error) = task.await
        {
            tracing::error!(%error, "the writer ended badly");
            return Err(StorageError::Poisoned);
        }
        closed
    }

    /// Writes a copy of the database, as it is at this moment, into a new file.
    pub async fn backup(&self, file: &Path) -> Result<(), StorageError> {
        let name = file.to_str().ok_or_else(|| {
            StorageError::Unsupported("the name of a backup file must be UTF-8".to_owned())
        })?;
        // Claiming the name first makes sure that nobody's file is touched; SQLite takes an empty file as new.
        let claimed = std::fs::File::options().write(true).create_new(true).open(file);
        let claimed = claimed.map_err(|error| match error.kind() {
            std::io::ErrorKind::AlreadyExists => StorageError::Conflict { what: "the file name" },
            _ => StorageError::Directory(error),
        })?;
        let result = self.copy_into(name).await;
        if result.is_ok() {
            return synced(&claimed, file).map_err(StorageError::Directory);
        }
        if let Err(error) = std::fs::remove_file(file) {
            tracing::warn!(%error, "a broken backup could not be removed");
        }
        result
    }

    async fn copy_into(&self, name: &str) -> Result<(), StorageError> {
        // A connection of its own: copying takes long, and the pool is for short reads.
        let mut conn = self.inner.backup.connect().await?;
        sqlx::query("VACUUM INTO ?").bind(name).execute(&mut conn).await?;
        Ok(conn.close().await?)
    }

    /// Counts the rows of each table, for monitoring.
    pub async fn counts(&self) -> Result<StoreCounts, StorageError> {
        let row = sqlx::query(COUNTS).fetch_one(&mut *self.reader().await?).await?;
        Ok(StoreCounts {
            lineages: row.whole("lineages")?,
            generations: row.whole("generations")?,
            individuals: row.whole("individuals")?,
            genomes: row.whole("genomes")?,
            scenes: row.whole("scenes")?,
            meshes: row.whole("meshes")?,
            light_assets: row.whole("light_assets")?,
            pictures: row.whole("pictures")?,
            jobs: row.whole("jobs")?,
            idempotency: row.whole("answers")?,
            tokens: row.whole("tokens")?,
        })
    }

    /// How many claims were granted since the start.
    pub(crate) fn claims(&self) -> &AtomicU64 {
        &self.inner.claims
    }

    /// A connection for one read.
    pub(crate) async fn reader(&self) -> Result<PoolConnection<Sqlite>, StorageError> {
        Ok(self.inner.readers.acquire().await?)
    }

    /// A connection for several reads of one state.
    pub(crate) async fn snapshot(&self) -> Result<Transaction<'static, Sqlite>, StorageError> {
        Ok(self.inner.readers.begin().await?)
    }

    /// Writes facts: durable when this returns.
    pub(crate) async fn write<T, F>(&self, operation: F) -> Result<T, StorageError>
    where
        T: Send + 'static,
        F: for<'c> FnOnce(&'c mut SqliteConnection) -> Running<'c, Result<T, StorageError>>
            + Send
            + 'static,
    {
        Ok(self.write_timed(operation).await?.0)
    }

    /// The same, with where the time went.
    pub(crate) async fn write_timed<T, F>(
        &self,
        operation: F,
    ) -> Result<(T, Committed), StorageError>
    where
        T: Send + 'static,
        F: for<'c> FnOnce(&'c mut SqliteConnection) -> Running<'c, Result<T, StorageError>>
            + Send
            + 'static,
    {
        self.inner.writer.write(Durability::PowerLoss, operation).await
    }

    /// Writes what is made again when a power cut takes it.
    pub(crate) async fn write_relaxed<T, F>(&self, operation: F) -> Result<T, StorageError>
    where
        T: Send + 'static,
        F: for<'c> FnOnce(&'c mut SqliteConnection) -> Running<'c, Result<T, StorageError>>
            + Send
            + 'static,
    {
        Ok(self.inner.writer.write(Durability::ProcessDeath, operation).await?.0)
    }
}

const COUNTS: &str = "SELECT
    (SELECT count(*) FROM lineage) AS lineages,
    (SELECT count(*) FROM generation) AS generations,
    (SELECT count(*) FROM individual) AS individuals,
    (SELECT count(*) FROM genome) AS genomes,
    (SELECT count(*) FROM scene) AS scenes,
    (SELECT count(*) FROM mesh) AS meshes,
    (SELECT count(*) FROM light_asset) AS light_assets,
    (SELECT count(*) FROM picture) AS pictures,
    (SELECT count(*) FROM job) AS jobs,
    (SELECT count(*) FROM idempotency) AS answers,
    (SELECT count(*) FROM token) AS tokens";

/// Waits until a file and its name are on disk.
fn synced(file: &std::fs::File, path: &Path) -> std::io::Result<()> {
    file.sync_all()?;
    #[cfg(unix)]
    if let Some(dir) = path.parent() {
        let dir = if dir.as_os_str().is_empty() { Path::new(".") } else { dir };
        std::fs::File::open(dir)?.sync_all()?;
    }
    Ok(())
}

/// Size of the write-ahead log: a clean end leaves none.
fn log_bytes(dir: &Path) -> u64 {
    std::fs::metadata(dir.join(format!("{FILE}-wal"))).map_or(0, |meta| meta.len())
}
