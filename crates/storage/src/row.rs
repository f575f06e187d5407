//! Conversions between Rust types and SQLite values: ids, hashes and integers as columns, sets as
//! JSON parameters. Independent of tables.

use brood_protocol::{GenerationId, IndividualId, JobId, LineageId, MeshId, SceneId, TargetId};
use sqlx::Row;
use sqlx::sqlite::SqliteRow;

use crate::StorageError;

/// Id that is stored as a BLOB of 16 bytes.
pub(crate) trait Key: Copy {
    fn from_key(bytes: [u8; 16]) -> Self;
    fn key(&self) -> &[u8];
}

macro_rules! keys {
    ($($name:ident),*) => {$(
        impl Key for $name {
            fn from_key(bytes: [u8; 16]) -> Self {
                Self::from_bytes(bytes)
            }

            fn key(&self) -> &[u8] {
                self.as_bytes()
            }
        }
    )*};
}

keys!(GenerationId, IndividualId, JobId, LineageId, MeshId, SceneId, TargetId);

/// Typed access to columns by name. A value of the wrong form means that the file is damaged.
pub(crate) trait Columns {
    fn blob(&self, column: &str) -> Result<Vec<u8>, StorageError>;
    fn optional_blob(&self, column: &str) -> Result<Option<Vec<u8>>, StorageError>;
    fn text(&self, column: &str) -> Result<String, StorageError>;
    fn optional_text(&self, column: &str) -> Result<Option<String>, StorageError>;
    fn real(&self, column: &str) -> Result<f64, StorageError>;
    fn integer(&self, column: &str) -> Result<i64, StorageError>;

    fn id<T: Key>(&self, column: &str) -> Result<T, StorageError> {
        exact(&self.blob(column)?, column).map(T::from_key)
    }

    fn optional_id<T: Key>(&self, column: &str) -> Result<Option<T>, StorageError> {
        let bytes = self.optional_blob(column)?;
        bytes.map(|bytes| exact(&bytes, column).map(T::from_key)).transpose()
    }

    fn hash(&self, column: &str) -> Result<[u8; 32], StorageError> {
        exact(&self.blob(column)?, column)
    }

    fn whole<T: TryFrom<i64>>(&self, column: &str) -> Result<T, StorageError> {
        T::try_from(self.integer(column)?).map_err(|_| corrupt_column(column))
    }

    fn flag(&self, column: &str) -> Result<bool, StorageError> {
        Ok(self.integer(column)? != 0)
    }

    fn single(&self, column: &str) -> Result<f32, StorageError> {
        self.real(column).map(f32_from_real)
    }
}

impl Columns for SqliteRow {
    fn blob(&self, column: &str) -> Result<Vec<u8>, StorageError> {
        Ok(self.try_get(column)?)
    }

    fn optional_blob(&self, column: &str) -> Result<Option<Vec<u8>>, StorageError> {
        Ok(self.try_get(column)?)
    }

    fn text(&self, column: &str) -> Result<String, StorageError> {
        Ok(self.try_get(column)?)
    }

    fn optional_text(&self, column: &str) -> Result<Option<String>, StorageError> {
        Ok(self.try_get(column)?)
    }

    fn real(&self, column: &str) -> Result<f64, StorageError> {
        Ok(self.try_get(column)?)
    }

    fn integer(&self, column: &str) -> Result<i64, StorageError> {
        Ok(self.try_get(column)?)
    }
}

/// Converts a REAL that was stored from an f32; the conversion is exact.
pub(crate) fn f32_from_real(real: f64) -> f32 {
    real as f32
}

/// Error for a column with an invalid value.
pub(crate) fn corrupt_column(column: &str) -> StorageError {
    StorageError::Corrupt(format!("column {column} has an invalid value"))
}

fn exact<const N: usize>(bytes: &[u8], column: &str) -> Result<[u8; N], StorageError> {
    bytes.try_into().map_err(|_| corrupt_column(column))
}

/// Converts a count or version to SQLite's signed integer. A value that does not fit was never
/// stored and matches no row.
pub(crate) fn signed(value: u64) -> i64 {
    i64::try_from(value).unwrap_or(i64::MAX)
}

/// Encodes a set of byte strings as one parameter, to be read with `SELECT unhex(value) FROM
/// json_each(?)`: the statement is the same for every size of the set.
pub(crate) fn json_set<'a>(items: impl IntoIterator<Item = &'a [u8]>) -> String {
    use std::fmt::Write as _;
    let mut json = String::from("[");
    for item in items {
        json.push_str(if json.len() == 1 { "\"" } else { ",\"" });
        for byte in item {
            write!(json, "{byte:02x}").expect("writing to a string does not fail");
        }
        json.push('"');
    }
    json.push(']');
    json
}
