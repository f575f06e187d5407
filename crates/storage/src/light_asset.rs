//! Light assets, identified by content. Owner of the table `light_asset`. Independent of the
//! content of files.

use brood_protocol::LightAssetKind;

use crate::Store;
use crate::error::Result;
use crate::sql::query;
use crate::write::operation;

impl Store {
    /// Stores a file. Equal files are stored once.
    ///
    /// # Errors
    /// Returns a `StorageError` if the write fails.
    pub async fn put_light_asset(
        &self,
        hash: [u8; 32],
        kind: LightAssetKind,
        bytes: Vec<u8>,
    ) -> Result<()> {
        self.write(operation!(|conn| {
            query(
                "INSERT INTO light_asset (hash, kind, bytes) VALUES (?, ?, ?)
                 ON CONFLICT (hash) DO NOTHING",
            )
            .bind(hash.as_slice())
            .bind(kind.name())
            .bind(bytes)
            .execute(conn)
            .await?;
            Ok(())
        }))
        .await
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
        let query = query("SELECT kind, bytes FROM light_asset WHERE hash = ?");
        let row = query.bind(hash.as_slice()).fetch_one(&mut self.reader().await?).await?;
        Ok((row.column("kind")?, row.column("bytes")?))
    }
}
