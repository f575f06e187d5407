//! Client of the object store of large files. Objects are never changed, and no name is used twice,
//! so that an object may be removed while others with the same content are written.

use std::time::Duration;

use bytes::Bytes;
use futures::future::ready;
use futures::stream::BoxStream;
use futures::{StreamExt as _, TryStreamExt as _};
use object_store::aws::{AmazonS3, AmazonS3Builder};
use object_store::path::Path;
use object_store::{
    BackoffConfig, Error, ObjectStore, ObjectStoreExt as _, PutMode, PutOptions, PutPayload,
    RetryConfig,
};
use tokio::sync::OnceCell;
use tokio::time::timeout;
use uuid::Uuid;

use crate::StorageError;
use crate::blob_address::BlobAddress;
use crate::blob_http::BlobClient;
use crate::error::Result;

/// Time for one call with its retries, besides that for the bytes of an upload. Shorter than a
/// lease, in which a checkpoint is read.
const CALL: Duration = Duration::from_secs(12);
/// Least bytes of an upload that are sent in a second.
const LEAST_BYTES_PER_S: usize = 1 << 20;
/// Time in which a failed request is sent again.
const RETRY: Duration = Duration::from_secs(6);
/// Objects of a page of a list.
const PAGE: usize = 1000;
/// Most bytes of an object. No report of a worker has more.
const MOST_BYTES: u64 = 256 << 20;
/// Longest description of a failure.
const REASON_CHARS: usize = 300;
/// Folder of objects that only test the store.
const PROBE: &str = "probe";
/// Object with the name of the database that owns the folder.
const OWNER: &str = "owner";

/// Kind of the files in a folder of the store.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum BlobKind {
    Target,
    LightAsset,
    Mesh,
    Checkpoint,
}

impl BlobKind {
    const ALL: [Self; 4] = [Self::Target, Self::LightAsset, Self::Mesh, Self::Checkpoint];

    fn folder(self) -> &'static str {
        match self {
            Self::Target => "targets",
            Self::LightAsset => "light-assets",
            Self::Mesh => "meshes",
            Self::Checkpoint => "checkpoints",
        }
    }
}

/// Name and age of an object.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct FoundBlob {
    /// Name of the object.
    pub name: String,
    /// Time of its last change by the clock of the store, in milliseconds since 1970-01-01 UTC.
    pub changed_ms: i64,
}

/// Object store of one database.
#[derive(Debug)]
pub(crate) struct Blobs {
    store: AmazonS3,
    address: BlobAddress,
    /// Set once the database is known to own the folder.
    pub confirmed: OnceCell<()>,
}

impl Blobs {
    /// Prepares a client. `variables` are those of the environment: `AWS_ENDPOINT`, `AWS_REGION`,
    /// `AWS_ACCESS_KEY_ID` and so on.
    ///
    /// # Errors
    /// Returns [`StorageError::Unsupported`] if a variable has an invalid value.
    pub fn open(address: &BlobAddress, variables: &[(String, String)]) -> Result<Self> {
        let authorities = variables.iter().find(|(name, _)| name == "AWS_CA_BUNDLE");
        let client = BlobClient::new(authorities.map(|(_, file)| file.as_str()))?;
        let mut builder = AmazonS3Builder::new();
        for (name, value) in variables.iter().filter(|(name, _)| name.starts_with("AWS_")) {
            // Others are for other programs.
            if let Ok(key) = name.to_ascii_lowercase().parse() {
                builder = builder.with_config(key, value);
            }
        }
        let backoff = BackoffConfig {
            init_backoff: Duration::from_millis(100),
            max_backoff: Duration::from_secs(1),
            base: 2.0,
        };
        let store = builder
            .with_bucket_name(address.bucket())
            .with_http_connector(client)
            .with_retry(RetryConfig { backoff, max_retries: 8, retry_timeout: RETRY })
            // Stores differ in how they check requests for several objects.
            .with_disable_bulk_delete(true)
            .build()
            .map_err(|error| {
                StorageError::Unsupported(format!("the object store {address}: {error}"))
            })?;
        Ok(Self { store, address: address.clone(), confirmed: OnceCell::new() })
    }

    /// Address of the store.
    pub fn address(&self) -> &BlobAddress {
        &self.address
    }

    /// Stores an object. Returns its name, which has the hash of the content.
    ///
    /// # Errors
    /// Returns [`StorageError::BlobsUnreachable`] if the store does not take it.
    pub async fn put(&self, kind: BlobKind, bytes: Vec<u8>) -> Result<String> {
        self.put_in(kind.folder(), bytes).await
    }

    async fn put_in(&self, folder: &str, bytes: Vec<u8>) -> Result<String> {
        let (hash, bytes) = hashed(bytes.into()).await?;
        let name = format!("{folder}/{}-{}", Uuid::now_v7(), hash.to_hex());
        let path = self.path(&name);
        let limit = CALL + Duration::from_secs((bytes.len() / LEAST_BYTES_PER_S) as u64);
        let payload = PutPayload::from(bytes);
        self.call_within(limit, async { self.store.put(&path, payload).await.map(drop) }).await?;
        Ok(name)
    }

    /// Returns an object; `None` if there is none of this name.
    ///
    /// # Errors
    /// Returns [`StorageError::BlobsUnreachable`] if the store does not answer,
    /// [`StorageError::BlobDamaged`] if the object has another content than it was stored with.
    pub async fn get(&self, name: &str) -> Result<Option<Vec<u8>>> {
        let path = self.path(name);
        let found = self.call(async {
            match self.store.get(&path).await {
                Ok(found) if found.meta.size > MOST_BYTES => Ok(Some(Bytes::new())),
                Ok(found) => found.bytes().await.map(Some),
                Err(Error::NotFound { source, .. }) if is_missing(&*source) => Ok(None),
                Err(error) => Err(error),
            }
        });
        let Some(bytes) = found.await? else { return Ok(None) };
        let (hash, bytes) = hashed(bytes).await?;
        if hash_of(name) == Some(hash) {
            return Ok(Some(bytes.into()));
        }
        Err(StorageError::BlobDamaged(format!("{}/{name}", self.address)))
    }

    /// Removes an object, if there is one of this name.
    ///
    /// # Errors
    /// Returns [`StorageError::BlobsUnreachable`] if the store does not answer.
    pub async fn remove(&self, name: &str) -> Result<()> {
        let path = self.path(name);
        self.call(async {
            match self.store.delete(&path).await {
                Err(Error::NotFound { .. }) => Ok(()),
                removed => removed,
            }
        })
        .await
    }

    /// Writes, reads and removes an object. Returns the time of the store's clock, in milliseconds
    /// since 1970-01-01 UTC.
    ///
    /// # Errors
    /// Returns [`StorageError::BlobsUnreachable`] if the store refuses one of them.
    pub async fn probe(&self) -> Result<i64> {
        let name = self.put_in(PROBE, b"brood".to_vec()).await?;
        let path = self.path(&name);
        let found = self.call(async { self.store.head(&path).await }).await?;
        let read = self.get(&name).await?;
        self.remove(&name).await?;
        match read {
            Some(_) => Ok(found.last_modified.timestamp_millis()),
            None => Err(self.unreachable("an object that was stored cannot be read")),
        }
    }

    /// Returns the name of the database that owns the folder; `None` if none does.
    ///
    /// # Errors
    /// Returns [`StorageError::BlobsUnreachable`] if the store does not answer.
    pub async fn owner(&self) -> Result<Option<String>> {
        let path = self.path(OWNER);
        let found = self.call(async {
            match self.store.get(&path).await {
                Ok(found) => found.bytes().await.map(Some),
                Err(Error::NotFound { source, .. }) if is_missing(&*source) => Ok(None),
                Err(error) => Err(error),
            }
        });
        Ok(found.await?.map(|name| String::from_utf8_lossy(&name).into_owned()))
    }

    /// Makes a database the owner of the folder, unless it has an owner. Returns the owner.
    ///
    /// # Errors
    /// Returns [`StorageError::BlobsUnreachable`] if the store does not take it.
    pub async fn claim(&self, name: &str) -> Result<Option<String>> {
        let (path, payload) = (self.path(OWNER), PutPayload::from(name.to_owned()));
        self.call(async {
            let create = PutOptions::from(PutMode::Create);
            match self.store.put_opts(&path, payload.clone(), create).await {
                Ok(_) | Err(Error::AlreadyExists { .. }) => Ok(()),
                // Some stores refuse the condition.
                Err(_) => self.store.put(&path, payload).await.map(drop),
            }
        })
        .await?;
        self.owner().await
    }

    /// Overwrites an object, or `owner`.
    #[cfg(test)]
    pub async fn overwrite(&self, name: &str, bytes: &'static str) {
        self.store.put(&self.path(name), PutPayload::from(bytes)).await.unwrap();
    }

    /// Lists objects of this module, page by page.
    pub fn list(&self) -> BoxStream<'_, Result<Vec<FoundBlob>>> {
        let folder = Path::from(self.address.path(""));
        let listed = self.store.list(Some(&folder)).map_err(|error| self.unreachable(root(&error)));
        let listed = listed.try_filter_map(|found| {
            let name = self.address.name(found.location.as_ref()).filter(|name| is_own(name));
            let changed_ms = found.last_modified.timestamp_millis();
            ready(Ok(name.map(|name| FoundBlob { name: name.to_owned(), changed_ms })))
        });
        listed.try_chunks(PAGE).map_err(|error| error.1).boxed()
    }

    fn path(&self, name: &str) -> Path {
        Path::from(self.address.path(name))
    }

    /// Makes a call within the usual time.
    async fn call<T>(
        &self,
        call: impl Future<Output = object_store::Result<T>> + Send,
    ) -> Result<T> {
        self.call_within(CALL, call).await
    }

    async fn call_within<T>(
        &self,
        limit: Duration,
        call: impl Future<Output = object_store::Result<T>> + Send,
    ) -> Result<T> {
        match timeout(limit, call).await {
            Ok(Ok(answer)) => Ok(answer),
            Ok(Err(error)) => Err(self.unreachable(root(&error))),
            Err(_) => Err(self.unreachable(format!("no answer within {} s", limit.as_secs()))),
        }
    }

    /// Error of a store that cannot be used. Logs it.
    pub fn unreachable(&self, reason: impl std::fmt::Display) -> StorageError {
        let reason = reason.to_string().replace('\n', " ");
        let reason: String = reason.chars().take(REASON_CHARS).collect();
        let store = self.address.to_string();
        tracing::warn!(store, reason, "the object store cannot be used");
        StorageError::BlobsUnreachable(format!("{store}: {reason}"))
    }
}

/// Returns the first cause of an error: the others repeat the names of the object.
fn root(error: &Error) -> &dyn std::error::Error {
    let mut cause: &dyn std::error::Error = error;
    while let Some(source) = cause.source() {
        cause = source;
    }
    cause
}

/// True if the reason of a 404 is that the object is missing, and neither the bucket nor the path
/// of the store.
fn is_missing(source: &(dyn std::error::Error + Send + Sync)) -> bool {
    source.to_string().contains("NoSuchKey")
}

/// Returns the hash of bytes, computed outside the tasks of requests.
async fn hashed(bytes: Bytes) -> Result<(blake3::Hash, Bytes)> {
    let hash = tokio::task::spawn_blocking(move || (blake3::hash(&bytes), bytes));
    hash.await.map_err(|_| StorageError::Closed)
}

/// Returns the hash that is the end of an object's name.
fn hash_of(name: &str) -> Option<blake3::Hash> {
    blake3::Hash::from_hex(name.rsplit_once('-')?.1).ok()
}

/// True if a name is one that this module gives, so that the object may be removed.
fn is_own(name: &str) -> bool {
    let Some((folder, rest)) = name.split_once('/') else { return false };
    let is_known = BlobKind::ALL.into_iter().any(|kind| kind.folder() == folder);
    let is_uuid = |text: &str| Uuid::try_parse(text).is_ok();
    (is_known || folder == PROBE)
        && hash_of(rest).is_some()
        && rest.rsplit_once('-').is_some_and(|(id, _)| is_uuid(id))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_objects_of_brood_are_own() {
        let (id, hash) = (Uuid::now_v7(), blake3::hash(b"x").to_hex());
        assert!(is_own(&format!("targets/{id}-{hash}")));
        assert!(is_own(&format!("probe/{id}-{hash}")));
        for other in [
            format!("others/{id}-{hash}"),
            format!("targets/{hash}"),
            format!("targets/a/{id}-{hash}"),
            format!("targets/{id}-abc"),
            "picture.png".to_owned(),
        ] {
            assert!(!is_own(&other), "{other}");
        }
    }

    #[test]
    fn invalid_variables_are_refused() {
        let address = "s3://studio".parse().unwrap();
        let variables = |pairs: &[(&str, &str)]| -> Vec<(String, String)> {
            pairs.iter().map(|(name, value)| ((*name).into(), (*value).into())).collect()
        };
        let half = variables(&[("AWS_ACCESS_KEY_ID", "a"), ("AWS_PAGER", "less")]);
        assert!(matches!(Blobs::open(&address, &half), Err(StorageError::Unsupported(_))));
        let missing = variables(&[("AWS_CA_BUNDLE", "/no/such/file")]);
        assert!(matches!(Blobs::open(&address, &missing), Err(StorageError::Unsupported(_))));
    }
}
