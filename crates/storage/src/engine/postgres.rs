//! The engine on a PostgreSQL server.
//!
//! Each write is a transaction of its own connection. PostgreSQL ends the transaction of a lost
//! server after 3 s, see `LIMITS`.

pub(crate) mod bus;
mod migration;
mod presence;
mod schema;

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use sqlx::migrate::Migrator;
use sqlx::postgres::{PgConnectOptions, PgPoolOptions};
use sqlx::{ConnectOptions, Connection, PgConnection, PgPool};
use tokio::sync::Semaphore;
use tokio::time::timeout;

use crate::StorageError;
use crate::address::DatabaseAddress;
use crate::error::{Result, postgres_error};
use crate::sql::{Conn, LinkLoss, Session, answers};
use crate::write::{CommitTimes, WriteFuture};

use bus::{Bus, BusLink};
use presence::{Presence, Standing};
pub(crate) use schema::{Usage, lock_of};

/// Oldest supported PostgreSQL, as `server_version_num` gives it.
const MIN_VERSION: i32 = 150_000;
/// Connections of a server besides: the lock, the bus and its replacement.
const OTHER_CONNECTIONS: u32 = 4;
/// Time that a read or write waits for a connection.
const WAIT: Duration = Duration::from_secs(5);
/// Writes that may wait for a connection. Others fail with [`StorageError::Busy`].
const WAITING_WRITES: usize = 256;
/// A connection that was idle for this long is checked before it is used.
const IDLE: Duration = Duration::from_secs(1);
/// Time for the end of statements when the connections are closed.
const CLOSE_LIMIT: Duration = Duration::from_secs(5);
/// Limits of a session. The first ends the transaction of a lost server, which holds the lock of a
/// lineage until then.
const LIMITS: [(&str, &str); 7] = [
    ("idle_in_transaction_session_timeout", "3s"),
    // A connection may be idle for as long as the server runs.
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

/// Migrations of this build.
pub(crate) static MIGRATIONS: Migrator = sqlx::migrate!("../../migrations/postgres");

/// Database on a PostgreSQL server.
#[derive(Debug)]
pub(crate) struct Postgres {
    pool: PgPool,
    loss: LinkLoss,
    /// Lock of a server or a copy; `None` for a command, and after [`Postgres::close`].
    presence: Mutex<Option<Presence>>,
    /// State of that lock.
    standing: Option<Arc<Standing>>,
    /// Version of the server.
    pub version: String,
    waiting: Arc<Semaphore>,
    /// Number of writes refused since the start.
    refused: AtomicU64,
}

impl Postgres {
    /// Connects to a database and checks it. Creates and upgrades its tables, unless that excludes
    /// a server that uses them.
    ///
    /// # Errors
    /// As [`Store::connect`](crate::Store::connect).
    pub async fn connect(address: &DatabaseAddress, usage: Usage) -> Result<Self> {
        Self::connect_with(address, usage, &MIGRATIONS).await
    }

    /// As [`Postgres::connect`], as a build with these migrations.
    ///
    /// # Errors
    /// As [`Postgres::connect`].
    pub async fn connect_with(
        address: &DatabaseAddress,
        usage: Usage,
        steps: &'static Migrator,
    ) -> Result<Self> {
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
        schema::prepare(&mut conn, usage, steps).await?;
        let loss = LinkLoss::default();
        let presence = match usage {
            Usage::Server => {
                Some(Presence::of_server(conn, loss.clone(), (options.clone(), steps)))
            }
            Usage::Alone => Some(Presence::of_copy(conn, loss.clone())),
            Usage::Command => {
                conn.close().await.map_err(postgres_error)?;
                None
            }
        };
        let standing = presence.as_ref().map(Presence::standing);
        let pool = pool(connections, loss.clone()).connect_lazy_with(options);
        let waiting = Arc::new(Semaphore::new(WAITING_WRITES));
        let presence = Mutex::new(presence);
        Ok(Self { pool, loss, presence, standing, version, waiting, refused: AtomicU64::new(0) })
    }

    /// True if the tables were changed while the connection with the lock was lost, so that this
    /// server may not use them any more. Reads and writes then fail.
    pub fn is_excluded(&self) -> bool {
        self.standing.as_ref().is_some_and(|standing| standing.is_excluded())
    }

    fn assert_included(&self) -> Result<()> {
        if self.is_excluded() { Err(excluded()) } else { Ok(()) }
    }

    /// Error if another process may change the tables now, or has changed them.
    fn assert_usable(&self) -> Result<()> {
        self.assert_included()?;
        if self.standing.as_ref().is_some_and(|standing| standing.is_unconfirmed()) {
            let reason = "the connection that keeps other versions from its tables is lost";
            return Err(StorageError::Unreachable(reason.to_owned()));
        }
        Ok(())
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
    ///
    /// # Errors
    /// Returns [`StorageError::Unsupported`] if the tables are not for this server any more.
    pub async fn close(&self) -> Result<()> {
        // A statement waits longer for a lost answer. PostgreSQL ends its transaction.
        if timeout(CLOSE_LIMIT, self.pool.close()).await.is_err() {
            tracing::warn!("connections with PostgreSQL are left, since statements have no answer");
        }
        let presence = self.presence.lock().expect("no code panics while holding this lock").take();
        if let Some(presence) = presence {
            presence.end().await;
        }
        self.assert_included()
    }

    /// Returns a connection for one read.
    pub async fn reader(&self) -> Result<Conn> {
        self.assert_usable()?;
        Ok(Conn::Postgres(session(&self.pool, &self.loss).await?))
    }

    /// Returns a connection for several reads of one consistent state.
    pub async fn snapshot(&self) -> Result<Conn> {
        self.assert_usable()?;
        let mut session = session(&self.pool, &self.loss).await?;
        session.begin(SNAPSHOT).await?;
        Ok(Conn::Postgres(session))
    }

    /// Runs an operation in a transaction, and returns when it is committed. It is committed even
    /// if the caller does not wait for it.
    pub async fn write<T, F>(&self, operation: F) -> Result<(T, CommitTimes)>
    where
        T: Send + 'static,
        F: for<'c> FnOnce(&'c mut Conn) -> WriteFuture<'c, Result<T>> + Send + 'static,
    {
        self.assert_usable()?;
        let Ok(permit) = self.waiting.clone().try_acquire_owned() else {
            self.refused.fetch_add(1, Ordering::Relaxed);
            return Err(StorageError::Busy);
        };
        let (pool, loss) = (self.pool.clone(), self.loss.clone());
        let write = tokio::spawn(async move {
            let enqueued = Instant::now();
            let mut session = session(&pool, &loss).await?;
            session.begin(BEGIN).await?;
            drop(permit);
            let started = Instant::now();
            let mut conn = Conn::Postgres(session);
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

/// Makes a pool that replaces the connections that PostgreSQL or the loss of the link has closed.
fn pool(connections: u32, loss: LinkLoss) -> PgPoolOptions {
    PgPoolOptions::new()
        .max_connections(connections)
        .acquire_timeout(WAIT)
        .test_before_acquire(false)
        .before_acquire(move |conn, meta| {
            let is_lost = Instant::now()
                .checked_sub(meta.idle_for)
                .is_some_and(|returned| loss.is_after(returned));
            Box::pin(async move { Ok(!is_lost && (meta.idle_for < IDLE || answers(conn).await)) })
        })
}

/// Takes a connection from the pool.
async fn session(pool: &PgPool, loss: &LinkLoss) -> Result<Session> {
    let conn = pool.acquire().await.map_err(|error| no_connection(pool, error))?;
    Ok(Session::new(conn, loss.clone()))
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

fn excluded() -> StorageError {
    StorageError::Unsupported(
        "another version of brood has changed the tables of the database; start that version"
            .to_owned(),
    )
}
