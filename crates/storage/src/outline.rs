//! Outlines of generations: what a history shows, without reading all individuals.

use std::collections::HashMap;

use brood_protocol::{GenerationId, IndividualId, LineageId};

use crate::column::Key;
use crate::error::Result;
use crate::individual::{fetch_all, select_individuals, with_parents};
use crate::row::{Record, key_set, record, select, signed};
use crate::{Store, StoredIndividual};

record! {
    /// Stored outline of a generation.
    #[derive(Debug, Clone, PartialEq)]
    pub struct StoredOutline {
        /// Id of the generation.
        pub id: GenerationId,
        /// Position in the lineage, from 0.
        pub index: u64 = "position",
        /// Generation of the lineage in which the first parent was born; for a parent given by its
        /// hash, the first with an individual of that genome.
        pub from: Option<GenerationId> = "(
            SELECT coalesce(
                (SELECT born.id FROM generation AS born
                 WHERE born.id = parent.parent_generation_id
                     AND born.lineage_id = generation.lineage_id),
                (SELECT born.id FROM individual AS one
                 /*sqlite*/ CROSS /*end*/ JOIN generation AS born ON born.id = one.generation_id
                 WHERE parent.individual_id IS NULL AND one.genome_hash = parent.genome_hash
                     AND born.lineage_id = generation.lineage_id
                     AND born.position < generation.position
                 ORDER BY born.position LIMIT 1))
            FROM generation_parent AS parent
            WHERE parent.generation_id = generation.id AND parent.place = 0)",
    } and {
        /// Parent that is shown large, unless it has been removed.
        pub centre: Option<StoredIndividual>,
        /// Children that are favourites or were adopted, and the first one if there is no centre,
        /// by slot.
        pub individuals: Vec<StoredIndividual>,
    }
}

/// First children.
const FIRST: &str = "WHERE individual.slot = 0
     AND individual.generation_id IN (SELECT unhex(value) FROM json_each(?1))";
/// Others that are kept: favourites, and all of generations that were adopted. `IS TRUE` keeps
/// SQLite from reading all favourites.
const OTHERS: &str = "WHERE individual.slot > 0 AND individual.id IN (
         SELECT id FROM individual
         WHERE generation_id IN (SELECT unhex(value) FROM json_each(?1)) AND favourite IS TRUE
         UNION
         SELECT id FROM individual
         WHERE generation_id IN (SELECT unhex(value) FROM json_each(?2)) AND operator = 'adopt')";

impl Store {
    /// Lists the outlines of a lineage's generations, the oldest first, those after `after_index`.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`](crate::StorageError::NotFound) if the lineage does not
    /// exist.
    pub async fn list_outlines(
        &self,
        lineage: LineageId,
        after_index: Option<u64>,
        limit: u32,
    ) -> Result<Vec<StoredOutline>> {
        let mut conn = self.snapshot().await?;
        crate::lineage::fetch(&mut conn, lineage).await?;
        let rest = ", centre_id FROM generation
             WHERE lineage_id = ? AND position > ? ORDER BY position LIMIT ?";
        let query = select::<StoredOutline>(rest).bind(lineage.key());
        let query = query.bind(after_index.map_or(-1, signed)).bind(limit);
        let rows = query.fetch_all(&mut conn).await?;
        let mut outlines = rows.iter().map(StoredOutline::read).collect::<Result<Vec<_>>>()?;

        let ids = key_set(outlines.iter().map(|one| &one.id));
        let first = select_individuals(FIRST).bind(ids.clone()).fetch_all(&mut conn).await?;
        let mut children = with_parents(&mut conn, &first).await?;
        let adopted = children.iter().filter(|one| one.operator == "adopt");
        let adopted = key_set(adopted.map(|one| &one.generation));
        let others = select_individuals(OTHERS).bind(ids).bind(adopted);
        let others = others.fetch_all(&mut conn).await?;
        children.extend(with_parents(&mut conn, &others).await?);
        children.sort_by_key(|one| one.slot);

        let centres = rows.iter().map(|row| row.column("centre_id"));
        let centres = centres.collect::<Result<Vec<Option<IndividualId>>>>()?;
        let wanted: Vec<_> = centres.iter().flatten().copied().collect();
        let found = fetch_all(&mut conn, &wanted).await?;
        let found: HashMap<_, _> = found.into_iter().map(|one| (one.id, one)).collect();
        let mut kept: HashMap<GenerationId, Vec<StoredIndividual>> = HashMap::new();
        for child in children {
            kept.entry(child.generation).or_default().push(child);
        }
        for (outline, centre) in outlines.iter_mut().zip(centres) {
            outline.centre = centre.and_then(|id| found.get(&id).cloned());
            outline.individuals = kept.remove(&outline.id).unwrap_or_default();
            if outline.centre.is_some() {
                outline.individuals.retain(|one| one.favourite || one.operator == "adopt");
            }
        }
        Ok(outlines)
    }
}
