//! Genomes by content hash. Owner of the table `genome`. Genomes are opaque bytes here, except for
//! rows without the column `layers`, whose layers are decoded.
//!
//! Bytes are packed against the parents of the generation that a genome is born in ([`Bases`]).
//! Those of parents are packed against none, so a genome needs at most two others. They stay as
//! long as that generation does: it names them as parents. A purge packs the genomes that survive
//! it against none.

use std::borrow::Borrow;
use std::collections::HashMap;

use brood_genome::{Genome, GenomeHash, ModelKind};
use brood_protocol::GenerationId;

use crate::column::{Key, corrupt_column};
use crate::error::Result;
use crate::packing::{self, BASES_MAX, Packer};
use crate::row::{insert_rows, key_set, values};
use crate::sql::{Conn, GenomeUse, SqlRow, query};
use crate::write::operation;
use crate::{StorageError, Store};

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
            conn.lock_genomes(GenomeUse::Birth).await?;
            insert(conn, std::slice::from_ref(&genome), &Bases::default()).await?;
            query("UPDATE genome SET kept = TRUE WHERE hash = ? AND NOT kept")
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
    /// Returns `StorageError::NotFound` if it does not exist, `StorageError::Corrupt` if its bytes
    /// do not have its hash.
    pub async fn genome(&self, hash: GenomeHash) -> Result<StoredGenome> {
        self.genomes(&[hash]).await?.remove(&hash).ok_or(StorageError::NotFound)
    }

    /// Returns several genomes, without the unknown ones.
    ///
    /// # Errors
    /// Returns `StorageError::Corrupt` if bytes do not have their hash, other variants if the read
    /// fails.
    pub async fn genomes(
        &self,
        hashes: &[GenomeHash],
    ) -> Result<HashMap<GenomeHash, StoredGenome>> {
        read(&mut self.snapshot().await?, hashes).await
    }
}

/// Genome as a row has it.
struct Row {
    hash: GenomeHash,
    content: StoredGenome,
    /// Genomes that the bytes are packed against; `None` if they are not packed.
    bases: Option<Vec<GenomeHash>>,
}

impl Row {
    fn read(row: &SqlRow) -> Result<Self> {
        let content = match row.column("bytes")? {
            Some(bytes) => StoredGenome::Bytes(bytes),
            None => StoredGenome::Text(row.column("text")?),
        };
        let bases = row.column::<Option<Vec<u8>>>("bases")?.map(|hashes| {
            let (hashes, _) = hashes.as_chunks();
            hashes.iter().map(|hash| GenomeHash::from_bytes(*hash)).collect()
        });
        Ok(Self { hash: row.column("hash")?, content, bases })
    }

    /// True if reading it needs other rows.
    fn needs_bases(&self) -> bool {
        self.bases.as_ref().is_some_and(|bases| !bases.is_empty())
    }

    /// Returns the genome. `bases` has those that it is packed against. Error if the bytes do not
    /// have the hash.
    fn unpack(self, bases: &HashMap<GenomeHash, Vec<u8>>) -> Result<StoredGenome> {
        let damaged = || StorageError::Corrupt(format!("genome {} is damaged", self.hash));
        let bytes = match (self.content, self.bases) {
            (StoredGenome::Text(text), _) => return Ok(StoredGenome::Text(text)),
            (StoredGenome::Bytes(bytes), None) => bytes,
            (StoredGenome::Bytes(packed), Some(hashes)) => {
                let found = hashes.iter().map(|hash| bases.get(hash).map(Vec::as_slice));
                let found = found.collect::<Option<Vec<_>>>().ok_or_else(damaged)?;
                packing::unpack(&packed, &found).map_err(|_| damaged())?
            }
        };
        if GenomeHash::of(&bytes) == self.hash {
            Ok(StoredGenome::Bytes(bytes))
        } else {
            Err(damaged())
        }
    }
}

async fn rows<'h>(
    conn: &mut Conn,
    hashes: impl IntoIterator<Item = &'h GenomeHash>,
) -> Result<Vec<Row>> {
    let rows = query(
        "SELECT hash, bytes, text, bases FROM genome
         WHERE hash IN (SELECT unhex(value) FROM json_each(?))",
    )
    .bind(key_set(hashes))
    .fetch_all(conn)
    .await?;
    rows.iter().map(Row::read).collect()
}

/// Reads genomes, without the unknown ones.
pub(crate) async fn read(
    conn: &mut Conn,
    hashes: &[GenomeHash],
) -> Result<HashMap<GenomeHash, StoredGenome>> {
    let found = rows(conn, hashes).await?;
    let mut wanted: Vec<_> = found.iter().flat_map(|row| row.bases.iter().flatten()).collect();
    wanted.sort_unstable();
    wanted.dedup();
    let mut bases = HashMap::new();
    if !wanted.is_empty() {
        for row in rows(conn, wanted).await? {
            let hash = row.hash;
            if let StoredGenome::Bytes(bytes) = row.unpack(&HashMap::new())? {
                bases.insert(hash, bytes);
            }
        }
    }
    found.into_iter().map(|row| Ok((row.hash, row.unpack(&bases)?))).collect()
}

/// Genomes that others are packed against, at most [`BASES_MAX`].
#[derive(Debug, Default)]
pub(crate) struct Bases(Vec<(GenomeHash, Vec<u8>)>);

impl Bases {
    /// Returns the bases for the children of a generation: its first parents. For three children or
    /// more, first packs parents against none that are packed against others; for fewer, which
    /// would not save space, leaves those parents out.
    pub(crate) async fn of(
        conn: &mut Conn,
        generation: GenerationId,
        children: usize,
    ) -> Result<Self> {
        let parents = query(
            "SELECT genome_hash FROM generation_parent
             WHERE generation_id = ? GROUP BY genome_hash ORDER BY min(place) LIMIT ?",
        )
        .bind(generation.key())
        .bind(BASES_MAX as i64)
        .fetch_all(conn)
        .await?;
        let parents = parents.iter().map(|row| row.column("genome_hash"));
        let parents = parents.collect::<Result<Vec<GenomeHash>>>()?;
        if parents.is_empty() {
            return Ok(Self::default());
        }
        if children > BASES_MAX {
            pack_alone(conn, &parents).await?;
        }
        let alone = rows(conn, &parents).await?.into_iter().filter(|row| !row.needs_bases());
        let mut bases = Vec::new();
        for row in alone {
            let hash = row.hash;
            if let StoredGenome::Bytes(bytes) = row.unpack(&HashMap::new())? {
                bases.push((hash, bytes));
            }
        }
        bases.sort_by_key(|(hash, _)| parents.iter().position(|parent| parent == hash));
        Ok(Self(bases))
    }

    fn hashes(&self) -> Vec<u8> {
        self.0.iter().flat_map(|(hash, _)| *hash.as_bytes()).collect()
    }

    fn packer(&self) -> Result<Packer> {
        let bytes: Vec<_> = self.0.iter().map(|(_, bytes)| bytes.as_slice()).collect();
        Packer::new(&bytes).map_err(not_packed)
    }
}

fn not_packed(error: std::io::Error) -> StorageError {
    StorageError::Unsupported(format!("cannot pack a genome: {error}"))
}

/// Packs those of the genomes that are packed against others against none.
pub(crate) async fn pack_alone(conn: &mut Conn, hashes: &[GenomeHash]) -> Result<()> {
    let packed = rows(conn, hashes).await?.into_iter().filter(Row::needs_bases);
    let packed: Vec<_> = packed.map(|row| row.hash).collect();
    let alone = Bases::default();
    let mut found: Vec<_> = read(conn, &packed).await?.into_iter().collect();
    // Sorted, so that two transactions with the same genomes cannot wait for each other.
    found.sort_by_key(|(hash, _)| *hash);
    for (hash, genome) in found {
        if let StoredGenome::Bytes(bytes) = genome {
            pack(conn, (hash, &bytes), &alone).await?;
        }
    }
    Ok(())
}

/// Replaces the content of a stored genome by packed bytes.
pub(crate) async fn pack(
    conn: &mut Conn,
    (hash, bytes): (GenomeHash, &[u8]),
    bases: &Bases,
) -> Result<()> {
    let packed = bases.packer()?.pack(bytes).map_err(not_packed)?;
    query("UPDATE genome SET bytes = ?, text = '', bases = ? WHERE hash = ?")
        .bind(packed)
        .bind(bases.hashes())
        .bind(hash.key())
        .execute(conn)
        .await?;
    Ok(())
}

/// Inserts genomes, packed against `bases`. Existing ones are unchanged.
pub(crate) async fn insert<G: Borrow<NewGenome> + Sync>(
    conn: &mut Conn,
    genomes: &[G],
    bases: &Bases,
) -> Result<()> {
    let mut packer = bases.packer()?;
    let hashes = bases.hashes();
    let mut packed = Vec::with_capacity(genomes.len());
    // Sorted, so that two transactions with the same genomes cannot wait for each other.
    let mut sorted: Vec<&NewGenome> = genomes.iter().map(Borrow::borrow).collect();
    sorted.sort_by_key(|genome| genome.hash);
    sorted.dedup_by_key(|genome| genome.hash);
    for genome in sorted {
        packed.push((genome, packer.pack(&genome.bytes).map_err(not_packed)?));
    }
    let head = "INSERT INTO genome (hash, program_hash, live_instructions, layers, kept, text,
         bytes, bases) ";
    insert_rows(conn, (head, " ON CONFLICT (hash) DO NOTHING"), &packed, |(genome, bytes)| {
        values![
            genome.hash.key(),
            genome.program_hash.as_slice(),
            genome.live_instructions,
            layer_names(&genome.layers),
            false,
            "",
            bytes.as_slice(),
            hashes.as_slice(),
        ]
    })
    .await
}

/// Encodes layers for the column `layers`.
fn layer_names(layers: &[ModelKind]) -> String {
    layers.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(" ")
}

/// Reads the layers of a row from `layers` or, if that is NULL, from the genome in `unread_bytes`.
/// Genomes of the first version, stored as text, have none.
pub(crate) fn layers(row: &SqlRow) -> Result<Vec<ModelKind>> {
    const COLUMN: &str = "layers";
    let names: Option<String> = row.column(COLUMN)?;
    match (names, row.column::<Option<Vec<u8>>>("unread_bytes")?) {
        (Some(names), _) => names
            .split_whitespace()
            .map(|name| name.parse().map_err(|_| corrupt_column(COLUMN)))
            .collect(),
        (None, Some(bytes)) => decoded_layers(&bytes),
        (None, None) => Ok(Vec::new()),
    }
}

fn decoded_layers(bytes: &[u8]) -> Result<Vec<ModelKind>> {
    let genome = Genome::from_canonical_bytes(bytes).map_err(|_| corrupt_column("bytes"))?;
    Ok(genome.layers().iter().map(|model| model.kind()).collect())
}

/// Fills the column `layers` of a row that has none. `bytes` is its genome.
pub(crate) async fn set_layers(conn: &mut Conn, hash: GenomeHash, bytes: &[u8]) -> Result<()> {
    let row = query("SELECT 1 FROM genome WHERE hash = ? AND layers IS NULL");
    if row.bind(hash.key()).fetch_optional(conn).await?.is_none() {
        return Ok(());
    }
    query("UPDATE genome SET layers = ? WHERE hash = ?")
        .bind(layer_names(&decoded_layers(bytes)?))
        .bind(hash.key())
        .execute(conn)
        .await?;
    Ok(())
}
