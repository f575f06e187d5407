//! The family tree across lineages. Owns the walks along parents and children; refuses to know how individuals are
//! stored.

use std::collections::HashSet;

use brood_protocol::{IndividualId, ParentRef};

use crate::individual::{fetch, fetch_all, select_individual, with_parents};
use crate::row::Key;
use crate::{StorageError, Store, StoredIndividual};

/// More ancestors are not given, whatever the depth asked for.
const MAX_ANCESTORS: usize = 10_000;

/// Broods whose parents are an individual, then broods with parents in those broods, each brood once however many ways
/// lead to it. The bound is on broods; what is beyond it is not found.
const DESCENDANTS: &str = select_individual!(
    "WHERE individual.generation_id IN (
         WITH RECURSIVE brood (id) AS (
             SELECT generation_id FROM generation_parent WHERE individual_id = ?1
             UNION
             SELECT child.generation_id
             FROM brood
             JOIN individual AS parent ON parent.generation_id = brood.id
             JOIN generation_parent AS child ON child.individual_id = parent.id
             LIMIT 10000
         )
         SELECT id FROM brood
     )
     AND (?2 IS NULL OR individual.id > ?2)
     ORDER BY individual.id LIMIT ?3"
);

impl Store {
    /// The ancestors of an individual, itself left out: parents first, then grandparents, `depth` steps at most and
    /// 10,000 individuals at most. Each is given once, where it is nearest.
    pub async fn ancestry(
        &self,
        id: IndividualId,
        depth: u32,
    ) -> Result<Vec<StoredIndividual>, StorageError> {
        let mut conn = self.snapshot().await?;
        let mut level = vec![fetch(&mut conn, id).await?];
        let mut seen = HashSet::from([id]);
        let mut ancestors = Vec::new();
        // Level by level rather than in one recursive query: SQLite can tell rows apart by (individual, depth) only,
        // and there are as many of those as there are ways up when relatives are bred.
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

    /// The descendants of an individual, eldest first, after the cursor: its children, their children and so on, in
    /// all lineages, from at most 10,000 broods.
    pub async fn descendants(
        &self,
        id: IndividualId,
        cursor: Option<IndividualId>,
        limit: u32,
    ) -> Result<Vec<StoredIndividual>, StorageError> {
        let mut conn = self.snapshot().await?;
        fetch(&mut conn, id).await?;
        let rows = sqlx::query(DESCENDANTS)
            .bind(id.key())
            .bind(cursor.map(|cursor| cursor.key().to_vec()))
            .bind(limit)
            .fetch_all(&mut *conn)
            .await?;
        with_parents(&mut conn, &rows).await
    }
}
