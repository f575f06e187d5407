//! Genomes: texts by content hash. Owns the table `genome`; refuses to know what the text means.

use std::collections::HashMap;

use brood_genome::GenomeHash;
use sqlx::{QueryBuilder, Sqlite, SqliteConnection};

use crate::row::{Columns, set};
use crate::{StorageError, Store};

/// Rows of one INSERT: keeps statements small however large a brood is.
pub(crate) const CHUNK_ROWS: usize = 256;

/// A genome to be stored.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewGenome {
    /// Content hash.
    pub hash: GenomeHash,
    /// Canonical text.
    pub text: String,
    /// Hash of the program that it lowers to.
    pub program_hash: [u8; 32],
    /// Instructions that can change the result.
    pub live_instructions: u32,
}

impl Store {
    /// Stores a genome that someone saves by hand; one that is there already is kept from now on, whatever becomes of
    /// the individuals that carry it.
    pub async fn put_genome(
        &self,
        hash: GenomeHash,
        text: String,
        program_hash: [u8; 32],
        live_instructions: u32,
    ) -> Result<(), StorageError> {
        let genome = NewGenome { hash, text, program_hash, live_instructions };
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

    /// The text of a genome.
    pub async fn genome_text(&self, hash: GenomeHash) -> Result<String, StorageError> {
        let query = sqlx::query_scalar("SELECT text FROM genome WHERE hash = ?");
        let mut conn = self.reader().await?;
        Ok(query.bind(hash.as_bytes().as_slice()).fetch_one(&mut *conn).await?)
    }

    /// The texts of many genomes; unknown ones are left out.
    pub async fn genome_texts(
        &self,
        hashes: &[GenomeHash],
    ) -> Result<HashMap<GenomeHash, String>, StorageError> {
        let wanted = set(hashes.iter().map(|hash| hash.as_bytes().as_slice()));
        let rows = sqlx::query(
            "SELECT hash, text FROM genome WHERE hash IN (SELECT unhex(value) FROM json_each(?))",
        )
        .bind(wanted)
        .fetch_all(&mut *self.reader().await?)
        .await?;
        rows.iter()
            .map(|row| Ok((GenomeHash::from_bytes(row.hash("hash")?), row.text("text")?)))
            .collect()
    }
}

/// Stores genomes; those that are there already stay as they are.
pub(crate) async fn insert(
    conn: &mut SqliteConnection,
    genomes: &[NewGenome],
) -> Result<(), StorageError> {
    for chunk in genomes.chunks(CHUNK_ROWS) {
        let mut query = QueryBuilder::<Sqlite>::new(
            "INSERT INTO genome (hash, program_hash, live_instructions, kept, text) ",
        );
        query.push_values(chunk, |mut row, genome| {
            row.push_bind(genome.hash.as_bytes().as_slice())
                .push_bind(genome.program_hash.as_slice())
                .push_bind(genome.live_instructions)
                .push("0")
                .push_bind(genome.text.as_str());
        });
        query.push(" ON CONFLICT (hash) DO NOTHING");
        query.build().execute(&mut *conn).await?;
    }
    Ok(())
}
