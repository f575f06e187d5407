//! The engine on a PostgreSQL server.
//!
//! Each write is a transaction of its own connection. PostgreSQL ends the transaction of a lost
//! server after 3 s, see `LIMITS`.

pub(crate) mod bus;

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use sqlx::migrate::MigrateError;
use sqlx::postgres::{PgConnectOptions, PgPoolOptions};
use sqlx::{AssertSqlSafe, ConnectOptions, Connection, PgConnection, PgPool};
use tokio::sync::Semaphore;

use crate::StorageError;
use crate::address::DatabaseAddress;
use crate::error::{Result, postgres_error};
use crate::sql::{Conn, Held};
use crate::write::{CommitTimes, WriteFuture};

use bus::{Bus, BusLink};

/// Oldest supported PostgreSQL, as `server_version_num` gives it.
const MIN_VERSION: i32 = 150_000;
/// Connections of a server besides: the lock, the bus and its replacement.
const OTHER_CONNECTIONS: u32 = 4;
/// Time for which the start of a server waits for a command, or for the end of servers of another
/// version.
const LOCK_WAIT: Duration = Duration::from_secs(10);
/// Interval of attempts to lock the schema.
const LOCK_RETRY: Duration = Duration::from_millis(200);
/// Time that a read or write waits for a connection.
const WAIT: Duration = Duration::from_secs(5);
/// Writes that may wait for a connection. Others fail with [`StorageError::Busy`].
const WAITING_WRITES: usize = 256;
/// A connection that was idle for this long is checked before it is used.
const IDLE: Duration = Duration::from_secs(1);
/// Limits of a session. The first ends the transaction of a lost server, which holds the lock of a
/// lineage until then.
const LIMITS: [(&str, &str); 7] = [
    ("idle_in_transaction_session_timeout", "3s"),
    // The connection with the lock of the schema is idle for ever.
    ("idle_session_timeout", "0"),
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
    /// Connection with the lock of a server or a copy; `None` for a command, and after
    /// [`Postgres::close`]. A restart of PostgreSQL releases the lock.
    lock: Mutex<Option<PgConnection>>,
    /// Version of the server.
    pub version: String,
    waiting: Arc<Semaphore>,
    /// Number of writes refused since the start.
    refused: AtomicU64,
}

impl Postgres {
    /// Connects to a database and checks it. Creates and upgrades its tables if no other process
    /// uses it.
    ///
    /// # Errors
    /// As [`Store::connect`](crate::Store::connect).
    pub async fn connect(address: &DatabaseAddress, usage: Usage) -> Result<Self> {
        let (options, connections) = (options(address)?, address.connections());
        let conn = options.connect().await.map_err(postgres_error);
        let mut conn = conn.map_err(|error| match error {
            StorageError::Unreachable(reason) => {
                StorageError::Unreachable(format!("{address}: {reason}"))
            }
            error => error,
        })?;
        let version = assert_version(&mut conn).await?;
        assert_durable(&mut conn).await?;
        if usage == Usage::Server {
            assert_connections(&mut conn, connections).await?;
        }
        prepare(&mut conn, usage).await?;
        let lock = if usage == Usage::Command {
            conn.close().await.map_err(postgres_error)?;
            None
        } else {
            Some(conn)
        };
        let pool = PgPoolOptions::new()
            .max_connections(connections)
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
        let lock = Mutex::new(lock);
        Ok(Self { pool, lock, version, waiting, refused: AtomicU64::new(0) })
    }

    /// Number of writes refused since the start.
    pub fn refused(&self) -> u64 {
        self.refused.load(Ordering::Relaxed)
    }

    /// Connects to the bus of the servers of this database.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if PostgreSQL cannot be reached.
    pub async fn join_bus(&self) -> Result<(Bus, BusLink)> {
        BusLink::join(PgConnectOptions::clone(&self.pool.connect_options())).await
    }

    /// Closes all connections.
    pub async fn close(&self) {
        self.pool.close().await;
        let locking = self.lock.lock().expect("no code panics while holding this lock").take();
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

/// Use of a database, which decides who else may use it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Usage {
    /// One of any number of servers.
    Server,
    /// Copy of another database, without servers.
    Alone,
    /// Short command, beside servers or without any.
    Command,
}

/// Locks the schema until the connection ends, and upgrades it if no other process uses it. Servers
/// share the lock; a server waits for commands, which have it for moments.
///
/// # Errors
/// Returns [`StorageError::Locked`] if another kind of process has the lock, and
/// [`StorageError::Unsupported`] if running servers are of another version.
async fn prepare(conn: &mut PgConnection, usage: Usage) -> Result<()> {
    let deadline = Instant::now() + LOCK_WAIT;
    loop {
        if try_lock(conn, "SELECT pg_try_advisory_lock(").await? {
            // A role that may not create tables uses those that another has created.
            if assert_migrated(conn).await.is_err() {
                migrate(conn).await?;
            }
            if usage == Usage::Server {
                // One connection may hold both.
                try_lock(conn, "SELECT pg_try_advisory_lock_shared(").await?;
                try_lock(conn, "SELECT pg_advisory_unlock(").await?;
            }
            return Ok(());
        }
        let checked = match usage {
            // The servers decide on the schema.
            Usage::Command => return assert_migrated(conn).await,
            Usage::Alone => {
                return Err(StorageError::Unsupported(
                    "a server or a command uses the database; stop it first".to_owned(),
                ));
            }
            Usage::Server if try_lock(conn, "SELECT pg_try_advisory_lock_shared(").await? => {
                match assert_migrated(conn).await {
                    Ok(()) => return Ok(()),
                    // Servers of another version may be about to end.
                    Err(error) => {
                        try_lock(conn, "SELECT pg_advisory_unlock_shared(").await?;
                        error
                    }
                }
            }
            Usage::Server => StorageError::Unsupported(
                "another process creates or copies the tables of the database; try again"
                    .to_owned(),
            ),
        };
        if Instant::now() >= deadline {
            return Err(checked);
        }
        tokio::time::sleep(LOCK_RETRY).await;
    }
}

/// Calls a function on the lock of the schema, and returns its result.
async fn try_lock(conn: &mut PgConnection, call: &str) -> Result<bool> {
    let sql = format!("{call}hashtext('brood'), hashtext(current_schema()))");
    sqlx::query_scalar(AssertSqlSafe(sql)).fetch_one(conn).await.map_err(postgres_error)
}

/// Error if PostgreSQL does not accept the connections of one server.
async fn assert_connections(conn: &mut PgConnection, own: u32) -> Result<()> {
    let number = |text: String| text.parse::<u32>().unwrap_or_default();
    let most = number(show(conn, "SHOW max_connections").await?);
    let reserved = number(show(conn, "SHOW superuser_reserved_connections").await?);
    let (needed, free) = (own + OTHER_CONNECTIONS, most.saturating_sub(reserved));
    if needed <= free {
        return Ok(());
    }
    Err(StorageError::Unsupported(format!(
        "a server needs {needed} connections, but PostgreSQL accepts {free} (max_connections \
         {most}, {reserved} reserved)"
    )))
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
        sqlx::Error::PoolTimedOut if pool.size() < pool.options().get_max_connections() => {
            StorageError::Unreachable(format!("no connection within {} s", WAIT.as_secs()))
        }
        error => postgres_error(error),
    }
}

fn other_version() -> StorageError {
    StorageError::Unsupported("the database was written by another version of brood".to_owned())
}

/// Error if the applied migrations differ from those of this build. Only processes that use the
/// database meanwhile keep this one from applying them.
async fn assert_migrated(conn: &mut PgConnection) -> Result<()> {
    let sql = "SELECT version, checksum FROM _sqlx_migrations WHERE success ORDER BY version";
    let applied: Vec<(i64, Vec<u8>)> =
        sqlx::query_as(sql).fetch_all(conn).await.map_err(postgres_error)?;
    let known = MIGRATIONS.iter().map(|step| (step.version, step.checksum.to_vec()));
    if known.eq(applied) {
        return Ok(());
    }
    Err(StorageError::Unsupported(
        "servers of another version of brood use the database; stop them first".to_owned(),
    ))
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
