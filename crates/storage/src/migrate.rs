//! Copy of a data directory's database into PostgreSQL.
//!
//! Rows are copied in the order of their keys, each batch in one transaction. A repeated copy first
//! compares the rows that are there with those of the source, and writes nothing if they differ;
//! then it resumes after the largest key. At the end, all rows of both databases are read again and
//! compared by a hash of each table.

use std::path::Path;

use crate::StorageError;
use crate::address::DatabaseAddress;
use crate::engine::postgres::{Postgres, Usage};
use crate::engine::sqlite::Opened;
use crate::error::Result;
use crate::sql::{Conn, Query, SqlRow, Value, query};
use crate::write::operation;

/// Tables in the order of their references, with the number of rows in a transaction and the
/// columns: those of the key first, marked by `*`. A column that refers to a later table is marked
/// by `>` and filled at the end. The letter is the type: Bytes, Flag, Integer, Real, Text. Only
/// PostgreSQL has `export_blob` and `blob_store`: files of exports are not copied, and the first
/// download of an export has them made again. Large files are copied into rows.
const TABLES: [(&str, i64, &str); 21] = [
    (
        "genome",
        512,
        "*hash:B program_hash:B live_instructions:I kept:F text:T bytes:B layers:T bases:B",
    ),
    (
        "mesh",
        2,
        "*id:B content_hash:B vertices:I triangles:I has_uv:F warnings_json:T data:B object:T",
    ),
    ("light_asset", 2, "*hash:B kind:T bytes:B object:T"),
    ("scene", 128, "*id:B content_hash:B created_ms:I json:T"),
    (
        "lineage",
        256,
        "*id:B name:T notes:T tags_json:T scene_id:B thumbnail_px:I start:T dialect_json:T \
         saturation:R energy_limit:F >cover_id:B created_ms:I hidden:F version:I",
    ),
    ("unfinished_lineage", 256, "*lineage_id:B until_ms:I removing:F"),
    (
        "generation",
        256,
        "*id:B lineage_id:B position:I seed_bits:I >centre_id:B mutation:R recombination:R \
         curation:T isotropic:F homogeneous:F bumps:F saturation:R energy_limit:F locks_json:T \
         steer_json:T painting_json:T created_ms:I",
    ),
    (
        "individual",
        1024,
        "*id:B lineage_id:B generation_id:B slot:I genome_hash:B operator:T attempts:I twin:F \
         favourite:F note:T version:I",
    ),
    (
        "generation_parent",
        1024,
        "*generation_id:B *place:I genome_hash:B individual_id:B parent_generation_id:B",
    ),
    (
        "picture",
        1024,
        "*key:B genome_hash:B scene_id:B light_deg:R size_px:I height_px:I samples:I adaptive:F \
         area:T format:T backend:T renderer_version:I",
    ),
    ("token", 256, "*name:T scope:T hash:B expires_ms:I"),
    ("closed", 256, "*at_ms:I"),
    ("idempotency", 64, "*key:T *route:T body_hash:B status:I created_ms:I answer:B"),
    ("target_file", 2, "*hash:B bytes:B object:T"),
    ("target", 64, "*id:B kind:T file_hash:B created_ms:I json:T"),
    (
        "search",
        4,
        "*id:B target_id:B target_kind:T target_hash:B lineage_id:B state:T epoch:I turn:I deaths:I \
         worker:T lease_until_ms:I reason:T generation:I evaluations:I seconds:R fitted:R held:R recorded:R \
         population:B created_ms:I started_ms:I ended_ms:I options_json:T best_json:T front_json:T \
         spread_json:T darkest_png:B brightest_png:B start:B parent_id:B island:I previous_id:B \
         awaits:I found:B",
    ),
    ("migrant", 64, "*search_id:B *generation:I genomes:B"),
    ("search_checkpoint", 4, "*search_id:B generation:I bytes:B object:T"),
    (
        "search_log",
        1024,
        "*search_id:B *generation:I evaluations:I seconds:R fitted:R held:R median:R diversity:R \
         repeats:I best_hash:B",
    ),
    (
        "export",
        64,
        "*id:B state:T epoch:I deaths:I worker:T lease_until_ms:I reason:T energy_limit:F \
         created_ms:I started_ms:I ended_ms:I plan_json:T",
    ),
    ("export_file", 256, "*export_id:B *number:I genome_hash:B format:T bytes:I note:T"),
];

/// Result of [`migrate`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Migrated {
    /// Number of rows in all tables.
    pub rows: u64,
    /// Number of texts with the character U+0000, which PostgreSQL cannot store: it became U+FFFD.
    pub changed_texts: u64,
}

/// Step of [`migrate`], for showing progress.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MigrationStep {
    /// Rows of a table have been copied.
    Copied {
        /// Name of the table.
        table: &'static str,
        /// Number of rows so far.
        rows: u64,
    },
    /// A table is compared.
    Compared {
        /// Name of the table.
        table: &'static str,
    },
}

/// Copies the database of a data directory that no server uses into a PostgreSQL database that no
/// server uses. Stopped halfway, it loses nothing and can be repeated. The data directory is not
/// changed, except that a database of an earlier version is brought up to date.
///
/// # Errors
/// Returns [`StorageError::Locked`] if a server uses the directory, [`StorageError::Mixed`] if the
/// PostgreSQL database has other rows, others as [`Store::open`](crate::Store::open) and
/// [`Store::connect`](crate::Store::connect).
pub async fn migrate(
    dir: &Path,
    address: &DatabaseAddress,
    step: impl Fn(MigrationStep),
) -> Result<Migrated> {
    let mut from = Opened::take(dir).await?;
    let to = Postgres::connect(address, Usage::Alone).await?;
    let mut migrated = Migrated::default();
    for table in TABLES.map(Table::parse) {
        let Some(last) = table.last_key(&mut to.reader().await?).await? else { continue };
        let (source, _) = table.digest(&mut from.conn, Rows::CopiedUpTo(&last)).await?;
        let (copy, _) = table.digest(&mut to.snapshot().await?, Rows::CopiedUpTo(&last)).await?;
        if source != copy {
            return Err(StorageError::Mixed { table: table.name });
        }
    }
    for table in TABLES.map(Table::parse) {
        let mut rows = 0;
        let mut last = table.last_key(&mut to.reader().await?).await?;
        loop {
            let batch = table.read(&mut from.conn, last.as_deref(), None, table.batch).await?;
            let Some(end) = batch.last() else { break };
            last = Some(end[..table.keys].to_vec());
            rows += batch.len() as u64;
            table.insert(&to, batch).await?;
            step(MigrationStep::Copied { table: table.name, rows });
        }
    }
    for table in TABLES.map(Table::parse) {
        table.fill(&mut from.conn, &to).await?;
    }
    for table in TABLES.map(Table::parse) {
        step(MigrationStep::Compared { table: table.name });
        let (source, changed_texts) = table.digest(&mut from.conn, Rows::All).await?;
        let (copy, _) = table.digest(&mut to.snapshot().await?, Rows::All).await?;
        if source != copy {
            return Err(StorageError::Mixed { table: table.name });
        }
        migrated.rows += source.rows;
        migrated.changed_texts += changed_texts;
    }
    to.close().await?;
    from.conn.close().await?;
    Ok(migrated)
}

/// Type of a column.
#[derive(Debug, Clone, Copy)]
enum Kind {
    Bytes,
    Flag,
    Integer,
    Real,
    Text,
}

/// Table of [`TABLES`].
struct Table {
    name: &'static str,
    batch: i64,
    columns: Vec<(&'static str, Kind)>,
    /// Number of columns of the key, which are the first.
    keys: usize,
    /// Numbers of the columns that refer to later tables.
    later: Vec<usize>,
}

/// Rows that are hashed.
#[derive(Clone, Copy)]
enum Rows<'k> {
    All,
    /// Rows up to a key, without references to later tables: those are filled at the end.
    CopiedUpTo(&'k [Value]),
}

/// Number of rows and hash of their values.
#[derive(Debug, PartialEq, Eq)]
struct Digest {
    rows: u64,
    hash: blake3::Hash,
}

impl Table {
    fn parse((name, batch, columns): (&'static str, i64, &'static str)) -> Self {
        let mut table = Self { name, batch, columns: Vec::new(), keys: 0, later: Vec::new() };
        for column in columns.split_whitespace() {
            let (column, kind) = column.split_once(':').expect("columns have a type");
            let kind = match kind {
                "B" => Kind::Bytes,
                "F" => Kind::Flag,
                "I" => Kind::Integer,
                "R" => Kind::Real,
                _ => Kind::Text,
            };
            table.keys += usize::from(column.starts_with('*'));
            if column.starts_with('>') {
                table.later.push(table.columns.len());
            }
            table.columns.push((column.trim_start_matches(['*', '>']), kind));
        }
        table
    }

    fn key(&self) -> String {
        let names: Vec<_> = self.columns[..self.keys].iter().map(|(name, _)| *name).collect();
        names.join(", ")
    }

    fn names(&self) -> String {
        self.columns.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
    }

    /// Returns the largest key in a database.
    async fn last_key(&self, conn: &mut Conn) -> Result<Option<Vec<Value>>> {
        let order: Vec<_> =
            self.columns[..self.keys].iter().map(|(name, _)| format!("{name} DESC")).collect();
        let (names, order) = (self.names(), order.join(", "));
        let sql = format!("SELECT {names} FROM {} ORDER BY {order} LIMIT 1", self.name);
        let Some(row) = query(sql).fetch_optional(conn).await? else { return Ok(None) };
        Ok(Some(self.values(&row)?[..self.keys].to_vec()))
    }

    /// Reads rows after a key and up to another, at most `limit`.
    async fn read(
        &self,
        conn: &mut Conn,
        after: Option<&[Value]>,
        until: Option<&[Value]>,
        limit: i64,
    ) -> Result<Vec<Vec<Value>>> {
        let (names, key, name) = (self.names(), self.key(), self.name);
        let places = vec!["?"; self.keys].join(", ");
        let bound = |is_given: bool, sign| match is_given {
            true => format!("({key}) {sign} ({places})"),
            false => "TRUE".to_owned(),
        };
        let (lower, upper) = (bound(after.is_some(), ">"), bound(until.is_some(), "<="));
        let sql =
            format!("SELECT {names} FROM {name} WHERE {lower} AND {upper} ORDER BY {key} LIMIT ?");
        let keys = after.into_iter().chain(until).flatten().cloned();
        let rows = keys.fold(query(sql), Query::bind).bind(limit).fetch_all(conn).await?;
        rows.iter().map(|row| self.values(row)).collect()
    }

    fn values(&self, row: &SqlRow) -> Result<Vec<Value>> {
        let value = |(name, kind): &(&str, Kind)| {
            Ok(match kind {
                Kind::Bytes => Value::Bytes(row.column(*name)?),
                Kind::Flag => Value::Flag(row.column(*name)?),
                Kind::Integer => Value::Integer(row.column(*name)?),
                Kind::Real => Value::Real(row.column(*name)?),
                Kind::Text => Value::Text(row.column(*name)?),
            })
        };
        self.columns.iter().map(value).collect()
    }

    /// Inserts rows without the references to later tables. Rows with a key that is there are
    /// left as they are.
    async fn insert(&self, to: &Postgres, mut rows: Vec<Vec<Value>>) -> Result<()> {
        for row in &mut rows {
            for column in &self.later {
                row[*column] = Value::Bytes(None);
            }
            row.iter_mut().for_each(without_nul);
        }
        let row = format!("({})", vec!["?"; self.columns.len()].join(", "));
        let (name, names) = (self.name, self.names());
        to.write(operation!(|conn| {
            // A statement has 65,535 values at most.
            for chunk in rows.chunks(256) {
                let places = vec![row.as_str(); chunk.len()].join(", ");
                let sql =
                    format!("INSERT INTO {name} ({names}) VALUES {places} ON CONFLICT DO NOTHING");
                let values = chunk.iter().flatten().cloned();
                values.fold(query(sql), Query::bind).execute(conn).await?;
            }
            Ok(())
        }))
        .await?;
        Ok(())
    }

    /// Fills the references to later tables.
    async fn fill(&self, from: &mut Conn, to: &Postgres) -> Result<()> {
        for column in &self.later {
            let (name, (reference, _)) = (self.name, self.columns[*column]);
            let mut last: Option<Vec<Value>> = None;
            loop {
                let rows = self.read(from, last.as_deref(), None, 1024).await?;
                let Some(end) = rows.last() else { break };
                last = Some(end[..self.keys].to_vec());
                let filled = rows.into_iter().filter(|row| !is_null(&row[*column]));
                let pairs: Vec<_> =
                    filled.flat_map(|row| [row[0].clone(), row[*column].clone()]).collect();
                if pairs.is_empty() {
                    continue;
                }
                let places = vec!["(?, ?)"; pairs.len() / 2].join(", ");
                let sql = format!(
                    "UPDATE {name} SET {reference} = filled.reference
                     FROM (VALUES {places}) AS filled (id, reference)
                     WHERE {name}.id = filled.id AND {name}.{reference} IS NULL"
                );
                to.write(operation!(|conn| {
                    let update = pairs.into_iter().fold(query(sql), Query::bind);
                    update.execute(conn).await
                }))
                .await?;
            }
        }
        Ok(())
    }

    /// Hashes rows in the order of their keys. Also returns the number of texts with U+0000.
    async fn digest(&self, conn: &mut Conn, of: Rows<'_>) -> Result<(Digest, u64)> {
        let mut hasher = blake3::Hasher::new();
        let (mut count, mut changed) = (0, 0);
        let mut last: Option<Vec<Value>> = None;
        let until = match of {
            Rows::All => None,
            Rows::CopiedUpTo(key) => Some(key),
        };
        loop {
            let rows = self.read(conn, last.as_deref(), until, self.batch).await?;
            let Some(end) = rows.last() else { break };
            last = Some(end[..self.keys].to_vec());
            count += rows.len() as u64;
            for mut row in rows {
                if until.is_some() {
                    self.later.iter().for_each(|column| row[*column] = Value::Bytes(None));
                }
                for value in &mut row {
                    changed += u64::from(has_nul(value));
                    without_nul(value);
                    hash(&mut hasher, value);
                }
            }
        }
        Ok((Digest { rows: count, hash: hasher.finalize() }, changed))
    }
}

fn is_null(value: &Value) -> bool {
    matches!(value, Value::Bytes(None))
}

fn has_nul(value: &Value) -> bool {
    matches!(value, Value::Text(Some(text)) if text.contains('\0'))
}

/// Replaces the character that PostgreSQL cannot store.
fn without_nul(value: &mut Value) {
    if let Value::Text(Some(text)) = value
        && text.contains('\0')
    {
        *text = text.replace('\0', "\u{fffd}");
    }
}

/// Adds a value with its length; NULL has the length 2^64 - 1.
fn hash(hasher: &mut blake3::Hasher, value: &Value) {
    let bytes = match value {
        Value::Flag(flag) => flag.map(|flag| vec![u8::from(flag)]),
        Value::Integer(integer) => integer.map(|integer| integer.to_le_bytes().to_vec()),
        Value::Real(real) => real.map(|real| real.to_bits().to_le_bytes().to_vec()),
        Value::Text(text) => text.as_ref().map(|text| text.as_bytes().to_vec()),
        Value::Bytes(bytes) => bytes.clone(),
        Value::Keys(_) => unreachable!("no column is a set"),
    };
    let length = bytes.as_ref().map_or(u64::MAX, |bytes| bytes.len() as u64);
    hasher.update(&length.to_le_bytes());
    hasher.update(&bytes.unwrap_or_default());
}

/// Names of all columns that are copied, each after its table and a point.
#[cfg(test)]
pub(crate) fn copied_columns() -> std::collections::BTreeSet<String> {
    let names = |table: Table| {
        table.columns.into_iter().map(move |(column, _)| format!("{}.{column}", table.name))
    };
    TABLES.map(Table::parse).into_iter().flat_map(names).collect()
}
