//! Check of a whole database: its pages, references between rows, and genomes against their hashes.

use brood_genome::{Genome, GenomeHash};

use crate::blob_join::{TABLES, used_objects};
use crate::column::Key;
use crate::error::Result;
use crate::genome;
use crate::sql::{Conn, query};
use crate::{StorageError, Store, StoredGenome};

/// Number of genomes that are read together.
const BATCH: i64 = 256;
/// Largest number of problems of each kind that are listed.
const PROBLEMS: usize = 20;

/// Result of [`Store::check`].
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CheckedStore {
    /// Number of genomes that were read.
    pub genomes: u64,
    /// Number of files in the object store that were read.
    pub files: u64,
    /// Number of files in the object store that were not read, since none was named.
    pub unread_files: u64,
    /// Damage in words; at most 20 problems of each kind.
    pub problems: Vec<String>,
}

impl Store {
    /// Compares every genome and every file in the object store with its hash, and checks structure
    /// and references of SQLite. Reads a snapshot of the rows, so a server may write meanwhile.
    /// Calls `read` with the number of genomes so far.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the file cannot be read, or the object store does not answer.
    /// Damage is not an error, it is listed.
    pub async fn check(&self, read: impl Fn(u64)) -> Result<CheckedStore> {
        let mut checked = CheckedStore::default();
        // First: the object store may not answer.
        self.check_files(&mut checked).await?;
        let mut conn = self.snapshot().await?;
        // PostgreSQL checks references on each write, and pages only with `data_checksums`.
        if let Conn::Sqlite(_) = conn {
            checked.problems.extend(structure(&mut conn).await?);
            checked.problems.extend(references(&mut conn).await?);
        }
        let mut damaged = Vec::new();
        let mut last = Vec::new();
        loop {
            let next = "SELECT hash FROM genome WHERE hash > ? ORDER BY hash LIMIT ?";
            let rows = query(next).bind(last.as_slice()).bind(BATCH).fetch_all(&mut conn).await?;
            let hashes = rows.iter().map(|row| row.column("hash"));
            let hashes: Vec<GenomeHash> = hashes.collect::<Result<_>>()?;
            let Some(end) = hashes.last() else { break };
            checked.genomes += hashes.len() as u64;
            damaged.extend(damaged_genomes(&mut conn, &hashes).await?);
            read(checked.genomes);
            last = end.key().to_vec();
        }
        let more = damaged.len().saturating_sub(PROBLEMS);
        checked.problems.extend(damaged.drain(..damaged.len().min(PROBLEMS)));
        if more > 0 {
            checked.problems.push(format!("{more} more genomes are damaged"));
        }
        Ok(checked)
    }

    /// Reads all files in the object store.
    async fn check_files(&self, checked: &mut CheckedStore) -> Result<()> {
        let mut damaged = Vec::new();
        for table in TABLES {
            let names = format!("SELECT object FROM {table} WHERE object IS NOT NULL");
            let rows = query(names).fetch_all(&mut self.reader().await?).await?;
            if self.blobs().is_none() {
                checked.unread_files += rows.len() as u64;
                continue;
            }
            for row in &rows {
                let name: String = row.column("object")?;
                let is_whole = match self.object(&name).await {
                    Ok(found) => found.is_some(),
                    Err(StorageError::BlobDamaged(_)) => false,
                    Err(error) => return Err(error),
                };
                checked.files += 1;
                // A row that was removed meanwhile has no object any more.
                if !is_whole && is_used(&mut self.reader().await?, &name).await? {
                    damaged.push(format!("a file of {table} is missing or damaged: {name}"));
                }
            }
        }
        let more = damaged.len().saturating_sub(PROBLEMS);
        checked.problems.extend(damaged.drain(..damaged.len().min(PROBLEMS)));
        if more > 0 {
            checked.problems.push(format!("{more} more files are missing or damaged"));
        }
        Ok(())
    }
}

/// True if a row has an object.
async fn is_used(conn: &mut Conn, name: &str) -> Result<bool> {
    Ok(!used_objects(conn, (name, name)).await?.is_empty())
}

/// Problems of pages, indexes and constraints.
async fn structure(conn: &mut Conn) -> Result<Vec<String>> {
    let rows = query("PRAGMA integrity_check(20)").fetch_all(conn).await?;
    let words = rows.iter().map(|row| row.column("integrity_check"));
    let words = words.collect::<Result<Vec<_>>>()?;
    Ok(if words == ["ok"] { Vec::new() } else { words })
}

/// Rows that refer to missing rows.
async fn references(conn: &mut Conn) -> Result<Vec<String>> {
    let rows = query(
        "SELECT \"table\", parent, count(*) AS missing FROM pragma_foreign_key_check
         GROUP BY \"table\", parent",
    )
    .fetch_all(conn)
    .await?;
    let words = rows.iter().map(|row| {
        let (table, parent): (String, String) = (row.column("table")?, row.column("parent")?);
        let count: u64 = row.column("missing")?;
        Ok(format!("{count} rows of {table} refer to a missing row of {parent}"))
    });
    words.collect()
}

/// Problems of genomes. They are read one by one if one of them is damaged.
async fn damaged_genomes(conn: &mut Conn, hashes: &[GenomeHash]) -> Result<Vec<String>> {
    match genome::read(conn, hashes).await {
        Ok(found) => Ok(found.into_iter().filter_map(not_a_genome).collect()),
        // This genome is damaged, or one that it is packed against.
        Err(StorageError::Corrupt(_)) if hashes.len() == 1 => Ok(vec![is_damaged(hashes[0])]),
        Err(StorageError::Corrupt(_)) => {
            let mut problems = Vec::new();
            for hash in hashes {
                problems.extend(Box::pin(damaged_genomes(conn, &[*hash])).await?);
            }
            Ok(problems)
        }
        Err(error) => Err(error),
    }
}

/// Returns an error text if a stored genome is invalid.
fn not_a_genome((hash, stored): (GenomeHash, StoredGenome)) -> Option<String> {
    let genome = match stored {
        StoredGenome::Bytes(bytes) => {
            Genome::from_canonical_bytes(&bytes).map_err(|error| error.to_string())
        }
        StoredGenome::Text(text) => text.parse::<Genome>().map_err(|error| error.to_string()),
    };
    match genome {
        Ok(genome) if genome.hash() == hash => None,
        Ok(_) => Some(is_damaged(hash)),
        Err(error) => Some(format!("genome {hash} cannot be read: {error}")),
    }
}

fn is_damaged(hash: GenomeHash) -> String {
    format!("genome {hash} is damaged")
}
