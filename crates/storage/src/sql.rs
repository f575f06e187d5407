//! Statements, connections and rows, the same for every engine. Independent of tables.
//!
//! A statement is one text for all engines, with `?` or `?1` for its values; `dialect` says how the
//! engines read it. The tables' modules use sqlx through this file only.

mod dialect;
mod session;

use std::borrow::Cow;
use std::ops::{Deref, DerefMut};

use sqlx::pool::PoolConnection;
use sqlx::postgres::PgRow;
use sqlx::query::Query as SqlxQuery;
use sqlx::sqlite::{SqliteArguments, SqliteRow};
use sqlx::{
    AssertSqlSafe, ColumnIndex, Connection as _, Row as _, Sqlite, SqliteConnection, Transaction,
};

use crate::StorageError;
use crate::column::{Column, corrupt_column};
use crate::error::Result;
pub(crate) use session::{LinkLoss, Session, answers};

/// Connection to the database.
pub(crate) enum Conn {
    Sqlite(Held),
    Postgres(Session),
}

/// Number of the lock of [`Conn::lock_genomes`]: "genome" in ASCII.
const GENOME_LOCK: i64 = 0x67_65_6e_6f_6d_65;

/// Use of genomes by a transaction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum GenomeUse {
    /// Stores genomes, or refers to stored ones.
    Birth,
    /// Removes those without references.
    Removal,
}

/// Connection of SQLite, by its owner.
pub(crate) enum Held {
    /// Opened for this use alone.
    Own(SqliteConnection),
    /// Taken from a pool, to which it returns.
    Pooled(PoolConnection<Sqlite>),
    /// Taken from a pool, in a transaction that ends with it.
    Transaction(Transaction<'static, Sqlite>),
}

impl Deref for Held {
    type Target = SqliteConnection;

    fn deref(&self) -> &SqliteConnection {
        match self {
            Self::Own(conn) => conn,
            Self::Pooled(conn) => conn,
            Self::Transaction(conn) => conn,
        }
    }
}

impl DerefMut for Held {
    fn deref_mut(&mut self) -> &mut SqliteConnection {
        match self {
            Self::Own(conn) => conn,
            Self::Pooled(conn) => conn,
            Self::Transaction(conn) => conn,
        }
    }
}

/// Value of a statement.
#[derive(Debug, Clone)]
pub(crate) enum Value {
    Flag(Option<bool>),
    Integer(Option<i64>),
    Real(Option<f64>),
    Text(Option<String>),
    Bytes(Option<Vec<u8>>),
    Keys(KeySet),
}

/// Set of ids or hashes as one value, for `IN (SELECT unhex(value) FROM json_each(?))`: the
/// statement is the same for every size of the set.
#[derive(Debug, Clone, Default)]
pub(crate) struct KeySet {
    /// The keys one after the other.
    pub bytes: Vec<u8>,
    /// Length of a key, in bytes.
    pub width: usize,
}

impl KeySet {
    /// Returns the keys one by one.
    fn list(&self) -> Vec<Vec<u8>> {
        self.bytes.chunks_exact(self.width.max(1)).map(<[u8]>::to_vec).collect()
    }

    /// Returns the keys as a JSON list of hexadecimal texts.
    fn json(&self) -> String {
        use std::fmt::Write as _;
        let mut json = String::with_capacity(2 + 2 * self.bytes.len() + 64);
        json.push('[');
        for key in self.bytes.chunks_exact(self.width.max(1)) {
            json.push_str(if json.len() == 1 { "\"" } else { ",\"" });
            for byte in key {
                write!(json, "{byte:02x}").expect("writing to a string does not fail");
            }
            json.push('"');
        }
        json.push(']');
        json
    }
}

/// Type that can be a value of a statement.
pub(crate) trait Bind {
    /// Returns the value of a statement.
    fn value(self) -> Value;
}

/// Implements [`Bind`] for types: `kind => types: conversion`.
macro_rules! binds {
    ($($kind:ident => $($name:ty),+: $convert:expr;)*) => {$($(
        impl Bind for $name {
            fn value(self) -> Value {
                Some(self).value()
            }
        }

        impl Bind for Option<$name> {
            fn value(self) -> Value {
                Value::$kind(self.map($convert))
            }
        }
    )+)*};
}

binds! {
    Flag => bool: |flag| flag;
    Integer => i64, i32, u32, u16: i64::from;
    Real => f64, f32: f64::from;
    Text => &str, String: String::from;
    Bytes => Vec<u8>, &[u8]: Vec::from;
}

impl Bind for Value {
    fn value(self) -> Value {
        self
    }
}

impl Bind for KeySet {
    fn value(self) -> Value {
        Value::Keys(self)
    }
}

/// Statement with its values.
pub(crate) struct Query {
    text: Cow<'static, str>,
    values: Vec<Value>,
}

/// Returns a statement without values. Its text consists of literals of this crate; values are
/// bound.
pub(crate) fn query(text: impl Into<Cow<'static, str>>) -> Query {
    Query { text: text.into(), values: Vec::new() }
}

impl Query {
    /// Binds the next value.
    pub(crate) fn bind(mut self, value: impl Bind) -> Self {
        self.values.push(value.value());
        self
    }

    /// Runs the statement. Returns the number of changed rows.
    pub(crate) async fn execute(self, conn: &mut Conn) -> Result<u64> {
        match conn {
            Conn::Sqlite(conn) => Ok(self.sqlite().execute(&mut **conn).await?.rows_affected()),
            Conn::Postgres(conn) => conn.execute(self.postgres()).await,
        }
    }

    /// Returns the first row, if there is one.
    pub(crate) async fn fetch_optional(self, conn: &mut Conn) -> Result<Option<SqlRow>> {
        match conn {
            Conn::Sqlite(conn) => {
                Ok(self.sqlite().fetch_optional(&mut **conn).await?.map(SqlRow::Sqlite))
            }
            Conn::Postgres(conn) => {
                let rows = conn.rows(self.postgres()).await?;
                Ok(rows.into_iter().next().map(SqlRow::Postgres))
            }
        }
    }

    /// Returns the first row. Error if there is none.
    pub(crate) async fn fetch_one(self, conn: &mut Conn) -> Result<SqlRow> {
        self.fetch_optional(conn).await?.ok_or(StorageError::NotFound)
    }

    /// Returns all rows.
    pub(crate) async fn fetch_all(self, conn: &mut Conn) -> Result<Vec<SqlRow>> {
        match conn {
            Conn::Sqlite(conn) => {
                let rows = self.sqlite().fetch_all(&mut **conn).await?;
                Ok(rows.into_iter().map(SqlRow::Sqlite).collect())
            }
            Conn::Postgres(conn) => {
                let rows = conn.rows(self.postgres()).await?;
                Ok(rows.into_iter().map(SqlRow::Postgres).collect())
            }
        }
    }

    /// Returns the first column of the first row. Error if there is no row.
    pub(crate) async fn fetch_value<T: Column>(self, conn: &mut Conn) -> Result<T> {
        self.fetch_one(conn).await?.column(0)
    }

    fn sqlite(self) -> SqlxQuery<'static, Sqlite, SqliteArguments> {
        let query = match self.text {
            Cow::Borrowed(text) => sqlx::query(text),
            Cow::Owned(text) => sqlx::query(AssertSqlSafe(text)),
        };
        self.values.into_iter().fold(query, |query, value| match value {
            Value::Flag(flag) => query.bind(flag),
            Value::Integer(integer) => query.bind(integer),
            Value::Real(real) => query.bind(real),
            Value::Text(text) => query.bind(text),
            Value::Bytes(bytes) => query.bind(bytes),
            Value::Keys(keys) => query.bind(keys.json()),
        })
    }

    fn postgres(self) -> session::Statement {
        let query = sqlx::query(AssertSqlSafe(dialect::postgres(&self.text)));
        self.values.into_iter().fold(query, |query, value| match value {
            Value::Flag(flag) => query.bind(flag),
            Value::Integer(integer) => query.bind(integer),
            Value::Real(real) => query.bind(real),
            Value::Text(text) => query.bind(text),
            Value::Bytes(bytes) => query.bind(bytes),
            Value::Keys(keys) => query.bind(keys.list()),
        })
    }
}

/// Row of a result.
pub(crate) enum SqlRow {
    Sqlite(SqliteRow),
    Postgres(PgRow),
}

/// Name or number of a column.
pub(crate) trait ColumnName:
    ColumnIndex<SqliteRow> + ColumnIndex<PgRow> + std::fmt::Display + Copy
{
}

impl<T> ColumnName for T where
    T: ColumnIndex<SqliteRow> + ColumnIndex<PgRow> + std::fmt::Display + Copy
{
}

impl SqlRow {
    /// Returns a column. A value of the wrong form means that the database is damaged.
    pub(crate) fn column<T: Column>(&self, name: impl ColumnName) -> Result<T> {
        let value = match self {
            Self::Sqlite(row) => row.try_get(name)?,
            Self::Postgres(row) => row.try_get(name)?,
        };
        T::from_sql(value).ok_or_else(|| corrupt_column(name))
    }
}

impl Conn {
    /// Connection that was opened for this use alone.
    pub(crate) fn own(conn: SqliteConnection) -> Self {
        Self::Sqlite(Held::Own(conn))
    }

    /// Closes a connection that was opened for this use alone; another returns to its pool.
    pub(crate) async fn close(self) -> Result<()> {
        match self {
            Self::Sqlite(Held::Own(conn)) => Ok(conn.close().await?),
            Self::Sqlite(_) | Self::Postgres(_) => Ok(()),
        }
    }

    /// True if other connections may write at the same time.
    pub(crate) fn has_other_writers(&self) -> bool {
        matches!(self, Self::Postgres(_))
    }

    /// Keeps births and removals of genomes apart until the end of the transaction: any number of
    /// births at a time, or one removal. A genome that a birth found stored is then still there
    /// when an individual refers to it.
    pub(crate) async fn lock_genomes(&mut self, use_of: GenomeUse) -> Result<()> {
        if !self.has_other_writers() {
            return Ok(());
        }
        let lock = match use_of {
            GenomeUse::Birth => "SELECT pg_advisory_xact_lock_shared(?)",
            GenomeUse::Removal => "SELECT pg_advisory_xact_lock(?)",
        };
        query(lock).bind(GENOME_LOCK).execute(self).await?;
        Ok(())
    }

    /// Ends the transaction of a connection: commits it, or rolls it back.
    pub(crate) async fn end(self, commit: bool) -> Result<()> {
        match self {
            Self::Postgres(session) => session.end(commit).await,
            Self::Sqlite(Held::Transaction(transaction)) if commit => {
                Ok(transaction.commit().await?)
            }
            Self::Sqlite(Held::Transaction(transaction)) => Ok(transaction.rollback().await?),
            Self::Sqlite(_) => Ok(()),
        }
    }
}
