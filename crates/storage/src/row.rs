//! Records made of columns, rows to be inserted, and sets of keys. Independent of tables.

use crate::StorageError;
use crate::column::Key;
use crate::sql::{Conn, KeySet, Query, SqlRow, Value, query};

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

/// Converts a count or version to the engines' signed integer. A value that does not fit was never
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
