//! Individuals: reading them with their parents, favourites, notes. Owner of the table
//! `individual`. See `generation` for inserting them, `family` for their relations.

use std::collections::{HashMap, HashSet};

use brood_genome::{GenomeHash, ModelKind};
use brood_protocol::{GenerationId, IndividualId, LineageId, ParentRef, PatchIndividual};

use crate::column::{Key, optional_key};
use crate::error::{Result, changed};
use crate::row::{Record, key_set, record, select, signed};
use crate::sql::{Conn, KeySet, Query, SqlRow, query};
use crate::write::operation;
use crate::{StorageError, Store, genome};

record! {
    /// Stored individual.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct StoredIndividual {
        /// Id of the individual.
        pub id: IndividualId,
        /// Id of its lineage.
        pub lineage: LineageId = "lineage_id",
        /// Id of its generation.
        pub generation: GenerationId = "generation_id",
        /// Content hash of its genome.
        pub hash: GenomeHash = "genome_hash",
        /// Hash of the program that the genome lowered to when it was stored.
        pub program_hash: [u8; 32],
        /// Slot in its brood, from 0.
        pub slot: u32,
        /// Origin: `random`, `mutate`, `recombine`, `adopt` or `fit`.
        pub operator: String,
        /// Number of live instructions.
        pub live_instructions: u32,
        /// Number of draws for this slot.
        pub attempts: u32,
        /// True if no draw gave a program that differs from those of its parents and siblings.
        pub twin: bool,
        /// True if marked as a favourite.
        pub favourite: bool,
        /// Note of a user.
        pub note: String,
        /// Version: 1 at first, incremented by each change of the mark or the note.
        pub version: u64,
    } and {
        /// Parents: by id, or by hash if they were given so or have been removed.
        pub parents: Vec<ParentRef>,
        /// Models of the genome's layers, lowest first.
        pub layers: Vec<ModelKind>,
    }
}

/// Cover of each lineage of a set; NULL if it has no individuals.
const COVERS: &str = "SELECT lineage.id, coalesce(
         lineage.cover_id,
         (SELECT individual.id FROM individual
          WHERE individual.favourite /*sqlite*/ = 1 /*end*/ AND individual.lineage_id = lineage.id
          ORDER BY individual.id DESC LIMIT 1),
         (SELECT coalesce(generation.centre_id,
              (SELECT individual.id FROM individual
               WHERE individual.generation_id = generation.id ORDER BY slot LIMIT 1))
          FROM generation WHERE generation.lineage_id = lineage.id
          ORDER BY position DESC LIMIT 1)) AS cover_id
     FROM lineage WHERE lineage.id IN (SELECT unhex(value) FROM json_each(?))";
/// Condition of favourites in visible lineages, and in lineage `?3`: two statements, so that each
/// uses its index.
const IN_VISIBLE: &str =
    "EXISTS (SELECT 1 FROM lineage WHERE id = individual.lineage_id AND NOT hidden)";
const IN_LINEAGE: &str = "individual.lineage_id = ?3";

/// Query for individuals, to be read by [`with_parents`]; `rest` is its end. `unread_bytes` are the
/// genome's bytes if only they have its layers.
pub(crate) fn select_individuals(rest: &str) -> Query {
    select::<StoredIndividual>(&format!(
        ", genome.layers,
         CASE WHEN genome.layers IS NULL THEN genome.bytes END AS unread_bytes
         FROM individual JOIN genome ON genome.hash = individual.genome_hash {rest}"
    ))
}

impl Store {
    /// Returns an individual.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if it does not exist.
    pub async fn individual(&self, id: IndividualId) -> Result<StoredIndividual> {
        fetch(&mut self.snapshot().await?, id).await
    }

    /// Returns several individuals, in the order of `ids`.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if one does not exist.
    pub async fn individuals(&self, ids: &[IndividualId]) -> Result<Vec<StoredIndividual>> {
        let mut conn = self.snapshot().await?;
        let found = fetch_all(&mut conn, ids).await?;
        let found: HashMap<_, _> = found.into_iter().map(|one| (one.id, one)).collect();
        ids.iter().map(|id| found.get(id).cloned().ok_or(StorageError::NotFound)).collect()
    }

    /// Returns the cover of each of these lineages: the chosen individual, else the newest
    /// favourite, else the newest generation's centre or first child. Lineages without individuals
    /// are left out.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn covers(
        &self,
        lineages: &[LineageId],
    ) -> Result<HashMap<LineageId, StoredIndividual>> {
        let mut conn = self.snapshot().await?;
        let query = query(COVERS).bind(key_set(lineages));
        let mut chosen: Vec<(LineageId, IndividualId)> = Vec::new();
        for row in query.fetch_all(&mut conn).await? {
            if let Some(cover) = row.column("cover_id")? {
                chosen.push((row.column("id")?, cover));
            }
        }
        let ids: Vec<_> = chosen.iter().map(|(_, cover)| *cover).collect();
        let found = fetch_all(&mut conn, &ids).await?;
        let found: HashMap<_, _> = found.into_iter().map(|one| (one.id, one)).collect();
        let cover = |(lineage, id)| found.get(&id).cloned().map(|one| (lineage, one));
        Ok(chosen.into_iter().filter_map(cover).collect())
    }

    /// Changes the favourite mark or the note of an individual.
    ///
    /// # Errors
    /// Returns [`StorageError::StaleVersion`] if its version is not `expected_version`,
    /// [`StorageError::NotFound`] if it does not exist.
    pub async fn patch_individual(
        &self,
        id: IndividualId,
        expected_version: u64,
        patch: PatchIndividual,
    ) -> Result<StoredIndividual> {
        self.write(operation!(|conn| {
            let done = query(
                "UPDATE individual SET favourite = coalesce(?, favourite),
                     note = coalesce(?, note), version = version + 1
                 WHERE id = ? AND version = ?",
            )
            .bind(patch.favourite)
            .bind(patch.note)
            .bind(id.key())
            .bind(signed(expected_version))
            .execute(conn)
            .await?;
            let individual = fetch(conn, id).await?;
            changed(done, StorageError::StaleVersion { current: individual.version })?;
            Ok(individual)
        }))
        .await
    }

    /// Lists the favourites of all visible lineages, or of one that may be hidden, the youngest
    /// first, after the cursor.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn favourites(
        &self,
        cursor: Option<IndividualId>,
        limit: u32,
        lineage: Option<LineageId>,
    ) -> Result<Vec<StoredIndividual>> {
        let mut conn = self.snapshot().await?;
        let place = if lineage.is_some() { IN_LINEAGE } else { IN_VISIBLE };
        let mut query = select_individuals(&format!(
            "WHERE individual.favourite /*sqlite*/ = 1 /*end*/ AND (?1 IS NULL OR individual.id < ?1) AND {place}
             ORDER BY individual.id DESC LIMIT ?2"
        ));
        query = query.bind(optional_key(cursor)).bind(limit);
        if let Some(lineage) = lineage {
            query = query.bind(lineage.key().to_vec());
        }
        let rows = query.fetch_all(&mut conn).await?;
        with_parents(&mut conn, &rows).await
    }
}

/// Reads an individual.
pub(crate) async fn fetch(conn: &mut Conn, id: IndividualId) -> Result<StoredIndividual> {
    fetch_all(conn, &[id]).await?.pop().ok_or(StorageError::NotFound)
}

/// Reads those of the individuals that exist, in any order.
pub(crate) async fn fetch_all(
    conn: &mut Conn,
    ids: &[IndividualId],
) -> Result<Vec<StoredIndividual>> {
    let wanted = key_set(ids);
    let query =
        select_individuals("WHERE individual.id IN (SELECT unhex(value) FROM json_each(?))");
    let rows = query.bind(wanted).fetch_all(conn).await?;
    with_parents(conn, &rows).await
}

/// Reads individuals from rows of [`select_individuals`], with the parents of their generations.
pub(crate) async fn with_parents(
    conn: &mut Conn,
    rows: &[SqlRow],
) -> Result<Vec<StoredIndividual>> {
    let mut individuals = Vec::with_capacity(rows.len());
    for row in rows {
        let layers = genome::layers(row)?;
        individuals.push(StoredIndividual { layers, ..StoredIndividual::read(row)? });
    }
    let generations: HashSet<_> = individuals.iter().map(|one| &one.generation).collect();
    let parents = parents(conn, key_set(generations)).await?;
    for individual in &mut individuals {
        if let Some(parents) = parents.get(&individual.generation) {
            individual.parents.clone_from(parents);
        }
    }
    Ok(individuals)
}

/// Reads the parents of a set of generations, in order.
pub(crate) async fn parents(
    conn: &mut Conn,
    generations: KeySet,
) -> Result<HashMap<GenerationId, Vec<ParentRef>>> {
    let query = query(
        "SELECT generation_id, genome_hash, individual_id FROM generation_parent
         WHERE generation_id IN (SELECT unhex(value) FROM json_each(?))
         ORDER BY generation_id, place",
    )
    .bind(generations);
    let mut parents: HashMap<_, Vec<_>> = HashMap::new();
    for row in query.fetch_all(conn).await? {
        let parent = match row.column("individual_id")? {
            Some(id) => ParentRef::Individual(id),
            None => ParentRef::Genome(row.column("genome_hash")?),
        };
        parents.entry(row.column("generation_id")?).or_default().push(parent);
    }
    Ok(parents)
}
