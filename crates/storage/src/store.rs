//! The store: opening, closing, row counts, and access to the read and write connections of its
//! engine. The methods for each kind of record are in the other modules.

use std::path::Path;
use std::sync::{Arc, Mutex};

use crate::StorageError;
use crate::address::DatabaseAddress;
use crate::blob_store::Blobs;
use crate::engine::Engine;
use crate::engine::postgres::bus::{Bus, BusLink};
use crate::engine::postgres::{Postgres, Usage};
use crate::engine::sqlite::Sqlite;
use crate::engine::sqlite::lock::DirectoryLock;
use crate::error::Result;
use crate::lease_fault::LeaseFaults;
use crate::sql::{Conn, query};
use crate::write::{CommitTimes, Durability, WriteFuture};

/// Store of one data directory or of one PostgreSQL database. Clones share it.
#[derive(Debug, Clone)]
pub struct Store {
    engine: Arc<Engine>,
    /// Lock of the data directory beside a PostgreSQL database; `None` after [`Store::close`].
    /// SQLite's writer has its own.
    lock: Arc<Mutex<Option<DirectoryLock>>>,
    lease_faults: Arc<LeaseFaults>,
    /// Object store of large files; `None` if they are in rows.
    blobs: Option<Arc<Blobs>>,
}

/// Declares [`StoreCounts`]: fields with their tables.
macro_rules! counts {
    ($($(#[$doc:meta])* $field:ident = $table:literal,)+) => {
        /// Number of rows by table. PostgreSQL's are estimates from 10,000 on.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
        pub struct StoreCounts {
            $($(#[$doc])* pub $field: u64,)+
        }

        impl StoreCounts {
            async fn read(conn: &mut Conn) -> Result<Self> {
                Ok(Self { $($field: rows(conn, $table).await?,)+ })
            }
        }
    };
}

counts! {
    /// Lineages, including hidden ones.
    lineages = "lineage",
    /// Generations.
    generations = "generation",
    /// Individuals.
    individuals = "individual",
    /// Genomes.
    genomes = "genome",
    /// Scenes.
    scenes = "scene",
    /// Uploaded meshes.
    meshes = "mesh",
    /// Uploaded light assets.
    light_assets = "light_asset",
    /// Picture keys.
    pictures = "picture",
    /// Idempotency records.
    idempotency = "idempotency",
    /// Tokens.
    tokens = "token",
}

/// Tables with fewer rows are counted; PostgreSQL reads every row for it.
const COUNTED_ROWS: u64 = 10_000;
/// Estimate of the rows of a table, from the last analysis of it and the changes since the start of
/// PostgreSQL.
const ESTIMATE: &str = "SELECT CAST(greatest(reltuples, n_live_tup, 0) AS BIGINT)
    FROM pg_class JOIN pg_stat_user_tables ON relid = oid WHERE oid = CAST(? AS regclass)";

/// Number of rows of a table.
async fn rows(conn: &mut Conn, table: &'static str) -> Result<u64> {
    if let Conn::Postgres(_) = conn {
        let estimate: u64 = query(ESTIMATE).bind(table).fetch_value(conn).await?;
        if estimate >= COUNTED_ROWS {
            return Ok(estimate);
        }
    }
    query(format!("SELECT count(*) FROM {table}")).fetch_value(conn).await
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
        let engine = Sqlite::open_unchecked(dir).await?;
        if let Err(error) = engine.check_after_crash().await {
            engine.close_readers().await;
            return Err(error);
        }
        Ok(Self::of(Engine::Sqlite(engine)))
    }

    /// As [`Store::open`], but leaves the check to [`Store::check_after_crash`], so that the store
    /// can be used meanwhile.
    ///
    /// # Errors
    /// As [`Store::open`].
    pub async fn open_unchecked(dir: &Path) -> Result<Self> {
        Ok(Self::of(Engine::Sqlite(Sqlite::open_unchecked(dir).await?)))
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
            Err(StorageError::Locked) => {
                Ok(Self::of(Engine::Sqlite(Sqlite::open_locked(dir).await?)))
            }
            other => other,
        }
    }

    /// Connects to a PostgreSQL database, which other servers may use, and creates what is missing
    /// in it, also while servers of an earlier version run that the change does not exclude. Locks
    /// the data directory of pictures against other servers. Uses the connections of the address
    /// ([`DatabaseAddress::with_connections`]), and four for other purposes.
    ///
    /// # Errors
    /// Returns [`StorageError::Locked`] if another server uses the directory,
    /// [`StorageError::Unreachable`] if there is no connection, [`StorageError::Unsupported`] if
    /// the address, the server, one of its settings or the schema is not supported, or if a copy is
    /// made into the database.
    pub async fn connect(address: &DatabaseAddress, data: &Path) -> Result<Self> {
        let lock = DirectoryLock::take(data)?;
        let engine = Postgres::connect(address, Usage::Server).await?;
        let store = Self::of(Engine::Postgres(engine));
        Ok(Self { lock: Arc::new(Mutex::new(Some(lock))), ..store })
    }

    /// As [`Store::connect`], also while a server uses the database, for a short command.
    ///
    /// # Errors
    /// As [`Store::connect`], except [`StorageError::Locked`].
    pub async fn connect_shared(address: &DatabaseAddress) -> Result<Self> {
        Ok(Self::of(Engine::Postgres(Postgres::connect(address, Usage::Command).await?)))
    }

    fn of(engine: Engine) -> Self {
        Self {
            engine: Arc::new(engine),
            lock: Arc::default(),
            lease_faults: Arc::default(),
            blobs: None,
        }
    }

    /// Object store of large files; `None` if they are in rows.
    pub(crate) fn blobs(&self) -> Option<&Arc<Blobs>> {
        self.blobs.as_ref()
    }

    /// Sets the object store of large files.
    pub(crate) fn set_blobs(&mut self, blobs: Option<Blobs>) {
        self.blobs = blobs.map(Arc::new);
    }

    /// Failed writes of leases.
    pub(crate) fn lease_faults(&self) -> &LeaseFaults {
        &self.lease_faults
    }

    /// True if several servers may use the database.
    #[must_use]
    pub fn is_shared(&self) -> bool {
        matches!(&*self.engine, Engine::Postgres(_))
    }

    /// Connects to the other servers of the database; `None` if there can be none.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the database cannot be reached.
    pub async fn join_bus(&self) -> Result<Option<(Bus, BusLink)>> {
        match &*self.engine {
            Engine::Sqlite(_) => Ok(None),
            Engine::Postgres(engine) => Ok(Some(engine.join_bus().await?)),
        }
    }

    /// True if the last process did not call [`Store::close`] and the check has not passed yet.
    #[must_use]
    pub fn is_unchecked(&self) -> bool {
        match &*self.engine {
            Engine::Sqlite(engine) => engine.is_unchecked(),
            Engine::Postgres(_) => false,
        }
    }

    /// Checks the whole file if the last shutdown was not clean. If it is damaged, all writes fail
    /// from then on, and the next start checks again.
    ///
    /// # Errors
    /// Returns [`StorageError::Corrupt`] if the file is damaged.
    pub async fn check_after_crash(&self) -> Result<()> {
        match &*self.engine {
            Engine::Sqlite(engine) => engine.check_after_crash().await,
            Engine::Postgres(_) => Ok(()),
        }
    }

    /// Returns the size of the write-ahead log in the data directory, in bytes.
    #[must_use]
    pub fn log_bytes(&self) -> u64 {
        match &*self.engine {
            Engine::Sqlite(engine) => engine.log_bytes(),
            Engine::Postgres(_) => 0,
        }
    }

    /// Returns the number of writes that were refused since the start: the disk was full or had
    /// failed, or too many writes were waiting.
    #[must_use]
    pub fn refused_writes(&self) -> u64 {
        match &*self.engine {
            Engine::Sqlite(engine) => engine.writer.refused(),
            Engine::Postgres(engine) => engine.refused(),
        }
    }

    /// Returns name and version of the engine.
    #[must_use]
    pub fn engine_version(&self) -> String {
        match &*self.engine {
            Engine::Sqlite(engine) => format!("SQLite {}", engine.version),
            Engine::Postgres(engine) => format!("PostgreSQL {}", engine.version),
        }
    }

    /// True if a write to the disk has failed, or if the tables of a PostgreSQL database are not
    /// for this version any more, so that all writes fail until the process is restarted.
    #[must_use]
    pub fn is_poisoned(&self) -> bool {
        match &*self.engine {
            Engine::Sqlite(engine) => engine.writer.is_poisoned(),
            Engine::Postgres(engine) => engine.is_excluded(),
        }
    }

    /// Waits for pending writes and closes all connections. Other clones then return
    /// [`StorageError::Closed`].
    ///
    /// # Errors
    /// Returns [`StorageError::Poisoned`] if an earlier write to the disk failed,
    /// [`StorageError::Unsupported`] if the tables are not for this version any more, others if
    /// SQLite's log cannot be written back.
    pub async fn close(self) -> Result<()> {
        match &*self.engine {
            Engine::Sqlite(engine) => engine.close().await,
            Engine::Postgres(engine) => {
                let closed = engine.close().await;
                drop(self.lock.lock().expect("no code panics while holding this lock").take());
                closed
            }
        }
    }

    /// Returns the embedded engine. Error for another, which cannot do `what`.
    pub(crate) fn embedded(&self, what: &str) -> Result<&Sqlite> {
        match &*self.engine {
            Engine::Sqlite(engine) => Ok(engine),
            Engine::Postgres(_) => Err(StorageError::Unsupported(format!(
                "{what} is for data directories; use the tools of PostgreSQL, such as pg_dump"
            ))),
        }
    }

    /// Counts the rows of each table, for monitoring.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn counts(&self) -> Result<StoreCounts> {
        StoreCounts::read(&mut self.reader().await?).await
    }

    /// Returns a connection for one read.
    pub(crate) async fn reader(&self) -> Result<Conn> {
        match &*self.engine {
            Engine::Sqlite(engine) => engine.reader().await,
            Engine::Postgres(engine) => engine.reader().await,
        }
    }

    /// Returns a connection for several reads of one consistent state.
    pub(crate) async fn snapshot(&self) -> Result<Conn> {
        match &*self.engine {
            Engine::Sqlite(engine) => engine.snapshot().await,
            Engine::Postgres(engine) => engine.snapshot().await,
        }
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
        self.write_as(Durability::PowerLoss, operation).await
    }

    /// Runs a write that survives the end of the process but not a power loss.
    pub(crate) async fn write_relaxed<T, F>(&self, operation: F) -> Result<T>
    where
        T: Send + 'static,
        F: for<'c> FnOnce(&'c mut Conn) -> WriteFuture<'c, Result<T>> + Send + 'static,
    {
        Ok(self.write_as(Durability::ProcessDeath, operation).await?.0)
    }

    /// Runs a write, and returns the times of its commit.
    pub(crate) async fn write_as<T, F>(
        &self,
        durability: Durability,
        operation: F,
    ) -> Result<(T, CommitTimes)>
    where
        T: Send + 'static,
        F: for<'c> FnOnce(&'c mut Conn) -> WriteFuture<'c, Result<T>> + Send + 'static,
    {
        match &*self.engine {
            Engine::Sqlite(engine) => engine.writer.write(durability, operation).await,
            // Its log is flushed once for all commits that wait.
            Engine::Postgres(engine) => engine.write(operation).await,
        }
    }
}
