//! Import of a whole lineage, in slices. Independent of the format of lineage files.
//!
//! The lineage is unfinished until the last transaction: lists leave it out, and it is removed if
//! the import fails or the process ends.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use brood_genome::GenomeHash;
use brood_protocol::{IndividualId, Lineage, LineageId, ParentRef, PatchIndividual};

use crate::column::Key;
use crate::error::{Result, changed};
use crate::genome::Bases;
use crate::lineage::{self, Unfinished};
use crate::search_lease::PlacedCheckpoint;
use crate::slice::Pace;
use crate::sql::{Conn, GenomeUse, query};
use crate::write::{Durability, operation};
use crate::{
    Idempotency, NewGeneration, NewGenome, StorageError, Store, generation, genome, idempotency,
};

/// Number of individuals in the first transaction, and the most.
const INDIVIDUALS: u32 = 64;
const INDIVIDUALS_MAX: u32 = 8192;

/// Lineage to be imported.
#[derive(Debug, Clone, PartialEq)]
pub struct NewImport {
    /// The lineage.
    pub lineage: Lineage,
    /// Genomes of parents that are not among its individuals, by hash. Others are not stored.
    pub genomes: HashMap<GenomeHash, Arc<NewGenome>>,
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
    /// Stores a lineage with its whole history, or nothing. It is stored even if the caller does
    /// not wait for the end.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if a scene, parent or marked individual does not exist,
    /// [`StorageError::Conflict`] if an id or the idempotency key is in use.
    pub async fn import_lineage(&self, new: NewImport) -> Result<Lineage> {
        let store = self.clone();
        let import = tokio::spawn(async move {
            let id = new.lineage.id;
            let lineage = new.lineage.clone();
            store.write(operation!(|conn| insert_unfinished(conn, &lineage).await)).await?;
            let imported = store.import_rest(Arc::new(new)).await;
            if imported.is_err()
                && let Err(error) = store.remove_lineage(id).await
            {
                tracing::warn!(%id, %error, "a failed import is removed later");
            }
            imported
        });
        import.await.unwrap_or(Err(StorageError::Closed))
    }

    /// Stores everything but the row of the lineage, and finishes it.
    async fn import_rest(&self, new: Arc<NewImport>) -> Result<Lineage> {
        let mut pace = Pace::new(INDIVIDUALS, INDIVIDUALS_MAX);
        let mut start = 0;
        while start < new.generations.len() {
            let slice = generations_of(&new.generations, start, pace.size());
            start = slice.end;
            pace.adapt(
                self.write_slice(Durability::ProcessDeath, || {
                    let (new, slice) = (new.clone(), slice.clone());
                    operation!(|conn| insert_generations(conn, &new, slice).await)
                })
                .await?,
            );
        }
        let mut start = 0;
        while start < new.marks.len() {
            let slice = start..new.marks.len().min(start + pace.size() as usize);
            start = slice.end;
            pace.adapt(
                self.write_slice(Durability::ProcessDeath, || {
                    let (new, slice) = (new.clone(), slice.clone());
                    operation!(|conn| {
                        lineage::renew_unfinished(conn, new.lineage.id, Unfinished::Import).await?;
                        insert_marks(conn, &new.marks[slice]).await
                    })
                })
                .await?,
            );
        }
        self.write(operation!(|conn| {
            let lineage = &new.lineage;
            lineage::renew_unfinished(conn, lineage.id, Unfinished::Import).await?;
            idempotency::insert(conn, new.idempotency.as_ref(), lineage.created_ms).await?;
            if let Some(cover) = new.cover {
                lineage::set_cover(conn, lineage.id, cover).await?;
            }
            finish(conn, lineage.id).await?;
            lineage::fetch(conn, lineage.id).await
        }))
        .await
    }

    /// Returns the lineages whose import or removal has stopped, for this server to remove.
    /// With `all`, and on SQLite alone, those that the last process did not finish.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the write fails.
    pub async fn take_unfinished_lineages(&self, all: bool) -> Result<Vec<LineageId>> {
        let any = query("SELECT EXISTS (SELECT 1 FROM unfinished_lineage)");
        let any: bool = any.fetch_value(&mut self.reader().await?).await?;
        if !any {
            return Ok(Vec::new());
        }
        self.write(operation!(|conn| lineage::take_unfinished(conn, all).await)).await
    }
}

/// Returns the generations from `start` that have at most this number of individuals together, but
/// at least one generation.
fn generations_of(generations: &[NewGeneration], start: usize, individuals: u32) -> Range<usize> {
    let mut left = individuals as usize;
    let within = generations[start..].iter().take_while(|one| {
        let fits = one.individuals.len() <= left;
        left = left.saturating_sub(one.individuals.len());
        fits
    });
    let count = within.count().max(1);
    start..start + count
}

async fn insert_unfinished(conn: &mut Conn, new: &Lineage) -> Result<()> {
    lineage::insert(conn, new).await?;
    lineage::set_unfinished(conn, new.id, Unfinished::Import).await
}

async fn insert_generations(
    conn: &mut Conn,
    new: &NewImport,
    slice: Range<usize>,
) -> Result<Duration> {
    let start = Instant::now();
    conn.lock_genomes(GenomeUse::Birth).await?;
    lineage::renew_unfinished(conn, new.lineage.id, Unfinished::Import).await?;
    for one in &new.generations[slice] {
        let own = one.parents.iter().filter_map(|parent| match parent {
            ParentRef::Genome(hash) => new.genomes.get(hash).cloned(),
            ParentRef::Individual(_) => None,
        });
        let own: Vec<_> = own.collect();
        genome::insert(conn, &own, &Bases::default()).await?;
        generation::insert(conn, one.clone(), PlacedCheckpoint::default()).await?;
    }
    Ok(start.elapsed())
}

async fn insert_marks(
    conn: &mut Conn,
    marks: &[(IndividualId, PatchIndividual)],
) -> Result<Duration> {
    let start = Instant::now();
    for (id, mark) in marks {
        let done = query(
            "UPDATE individual SET favourite = coalesce(?, favourite), note = coalesce(?, note)
             WHERE id = ?",
        )
        .bind(mark.favourite)
        .bind(mark.note.as_deref())
        .bind(id.key())
        .execute(conn)
        .await?;
        changed(done, StorageError::NotFound)?;
    }
    Ok(start.elapsed())
}

async fn finish(conn: &mut Conn, id: LineageId) -> Result<()> {
    for sql in [
        "DELETE FROM unfinished_lineage WHERE lineage_id = ?",
        "UPDATE lineage SET hidden = FALSE WHERE id = ?",
    ] {
        query(sql).bind(id.key()).execute(conn).await?;
    }
    Ok(())
}
