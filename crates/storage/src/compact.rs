//! Compaction of a database that no server uses: packs genomes of earlier versions, and gives free
//! pages back to the file system.

use std::path::Path;

use brood_genome::{Genome, GenomeHash};
use brood_protocol::GenerationId;

use crate::column::{Key, corrupt_column};
use crate::engine::sqlite::Opened;
use crate::error::Result;
use crate::genome::{self, Bases};
use crate::sql::{Conn, query};
use crate::{StorageError, Store, StoredGenome};

/// Number of generations, or of genomes, in a transaction.
const BATCH: i64 = 64;
/// Genomes that are not packed and not the parents of a generation, with a generation that they
/// were born in.
const CHILDREN: &str =
    "SELECT individual.generation_id AS generation_id, individual.genome_hash AS hash
    FROM individual JOIN genome ON genome.hash = individual.genome_hash
    WHERE individual.generation_id IN (
            SELECT id FROM generation WHERE id > ?1 ORDER BY id LIMIT ?2)
        AND genome.bases IS NULL
        AND NOT EXISTS (
            SELECT 1 FROM generation_parent WHERE genome_hash = individual.genome_hash)
    ORDER BY individual.generation_id";
const LAST_GENERATION: &str =
    "SELECT max(id) AS id FROM (SELECT id FROM generation WHERE id > ?1 ORDER BY id LIMIT ?2)";
const UNPACKED: &str =
    "SELECT hash FROM genome WHERE hash > ?1 AND bases IS NULL ORDER BY hash LIMIT ?2";

/// Work of [`Store::compact`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Compacted {
    /// Number of genomes that were packed.
    pub genomes: u64,
    /// Size of the database before, in bytes.
    pub bytes_before: u64,
    /// Size of the database after.
    pub bytes_after: u64,
}

impl Store {
    /// Compacts the database of a data directory. Needs as much free space as the database has.
    /// Stopped halfway, it loses nothing and can be repeated. Calls `packed` with the number of
    /// packed genomes so far.
    ///
    /// # Errors
    /// Returns [`StorageError::Locked`] if a server uses the directory, [`StorageError::Corrupt`]
    /// if a genome is damaged, others as [`Store::open`].
    pub async fn compact(dir: &Path, packed: impl Fn(u64)) -> Result<Compacted> {
        let mut opened = Opened::take(dir).await?;
        let bytes_before = opened.bytes()?;
        let conn = &mut opened.conn;
        let genomes = pack_children(conn, &packed).await?;
        let genomes = pack_others(conn, genomes, &packed).await?;
        query("VACUUM").execute(conn).await?;
        query("PRAGMA wal_checkpoint(TRUNCATE)").execute(conn).await?;
        let bytes_after = opened.bytes()?;
        opened.conn.close().await?;
        Ok(Compacted { genomes, bytes_before, bytes_after })
    }
}

/// Packs the genomes that are not parents, against their parents. Returns their number.
async fn pack_children(conn: &mut Conn, packed: impl Fn(u64)) -> Result<u64> {
    let (mut last, mut count) = (Vec::new(), 0);
    loop {
        let end = query(LAST_GENERATION).bind(last.as_slice()).bind(BATCH).fetch_one(conn);
        let Some(end) = end.await?.column::<Option<Vec<u8>>>("id")? else { return Ok(count) };
        let rows = query(CHILDREN).bind(last.as_slice()).bind(BATCH).fetch_all(conn).await?;
        let children =
            rows.iter().map(|row| Ok((row.column("generation_id")?, row.column("hash")?)));
        let children: Vec<(GenerationId, GenomeHash)> = children.collect::<Result<_>>()?;
        query("BEGIN IMMEDIATE").execute(conn).await?;
        for brood in children.chunk_by(|one, next| one.0 == next.0) {
            let bases = Bases::of(conn, brood[0].0, brood.len()).await?;
            for &(_, hash) in brood {
                pack(conn, hash, &bases).await?;
            }
        }
        count += children.len() as u64;
        query("COMMIT").execute(conn).await?;
        packed(count);
        last = end;
    }
}

/// Packs the remaining genomes against none. Returns `count` plus their number.
async fn pack_others(conn: &mut Conn, mut count: u64, packed: impl Fn(u64)) -> Result<u64> {
    let (mut last, alone) = (Vec::new(), Bases::default());
    loop {
        let rows = query(UNPACKED).bind(last.as_slice()).bind(BATCH).fetch_all(conn).await?;
        let hashes = rows.iter().map(|row| row.column("hash"));
        let hashes: Vec<GenomeHash> = hashes.collect::<Result<_>>()?;
        let Some(end) = hashes.last() else { return Ok(count) };
        query("BEGIN IMMEDIATE").execute(conn).await?;
        for &hash in &hashes {
            pack(conn, hash, &alone).await?;
        }
        query("COMMIT").execute(conn).await?;
        count += hashes.len() as u64;
        packed(count);
        last = end.key().to_vec();
    }
}

/// Packs one genome. One that is stored as text gets its canonical bytes, and one without layers in
/// their column gets them: packed bytes are not decoded for them.
async fn pack(conn: &mut Conn, hash: GenomeHash, bases: &Bases) -> Result<()> {
    let stored = genome::read(conn, &[hash]).await?.remove(&hash).ok_or(StorageError::NotFound)?;
    let bytes = match stored {
        StoredGenome::Bytes(bytes) => bytes,
        StoredGenome::Text(text) => {
            let genome: Genome = text.parse().map_err(|_| corrupt_column("text"))?;
            let bytes = genome.canonical_bytes();
            if GenomeHash::of(&bytes) != hash {
                return Err(corrupt_column("text"));
            }
            bytes
        }
    };
    genome::set_layers(conn, hash, &bytes).await?;
    genome::pack(conn, (hash, &bytes), bases).await
}
