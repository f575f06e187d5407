//! What lights of scenes refer to: checked when a scene comes in, read when this process renders one itself.
//!
//! A name in a scene is the hash of a file, so what it stands for never changes.

use std::sync::Arc;

use brood_eval::decode_environment;
use brood_protocol::LightAssetKind;
use brood_scene::{AssetRef, IesProfile, Light, LightAssets, Scene};
use brood_storage::{StorageError, Store};

use crate::limit;
use crate::problem::{ApiError, quote};

/// Refuses a scene whose lights refer to files that are not here, or make more samples than pictures can wait for.
pub async fn check(store: &Store, scene: &Scene) -> Result<(), ApiError> {
    let samples = scene.light_samples();
    if samples > limit::LIGHT_SAMPLES {
        let words = format!(
            "the lights make {samples} samples at one place; {} is the most here",
            limit::LIGHT_SAMPLES
        );
        return Err(ApiError::refused(words).at("/lights"));
    }
    for (index, light) in scene.lights.iter().enumerate() {
        let Some(asset) = light.asset() else { continue };
        let (field, name, wanted) = parts(asset);
        let pointer = format!("/lights/{index}/{field}");
        let found = match hash(name) {
            Some(hash) => store.light_asset_kind(hash).await,
            None => Err(StorageError::NotFound),
        };
        match found {
            Ok(kind) if kind == wanted => {}
            Ok(kind) => {
                let words = format!("this is the id of an {}", kind.name());
                return Err(ApiError::refused(words).at(pointer));
            }
            Err(StorageError::NotFound) => {
                let words = format!(
                    "there is no {} {}; POST /v1/{}s answers the id of one",
                    wanted.name(),
                    quote(name),
                    wanted.name()
                );
                return Err(ApiError::not_found(words).at(pointer));
            }
            Err(error) => return Err(error.into()),
        }
    }
    Ok(())
}

/// What the lights of a checked scene refer to.
pub async fn load(store: &Store, scene: &Scene) -> Result<LightAssets, ApiError> {
    let mut assets = LightAssets::default();
    for asset in scene.lights.iter().filter_map(Light::asset) {
        let (_, name, _) = parts(asset);
        let hash = hash(name).ok_or_else(|| ApiError::internal("a light's file has no hash"))?;
        let (kind, bytes) = store.light_asset(hash).await?;
        let damaged = |error: String| {
            ApiError::internal(format!("a stored {} cannot be read: {error}", kind.name()))
        };
        match kind {
            LightAssetKind::Profile => {
                let read = IesProfile::parse(&bytes).map_err(|error| damaged(error.to_string()))?;
                assets.insert_profile(name, Arc::new(read));
            }
            LightAssetKind::Environment => {
                let read = tokio::task::spawn_blocking(move || decode_environment(&bytes)).await;
                let read = read.map_err(|error| ApiError::internal(error.to_string()))?;
                let read = read.map_err(|error| damaged(error.to_string()))?;
                assets.insert_environment(name, Arc::new(read));
            }
        }
    }
    Ok(assets)
}

/// The file of that name, as it was uploaded.
pub async fn file(store: &Store, name: &str) -> Result<Vec<u8>, ApiError> {
    let hash = hash(name).ok_or_else(|| ApiError::internal("a light's file has no hash"))?;
    Ok(store.light_asset(hash).await?.1)
}

/// The files of a scene's lights, each once, with the hash that names it.
pub fn files(scene: &Scene) -> Vec<[u8; 32]> {
    let mut hashes: Vec<[u8; 32]> =
        scene.lights.iter().filter_map(|light| hash(parts(light.asset()?).1)).collect();
    hashes.sort_unstable();
    hashes.dedup();
    hashes
}

fn parts(asset: AssetRef<'_>) -> (&'static str, &str, LightAssetKind) {
    match asset {
        AssetRef::Profile(name) => ("profile", name, LightAssetKind::Profile),
        AssetRef::Environment(name) => ("image", name, LightAssetKind::Environment),
    }
}

fn hash(name: &str) -> Option<[u8; 32]> {
    blake3::Hash::from_hex(name).ok().map(|hash| *hash.as_bytes())
}
