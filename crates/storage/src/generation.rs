//! Generations: the transaction that inserts one, and the history. Owner of the tables `generation`
//! and `generation_parent`. Independent of how children are bred.

use std::collections::HashMap;
use std::sync::Arc;

use brood_protocol::{
    BreedOptions, DialectConstraints, GenerationId, IndividualId, LineageId, ParentRef, Seed,
};

use crate::column::{Key, optional_key};
use crate::error::changed;
use crate::genome::{self, Bases, NewGenome};
use crate::individual::{self, StoredIndividual};
use crate::row::{Record, insert_rows, key_set, record, select, signed, values};
use crate::search_lease::PlacedCheckpoint;
use crate::sql::{Conn, GenomeUse, Query, SqlRow, query};
use crate::write::operation;
use crate::{
    CommitTimes, Idempotency, NewPicture, SearchStep, StorageError, Store, idempotency, lineage,
    picture, search_lease,
};

/// Generation to be stored, with everything that is written in the same transaction.
#[derive(Debug, Clone, PartialEq)]
pub struct NewGeneration {
    /// Id of the generation.
    pub id: GenerationId,
    /// Id of its lineage.
    pub lineage: LineageId,
    /// Seed of the brood.
    pub seed: Seed,
    /// Parents of all its individuals.
    pub parents: Vec<ParentRef>,
    /// Parent that is shown large.
    pub centre: Option<IndividualId>,
    /// Options of the brood.
    pub options: BreedOptions,
    /// Creation time, in milliseconds since 1970-01-01 UTC.
    pub created_ms: i64,
    /// Children.
    pub individuals: Vec<NewIndividual>,
    /// Keys of their pictures.
    pub pictures: Vec<NewPicture>,
    /// Step of the search that found them.
    pub search: Option<SearchStep>,
    /// Idempotency record to be stored with it.
    pub idempotency: Option<Idempotency>,
}

/// Child to be stored.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewIndividual {
    /// Id of the individual.
    pub id: IndividualId,
    /// Slot in the brood, from 0.
    pub slot: u32,
    /// Genome, shared with other individuals that have it.
    pub genome: Arc<NewGenome>,
    /// Origin: `random`, `mutate`, `recombine`, `adopt` or `fit`.
    pub operator: &'static str,
    /// Number of draws for this slot, at least 1.
    pub attempts: u32,
    /// True if no draw gave a program that differs from those of its parents and siblings.
    pub twin: bool,
}

impl NewIndividual {
    /// Returns what reading the individual back would return, without the read.
    #[must_use]
    pub fn stored(
        &self,
        lineage: LineageId,
        generation: GenerationId,
        parents: &[ParentRef],
    ) -> StoredIndividual {
        StoredIndividual {
            id: self.id,
            lineage,
            generation,
            hash: self.genome.hash,
            program_hash: self.genome.program_hash,
            slot: self.slot,
            parents: parents.to_vec(),
            operator: self.operator.to_owned(),
            live_instructions: self.genome.live_instructions,
            layers: self.genome.layers.clone(),
            attempts: self.attempts,
            twin: self.twin,
            favourite: false,
            note: String::new(),
            version: 1,
        }
    }
}

record! {
    /// Stored generation.
    #[derive(Debug, Clone, PartialEq)]
    pub struct StoredGeneration {
        /// Id of the generation.
        pub id: GenerationId,
        /// Id of its lineage.
        pub lineage: LineageId = "lineage_id",
        /// Position in the lineage, from 0.
        pub index: u64 = "position",
        /// Seed of the brood.
        pub seed: Seed = "seed_bits",
        /// Creation time, in milliseconds since 1970-01-01 UTC.
        pub created_ms: i64,
    } and {
        /// Options of the brood.
        pub options: BreedOptions,
        /// Parents: by id, or by hash if they were given so or have been removed.
        pub parents: Vec<ParentRef>,
        /// Parent that is shown large, unless it has been removed.
        pub centre: Option<StoredIndividual>,
        /// Children, by slot.
        pub individuals: Vec<StoredIndividual>,
    }
}

record!(BreedOptions {
    mutation,
    recombination,
    curation,
    saturation,
    energy_limit,
    locks = "locks_json",
    steer = "steer_json",
    painting = "painting_json",
} and { constraints });
record!(DialectConstraints { isotropic, homogeneous, bumps });

const CHILDREN: &str = "WHERE individual.generation_id IN (SELECT unhex(value) FROM json_each(?))
     ORDER BY individual.generation_id, individual.slot";

/// Query for generations, to be read by [`read_with_relations`]; `rest` is its end.
fn select_generations(rest: &str) -> Query {
    let (options, constraints) = (BreedOptions::COLUMNS, DialectConstraints::COLUMNS);
    select::<StoredGeneration>(&format!(
        ", {options}, {constraints}, centre_id FROM generation {rest}"
    ))
}

impl Store {
    /// Stores a generation with its individuals, genomes, parents, picture keys, search step and
    /// idempotency record, in one transaction. Its index is the next one of the lineage.
    /// Returns it with the times of the commit. On SQLite, once the future was polled, all later
    /// writes are ordered after it.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if the lineage, a parent or a scene does not exist,
    /// [`StorageError::Conflict`] if an id or the idempotency key is in use or the search's lease
    /// is no longer valid.
    pub async fn create_generation_timed(
        &self,
        mut new: NewGeneration,
    ) -> Result<(StoredGeneration, CommitTimes), StorageError> {
        let saved = match &mut new.search {
            Some(step) => self.place_checkpoint(step).await?,
            None => PlacedCheckpoint::default(),
        };
        let objects = saved.objects();
        let written = self.write_timed(operation!(|conn| insert(conn, new, saved).await)).await;
        self.discard_checkpoint(objects, &written);
        written
    }

    /// Returns a generation.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if it does not exist.
    pub async fn generation(&self, id: GenerationId) -> Result<StoredGeneration, StorageError> {
        let mut conn = self.snapshot().await?;
        let query = select_generations("WHERE id = ?").bind(id.key());
        let row = query.fetch_one(&mut conn).await?;
        let mut generations = read_with_relations(&mut conn, std::slice::from_ref(&row)).await?;
        generations.pop().ok_or(StorageError::NotFound)
    }

    /// Returns the positions of generations in their lineages. Unknown generations are left out.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn generation_indices(
        &self,
        ids: &[GenerationId],
    ) -> Result<HashMap<GenerationId, u64>, StorageError> {
        let query = query(
            "SELECT id, position FROM generation
             WHERE id IN (SELECT unhex(value) FROM json_each(?))",
        )
        .bind(key_set(ids));
        let rows = query.fetch_all(&mut self.reader().await?).await?;
        rows.iter().map(|row| Ok((row.column("id")?, row.column("position")?))).collect()
    }

    /// Returns how many of the next `limit` generations have at most `individuals` together, but at
    /// least 1.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the read fails.
    pub async fn generations_within(
        &self,
        lineage: LineageId,
        after_index: Option<u64>,
        limit: u32,
        individuals: u32,
    ) -> Result<u32, StorageError> {
        let query = query(WITHIN).bind(lineage.key()).bind(after_index.map_or(-1, signed));
        let query = query.bind(limit).bind(individuals);
        let row = query.fetch_one(&mut self.reader().await?).await?;
        Ok(row.column::<u32>("within")?.max(1))
    }

    /// Lists the generations of a lineage, the oldest first, those after `after_index`.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if the lineage does not exist.
    pub async fn list_generations(
        &self,
        lineage: LineageId,
        after_index: Option<u64>,
        limit: u32,
    ) -> Result<Vec<StoredGeneration>, StorageError> {
        let mut conn = self.snapshot().await?;
        lineage::fetch(&mut conn, lineage).await?;
        let query =
            select_generations("WHERE lineage_id = ? AND position > ? ORDER BY position LIMIT ?");
        let query = query.bind(lineage.key()).bind(after_index.map_or(-1, signed)).bind(limit);
        let rows = query.fetch_all(&mut conn).await?;
        read_with_relations(&mut conn, &rows).await
    }
}

/// Number of generations at a place in a lineage with at most this number of individuals together.
const WITHIN: &str = "SELECT count(*) AS within FROM (
         SELECT sum(children) OVER (ORDER BY position) AS total FROM (
             SELECT position,
                 (SELECT count(*) FROM individual WHERE generation_id = generation.id) AS children
             FROM generation WHERE lineage_id = ? AND position > ? ORDER BY position LIMIT ?)
         AS sized) AS summed
     WHERE total <= ?";

/// Inserts a generation with everything that belongs to it. `saved` is the checkpoint of its search
/// step.
pub(crate) async fn insert(
    conn: &mut Conn,
    new: NewGeneration,
    saved: PlacedCheckpoint,
) -> Result<StoredGeneration, StorageError> {
    // Before the rows that a removal of the lineage takes after it.
    conn.lock_genomes(GenomeUse::Birth).await?;
    idempotency::insert(conn, new.idempotency.as_ref(), new.created_ms).await?;
    if let Some(step) = &new.search {
        search_lease::apply(conn, step, saved).await?;
    }
    lineage::lock(conn, new.lineage).await?;
    let index = insert_row(conn, &new).await?;
    insert_parents(conn, new.id, &new.parents).await?;
    let genomes: Vec<_> = new.individuals.iter().map(|child| child.genome.clone()).collect();
    let bases = Bases::of(conn, new.id, genomes.len()).await?;
    genome::insert(conn, &genomes, &bases).await?;
    insert_individuals(conn, &new).await?;
    picture::insert(conn, &new.pictures).await?;
    let centre = match new.centre {
        Some(id) => Some(individual::fetch(conn, id).await?),
        None => None,
    };
    Ok(stored(new, index, centre))
}

/// Inserts the row of the generation. Returns its index.
async fn insert_row(conn: &mut Conn, new: &NewGeneration) -> Result<u64, StorageError> {
    let words = |locks| serde_json::to_string(locks).expect("locks are lists of numbers and words");
    let options = &new.options;
    let locks = options.locks.as_ref().map(words);
    let steer = serde_json::to_string(&options.steer).expect("a steer is a list of words");
    let words =
        |painting| serde_json::to_string(painting).expect("a painting is colours and shares");
    let painting = options.painting.as_ref().map(words);
    query(
        "INSERT INTO generation (id, lineage_id, position, seed_bits, centre_id, mutation,
             recombination, curation, isotropic, homogeneous, bumps, saturation, energy_limit,
             locks_json, steer_json, painting_json, created_ms)
         SELECT ?1, ?2, coalesce((SELECT max(position) + 1 FROM generation WHERE lineage_id = ?2), 0),
             ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, ?15, ?16
         RETURNING position",
    )
    .bind(new.id.key())
    .bind(new.lineage.key())
    .bind(new.seed.0.cast_signed())
    .bind(optional_key(new.centre))
    .bind(options.mutation)
    .bind(options.recombination)
    .bind(options.curation.name())
    .bind(options.constraints.isotropic)
    .bind(options.constraints.homogeneous)
    .bind(options.constraints.bumps)
    .bind(options.saturation)
    .bind(options.energy_limit)
    .bind(locks)
    .bind(steer)
    .bind(painting)
    .bind(new.created_ms)
    .fetch_one(conn)
    .await?
    .column("position")
}

/// Inserts the parents of a generation, each with its genome hash. Error if one does not exist.
async fn insert_parents(
    conn: &mut Conn,
    generation: GenerationId,
    parents: &[ParentRef],
) -> Result<(), StorageError> {
    for (place, parent) in (0_i64..).zip(parents) {
        let query = match parent {
            ParentRef::Individual(id) => query(
                "INSERT INTO generation_parent
                     (generation_id, place, genome_hash, individual_id, parent_generation_id)
                 SELECT ?1, ?2, genome_hash, id, generation_id FROM individual WHERE id = ?3",
            )
            .bind(generation.key())
            .bind(place)
            .bind(id.key()),
            ParentRef::Genome(hash) => query(
                "INSERT INTO generation_parent (generation_id, place, genome_hash)
                 VALUES (?1, ?2, ?3)",
            )
            .bind(generation.key())
            .bind(place)
            .bind(hash.key()),
        };
        changed(query.execute(conn).await?, StorageError::NotFound)?;
    }
    Ok(())
}

async fn insert_individuals(conn: &mut Conn, new: &NewGeneration) -> Result<(), StorageError> {
    let head = "INSERT INTO individual (id, lineage_id, generation_id, slot, genome_hash, operator,
     attempts, twin) ";
    insert_rows(conn, (head, ""), &new.individuals, |child| {
        values![
            child.id.key(),
            new.lineage.key(),
            new.id.key(),
            child.slot,
            child.genome.hash.key(),
            child.operator,
            child.attempts,
            child.twin,
        ]
    })
    .await
}

/// Returns what reading the generation back would return, without the read.
fn stored(new: NewGeneration, index: u64, centre: Option<StoredIndividual>) -> StoredGeneration {
    let child = |child: &NewIndividual| child.stored(new.lineage, new.id, &new.parents);
    let mut individuals: Vec<_> = new.individuals.iter().map(child).collect();
    individuals.sort_by_key(|child| child.slot);
    StoredGeneration {
        id: new.id,
        lineage: new.lineage,
        index,
        seed: new.seed,
        parents: new.parents,
        centre,
        options: new.options,
        created_ms: new.created_ms,
        individuals,
    }
}

/// Reads generations from rows of [`select_generations`], with their parents, centres and children.
async fn read_with_relations(
    conn: &mut Conn,
    rows: &[SqlRow],
) -> Result<Vec<StoredGeneration>, StorageError> {
    let mut generations = rows.iter().map(StoredGeneration::read).collect::<Result<Vec<_>, _>>()?;
    let ids = key_set(generations.iter().map(|one| &one.id));
    let mut parents = individual::parents(conn, ids.clone()).await?;
    let query = individual::select_individuals(CHILDREN).bind(ids);
    let children = query.fetch_all(conn).await?;
    let children = individual::with_parents(conn, &children).await?;
    let centres = rows.iter().map(|row| row.column("centre_id"));
    let centres = centres.collect::<Result<Vec<Option<IndividualId>>, _>>()?;
    let wanted: Vec<_> = centres.iter().flatten().copied().collect();
    let found = individual::fetch_all(conn, &wanted).await?;
    for ((generation, row), centre) in generations.iter_mut().zip(rows).zip(centres) {
        let constraints = DialectConstraints::read(row)?;
        generation.options = BreedOptions { constraints, ..BreedOptions::read(row)? };
        generation.parents = parents.remove(&generation.id).unwrap_or_default();
        generation.centre = found.iter().find(|one| Some(one.id) == centre).cloned();
        // Children are sorted by generation and slot.
        let start = children.partition_point(|child| child.generation < generation.id);
        let own = children[start..].iter().take_while(|child| child.generation == generation.id);
        generation.individuals = own.cloned().collect();
    }
    Ok(generations)
}
