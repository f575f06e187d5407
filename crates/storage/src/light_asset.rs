//! Light assets, identified by content. Owner of the table `light_asset`. Independent of the
//! content of files.

use brood_protocol::LightAssetKind;

use crate::Store;
use crate::blob_store::BlobKind;
use crate::error::Result;
use crate::sql::query;
use crate::write::operation;

impl Store {
    /// Stores a file. Equal files are stored once; the last one replaces its object, which may be
    /// lost.
    ///
    /// # Errors
    /// Returns a `StorageError` if the write fails.
    pub async fn put_light_asset(
        &self,
        hash: [u8; 32],
        kind: LightAssetKind,
        bytes: Vec<u8>,
    ) -> Result<()> {
        let file = self.place_file(BlobKind::LightAsset, bytes).await?;
        let object = file.object.clone();
        let inserted = self.write(operation!(|conn| {
            file.admit(conn).await?;
            query(
                "INSERT INTO light_asset (hash, kind, bytes, object) VALUES (?, ?, ?, ?)
                 ON CONFLICT (hash) DO UPDATE SET bytes = excluded.bytes, object = excluded.object
                     WHERE light_asset.object IS NOT NULL",
            )
            .bind(hash.as_slice())
            .bind(kind.name())
            .bind(file.bytes)
            .bind(file.object)
            .execute(conn)
            .await
        }));
        if inserted.await? == 0 {
            self.discard_object(object);
        }
        Ok(())
    }

    /// Returns the kind of a file.
    ///
    /// # Errors
    /// Returns `StorageError::NotFound` if it does not exist.
    pub async fn light_asset_kind(&self, hash: [u8; 32]) -> Result<LightAssetKind> {
        let query = query("SELECT kind FROM light_asset WHERE hash = ?");
        let row = query.bind(hash.as_slice()).fetch_one(&mut self.reader().await?).await?;
        row.column("kind")
    }

    /// Returns a file and its kind.
    ///
    /// # Errors
    /// Returns `StorageError::NotFound` if it does not exist.
    pub async fn light_asset(&self, hash: [u8; 32]) -> Result<(LightAssetKind, Vec<u8>)> {
        let sql = "SELECT kind, bytes AS file, object FROM light_asset WHERE hash = ?";
        let (row, bytes) = self.read_file(|| query(sql).bind(hash.as_slice())).await?;
        Ok((row.column("kind")?, bytes))
    }
}
