//! Scenes, identified by content. Owner of the table `scene`. Independent of the content of the
//! JSON text.

use brood_genome::GenomeHash;
use brood_protocol::SceneId;

use crate::column::Key;
use crate::error::{Result, changed};
use crate::sql::{GenomeUse, query};
use crate::write::operation;
use crate::{StorageError, Store};

impl Store {
    /// Stores a scene. Returns its id; equal JSON (by its hash) keeps its first id. The genomes
    /// that it names as materials are kept from now on, even when all individuals with them are
    /// removed.
    ///
    /// # Errors
    /// Returns `StorageError::NotFound` if one of the genomes does not exist.
    pub async fn put_scene(
        &self,
        json: &str,
        hash: [u8; 32],
        materials: &[GenomeHash],
        created_ms: i64,
    ) -> Result<SceneId> {
        let (json, mut materials) = (json.to_owned(), materials.to_vec());
        // Sorted, so that two transactions with the same genomes cannot wait for each other.
        materials.sort_unstable();
        self.write(operation!(|conn| {
            conn.lock_genomes(GenomeUse::Birth).await?;
            for material in &materials {
                let keep = query("UPDATE genome SET kept = TRUE WHERE hash = ?");
                let done = keep.bind(material.key()).execute(conn).await?;
                changed(done, StorageError::NotFound)?;
            }
            query(
                "INSERT INTO scene (id, content_hash, created_ms, json) VALUES (?, ?, ?, ?)
                 ON CONFLICT (content_hash) DO NOTHING",
            )
            .bind(SceneId::fresh().key())
            .bind(hash.as_slice())
            .bind(created_ms)
            .bind(json)
            .execute(conn)
            .await?;
            query("SELECT id FROM scene WHERE content_hash = ?")
                .bind(hash.as_slice())
                .fetch_one(conn)
                .await?
                .column("id")
        }))
        .await
    }

    /// Returns the JSON text of a scene.
    ///
    /// # Errors
    /// Returns `StorageError::NotFound` if it does not exist.
    pub async fn scene(&self, id: SceneId) -> Result<String> {
        let query = query("SELECT json FROM scene WHERE id = ?");
        query.bind(id.key()).fetch_value(&mut self.reader().await?).await
    }
}
