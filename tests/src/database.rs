//! Engine of the servers under test: a schema for each data directory, of the PostgreSQL database
//! that `BROOD_TEST_DATABASE` names.

use std::path::Path;

use sqlx::{AssertSqlSafe, Connection, PgConnection};

/// Returns the address for servers and commands with a data directory; `None` for SQLite.
///
/// # Panics
/// If the schema cannot be created.
#[must_use]
pub fn of(data: &Path) -> Option<String> {
    let database = std::env::var("BROOD_TEST_DATABASE").ok()?;
    let path = data.to_string_lossy();
    let schema: String = path.bytes().map(|byte| format!("{byte:02x}")).collect();
    // Names have 63 bytes at most, and the end of a path is what differs.
    let schema = format!("d{}", &schema[schema.len().saturating_sub(60)..]);
    let create = format!("CREATE SCHEMA IF NOT EXISTS {schema}");
    let address = database.clone();
    // The caller may be in a runtime, which must not be blocked by another.
    let created = std::thread::spawn(move || {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
        runtime.expect("a runtime starts").block_on(async {
            let mut conn = PgConnection::connect(&address).await.expect("PostgreSQL runs");
            let create = sqlx::query(AssertSqlSafe(create)).execute(&mut conn).await;
            create.expect("schemas can be created");
        });
    });
    created.join().expect("the schema is created");
    let sign = if database.contains('?') { '&' } else { '?' };
    Some(format!("{database}{sign}options[search_path]={schema}"))
}
