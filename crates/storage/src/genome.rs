//! Genomes by content hash. Owner of the table `genome`. Genomes are opaque bytes here, except for
//! rows without the column `layers`, whose layers are decoded.

use std::borrow::Borrow;
use std::collections::HashMap;

use brood_genome::{Genome, GenomeHash, ModelKind};
use sqlx::SqliteConnection;
use sqlx::sqlite::SqliteRow;

use crate::Store;
use crate::error::Result;
use crate::row::{Columns, Key, corrupt_column, insert_rows, json_set};
use crate::writer::operation;

/// Genome to be stored.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewGenome {
    /// Content hash.
    pub hash: GenomeHash,
    /// Canonical bytes.
    pub bytes: Vec<u8>,
    /// Hash of the lowered program.
    pub program_hash: [u8; 32],
    /// Number of live instructions.
    pub live_instructions: u32,
    /// Models of the genome's layers, lowest first.
    pub layers: Vec<ModelKind>,
}

/// Stored genome.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StoredGenome {
    /// Canonical bytes.
    Bytes(Vec<u8>),
    /// Canonical text, in rows of the first version; three times as large and slow to write.
    Text(String),
}

impl Store {
    /// Stores a genome that a user saves. It is kept from now on, even when all individuals with it
    /// are removed.
    ///
    /// # Errors
    /// Returns a `StorageError` if the write fails.
    pub async fn put_genome(&self, genome: NewGenome) -> Result<()> {
        self.write(operation!(|conn| {
            insert(conn, std::slice::from_ref(&genome)).await?;
            sqlx::query("UPDATE genome SET kept = 1 WHERE hash = ? AND kept = 0")
                .bind(genome.hash.key())
                .execute(conn)
                .await?;
            Ok(())
        }))
        .await
    }

    /// Returns a genome.
    ///
    /// # Errors
    /// Returns `StorageError::NotFound` if it does not exist.
    pub async fn genome(&self, hash: GenomeHash) -> Result<StoredGenome> {
        let query = sqlx::query("SELECT bytes, text FROM genome WHERE hash = ?");
        let mut conn = self.reader().await?;
        let row = query.bind(hash.key()).fetch_one(&mut *conn).await?;
        StoredGenome::read(&row)
    }

    /// Returns several genomes, without the unknown ones.
    ///
    /// # Errors
    /// Returns a `StorageError` if the read fails.
    pub async fn genomes(
        &self,
        hashes: &[GenomeHash],
    ) -> Result<HashMap<GenomeHash, StoredGenome>> {
        let wanted = json_set(hashes);
        let rows = sqlx::query(
            "SELECT hash, bytes, text FROM genome
             WHERE hash IN (SELECT unhex(value) FROM json_each(?))",
        )
        .bind(wanted)
        .fetch_all(&mut *self.reader().await?)
        .await?;
        rows.iter().map(|row| Ok((row.column("hash")?, StoredGenome::read(row)?))).collect()
    }
}

impl StoredGenome {
    fn read(row: &SqliteRow) -> Result<Self> {
        Ok(match row.column("bytes")? {
            Some(bytes) => Self::Bytes(bytes),
            None => Self::Text(row.column("text")?),
        })
    }
}

/// Inserts genomes. Existing ones are unchanged.
pub(crate) async fn insert<G: Borrow<NewGenome> + Sync>(
    conn: &mut SqliteConnection,
    genomes: &[G],
) -> Result<()> {
    let head =
        "INSERT INTO genome (hash, program_hash, live_instructions, layers, kept, text, bytes) ";
    insert_rows(conn, (head, " ON CONFLICT (hash) DO NOTHING"), genomes, |row, genome| {
        let genome = genome.borrow();
        row.push_bind(genome.hash.key())
            .push_bind(genome.program_hash.as_slice())
            .push_bind(genome.live_instructions)
            .push_bind(layer_names(&genome.layers))
            .push("0")
            .push("''")
            .push_bind(genome.bytes.as_slice());
    })
    .await
}

/// Encodes layers for the column `layers`.
fn layer_names(layers: &[ModelKind]) -> String {
    layers.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(" ")
}

/// Reads the layers of a row from `layers` or, if that is NULL, from the genome in `unread_bytes`.
/// Genomes of the first version, stored as text, have none.
pub(crate) fn layers(row: &SqliteRow) -> Result<Vec<ModelKind>> {
    const COLUMN: &str = "layers";
    let names: Option<String> = row.column(COLUMN)?;
    match (names, row.column::<Option<Vec<u8>>>("unread_bytes")?) {
        (Some(names), _) => names
            .split_whitespace()
            .map(|name| name.parse().map_err(|_| corrupt_column(COLUMN)))
            .collect(),
        (None, Some(bytes)) => {
            let genome =
                Genome::from_canonical_bytes(&bytes).map_err(|_| corrupt_column("bytes"))?;
            Ok(genome.layers().iter().map(|model| model.kind()).collect())
        }
        (None, None) => Ok(Vec::new()),
    }
}
