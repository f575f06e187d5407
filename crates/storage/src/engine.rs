//! Engines that keep the data. A [`Store`](crate::Store) has one of them.

pub(crate) mod postgres;
pub(crate) mod sqlite;

use postgres::Postgres;
use sqlite::Sqlite;

/// Engine of a store.
#[derive(Debug)]
pub(crate) enum Engine {
    /// A file in the data directory, for one server.
    Sqlite(Sqlite),
    /// A PostgreSQL server, for any number of servers.
    Postgres(Postgres),
}
