//! Options of the database connections, checks of the pragmas that durability depends on, the
//! required SQLite version, migrations, and the check after an unclean shutdown.

use std::path::Path;
use std::time::Duration;

use sqlx::migrate::MigrateError;
use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqliteSynchronous};
use sqlx::{ConnectOptions, Row, SqliteConnection};

use crate::StorageError;
use crate::error::Result;

/// Oldest supported SQLite: earlier versions have bugs in the write-ahead log.
const MIN_SQLITE: [u32; 3] = [3, 51, 3];
const BUSY_TIMEOUT: Duration = Duration::from_secs(5);
/// The log file is truncated to this size after a checkpoint.
const JOURNAL_SIZE_LIMIT_BYTES: i64 = 64 << 20;

static MIGRATIONS: sqlx::migrate::Migrator = sqlx::migrate!("../../migrations");

/// Returns the options of the write connection.
pub(crate) fn writing(file: &Path, create: bool) -> SqliteConnectOptions {
    let options = SqliteConnectOptions::new()
        .filename(file)
        .create_if_missing(create)
        .journal_mode(SqliteJournalMode::Wal)
        .synchronous(SqliteSynchronous::Full)
        .foreign_keys(true)
        .busy_timeout(BUSY_TIMEOUT)
        .pragma("journal_size_limit", JOURNAL_SIZE_LIMIT_BYTES.to_string())
        // The writer task runs all checkpoints.
        .pragma("wal_autocheckpoint", "0")
        .thread_name(|_| "brood-sql-write".to_owned())
        .disable_statement_logging();
    in_any_order(options)
}

/// Returns the options of a read connection.
pub(crate) fn reading(file: &Path) -> SqliteConnectOptions {
    let options = SqliteConnectOptions::new()
        .filename(file)
        .read_only(true)
        .foreign_keys(true)
        .busy_timeout(BUSY_TIMEOUT)
        .pragma("query_only", "ON")
        .thread_name(|n| format!("brood-sql-{n}"))
        .disable_statement_logging();
    in_any_order(options)
}

/// In tests, reverses the rows of queries without ORDER BY, so that a query that relies on the
/// order of an index fails.
fn in_any_order(options: SqliteConnectOptions) -> SqliteConnectOptions {
    if cfg!(test) { options.pragma("reverse_unordered_selects", "ON") } else { options }
}

/// Error if a pragma of the write connection does not have the value that durability requires.
pub(crate) async fn assert_writing(conn: &mut SqliteConnection) -> Result<()> {
    let mode: String = sqlx::query_scalar("PRAGMA journal_mode").fetch_one(&mut *conn).await?;
    if mode != "wal" {
        return Err(StorageError::Unsupported(format!(
            "the data directory does not allow a write-ahead log (journal_mode is {mode})"
        )));
    }
    let busy_ms = i64::try_from(BUSY_TIMEOUT.as_millis()).expect("a timeout is short");
    expect(conn, "synchronous", "PRAGMA synchronous", 2).await?;
    expect(conn, "foreign_keys", "PRAGMA foreign_keys", 1).await?;
    expect(conn, "wal_autocheckpoint", "PRAGMA wal_autocheckpoint", 0).await?;
    expect(conn, "busy_timeout", "PRAGMA busy_timeout", busy_ms).await
}

/// Error if the connection can write.
pub(crate) async fn assert_reading(conn: &mut SqliteConnection) -> Result<()> {
    expect(conn, "query_only", "PRAGMA query_only", 1).await
}

async fn expect(
    conn: &mut SqliteConnection,
    name: &str,
    sql: &'static str,
    wanted: i64,
) -> Result<()> {
    let found: i64 = sqlx::query_scalar(sql).fetch_one(conn).await?;
    if found == wanted {
        return Ok(());
    }
    Err(StorageError::Unsupported(format!("SQLite's {name} must be {wanted}, got {found}")))
}

/// Returns the version of the SQLite library. Error if it is too old.
pub(crate) async fn sqlite_version(conn: &mut SqliteConnection) -> Result<String> {
    let version: String = sqlx::query_scalar("SELECT sqlite_version()").fetch_one(conn).await?;
    if is_recent_enough(&version) {
        return Ok(version);
    }
    let [major, minor, patch] = MIN_SQLITE;
    Err(StorageError::Unsupported(format!(
        "SQLite must be at least {major}.{minor}.{patch}, got {version}"
    )))
}

fn is_recent_enough(version: &str) -> bool {
    let numbers: Result<Vec<u32>, _> = version.split('.').map(str::parse).collect();
    numbers.is_ok_and(|numbers| numbers.as_slice() >= MIN_SQLITE.as_slice())
}

/// Applies missing migrations. Error if a newer or different build has written the file.
pub(crate) async fn migrate(conn: &mut SqliteConnection) -> Result<()> {
    match MIGRATIONS.run(conn).await {
        Ok(()) => Ok(()),
        Err(MigrateError::VersionMissing(_) | MigrateError::VersionMismatch(_)) => {
            Err(other_version())
        }
        Err(MigrateError::Execute(error) | MigrateError::ExecuteMigration(error, _)) => {
            Err(error.into())
        }
        Err(error) => Err(StorageError::Unsupported(error.to_string())),
    }
}

/// Error if the applied migrations differ from those of this build. For processes that do not own
/// the directory and must not migrate.
pub(crate) async fn assert_migrated(conn: &mut SqliteConnection) -> Result<()> {
    let sql = "SELECT version, checksum FROM _sqlx_migrations WHERE success ORDER BY version";
    let rows = sqlx::query(sql).fetch_all(conn).await?;
    let mut applied = Vec::with_capacity(rows.len());
    for row in rows {
        applied.push((row.try_get::<i64, _>("version")?, row.try_get::<Vec<u8>, _>("checksum")?));
    }
    let known = MIGRATIONS.iter().map(|step| (step.version, step.checksum.to_vec()));
    if known.eq(applied) { Ok(()) } else { Err(other_version()) }
}

fn other_version() -> StorageError {
    StorageError::Unsupported(
        "the data directory was written by another version of brood".to_owned(),
    )
}

/// Checks the integrity of the whole file. Its time grows with the size of the file, so it runs
/// after an unclean shutdown only.
pub(crate) async fn check(conn: &mut SqliteConnection) -> Result<()> {
    let verdict: String = sqlx::query_scalar("PRAGMA quick_check(1)").fetch_one(&mut *conn).await?;
    if verdict != "ok" {
        return Err(StorageError::Corrupt(verdict));
    }
    match sqlx::query("PRAGMA foreign_key_check").fetch_optional(conn).await? {
        None => Ok(()),
        Some(row) => {
            let table: String = row.try_get(0)?;
            Err(StorageError::Corrupt(format!("a row of {table} violates a foreign key")))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::is_recent_enough;

    #[test]
    fn sqlite_version_is_rejected_when_older_or_unreadable() {
        for version in ["3.51.3", "3.51.10", "3.52.0", "4.0.0"] {
            assert!(is_recent_enough(version), "{version}");
        }
        for version in ["3.51.2", "3.9.9", "2.99.99", "", "3.51", "x.y.z"] {
            assert!(!is_recent_enough(version), "{version}");
        }
    }
}
