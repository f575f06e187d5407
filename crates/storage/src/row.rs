//! Conversions between Rust types and SQLite values: columns, records made of columns, and sets as
//! JSON parameters. Independent of tables.

use brood_genome::{Dialect, GenomeHash, Locks, PaintingPalette, Start, Steer};
use brood_protocol::{
    Backend, Curation, FoundMaterial, GenerationId, IndividualId, JobId, JobStatus, LightAssetKind,
    LineageId, MaterialSpread, MeshId, PictureFormat, PictureKey, PixelArea, SceneId,
    SearchOptions, SearchState, Seed, Target, TargetId,
};

use crate::StorageError;
use crate::sql::{Conn, KeySet, Query, SqlRow, Stored, Value, query};

/// Id or hash that is stored as a BLOB.
pub(crate) trait Key {
    fn key(&self) -> &[u8];
}

/// Returns the parameter for an id that may be absent.
pub(crate) fn optional_key(id: Option<impl Key>) -> Option<Vec<u8>> {
    id.map(|id| id.key().to_vec())
}

/// Type of a column.
pub(crate) trait Column: Sized {
    /// Type that engines store.
    type Sql: Stored;

    /// Returns `None` if the value is invalid.
    fn from_sql(value: Self::Sql) -> Option<Self>;
}

impl<T: Column> Column for Option<T> {
    type Sql = Option<T::Sql>;

    fn from_sql(value: Self::Sql) -> Option<Self> {
        match value {
            Some(value) => T::from_sql(value).map(Some),
            None => Some(None),
        }
    }
}

/// Implements [`Column`] for types: `SQL type => types: conversion`. The conversion returns `None`
/// for an invalid value.
macro_rules! columns {
    ($($sql:ty => $($name:ty),+: $convert:expr;)*) => {$($(
        impl $crate::row::Column for $name {
            type Sql = $sql;

            fn from_sql(value: $sql) -> Option<Self> {
                let convert: fn($sql) -> Option<Self> = $convert;
                convert(value)
            }
        }
    )+)*};
}
pub(crate) use columns;

columns! {
    bool => bool: Some;
    i64 => i64: Some;
    i64 => u16, u32, u64: |value| value.try_into().ok();
    i64 => Seed: |bits| Some(Self(bits.cast_unsigned()));
    f64 => f64: Some;
    // Stored from an f32, so the conversion is exact.
    f64 => f32: |value| Some(value as f32);
    String => String: Some;
    String => Backend, Curation, JobStatus, LightAssetKind, PictureFormat, SearchState, Start:
        |name| Self::from_name(&name);
    String => PixelArea: |text| text.parse().ok();
    String => Dialect, FoundMaterial, Locks, MaterialSpread, PaintingPalette, SearchOptions, Target,
        Vec<FoundMaterial>, Vec<Steer>, Vec<String>:
        |json| serde_json::from_str(&json).ok();
    Vec<u8> => Vec<u8>: Some;
    Vec<u8> => [u8; 32]: |bytes| bytes.try_into().ok();
}

/// Implements [`Key`] and [`Column`] for ids and hashes made of bytes.
macro_rules! keys {
    ($($name:ty),*) => {$(
        impl Key for $name {
            fn key(&self) -> &[u8] {
                self.as_bytes()
            }
        }

        columns! {
            Vec<u8> => $name: |bytes| bytes.try_into().ok().map(Self::from_bytes);
        }
    )*};
}

keys!(GenerationId, GenomeHash, IndividualId, JobId, LineageId, MeshId, SceneId, TargetId);

impl Key for PictureKey {
    fn key(&self) -> &[u8] {
        &self.0
    }
}

/// Error for a column with an invalid value.
pub(crate) fn corrupt_column(name: impl std::fmt::Display) -> StorageError {
    StorageError::Corrupt(format!("column {name} has an invalid value"))
}

/// Struct that is read from the columns of a row. Implemented by `record!`.
pub(crate) trait Record: Sized {
    /// Columns, each named after its field.
    const COLUMNS: &'static str;

    fn read(row: &SqlRow) -> Result<Self, StorageError>;
}

/// Query for records; `rest` continues the SELECT after the columns.
pub(crate) fn select<T: Record>(rest: &str) -> Query {
    query(format!("SELECT {} {rest}", T::COLUMNS))
}

/// Query that returns records; `change` is an INSERT, UPDATE or DELETE.
pub(crate) fn returning<T: Record>(change: &str) -> Query {
    query(format!("{change} RETURNING {}", T::COLUMNS))
}

/// Inserts rows: `head` begins the statement, `tail` ends it, `values` has those of a row. A
/// statement has up to 256 rows, so that it stays small for large broods.
pub(crate) async fn insert_rows<T, const N: usize>(
    conn: &mut Conn,
    (head, tail): (&str, &str),
    rows: &[T],
    values: impl Fn(&T) -> [Value; N],
) -> Result<(), StorageError> {
    for chunk in rows.chunks(256) {
        let row = format!("({})", ["?"; N].join(", "));
        let text = format!("{head} VALUES {} {tail}", vec![row; chunk.len()].join(", "));
        let values = chunk.iter().flat_map(&values);
        values.fold(query(text), Query::bind).execute(conn).await?;
    }
    Ok(())
}

/// Implements [`Record`] for a struct, or declares the struct as well. A field is read from the
/// column of the same name, or from the SQL expression after `=`. Fields after `and` have their
/// defaults; the caller sets them.
macro_rules! record {
    (
        $(#[$meta:meta])*
        $vis:vis struct $name:ident {
            $($(#[$doc:meta])* $field_vis:vis $field:ident: $type:ty $(= $sql:literal)?,)+
        }
        $(and { $($(#[$other_doc:meta])* pub $other:ident: $other_type:ty,)+ })?
    ) => {
        $(#[$meta])*
        $vis struct $name {
            $($(#[$doc])* $field_vis $field: $type,)+
            $($($(#[$other_doc])* pub $other: $other_type,)+)?
        }

        $crate::row::record!($name { $($field $(= $sql)?,)+ } $(and { $($other),+ })?);
    };
    (
        $name:ident {
            $first:ident $(= $first_sql:literal)? $(, $field:ident $(= $sql:literal)?)* $(,)?
        }
        $(and { $($other:ident),+ })?
    ) => {
        impl $crate::row::Record for $name {
            const COLUMNS: &'static str = concat!(
                $crate::row::record!(@ $first $($first_sql)?)
                $(, ", ", $crate::row::record!(@ $field $($sql)?))*
            );

            fn read(row: &$crate::sql::SqlRow) -> Result<Self, $crate::StorageError> {
                Ok(Self {
                    $first: row.column(stringify!($first))?,
                    $($field: row.column(stringify!($field))?,)*
                    $($($other: Default::default(),)+)?
                })
            }
        }
    };
    (@ $field:ident) => {
        stringify!($field)
    };
    (@ $field:ident $sql:literal) => {
        concat!($sql, " AS \"", stringify!($field), "\"")
    };
}
pub(crate) use record;

/// Values of a row for [`insert_rows`].
macro_rules! values {
    ($($value:expr),+ $(,)?) => {
        [$($crate::sql::Bind::value($value)),+]
    };
}
pub(crate) use values;

/// Converts a count or version to SQLite's signed integer. A value that does not fit was never
/// stored and matches no row.
pub(crate) fn signed(value: u64) -> i64 {
    i64::try_from(value).unwrap_or(i64::MAX)
}

/// Collects ids or hashes to be bound as one value, see [`KeySet`].
pub(crate) fn key_set<'a, K: Key + 'a>(keys: impl IntoIterator<Item = &'a K>) -> KeySet {
    let mut set = KeySet::default();
    for key in keys {
        set.bytes.extend_from_slice(key.key());
        set.width = key.key().len();
    }
    set
}
