//! Genomes: their bytes by content hash. Owns the table `genome`; refuses to know what the bytes mean, but for the models of
//! rows that do not say them.

use std::collections::HashMap;

use brood_genome::{Genome, GenomeHash, ModelKind};
use sqlx::sqlite::SqliteRow;
use sqlx::{QueryBuilder, Sqlite, SqliteConnection};

use crate::row::{Columns, damaged, set};
use crate::{StorageError, Store};

/// Rows of one INSERT: keeps statements small however large a brood is.
pub(crate) const CHUNK_ROWS: usize = 256;

/// A genome to be stored.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewGenome {
    /// Content hash.
    pub hash: GenomeHash,
    /// Canonical bytes.
    pub bytes: Vec<u8>,
    /// Hash of the program that it lowers to.
    pub program_hash: [u8; 32],
    /// Instructions that can change the result.
    pub live_instructions: u32,
    /// The models that it has besides its program, lowest first.
    pub layers: Vec<ModelKind>,
}

/// A genome as it was stored.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StoredGenome {
    /// Canonical bytes.
    Bytes(Vec<u8>),
    /// Canonical text: rows of the first version, three times as large and slow to write.
    Text(String),
}

impl Store {
    /// Stores a genome that someone saves by hand; one that is there already is kept from now on, whatever becomes of
    /// the individuals that carry it.
    pub async fn put_genome(&self, genome: NewGenome) -> Result<(), StorageError> {
        self.write(move |conn| {
            Box::pin(async move {
                insert(conn, std::slice::from_ref(&genome)).await?;
                sqlx::query("UPDATE genome SET kept = 1 WHERE hash = ? AND kept = 0")
                    .bind(genome.hash.as_bytes().as_slice())
                    .execute(conn)
                    .await?;
                Ok(())
            })
        })
        .await
    }

    /// A genome.
    pub async fn genome(&self, hash: GenomeHash) -> Result<StoredGenome, StorageError> {
        let query = sqlx::query("SELECT bytes, text FROM genome WHERE hash = ?");
        let mut conn = self.reader().await?;
        let row = query.bind(hash.as_bytes().as_slice()).fetch_one(&mut *conn).await?;
        StoredGenome::read(&row)
    }

    /// Many genomes; unknown ones are left out.
    pub async fn genomes(
        &self,
        hashes: &[GenomeHash],
    ) -> Result<HashMap<GenomeHash, StoredGenome>, StorageError> {
        let wanted = set(hashes.iter().map(|hash| hash.as_bytes().as_slice()));
        let rows = sqlx::query(
            "SELECT hash, bytes, text FROM genome
             WHERE hash IN (SELECT unhex(value) FROM json_each(?))",
        )
        .bind(wanted)
        .fetch_all(&mut *self.reader().await?)
        .await?;
        rows.iter()
            .map(|row| Ok((GenomeHash::from_bytes(row.hash("hash")?), StoredGenome::read(row)?)))
            .collect()
    }
}

impl StoredGenome {
    fn read(row: &SqliteRow) -> Result<Self, StorageError> {
        Ok(match row.optional_blob("bytes")? {
            Some(bytes) => Self::Bytes(bytes),
            None => Self::Text(row.text("text")?),
        })
    }
}

/// Stores genomes; those that are there already stay as they are.
pub(crate) async fn insert(
    conn: &mut SqliteConnection,
    genomes: &[NewGenome],
) -> Result<(), StorageError> {
    for chunk in genomes.chunks(CHUNK_ROWS) {
        let mut query = QueryBuilder::<Sqlite>::new(
            "INSERT INTO genome (hash, program_hash, live_instructions, layers, kept, text, bytes) ",
        );
        query.push_values(chunk, |mut row, genome| {
            row.push_bind(genome.hash.as_bytes().as_slice())
                .push_bind(genome.program_hash.as_slice())
                .push_bind(genome.live_instructions)
                .push_bind(names(&genome.layers))
                .push("0")
                .push("''")
                .push_bind(genome.bytes.as_slice());
        });
        query.push(" ON CONFLICT (hash) DO NOTHING");
        query.build().execute(&mut *conn).await?;
    }
    Ok(())
}

/// Models as the column has them.
fn names(layers: &[ModelKind]) -> String {
    layers.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(" ")
}

/// The models of a row of `layers` and, where that is NULL, `unread_bytes`; a genome of the first version, which is text, had none.
pub(crate) fn layers(row: &SqliteRow) -> Result<Vec<ModelKind>, StorageError> {
    const COLUMN: &str = "layers";
    match (row.optional_text(COLUMN)?, row.optional_blob("unread_bytes")?) {
        (Some(names), _) => {
            names.split_whitespace().map(|name| name.parse().map_err(|_| damaged(COLUMN))).collect()
        }
        (None, Some(bytes)) => {
            let genome = Genome::from_canonical_bytes(&bytes).map_err(|_| damaged("bytes"))?;
            Ok(genome.layers().iter().map(|model| model.kind()).collect())
        }
        (None, None) => Ok(Vec::new()),
    }
}
