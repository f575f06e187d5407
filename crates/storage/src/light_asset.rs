//! Files that lights refer to, by content. Owns the table `light_asset`; refuses to know what is in them.

use brood_protocol::LightAssetKind;

use crate::row::Columns;
use crate::{StorageError, Store};

impl Store {
    /// Stores a file; the same bytes are stored once.
    pub async fn put_light_asset(
        &self,
        hash: [u8; 32],
        kind: LightAssetKind,
        bytes: Vec<u8>,
    ) -> Result<(), StorageError> {
        self.write(move |conn| {
            Box::pin(async move {
                sqlx::query(
                    "INSERT INTO light_asset (hash, kind, bytes) VALUES (?, ?, ?)
                     ON CONFLICT (hash) DO NOTHING",
                )
                .bind(hash.as_slice())
                .bind(kind.name())
                .bind(bytes)
                .execute(conn)
                .await?;
                Ok(())
            })
        })
        .await
    }

    /// What kind of file it is.
    pub async fn light_asset_kind(&self, hash: [u8; 32]) -> Result<LightAssetKind, StorageError> {
        let query = sqlx::query("SELECT kind FROM light_asset WHERE hash = ?");
        let row = query.bind(hash.as_slice()).fetch_one(&mut *self.reader().await?).await?;
        kind(&row)
    }

    /// A file and its kind.
    pub async fn light_asset(
        &self,
        hash: [u8; 32],
    ) -> Result<(LightAssetKind, Vec<u8>), StorageError> {
        let query = sqlx::query("SELECT kind, bytes FROM light_asset WHERE hash = ?");
        let row = query.bind(hash.as_slice()).fetch_one(&mut *self.reader().await?).await?;
        Ok((kind(&row)?, row.blob("bytes")?))
    }
}

fn kind(row: &sqlx::sqlite::SqliteRow) -> Result<LightAssetKind, StorageError> {
    let name = row.text("kind")?;
    LightAssetKind::from_name(&name)
        .ok_or_else(|| StorageError::Corrupt("light_asset.kind".to_owned()))
}
