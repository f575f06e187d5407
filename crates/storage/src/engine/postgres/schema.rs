//! Schema of a database: which servers may use its tables, and changes of the tables while servers
//! of an earlier schema run.
//!
//! The number of a schema is that of its last migration. A migration names the oldest schema whose
//! servers run on the tables after it ([`oldest`]). Each server holds an advisory lock of its
//! schema, which servers share; a migration holds those of the servers that it excludes. So none of
//! them runs or starts while the tables change, and the others do.

use std::time::{Duration, Instant};

use sqlx::migrate::{Migration, Migrator};
use sqlx::{AssertSqlSafe, PgConnection};

use super::migration::{apply, oldest};
use crate::StorageError;
use crate::error::{Result, postgres_error};

/// Time for which the start of a server waits for servers that it excludes, and a command for the
/// tables.
const LOCK_WAIT: Duration = Duration::from_secs(10);
/// Interval of attempts to lock the schema.
const LOCK_RETRY: Duration = Duration::from_millis(200);
/// Time for which the locks of excluded servers must have been free. A restart of PostgreSQL
/// releases them, and servers take them again within seconds.
const LOCKS_FREE: Duration = Duration::from_secs(5);
/// Lock of a process that changes or copies the tables.
const CHANGE: &str = "brood change";
/// Last schema of the versions that had one lock for all schemas.
const LAST_OF_ONE_LOCK: i64 = 2;
/// Reason to wait: another process has a lock.
const CHANGES: &str =
    "another process creates, changes or copies the tables of the database; try again";
/// Reason to wait: the migrations exclude a running server.
const RUNS: &str = "servers of an earlier version of brood use the database, and the tables of this \
                    version are not for them; stop them first";

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

/// Locks the schema until the connection ends, and applies the migrations that are missing. Waits
/// for servers that they exclude to end.
///
/// # Errors
/// Returns [`StorageError::Unsupported`] if such servers do not end in time, if another process has
/// the tables, or if the tables are not for this build.
pub(super) async fn prepare(conn: &mut PgConnection, usage: Usage, steps: &Migrator) -> Result<()> {
    let deadline = Instant::now() + LOCK_WAIT;
    let (mut free, mut reason) = (None, CHANGES);
    loop {
        match try_prepare(conn, usage, steps, &mut free).await? {
            Attempt::Ready => return Ok(()),
            Attempt::Changed => continue,
            // Other starts have that lock for moments.
            Attempt::Blocked(CHANGES) => {}
            Attempt::Blocked(other) => reason = other,
        }
        if usage == Usage::Alone || free.is_none() && Instant::now() >= deadline {
            return Err(StorageError::Unsupported(reason.to_owned()));
        }
        tokio::time::sleep(LOCK_RETRY).await;
    }
}

/// Takes the lock of a running server again, after its connection was lost. False if a process that
/// changes the tables has it.
///
/// # Errors
/// Returns [`StorageError::Unsupported`] if the tables are not for this build any more.
pub(super) async fn resume(conn: &mut PgConnection, steps: &Migrator) -> Result<bool> {
    if !call(conn, Call::Share, &lock_of(number(steps))).await? {
        return Ok(false);
    }
    let found = Found::read(conn, steps).await?;
    if found.missing.is_empty() {
        return Ok(true);
    }
    Err(other_version())
}

/// Releases all locks of a connection.
pub(super) async fn release_all(conn: &mut PgConnection) -> Result<()> {
    let released = sqlx::query("SELECT pg_advisory_unlock_all()").execute(conn).await;
    released.map(drop).map_err(postgres_error)
}

/// Result of an attempt to lock the schema.
enum Attempt {
    /// The process may use the tables.
    Ready,
    /// The tables were changed; the next attempt checks them.
    Changed,
    /// Another process must end first.
    Blocked(&'static str),
}

/// Tries to lock the schema. `free` is the time since which the locks of excluded servers are free.
async fn try_prepare(
    conn: &mut PgConnection,
    usage: Usage,
    steps: &Migrator,
    free: &mut Option<Instant>,
) -> Result<Attempt> {
    let own = lock_of(number(steps));
    if usage == Usage::Alone {
        return own_all(conn, steps).await;
    }
    if usage == Usage::Server && !call(conn, Call::Share, &own).await? {
        return Ok(Attempt::Blocked(CHANGES));
    }
    // An error ends the connection, which releases its locks.
    if Found::read(conn, steps).await?.missing.is_empty() {
        return Ok(Attempt::Ready);
    }
    if usage == Usage::Server {
        call(conn, Call::Unshare, &own).await?;
    }
    if !call(conn, Call::Own, CHANGE).await? {
        return Ok(Attempt::Blocked(CHANGES));
    }
    let attempt = upgrade(conn, usage, steps, free).await?;
    call(conn, Call::Disown, CHANGE).await?;
    Ok(attempt)
}

/// Locks the database against all other processes, and applies the migrations that are missing.
async fn own_all(conn: &mut PgConnection, steps: &Migrator) -> Result<Attempt> {
    let all = locks_of(1, number(steps) + 1);
    for lock in std::iter::once(CHANGE.to_owned()).chain(all) {
        if !call(conn, Call::Own, &lock).await? {
            return Ok(Attempt::Blocked("a server or a command uses the database; stop it first"));
        }
    }
    let found = Found::read(conn, steps).await?;
    if found.number > number(steps) {
        return Err(newer(&found, number(steps)));
    }
    apply(conn, &found.missing).await?;
    Ok(Attempt::Ready)
}

/// Applies the migrations that are missing, unless they exclude a server that runs. A command
/// excludes all servers of earlier schemas: servers decide on the tables.
async fn upgrade(
    conn: &mut PgConnection,
    usage: Usage,
    steps: &Migrator,
    free: &mut Option<Instant>,
) -> Result<Attempt> {
    let found = Found::read(conn, steps).await?;
    let first = match usage {
        Usage::Server => found.missing.iter().map(|step| oldest(step)).max().unwrap_or_default(),
        Usage::Alone | Usage::Command => number(steps),
    };
    // Only servers that the present tables allow can run; none on a database without tables.
    let from = if found.number == 0 { first } else { found.oldest };
    let excluded = locks_of(from, first);
    let mut owned = Vec::new();
    for lock in &excluded {
        if !call(conn, Call::Own, lock).await? {
            break;
        }
        owned.push(lock);
    }
    let mut attempt = Attempt::Blocked(RUNS);
    if owned.len() < excluded.len() {
        *free = None;
    } else {
        let since = *free.get_or_insert_with(Instant::now);
        if excluded.is_empty() || since.elapsed() >= LOCKS_FREE {
            apply(conn, &found.missing).await?;
            *free = None;
            attempt = Attempt::Changed;
        }
    }
    for lock in owned {
        call(conn, Call::Disown, lock).await?;
    }
    Ok(attempt)
}

/// Migrations of a database, compared with those of a build.
struct Found<'a> {
    /// Number of the schema; 0 without tables.
    number: i64,
    /// Oldest schema whose servers run on the tables.
    oldest: i64,
    /// Migrations of the build that are not applied.
    missing: Vec<&'a Migration>,
}

impl<'a> Found<'a> {
    /// Reads the applied migrations.
    ///
    /// # Errors
    /// Returns [`StorageError::Unsupported`] if the tables are not for this build, now and after
    /// the missing migrations.
    async fn read(conn: &mut PgConnection, steps: &'a Migrator) -> Result<Self> {
        let mut applied = Vec::new();
        if is_table(conn, "_sqlx_migrations").await? {
            let sql = "SELECT version, checksum FROM _sqlx_migrations WHERE success";
            let rows = sqlx::query_as::<_, (i64, Vec<u8>)>(sql).fetch_all(&mut *conn).await;
            applied = rows.map_err(postgres_error)?;
        }
        let number = applied.iter().map(|(version, _)| *version).max().unwrap_or_default();
        let mut found = Self { number, oldest: 0, missing: Vec::new() };
        for step in steps.iter() {
            match applied.iter().find(|(version, _)| *version == step.version) {
                None => found.missing.push(step),
                Some((_, checksum)) if checksum[..] == step.checksum[..] => {
                    found.oldest = found.oldest.max(oldest(step));
                }
                Some(_) => return Err(other_version()),
            }
        }
        applied.retain(|(version, _)| steps.iter().all(|step| step.version != *version));
        if applied.is_empty() {
            return Ok(found);
        }
        if !found.missing.is_empty() || !is_table(conn, "_brood_step").await? {
            return Err(other_version());
        }
        let unknown: Vec<i64> = applied.into_iter().map(|(version, _)| version).collect();
        let sql = "SELECT count(*), max(oldest) FROM _brood_step WHERE version = ANY($1)";
        let read = sqlx::query_as::<_, (i64, Option<i64>)>(sql).bind(&unknown);
        let (count, oldest) = read.fetch_one(&mut *conn).await.map_err(postgres_error)?;
        found.oldest = found.oldest.max(oldest.unwrap_or(i64::MAX));
        if usize::try_from(count).is_ok_and(|count| count < unknown.len()) {
            return Err(other_version());
        }
        if found.oldest > self::number(steps) {
            return Err(newer(&found, self::number(steps)));
        }
        Ok(found)
    }
}

async fn is_table(conn: &mut PgConnection, name: &str) -> Result<bool> {
    let sql = "SELECT to_regclass(CAST($1 AS TEXT)) IS NOT NULL";
    sqlx::query_scalar(sql).bind(name).fetch_one(conn).await.map_err(postgres_error)
}

/// Number of the schema that a build makes.
fn number(steps: &Migrator) -> i64 {
    steps.iter().map(|step| step.version).max().unwrap_or_default()
}

/// Name of the lock of servers of a schema.
pub(crate) fn lock_of(schema: i64) -> String {
    if schema <= LAST_OF_ONE_LOCK { "brood".to_owned() } else { format!("brood {schema}") }
}

/// Names of the locks of servers of the schemas from `first` to before `end`.
fn locks_of(first: i64, end: i64) -> Vec<String> {
    let mut locks: Vec<String> = (first..end).map(lock_of).collect();
    locks.dedup();
    locks
}

/// Call on a lock.
#[derive(Debug, Clone, Copy)]
enum Call {
    Share,
    Unshare,
    Own,
    Disown,
}

/// Makes a call on a lock of the schema in the search path. False if another process has the lock.
async fn call(conn: &mut PgConnection, call: Call, lock: &str) -> Result<bool> {
    let function = match call {
        Call::Share => "pg_try_advisory_lock_shared",
        Call::Unshare => "pg_advisory_unlock_shared",
        Call::Own => "pg_try_advisory_lock",
        Call::Disown => "pg_advisory_unlock",
    };
    let sql = format!("SELECT {function}(hashtext($1), hashtext(current_schema()))");
    let called = sqlx::query_scalar(AssertSqlSafe(sql)).bind(lock).fetch_one(conn).await;
    called.map_err(postgres_error)
}

fn newer(found: &Found<'_>, own: i64) -> StorageError {
    let Found { number, oldest, .. } = found;
    let reason = if *oldest > own {
        format!("which servers before schema {oldest} cannot use")
    } else {
        "which this command cannot use".to_owned()
    };
    StorageError::Unsupported(format!(
        "a newer version of brood has changed the tables of the database to schema {number}, \
         {reason}; this one has schema {own}"
    ))
}

fn other_version() -> StorageError {
    StorageError::Unsupported("the database was written by another version of brood".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn schemas_have_locks_of_their_own_after_the_second() {
        assert_eq!(locks_of(2, 2), Vec::<String>::new());
        assert_eq!(locks_of(1, 2), ["brood"]);
        assert_eq!(locks_of(1, 5), ["brood", "brood 3", "brood 4"]);
        assert_eq!(lock_of(5), "brood 5");
    }
}
