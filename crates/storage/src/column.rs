//! Conversions between Rust types and the values of columns. Independent of tables and statements.

use brood_genome::{Dialect, GenomeHash, Locks, PaintingPalette, Start, Steer};
use brood_protocol::{
    Backend, Curation, FoundMaterial, GenerationId, IndividualId, JobId, JobStatus, LightAssetKind,
    LineageId, MaterialSpread, MeshId, PictureFormat, PictureKey, PixelArea, SceneId,
    SearchOptions, SearchState, Seed, Target, TargetId,
};

use sqlx::{Decode, Postgres, Sqlite, Type};

use crate::StorageError;

/// Type of a value as engines store it.
pub(crate) trait Stored:
    for<'r> Decode<'r, Sqlite> + Type<Sqlite> + for<'r> Decode<'r, Postgres> + Type<Postgres>
{
}

impl<T> Stored for T where
    T: for<'r> Decode<'r, Sqlite> + Type<Sqlite> + for<'r> Decode<'r, Postgres> + Type<Postgres>
{
}

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
        impl $crate::column::Column for $name {
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
