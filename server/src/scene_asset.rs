//! Files that scenes name: checked when a scene is stored, loaded when this process renders one.
//!
//! Scenes name files by their hashes, so a name always means the same bytes.

use std::sync::Arc;

use brood_eval::{decode_environment, decode_image};
use brood_light::{AssetRef, BuiltinEnvironment, EnvironmentMap, IesProfile, LightAssets};
use brood_protocol::LightAssetKind;
use brood_scene::Scene;
use brood_storage::{StorageError, Store};

use crate::limit;
use crate::problem::{ApiError, quote};
use crate::processors::run_blocking;

const NOT_A_HASH: &str = "the name of a scene's file must be a hash";

/// Checks that a scene refers to existing files, and that its lights take at most
/// [`limit::LIGHT_SAMPLES`] samples per point.
///
/// # Errors
/// 404 or 422 with a pointer to the name of the file or to the lights.
pub async fn check(store: &Store, scene: &Scene) -> Result<(), ApiError> {
    let samples = scene.light_samples();
    if samples > limit::LIGHT_SAMPLES {
        let words = format!(
            "the lights need {samples} samples per point; at most {} are allowed",
            limit::LIGHT_SAMPLES
        );
        return Err(ApiError::refused(words).at("/lights"));
    }
    for (asset, pointer) in scene.assets() {
        let (name, expected) = parts(asset);
        let found = match hash(name) {
            Some(hash) => store.light_asset_kind(hash).await,
            None => Err(StorageError::NotFound),
        };
        match found {
            Ok(kind) if kind == expected => {}
            Ok(kind) => {
                let words = format!("the id belongs to a file of kind {}", kind.name());
                return Err(ApiError::refused(words).at(pointer));
            }
            Err(StorageError::NotFound) => {
                let builtin = match expected {
                    LightAssetKind::Profile | LightAssetKind::Image => String::new(),
                    LightAssetKind::Environment => {
                        let names = BuiltinEnvironment::ALL.map(BuiltinEnvironment::name);
                        format!(" name one of {}, or", names.join(", "))
                    }
                };
                let words = format!(
                    "there is no {} {};{builtin} upload one with `POST /v1/{}s`",
                    expected.name(),
                    quote(name),
                    expected.name()
                );
                return Err(ApiError::not_found(words).at(pointer));
            }
            Err(error) => return Err(error.into()),
        }
    }
    Ok(())
}

/// Loads the files that the light and the subject of a checked scene depend on.
///
/// # Errors
/// 500 if a file is missing or cannot be parsed.
pub async fn load(store: &Store, scene: &Scene) -> Result<LightAssets, ApiError> {
    let mut assets = LightAssets::default();
    for (asset, pointer) in scene.assets() {
        let (name, kind) = parts(asset);
        // Neither backdrop nor other objects are needed.
        if kind == LightAssetKind::Image && pointer != "/normal_map/image" {
            continue;
        }
        let hash = hash(name).ok_or_else(|| ApiError::internal(NOT_A_HASH))?;
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
                let read = run_blocking(move || decode_environment(&bytes)).await?;
                let read = read.map_err(|error| damaged(error.to_string()))?;
                assets.insert_environment(name, Arc::new(read));
            }
            LightAssetKind::Image => {
                let read = run_blocking(move || decode_image(&bytes)).await?;
                let read = read.map_err(|error| damaged(error.to_string()))?;
                assets.insert_image(name, Arc::new(read));
            }
        }
    }
    Ok(assets)
}

/// Loads an environment image.
///
/// # Errors
/// 404 if there is none of this id, 500 if it cannot be parsed.
pub async fn environment(store: &Store, id: &str) -> Result<Arc<EnvironmentMap>, ApiError> {
    let unknown = || ApiError::not_found(format!("there is no environment {}", quote(id)));
    let (kind, bytes) = store.light_asset(hash(id).ok_or_else(unknown)?).await?;
    if kind != LightAssetKind::Environment {
        return Err(unknown());
    }
    let read = run_blocking(move || decode_environment(&bytes)).await?;
    let damaged = |error| ApiError::internal(format!("an environment cannot be read: {error}"));
    Ok(Arc::new(read.map_err(damaged)?))
}

/// Returns a file as it was uploaded.
///
/// # Errors
/// [`ApiError`] if it does not exist.
pub async fn file(store: &Store, name: &str) -> Result<Vec<u8>, ApiError> {
    let hash = hash(name).ok_or_else(|| ApiError::internal(NOT_A_HASH))?;
    Ok(store.light_asset(hash).await?.1)
}

/// Returns the hashes of the files that a scene names, each once.
pub fn files(scene: &Scene) -> Vec<[u8; 32]> {
    let mut hashes: Vec<[u8; 32]> =
        scene.assets().filter_map(|(asset, _)| hash(parts(asset).0)).collect();
    hashes.sort_unstable();
    hashes.dedup();
    hashes
}

/// Returns the file name and the kind of an asset.
fn parts(asset: AssetRef<'_>) -> (&str, LightAssetKind) {
    match asset {
        AssetRef::Profile(name) => (name, LightAssetKind::Profile),
        AssetRef::Environment(name) => (name, LightAssetKind::Environment),
        AssetRef::Image(name) => (name, LightAssetKind::Image),
    }
}

fn hash(name: &str) -> Option<[u8; 32]> {
    blake3::Hash::from_hex(name).ok().map(|hash| *hash.as_bytes())
}
