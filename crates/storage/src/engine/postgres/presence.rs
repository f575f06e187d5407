//! Presence of a server or a copy on a database: its connection with the lock of the schema, which
//! is made again after a restart of PostgreSQL.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use sqlx::migrate::Migrator;
use sqlx::postgres::PgConnectOptions;
use sqlx::{ConnectOptions, Connection, PgConnection};
use tokio::sync::oneshot;
use tokio::task::JoinHandle;
use tokio::time::timeout;

use super::schema::{release_all, resume};
use crate::StorageError;
use crate::error::{Result, postgres_error};
use crate::sql::LinkLoss;

/// Interval between checks of the connection.
const CHECK: Duration = Duration::from_secs(1);
/// Interval between attempts to replace a lost connection.
const RETRY: Duration = Duration::from_millis(200);
/// Time for PostgreSQL to answer.
const ANSWER: Duration = Duration::from_secs(5);

/// Time after the last sign of the lock for which the tables may be used. A start that changes them
/// waits longer: `LOCKS_FREE` of `schema.rs`.
const CONFIRMED: Duration = Duration::from_secs(4);

/// Address of a database with the migrations of this build, to take a lost lock again.
pub(super) type Reconnection = (PgConnectOptions, &'static Migrator);

/// State of the lock of a process.
#[derive(Debug)]
pub(super) struct Standing {
    is_excluded: AtomicBool,
    /// Time of the last sign that the lock is held.
    confirmed: Mutex<Instant>,
}

impl Standing {
    /// True if the tables were changed while the lock was lost, so that this process may not use
    /// them any more.
    pub(super) fn is_excluded(&self) -> bool {
        self.is_excluded.load(Ordering::Relaxed)
    }

    /// True if the lock was not seen for seconds, so that another process may change the tables.
    pub(super) fn is_unconfirmed(&self) -> bool {
        self.confirmed.lock().expect("nothing panics under this lock").elapsed() > CONFIRMED
    }

    /// Records that the lock was held at this time.
    fn confirm(&self, at: Instant) {
        *self.confirmed.lock().expect("nothing panics under this lock") = at;
    }
}

/// Lock of a schema, held until this is dropped.
#[derive(Debug)]
pub(super) struct Presence {
    /// Ends the task when it is dropped.
    stop: oneshot::Sender<()>,
    task: JoinHandle<()>,
    standing: Arc<Standing>,
}

impl Presence {
    /// Keeps a connection with the lock of a server. It is replaced when it is lost.
    pub(super) fn of_server(conn: PgConnection, loss: LinkLoss, again: Reconnection) -> Self {
        Self::new(conn, loss, Some(again))
    }

    /// Keeps a connection with all locks. It is not replaced.
    pub(super) fn of_copy(conn: PgConnection, loss: LinkLoss) -> Self {
        Self::new(conn, loss, None)
    }

    fn new(conn: PgConnection, loss: LinkLoss, again: Option<Reconnection>) -> Self {
        let (stop, stopped) = oneshot::channel();
        let standing = Arc::new(Standing {
            is_excluded: AtomicBool::new(false),
            confirmed: Mutex::new(Instant::now()),
        });
        let keeper = Keeper { conn: Some(conn), loss, again, standing: standing.clone() };
        Self { stop, task: tokio::spawn(keeper.run(stopped)), standing }
    }

    /// State of the lock.
    pub(super) fn standing(&self) -> Arc<Standing> {
        self.standing.clone()
    }

    /// Releases the lock.
    pub(super) async fn end(self) {
        drop(self.stop);
        if let Err(error) = self.task.await {
            tracing::warn!(%error, "the lock of the schema was not released");
        }
    }
}

/// Task that keeps the connection.
struct Keeper {
    conn: Option<PgConnection>,
    loss: LinkLoss,
    again: Option<Reconnection>,
    standing: Arc<Standing>,
}

impl Keeper {
    async fn run(mut self, mut stopped: oneshot::Receiver<()>) {
        loop {
            let interval = if self.conn.is_some() { CHECK } else { RETRY };
            tokio::select! {
                // The sender is dropped.
                _ = &mut stopped => break,
                () = tokio::time::sleep(interval) => {}
            }
            if let Err(error) = self.check().await {
                tracing::error!(%error, "this server may not use the database any more");
                self.standing.is_excluded.store(true, Ordering::Relaxed);
                break;
            }
        }
        let Some(mut conn) = self.conn.take() else { return };
        // PostgreSQL sees the end of a connection later than this call.
        let close = async {
            release_all(&mut conn).await?;
            conn.close().await.map_err(postgres_error)
        };
        if let Ok(Err(error)) = timeout(ANSWER, close).await {
            tracing::debug!(%error, "cannot close the connection with the lock");
        }
    }

    /// Replaces a lost connection.
    ///
    /// # Errors
    /// Returns [`StorageError::Unsupported`] if the tables are not for this build any more.
    async fn check(&mut self) -> Result<()> {
        // An answer may be read long after it was sent.
        let asked = Instant::now();
        if let Some(conn) = &mut self.conn {
            match timeout(ANSWER, conn.ping()).await {
                Ok(Ok(())) => {
                    self.standing.confirm(asked);
                    return Ok(());
                }
                _ => {
                    self.conn = None;
                    self.loss.record(asked);
                }
            }
        }
        let Some((options, steps)) = &self.again else { return Ok(()) };
        let resumed = async {
            let mut conn = options.connect().await.map_err(postgres_error)?;
            Ok::<_, StorageError>(resume(&mut conn, steps).await?.then_some(conn))
        };
        match timeout(ANSWER, resumed).await {
            Ok(Ok(conn)) => {
                if conn.is_some() {
                    self.standing.confirm(asked);
                }
                self.conn = conn;
            }
            Ok(Err(error @ StorageError::Unsupported(_))) => return Err(error),
            Ok(Err(error)) => tracing::debug!(%error, "cannot take the lock of the schema"),
            Err(_) => tracing::debug!("cannot take the lock of the schema in time"),
        }
        Ok(())
    }
}
