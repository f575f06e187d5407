//! Scenes by content. Owns the table `scene`; refuses to know what the JSON says.

use brood_protocol::SceneId;

use crate::row::{Columns, Key};
use crate::{StorageError, Store};

impl Store {
    /// Stores a scene; equal JSON, told by its hash, gets the id that it got the first time.
    pub async fn put_scene(
        &self,
        json: &str,
        hash: [u8; 32],
        created_ms: i64,
    ) -> Result<SceneId, StorageError> {
        let json = json.to_owned();
        self.write(move |conn| {
            Box::pin(async move {
                sqlx::query(
                    "INSERT INTO scene (id, content_hash, created_ms, json) VALUES (?, ?, ?, ?)
                     ON CONFLICT (content_hash) DO NOTHING",
                )
                .bind(SceneId::fresh().key())
                .bind(hash.as_slice())
                .bind(created_ms)
                .bind(json)
                .execute(&mut *conn)
                .await?;
                sqlx::query("SELECT id FROM scene WHERE content_hash = ?")
                    .bind(hash.as_slice())
                    .fetch_one(conn)
                    .await?
                    .id("id")
            })
        })
        .await
    }

    /// The JSON of a scene.
    pub async fn scene(&self, id: SceneId) -> Result<String, StorageError> {
        let query = sqlx::query_scalar("SELECT json FROM scene WHERE id = ?");
        Ok(query.bind(id.key()).fetch_one(&mut *self.reader().await?).await?)
    }
}
