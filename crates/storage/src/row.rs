//! Between Rust's types and SQLite's: ids, hashes and whole numbers as columns, sets as JSON parameters. Owns the
//! conversions; refuses to know tables.

use brood_protocol::{GenerationId, IndividualId, JobId, LineageId, MeshId, SceneId, TargetId};
use sqlx::Row;
use sqlx::sqlite::SqliteRow;

use crate::StorageError;

/// An id that is kept as 16 bytes.
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

/// Columns by name. What cannot be read was never written: the file is damaged.
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
        T::try_from(self.integer(column)?).map_err(|_| damaged(column))
    }

    fn flag(&self, column: &str) -> Result<bool, StorageError> {
        Ok(self.integer(column)? != 0)
    }

    fn single(&self, column: &str) -> Result<f32, StorageError> {
        self.real(column).map(narrow)
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

/// A REAL that was an f32 when it was written, and is one again without loss.
pub(crate) fn narrow(real: f64) -> f32 {
    real as f32
}

/// The damage that an unreadable column is.
pub(crate) fn damaged(column: &str) -> StorageError {
    StorageError::Corrupt(format!("column {column} holds what was never written"))
}

fn exact<const N: usize>(bytes: &[u8], column: &str) -> Result<[u8; N], StorageError> {
    bytes.try_into().map_err(|_| damaged(column))
}

/// A count or version as SQLite's signed integer; what does not fit could not have been stored and matches nothing.
pub(crate) fn signed(value: u64) -> i64 {
    i64::try_from(value).unwrap_or(i64::MAX)
}

/// A set of byte strings as one parameter, to be read back with `SELECT unhex(value) FROM json_each(?)`: the statement
/// stays the same however large the set is.
pub(crate) fn set<'a>(items: impl IntoIterator<Item = &'a [u8]>) -> String {
    use std::fmt::Write as _;
    let mut json = String::from("[");
    for item in items {
        json.push_str(if json.len() == 1 { "\"" } else { ",\"" });
        for byte in item {
            write!(json, "{byte:02x}").expect("a string takes all that is written to it");
        }
        json.push('"');
    }
    json.push(']');
    json
}
