//! The engine on a PostgreSQL server.
//!
//! Each write is a transaction of its own connection. PostgreSQL ends the transaction of a lost
//! server after 3 s, see `LIMITS`.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use sqlx::migrate::MigrateError;
use sqlx::postgres::{PgConnectOptions, PgPoolOptions};
use sqlx::{ConnectOptions, Connection, PgConnection, PgPool};
use tokio::sync::Semaphore;

use crate::StorageError;
use crate::address::DatabaseAddress;
use crate::error::{Result, postgres_error};
use crate::sql::{Conn, Held};
use crate::write::{CommitTimes, WriteFuture};

/// Oldest supported PostgreSQL, as `server_version_num` gives it.
const MIN_VERSION: i32 = 150_000;
const CONNECTIONS: u32 = 32;
/// Time that a read or write waits for a connection.
const WAIT: Duration = Duration::from_secs(5);
/// Writes that may wait for a connection. Others fail with [`StorageError::Busy`].
const WAITING_WRITES: usize = 256;
/// A connection that was idle for this long is checked before it is used.
const IDLE: Duration = Duration::from_secs(1);
/// Limits of a session. The first ends the transaction of a lost server, which holds the lock of a
/// lineage until then.
const LIMITS: [(&str, &str); 6] = [
    ("idle_in_transaction_session_timeout", "3s"),
    ("lock_timeout", "5s"),
    ("statement_timeout", "30s"),
    ("tcp_user_timeout", "5s"),
    ("tcp_keepalives_idle", "5"),
    ("client_min_messages", "warning"),
];
/// Settings that durability depends on, with the statements that read them.
const DURABLE: [(&str, &str); 3] = [
    ("fsync", "SHOW fsync"),
    ("full_page_writes", "SHOW full_page_writes"),
    ("synchronous_commit", "SHOW synchronous_commit"),
];
/// Names the isolation level, since databases may have another default.
const BEGIN: &str = "BEGIN ISOLATION LEVEL READ COMMITTED READ WRITE";
const SNAPSHOT: &str = "BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY";

static MIGRATIONS: sqlx::migrate::Migrator = sqlx::migrate!("../../migrations/postgres");

/// Database on a PostgreSQL server.
#[derive(Debug)]
pub(crate) struct Postgres {
    pool: PgPool,
    /// Connection with the lock against a second server; `None` for a command, and after
    /// [`Postgres::close`]. A restart of PostgreSQL releases the lock.
    server_lock: Mutex<Option<PgConnection>>,
    /// Version of the server.
    pub version: String,
    waiting: Arc<Semaphore>,
    /// Number of writes refused since the start.
    refused: AtomicU64,
}

impl Postgres {
    /// Connects to a database and checks it. Creates and upgrades its tables unless a server has
    /// locked it. `alone` keeps the lock for a server.
    ///
    /// # Errors
    /// As [`Store::connect`](crate::Store::connect).
    pub async fn connect(address: &DatabaseAddress, alone: bool) -> Result<Self> {
        let options = options(address)?;
        let mut conn = options.connect().await.map_err(postgres_error)?;
        let version = assert_version(&mut conn).await?;
        assert_durable(&mut conn).await?;
        match lock_for_server(&mut conn).await? {
            true => migrate(&mut conn).await?,
            false if alone => return Err(StorageError::Locked),
            // The server with the lock decides on the schema.
            false => assert_migrated(&mut conn).await?,
        }
        let server_lock = if alone {
            Some(conn)
        } else {
            conn.close().await.map_err(postgres_error)?;
            None
        };
        let pool = PgPoolOptions::new()
            .max_connections(CONNECTIONS)
            .acquire_timeout(WAIT)
            .test_before_acquire(false)
            .before_acquire(|conn, meta| {
                Box::pin(async move {
                    // A connection that PostgreSQL has closed is replaced.
                    Ok(meta.idle_for < IDLE || conn.ping().await.is_ok())
                })
            })
            .connect_lazy_with(options);
        let waiting = Arc::new(Semaphore::new(WAITING_WRITES));
        let server_lock = Mutex::new(server_lock);
        Ok(Self { pool, server_lock, version, waiting, refused: AtomicU64::new(0) })
    }

    /// Number of writes refused since the start.
    pub fn refused(&self) -> u64 {
        self.refused.load(Ordering::Relaxed)
    }

    /// Closes all connections.
    pub async fn close(&self) {
        self.pool.close().await;
        let locking =
            self.server_lock.lock().expect("no code panics while holding this lock").take();
        if let Some(conn) = locking
            && let Err(error) = conn.close().await
        {
            tracing::debug!(%error, "cannot close the connection with the lock");
        }
    }

    /// Returns a connection for one read.
    pub async fn reader(&self) -> Result<Conn> {
        let conn = self.pool.acquire().await.map_err(|error| no_connection(&self.pool, error))?;
        Ok(Conn::Postgres(Held::Pooled(conn)))
    }

    /// Returns a connection for several reads of one consistent state.
    pub async fn snapshot(&self) -> Result<Conn> {
        let pool = self.pool.clone();
        // A task cannot be cancelled. sqlx does not roll back a transaction whose BEGIN was
        // cancelled: the connection would return to the pool inside it.
        let begin = tokio::spawn(async move {
            pool.begin_with(SNAPSHOT).await.map_err(|error| no_connection(&pool, error))
        });
        let snapshot = begin.await.unwrap_or(Err(StorageError::Closed))?;
        Ok(Conn::Postgres(Held::Transaction(snapshot)))
    }

    /// Runs an operation in a transaction, and returns when it is committed. It is committed even
    /// if the caller does not wait for it.
    pub async fn write<T, F>(&self, operation: F) -> Result<(T, CommitTimes)>
    where
        T: Send + 'static,
        F: for<'c> FnOnce(&'c mut Conn) -> WriteFuture<'c, Result<T>> + Send + 'static,
    {
        let Ok(permit) = self.waiting.clone().try_acquire_owned() else {
            self.refused.fetch_add(1, Ordering::Relaxed);
            return Err(StorageError::Busy);
        };
        let pool = self.pool.clone();
        let write = tokio::spawn(async move {
            let enqueued = Instant::now();
            let transaction =
                pool.begin_with(BEGIN).await.map_err(|error| no_connection(&pool, error))?;
            drop(permit);
            let started = Instant::now();
            let mut conn = Conn::Postgres(Held::Transaction(transaction));
            let result = operation(&mut conn).await;
            let written = Instant::now();
            conn.end(result.is_ok()).await?;
            let times = CommitTimes {
                queued: started - enqueued,
                written: written - started,
                synced: written.elapsed(),
            };
            Ok((result?, times))
        });
        // The operation has panicked, or the runtime stops.
        let written = write.await.unwrap_or(Err(StorageError::Closed));
        if matches!(written, Err(StorageError::Busy | StorageError::Full)) {
            self.refused.fetch_add(1, Ordering::Relaxed);
        }
        written
    }
}

/// Locks the schema against other servers. Returns false if another has the lock.
async fn lock_for_server(conn: &mut PgConnection) -> Result<bool> {
    let sql = "SELECT pg_try_advisory_lock(hashtext('brood'), hashtext(current_schema()))";
    sqlx::query_scalar(sql).fetch_one(conn).await.map_err(postgres_error)
}

fn options(address: &DatabaseAddress) -> Result<PgConnectOptions> {
    if !address.is_of_postgres() {
        return Err(StorageError::Unsupported(
            "the address of the database must begin with postgres://".to_owned(),
        ));
    }
    if let Some(name) = address.unknown_parameter() {
        return Err(StorageError::Unsupported(format!(
            "the address {address} has the unknown parameter {name:?}"
        )));
    }
    let options: PgConnectOptions = address.as_str().parse().map_err(|error: sqlx::Error| {
        let words = match &error {
            sqlx::Error::Configuration(detail) => detail.to_string(),
            error => error.to_string(),
        };
        StorageError::Unsupported(format!("the address {address} is invalid: {words}"))
    })?;
    Ok(options.application_name("brood").options(LIMITS).disable_statement_logging())
}

/// Returns the version of the server. Error if it is too old.
async fn assert_version(conn: &mut PgConnection) -> Result<String> {
    let number = show(conn, "SHOW server_version_num").await?;
    let version = show(conn, "SHOW server_version").await?;
    if number.parse::<i32>().is_ok_and(|number| number >= MIN_VERSION) {
        // Builds add their own words after a space.
        return Ok(version.split(' ').next().unwrap_or_default().to_owned());
    }
    let oldest = MIN_VERSION / 10_000;
    Err(StorageError::Unsupported(format!(
        "PostgreSQL must be at least version {oldest}, got {version}"
    )))
}

/// Error if a setting of the server risks commits, or if it cannot store every text.
async fn assert_durable(conn: &mut PgConnection) -> Result<()> {
    for (name, sql) in DURABLE {
        if show(conn, sql).await? == "off" {
            return Err(StorageError::Unsupported(format!(
                "PostgreSQL's {name} must be on, got off: acknowledged writes could be lost"
            )));
        }
    }
    match show(conn, "SHOW server_encoding").await?.as_str() {
        "UTF8" => Ok(()),
        other => Err(StorageError::Unsupported(format!(
            "the encoding of the database must be UTF8, got {other}"
        ))),
    }
}

async fn show(conn: &mut PgConnection, sql: &'static str) -> Result<String> {
    sqlx::query_scalar(sql).fetch_one(conn).await.map_err(postgres_error)
}

/// Error for a failure to get a connection from the pool. It also times out if PostgreSQL does not
/// accept more.
fn no_connection(pool: &PgPool, error: sqlx::Error) -> StorageError {
    match error {
        sqlx::Error::PoolTimedOut if pool.size() < CONNECTIONS => {
            StorageError::Unreachable(format!("no connection within {} s", WAIT.as_secs()))
        }
        error => postgres_error(error),
    }
}

fn other_version() -> StorageError {
    StorageError::Unsupported("the database was written by another version of brood".to_owned())
}

/// Error if the applied migrations differ from those of this build.
async fn assert_migrated(conn: &mut PgConnection) -> Result<()> {
    let sql = "SELECT version, checksum FROM _sqlx_migrations WHERE success ORDER BY version";
    let applied: Vec<(i64, Vec<u8>)> =
        sqlx::query_as(sql).fetch_all(conn).await.map_err(postgres_error)?;
    let known = MIGRATIONS.iter().map(|step| (step.version, step.checksum.to_vec()));
    if known.eq(applied) { Ok(()) } else { Err(other_version()) }
}

/// Applies missing migrations, one server at a time. Error if another version of brood has written
/// the database.
async fn migrate(conn: &mut PgConnection) -> Result<()> {
    // A change of large tables takes long, and another server that makes it is waited for.
    let unlimited = sqlx::raw_sql("SET statement_timeout = 0; SET lock_timeout = 0");
    unlimited.execute(&mut *conn).await.map_err(postgres_error)?;
    match MIGRATIONS.run(conn).await {
        Ok(()) => Ok(()),
        Err(MigrateError::VersionMissing(_) | MigrateError::VersionMismatch(_)) => {
            Err(other_version())
        }
        Err(MigrateError::Execute(error) | MigrateError::ExecuteMigration(error, _)) => {
            match error.as_database_error() {
                Some(database) => Err(StorageError::Unsupported(format!(
                    "the tables cannot be created: {}",
                    database.message()
                ))),
                None => Err(postgres_error(error)),
            }
        }
        Err(error) => Err(StorageError::Unsupported(error.to_string())),
    }
}
