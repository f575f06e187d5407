//! Import of a whole lineage in one transaction. Independent of the format of lineage files.

use std::sync::Arc;

use brood_protocol::{IndividualId, Lineage, PatchIndividual};

use crate::error::{Result, changed};
use crate::genome::Bases;
use crate::lineage;
use crate::row::Key;
use crate::writer::operation;
use crate::{
    Idempotency, NewGeneration, NewGenome, StorageError, Store, generation, genome, idempotency,
};

/// Lineage to be imported.
#[derive(Debug, Clone, PartialEq)]
pub struct NewImport {
    /// The lineage.
    pub lineage: Lineage,
    /// Genomes of parents that are not among its individuals.
    pub genomes: Vec<Arc<NewGenome>>,
    /// Generations, the oldest first.
    pub generations: Vec<NewGeneration>,
    /// Favourites and notes of its individuals.
    pub marks: Vec<(IndividualId, PatchIndividual)>,
    /// Individual that is the cover, if one was chosen.
    pub cover: Option<IndividualId>,
    /// Idempotency record to be stored with it.
    pub idempotency: Option<Idempotency>,
}

impl Store {
    /// Stores a lineage with its whole history, in one transaction.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if a scene, parent or marked individual does not exist,
    /// [`StorageError::Conflict`] if an id or the idempotency key is in use.
    pub async fn import_lineage(&self, new: NewImport) -> Result<Lineage> {
        self.write(operation!(|conn| {
            idempotency::insert(conn, new.idempotency.as_ref(), new.lineage.created_ms).await?;
            lineage::insert(conn, &new.lineage).await?;
            genome::insert(conn, &new.genomes, &Bases::default()).await?;
            for one in new.generations {
                generation::insert(conn, one).await?;
            }
            for (id, mark) in new.marks {
                let done = sqlx::query(
                    "UPDATE individual SET favourite = coalesce(?, favourite),
                         note = coalesce(?, note)
                     WHERE id = ?",
                )
                .bind(mark.favourite)
                .bind(mark.note)
                .bind(id.key())
                .execute(&mut *conn)
                .await?;
                changed(&done, StorageError::NotFound)?;
            }
            if let Some(cover) = new.cover {
                lineage::set_cover(conn, new.lineage.id, cover).await?;
            }
            lineage::fetch(conn, new.lineage.id).await
        }))
        .await
    }
}
