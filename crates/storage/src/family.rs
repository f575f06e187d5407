//! Ancestors and descendants across lineages.

use std::collections::HashSet;

use brood_protocol::{IndividualId, ParentRef};

use crate::column::{Key, optional_key};
use crate::error::Result;
use crate::individual::{fetch, fetch_all, select_individuals, with_parents};
use crate::{Store, StoredIndividual};

/// Largest number of ancestors returned, for any depth.
const MAX_ANCESTORS: usize = 10_000;

/// Broods with the individual as a parent, then broods with parents in those broods, each brood
/// once. At most 10,000 broods; later ones are not found. Broods are ordered by age, so that
/// children are read only until the page is full.
const DESCENDANTS: &str = "WHERE individual.generation_id IN (
         WITH RECURSIVE brood (id) AS (
             SELECT generation_id FROM generation_parent WHERE individual_id = ?1
             UNION
             SELECT child.generation_id
             FROM brood
             JOIN generation_parent AS child ON child.parent_generation_id = brood.id
             /*sqlite*/ LIMIT 10000 /*end*/
         )
         SELECT id FROM brood /*pg: LIMIT 10000*/
     )
     AND (?2 IS NULL OR (individual.generation_id, individual.slot) > (?2, ?4))
     ORDER BY individual.generation_id, individual.slot LIMIT ?3";

impl Store {
    /// Returns the ancestors of an individual, without itself: parents first, then grandparents, up
    /// to `depth` steps and 10,000 individuals. Each is returned once, at its nearest place.
    ///
    /// # Errors
    /// Returns `StorageError::NotFound` if the individual does not exist.
    pub async fn ancestry(&self, id: IndividualId, depth: u32) -> Result<Vec<StoredIndividual>> {
        let mut conn = self.snapshot().await?;
        let mut level = vec![fetch(&mut conn, id).await?];
        let mut seen = HashSet::from([id]);
        let mut ancestors = Vec::new();
        // One query per level, not one recursive query: SQLite can only deduplicate rows by
        // (individual, depth), and with inbreeding the number of paths grows exponentially.
        for _ in 0..depth {
            let parents = level.iter().flat_map(|one| &one.parents);
            let wanted: Vec<_> = parents
                .filter_map(|parent| match parent {
                    ParentRef::Individual(id) => Some(*id),
                    ParentRef::Genome(_) => None,
                })
                .filter(|id| seen.insert(*id))
                .collect();
            if wanted.is_empty() {
                break;
            }
            let mut next = fetch_all(&mut conn, &wanted).await?;
            next.sort_by_key(|one| wanted.iter().position(|id| *id == one.id));
            next.truncate(MAX_ANCESTORS - ancestors.len());
            ancestors.extend(next.iter().cloned());
            if ancestors.len() == MAX_ANCESTORS {
                break;
            }
            level = next;
        }
        Ok(ancestors)
    }

    /// Returns the descendants of an individual in all lineages, the oldest first, after the
    /// cursor, from at most 10,000 broods.
    ///
    /// # Errors
    /// Returns `StorageError::NotFound` if the individual or that of the cursor does not exist.
    pub async fn descendants(
        &self,
        id: IndividualId,
        cursor: Option<IndividualId>,
        limit: u32,
    ) -> Result<Vec<StoredIndividual>> {
        let mut conn = self.snapshot().await?;
        fetch(&mut conn, id).await?;
        let after = match cursor {
            Some(cursor) => Some(fetch(&mut conn, cursor).await?),
            None => None,
        };
        let query = select_individuals(DESCENDANTS)
            .bind(id.key())
            .bind(optional_key(after.as_ref().map(|one| one.generation)))
            .bind(limit)
            .bind(after.map_or(0, |one| one.slot));
        let rows = query.fetch_all(&mut conn).await?;
        with_parents(&mut conn, &rows).await
    }
}
