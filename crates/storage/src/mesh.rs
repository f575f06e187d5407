//! Uploaded meshes, identified by content. Owner of the table `mesh`. Independent of the format of
//! the data.

use brood_protocol::MeshId;

use crate::row::{Columns, Key, signed};
use crate::{StorageError, Store};

/// Mesh to be stored.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewMesh {
    /// Id of the mesh, unless a mesh with the same content exists.
    pub id: MeshId,
    /// Hash of the content.
    pub content_hash: [u8; 32],
    /// Number of vertices after merging equal corners.
    pub vertices: u64,
    /// Number of triangles.
    pub triangles: u64,
    /// True if the file has texture coordinates.
    pub has_uv: bool,
    /// Warnings of the parser, as JSON.
    pub warnings_json: String,
    /// Mesh data, in the caller's format.
    pub data: Vec<u8>,
}

/// Stored mesh without its data.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredMesh {
    /// Id of the mesh.
    pub id: MeshId,
    /// Hash of the content.
    pub content_hash: [u8; 32],
    /// Number of vertices after merging equal corners.
    pub vertices: u64,
    /// Number of triangles.
    pub triangles: u64,
    /// True if the file has texture coordinates.
    pub has_uv: bool,
    /// Warnings of the parser, as JSON.
    pub warnings_json: String,
}

impl Store {
    /// Stores a mesh. Returns its id; equal content keeps its first id.
    ///
    /// # Errors
    /// Returns a [`StorageError`] if the write fails.
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

    /// Returns a mesh without its data.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if it does not exist.
    pub async fn mesh(&self, id: MeshId) -> Result<StoredMesh, StorageError> {
        let row = sqlx::query(
            "SELECT id, content_hash, vertices, triangles, has_uv, warnings_json
             FROM mesh WHERE id = ?",
        )
        .bind(id.key())
        .fetch_one(&mut *self.reader().await?)
        .await?;
        Ok(StoredMesh {
            id: row.id("id")?,
            content_hash: row.hash("content_hash")?,
            vertices: row.whole("vertices")?,
            triangles: row.whole("triangles")?,
            has_uv: row.flag("has_uv")?,
            warnings_json: row.text("warnings_json")?,
        })
    }

    /// Returns the data of a mesh.
    ///
    /// # Errors
    /// Returns [`StorageError::NotFound`] if it does not exist.
    pub async fn mesh_data(&self, content_hash: [u8; 32]) -> Result<Vec<u8>, StorageError> {
        let query = sqlx::query_scalar("SELECT data FROM mesh WHERE content_hash = ?");
        Ok(query.bind(content_hash.as_slice()).fetch_one(&mut *self.reader().await?).await?)
    }
}
