//! Connection with PostgreSQL from the pool, which waits for an answer for a limited time.
//!
//! A broken link may lose an answer and report no error. sqlx would wait for it for ever, and the
//! connection would keep its place in the pool.

use std::time::{Duration, Instant};

use sqlx::pool::PoolConnection;
use sqlx::postgres::{PgArguments, PgRow};
use sqlx::query::Query;
use sqlx::{Connection as _, PgConnection, Postgres};
use tokio::runtime::Handle;
use tokio::sync::watch;
use tokio::time::timeout;

use crate::StorageError;
use crate::error::{Result, postgres_error};

/// Time for the answer to a statement. PostgreSQL ends statements earlier: `LIMITS` of its engine.
const ANSWER: Duration = Duration::from_secs(35);
/// Time for the answer of a connection that is idle or returns to the pool.
const IDLE_ANSWER: Duration = Duration::from_secs(2);

/// Statement with its values.
pub(super) type Statement = Query<'static, Postgres, PgArguments>;

/// Loss of the link with PostgreSQL, as the connection that checks it each second sees it.
#[derive(Debug, Clone, Default)]
pub(crate) struct LinkLoss(watch::Sender<Option<Instant>>);

impl LinkLoss {
    /// Records a check without an answer, by the time at which it was sent.
    pub(crate) fn record(&self, sent: Instant) {
        self.0.send_replace(Some(sent));
    }

    /// True if a check that was sent after `start` had no answer.
    pub(crate) fn is_after(&self, start: Instant) -> bool {
        self.0.borrow().is_some_and(|sent| sent > start)
    }

    /// Returns once a check that was sent after `start` has had no answer.
    async fn after(&self, start: Instant) {
        let mut sent = self.0.subscribe();
        let loss = sent.wait_for(|sent| sent.is_some_and(|sent| sent > start));
        // The sender is `self`.
        let _ = loss.await;
    }
}

/// Connection from the pool, to which it returns.
pub(crate) struct Session {
    /// `None` if an answer was lost.
    conn: Option<PoolConnection<Postgres>>,
    loss: LinkLoss,
    /// True from the start of a transaction to the answer to its end.
    in_transaction: bool,
}

impl Session {
    /// Uses a connection outside transactions.
    pub(crate) fn new(conn: PoolConnection<Postgres>, loss: LinkLoss) -> Self {
        Self { conn: Some(conn), loss, in_transaction: false }
    }

    /// Begins a transaction. It is rolled back unless [`Session::end`] commits it.
    pub(crate) async fn begin(&mut self, statement: &'static str) -> Result<()> {
        // The wait may be cancelled after PostgreSQL has begun it.
        self.in_transaction = true;
        self.execute(sqlx::query(statement)).await?;
        Ok(())
    }

    /// Commits the transaction or rolls it back. Does nothing outside a transaction.
    pub(super) async fn end(mut self, commit: bool) -> Result<()> {
        if !self.in_transaction {
            return Ok(());
        }
        self.execute(sqlx::query(if commit { "COMMIT" } else { "ROLLBACK" })).await?;
        self.in_transaction = false;
        Ok(())
    }

    /// Runs a statement. Returns the number of changed rows.
    pub(super) async fn execute(&mut self, statement: Statement) -> Result<u64> {
        let conn = self.conn.as_mut().ok_or_else(no_answer)?;
        let answer = in_time(&self.loss, statement.execute(&mut **conn)).await;
        Ok(self.accept(answer)?.rows_affected())
    }

    /// Runs a statement. Returns its rows.
    pub(super) async fn rows(&mut self, statement: Statement) -> Result<Vec<PgRow>> {
        let conn = self.conn.as_mut().ok_or_else(no_answer)?;
        let answer = in_time(&self.loss, statement.fetch_all(&mut **conn)).await;
        self.accept(answer)
    }

    /// Closes the connection if there is no answer.
    fn accept<T>(&mut self, answer: Option<sqlx::Result<T>>) -> Result<T> {
        if let Some(answer) = answer {
            return answer.map_err(postgres_error);
        }
        tracing::debug!("a statement has no answer; closing its connection");
        drop(self.conn.take().map(PoolConnection::detach));
        Err(no_answer())
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        let Some(mut conn) = self.conn.take() else { return };
        let Ok(runtime) = Handle::try_current() else { return drop(conn.detach()) };
        let in_transaction = self.in_transaction;
        runtime.spawn(async move {
            if in_transaction {
                let rollback = sqlx::query("ROLLBACK").execute(&mut *conn);
                if !matches!(timeout(IDLE_ANSWER, rollback).await, Ok(Ok(_))) {
                    return drop(conn.detach());
                }
            }
            // It closes the connection if PostgreSQL has closed it, or when it is dropped.
            let _ = timeout(IDLE_ANSWER, conn.return_to_pool()).await;
        });
    }
}

/// True if PostgreSQL answers on an idle connection.
pub(crate) async fn answers(conn: &mut PgConnection) -> bool {
    matches!(timeout(IDLE_ANSWER, conn.ping()).await, Ok(Ok(())))
}

/// Waits for the answer to a statement. Returns `None` if the link is lost meanwhile.
async fn in_time<T>(
    loss: &LinkLoss,
    statement: impl Future<Output = sqlx::Result<T>> + Send,
) -> Option<sqlx::Result<T>> {
    let start = Instant::now();
    tokio::select! {
        biased;
        answer = timeout(ANSWER, statement) => answer.ok(),
        () = loss.after(start) => None,
    }
}

fn no_answer() -> StorageError {
    StorageError::Unreachable("a statement has no answer".to_owned())
}
