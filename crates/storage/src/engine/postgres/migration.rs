//! Migrations of PostgreSQL: the servers that they are compatible with, and their application while
//! these servers run.

use std::time::{Duration, Instant};

use sqlx::migrate::{Migrate, MigrateError, Migration};
use sqlx::{AssertSqlSafe, PgConnection};

use crate::StorageError;
use crate::error::{Result, postgres_error};

/// Line of a migration before and after the oldest schema whose servers run on its tables.
const OLDEST: (&str, &str) = ("-- Servers of schema ", " or later run on these tables.");
/// Table of the applied migrations.
const APPLIED: &str = "_sqlx_migrations";
/// Table with the oldest schema of each migration, which servers read that do not have the
/// migration.
const STEP_TABLE: &str = "CREATE TABLE IF NOT EXISTS _brood_step (
    version BIGINT NOT NULL PRIMARY KEY,
    oldest  BIGINT NOT NULL
)";
/// Time for which a migration waits for a lock of a table. Other statements on the table wait
/// behind it.
const LOCK_TIMEOUT: &str = "SET lock_timeout = '500ms'";
/// Time between attempts of a migration, in which the statements that waited behind it run.
const RETRY: Duration = Duration::from_secs(1);
/// Time after which a migration that gets no lock fails.
const RETRY_LIMIT: Duration = Duration::from_secs(60);
/// Words before the name of an index that is made without stopping writes.
const INDEX: &str = "INDEX CONCURRENTLY IF NOT EXISTS ";

/// Returns the oldest schema whose servers run on the tables after a migration: that of its line,
/// or without one that of the migration.
pub(super) fn oldest(step: &Migration) -> i64 {
    let (before, after) = OLDEST;
    let named = step.sql.as_str().lines().find_map(|line| {
        line.trim_end().strip_prefix(before)?.strip_suffix(after)?.parse::<i64>().ok()
    });
    named.unwrap_or(step.version).min(step.version)
}

/// Applies migrations in their order. Each records the oldest schema first. A migration that does
/// not get a lock of a table is tried again, so that statements of servers do not wait long behind
/// it.
pub(super) async fn apply(conn: &mut PgConnection, missing: &[&Migration]) -> Result<()> {
    if missing.is_empty() {
        return Ok(());
    }
    // An index of a large table takes long.
    execute(conn, "SET statement_timeout = 0").await?;
    conn.ensure_migrations_table(APPLIED).await.map_err(failed)?;
    execute(conn, STEP_TABLE).await?;
    for step in missing {
        let record = sqlx::query(
            "INSERT INTO _brood_step (version, oldest) VALUES ($1, $2)
             ON CONFLICT (version) DO UPDATE SET oldest = excluded.oldest",
        );
        let record = record.bind(step.version).bind(oldest(step));
        record.execute(&mut *conn).await.map_err(postgres_error)?;
        apply_one(conn, step).await?;
        tracing::info!(schema = step.version, "changed the tables of the database");
    }
    execute(conn, "RESET statement_timeout").await?;
    execute(conn, "RESET lock_timeout").await
}

async fn apply_one(conn: &mut PgConnection, step: &Migration) -> Result<()> {
    let deadline = Instant::now() + RETRY_LIMIT;
    loop {
        if step.no_tx {
            // It waits for transactions, but no statement waits behind it.
            execute(conn, "SET lock_timeout = 0").await?;
            remove_partial_index(conn, step).await?;
        } else {
            execute(conn, LOCK_TIMEOUT).await?;
        }
        match conn.apply(APPLIED, step).await {
            Ok(_) => return Ok(()),
            Err(error) if is_locked(&error) && Instant::now() < deadline => {
                tracing::debug!(schema = step.version, %error, "a table is in use; trying again");
            }
            Err(error) => return Err(failed(error)),
        }
        tokio::time::sleep(RETRY).await;
    }
}

/// Removes the index of a migration that was ended while it made the index. PostgreSQL keeps it,
/// but does not use it.
async fn remove_partial_index(conn: &mut PgConnection, step: &Migration) -> Result<()> {
    let Some((_, rest)) = step.sql.as_str().split_once(INDEX) else { return Ok(()) };
    let name = rest.split_whitespace().next().unwrap_or_default();
    let sql = "SELECT count(*) FROM pg_index
        WHERE indexrelid = to_regclass(CAST($1 AS TEXT)) AND NOT indisvalid";
    let partial = sqlx::query_scalar::<_, i64>(sql).bind(name).fetch_one(&mut *conn).await;
    if partial.map_err(postgres_error)? == 0 {
        return Ok(());
    }
    let remove = AssertSqlSafe(format!("DROP INDEX CONCURRENTLY IF EXISTS {name}"));
    sqlx::raw_sql(remove).execute(conn).await.map(drop).map_err(postgres_error)
}

async fn execute(conn: &mut PgConnection, sql: &'static str) -> Result<()> {
    sqlx::raw_sql(sql).execute(conn).await.map(drop).map_err(postgres_error)
}

/// True for a timeout of a lock and a deadlock.
fn is_locked(error: &MigrateError) -> bool {
    let (MigrateError::Execute(error) | MigrateError::ExecuteMigration(error, _)) = error else {
        return false;
    };
    let code = error.as_database_error().and_then(|error| error.code());
    matches!(code.as_deref(), Some("55P03" | "40P01"))
}

fn failed(error: MigrateError) -> StorageError {
    let is_locked = is_locked(&error);
    match error {
        MigrateError::Execute(error) | MigrateError::ExecuteMigration(error, _) => {
            match error.as_database_error() {
                Some(_) if is_locked => StorageError::Unsupported(format!(
                    "the tables cannot be changed: a table is locked for more than {} s, for \
                     example by pg_dump; try again later",
                    RETRY_LIMIT.as_secs()
                )),
                Some(database) => StorageError::Unsupported(format!(
                    "the tables cannot be created or changed: {}",
                    database.message()
                )),
                None => postgres_error(error),
            }
        }
        error => StorageError::Unsupported(error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use sqlx::SqlSafeStr as _;
    use sqlx::migrate::MigrationType;

    use super::*;

    fn step(version: i64, sql: &'static str) -> Migration {
        let name = "step".into();
        Migration::new(version, name, MigrationType::Simple, sql.into_sql_str(), false)
    }

    #[test]
    fn migration_without_the_line_excludes_all_earlier_servers() {
        let line = "-- New table.\n-- Servers of schema 3 or later run on these tables.\nSELECT 1";
        assert_eq!(oldest(&step(5, line)), 3);
        assert_eq!(oldest(&step(5, "SELECT 1")), 5);
        assert_eq!(oldest(&step(5, "-- Servers of schema x or later run on these tables.")), 5);
        assert_eq!(oldest(&step(5, "-- Servers of schema 9 or later run on these tables.")), 5);
    }
}
