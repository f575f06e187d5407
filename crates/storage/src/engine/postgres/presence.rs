//! Presence of a server or a copy on a database: its connection with the lock of the schema, which
//! is made again after a restart of PostgreSQL.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use sqlx::migrate::Migrator;
use sqlx::postgres::PgConnectOptions;
use sqlx::{ConnectOptions, Connection, PgConnection};
use tokio::sync::oneshot;
use tokio::task::JoinHandle;
use tokio::time::timeout;

use super::schema::{release_all, resume};
use crate::StorageError;
use crate::error::{Result, postgres_error};

/// Interval between checks of the connection.
const CHECK: Duration = Duration::from_secs(1);
/// Time for PostgreSQL to answer.
const ANSWER: Duration = Duration::from_secs(5);

/// Lock of a schema, held until this is dropped.
#[derive(Debug)]
pub(super) struct Presence {
    /// Ends the task when it is dropped.
    stop: oneshot::Sender<()>,
    task: JoinHandle<()>,
    is_excluded: Arc<AtomicBool>,
}

impl Presence {
    /// Keeps a connection with the lock of a server. It is replaced when it is lost.
    pub(super) fn of_server(
        conn: PgConnection,
        options: PgConnectOptions,
        steps: &'static Migrator,
    ) -> Self {
        Self::new(conn, Some((options, steps)))
    }

    /// Keeps a connection with all locks. It is not replaced.
    pub(super) fn of_copy(conn: PgConnection) -> Self {
        Self::new(conn, None)
    }

    fn new(conn: PgConnection, again: Option<(PgConnectOptions, &'static Migrator)>) -> Self {
        let (stop, stopped) = oneshot::channel();
        let is_excluded = Arc::<AtomicBool>::default();
        let keeper = Keeper { conn: Some(conn), again, is_excluded: is_excluded.clone() };
        Self { stop, task: tokio::spawn(keeper.run(stopped)), is_excluded }
    }

    /// Flag that is set if the tables were changed while the lock was lost, so that this server may
    /// not use them any more.
    pub(super) fn exclusion(&self) -> Arc<AtomicBool> {
        self.is_excluded.clone()
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
    again: Option<(PgConnectOptions, &'static Migrator)>,
    is_excluded: Arc<AtomicBool>,
}

impl Keeper {
    async fn run(mut self, mut stopped: oneshot::Receiver<()>) {
        loop {
            tokio::select! {
                // The sender is dropped.
                _ = &mut stopped => break,
                () = tokio::time::sleep(CHECK) => {}
            }
            if let Err(error) = self.check().await {
                tracing::error!(%error, "this server may not use the database any more");
                self.is_excluded.store(true, Ordering::Relaxed);
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
        if let Some(conn) = &mut self.conn {
            match timeout(ANSWER, conn.ping()).await {
                Ok(Ok(())) => return Ok(()),
                _ => self.conn = None,
            }
        }
        let Some((options, steps)) = &self.again else { return Ok(()) };
        let resumed = async {
            let mut conn = options.connect().await.map_err(postgres_error)?;
            Ok::<_, StorageError>(resume(&mut conn, steps).await?.then_some(conn))
        };
        match timeout(ANSWER, resumed).await {
            Ok(Ok(conn)) => self.conn = conn,
            Ok(Err(error @ StorageError::Unsupported(_))) => return Err(error),
            Ok(Err(error)) => tracing::debug!(%error, "cannot take the lock of the schema"),
            Err(_) => tracing::debug!("cannot take the lock of the schema in time"),
        }
        Ok(())
    }
}
