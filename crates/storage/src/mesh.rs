//! Uploaded meshes by content. Owns the table `mesh`; refuses to know how the data is laid out.

use brood_protocol::MeshId;

use crate::row::{Columns, Key, signed};
use crate::{StorageError, Store};

/// A mesh to be stored.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewMesh {
    /// Its id, unless the same content has one already.
    pub id: MeshId,
    /// Hash of the content.
    pub content_hash: [u8; 32],
    /// Vertices after joining equal corners.
    pub vertices: u64,
    /// Triangles.
    pub triangles: u64,
    /// Whether the file had texture coordinates.
    pub has_uv: bool,
    /// What was odd, as JSON.
    pub warnings_json: String,
    /// The mesh itself, in whatever form the caller reads.
    pub data: Vec<u8>,
}

/// A stored mesh without its data.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MeshRow {
    /// Its id.
    pub id: MeshId,
    /// Hash of the content.
    pub content_hash: [u8; 32],
    /// Vertices after joining equal corners.
    pub vertices: u64,
    /// Triangles.
    pub triangles: u64,
    /// Whether the file had texture coordinates.
    pub has_uv: bool,
    /// What was odd, as JSON.
    pub warnings_json: String,
}

impl Store {
    /// Stores a mesh; the same content keeps the id that it got the first time.
    pub async fn put_mesh(&self, mesh: NewMesh) -> Result<MeshId, StorageError> {
        self.write(move |conn| {
            Box::pin(async move {
                sqlx::query(
                    "INSERT INTO mesh
                         (id, content_hash, vertices, triangles, has_uv, warnings_json, data)
                     VALUES (?, ?, ?, ?, ?, ?, ?) ON CONFLICT (content_hash) DO NOTHING",
                )
                .bind(mesh.id.key())
                .bind(mesh.content_hash.as_slice())
                .bind(signed(mesh.vertices))
                .bind(signed(mesh.triangles))
                .bind(mesh.has_uv)
                .bind(mesh.warnings_json)
                .bind(mesh.data)
                .execute(&mut *conn)
                .await?;
                sqlx::query("SELECT id FROM mesh WHERE content_hash = ?")
                    .bind(mesh.content_hash.as_slice())
                    .fetch_one(conn)
                    .await?
                    .id("id")
            })
        })
        .await
    }

    /// A mesh without its data.
    pub async fn mesh(&self, id: MeshId) -> Result<MeshRow, StorageError> {
        let row = sqlx::query(
            "SELECT id, content_hash, vertices, triangles, has_uv, warnings_json
             FROM mesh WHERE id = ?",
        )
        .bind(id.key())
        .fetch_one(&mut *self.reader().await?)
        .await?;
        Ok(MeshRow {
            id: row.id("id")?,
            content_hash: row.hash("content_hash")?,
            vertices: row.whole("vertices")?,
            triangles: row.whole("triangles")?,
            has_uv: row.flag("has_uv")?,
            warnings_json: row.text("warnings_json")?,
        })
    }

    /// The data of a mesh.
    pub async fn mesh_data(&self, content_hash: [u8; 32]) -> Result<Vec<u8>, StorageError> {
        let query = sqlx::query_scalar("SELECT data FROM mesh WHERE content_hash = ?");
        Ok(query.bind(content_hash.as_slice()).fetch_one(&mut *self.reader().await?).await?)
    }
}
