//! Uploaded meshes, identified by content. Owner of the table `mesh`. Independent of the format of
//! the data.

use brood_protocol::MeshId;

use crate::Store;
use crate::blob_store::BlobKind;
use crate::column::Key;
use crate::error::Result;
use crate::row::{Record, record, select, signed};
use crate::sql::query;
use crate::write::operation;

record! {
    /// Mesh without its data.
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
}

impl Store {
    /// Stores a mesh with its data, in the caller's format. Returns its id; equal content keeps its
    /// first id.
    ///
    /// # Errors
    /// Returns a `StorageError` if the write fails.
    pub async fn put_mesh(&self, mesh: StoredMesh, data: Vec<u8>) -> Result<MeshId> {
        let file = self.place_file(BlobKind::Mesh, data).await?;
        let object = file.object.clone();
        let stored = self.write(operation!(|conn| {
            file.admit(conn).await?;
            let inserted = query(
                "INSERT INTO mesh
                     (id, content_hash, vertices, triangles, has_uv, warnings_json, data, object)
                 VALUES (?, ?, ?, ?, ?, ?, ?, ?)
                 ON CONFLICT (content_hash) DO UPDATE
                     SET data = excluded.data, object = excluded.object
                     WHERE mesh.object IS NOT NULL",
            )
            .bind(mesh.id.key())
            .bind(mesh.content_hash.as_slice())
            .bind(signed(mesh.vertices))
            .bind(signed(mesh.triangles))
            .bind(mesh.has_uv)
            .bind(mesh.warnings_json)
            .bind(file.bytes)
            .bind(file.object)
            .execute(conn)
            .await?;
            let id = query("SELECT id FROM mesh WHERE content_hash = ?");
            let id = id.bind(mesh.content_hash.as_slice()).fetch_value(conn).await?;
            Ok((id, inserted > 0))
        }));
        let (id, is_new): (MeshId, bool) = stored.await?;
        if !is_new {
            self.discard_object(object);
        }
        Ok(id)
    }

    /// Returns a mesh without its data.
    ///
    /// # Errors
    /// Returns `StorageError::NotFound` if it does not exist.
    pub async fn mesh(&self, id: MeshId) -> Result<StoredMesh> {
        let query = select::<StoredMesh>("FROM mesh WHERE id = ?").bind(id.key());
        StoredMesh::read(&query.fetch_one(&mut self.reader().await?).await?)
    }

    /// Returns the data of a mesh.
    ///
    /// # Errors
    /// Returns `StorageError::NotFound` if it does not exist.
    pub async fn mesh_data(&self, content_hash: [u8; 32]) -> Result<Vec<u8>> {
        let sql = "SELECT data AS file, object FROM mesh WHERE content_hash = ?";
        let read = self.read_file(|| query(sql).bind(content_hash.as_slice()));
        Ok(read.await?.1)
    }
}
