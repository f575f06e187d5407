//! Cache of parsed light assets: IES profiles, environment maps and images, by the names that
//! scenes and materials use.

use std::sync::Arc;

use brood_eval::{decode_environment, decode_image};
use brood_light::{EnvironmentMap, IesProfile, ImagePyramid, LightAssets};
use brood_protocol::LightAssetKind;

use crate::bounded_cache::BoundedCache;

/// Shared cache; clones refer to the same entries.
#[derive(Clone)]
pub(crate) struct LightAssetCache {
    entries: BoundedCache,
}

enum LightAsset {
    Profile(Arc<IesProfile>),
    Environment(Arc<EnvironmentMap>),
    Image(Arc<ImagePyramid>),
}

impl LightAssetCache {
    /// Creates a cache in `entries`.
    pub(crate) fn new(entries: BoundedCache) -> Self {
        Self { entries }
    }

    /// Adds a cached asset to `assets`. Returns false if it is not in the cache.
    pub(crate) fn add_to(&self, name: &str, assets: &mut LightAssets) -> bool {
        let Some(asset) = self.entries.get::<LightAsset>(key(name)) else { return false };
        asset.add_to(name, assets);
        true
    }

    /// Parses a file, caches it, and adds it to `assets`. The error is the parser's message.
    pub(crate) fn parse_into(
        &self,
        name: &str,
        kind: LightAssetKind,
        bytes: &[u8],
        assets: &mut LightAssets,
    ) -> Result<(), String> {
        let asset = match kind {
            LightAssetKind::Profile => {
                LightAsset::Profile(Arc::new(IesProfile::parse(bytes).map_err(|e| e.to_string())?))
            }
            LightAssetKind::Environment => LightAsset::Environment(Arc::new(
                decode_environment(bytes).map_err(|e| e.to_string())?,
            )),
            LightAssetKind::Image => {
                LightAsset::Image(Arc::new(decode_image(bytes).map_err(|e| e.to_string())?))
            }
        };
        asset.add_to(name, assets);
        let bytes = match &asset {
            LightAsset::Profile(_) => bytes.len(),
            LightAsset::Environment(map) => map.bytes(),
            LightAsset::Image(image) => image.bytes(),
        };
        self.entries.insert(key(name), Arc::new(asset), bytes);
        Ok(())
    }
}

impl LightAsset {
    fn add_to(&self, name: &str, assets: &mut LightAssets) {
        match self {
            Self::Profile(profile) => assets.insert_profile(name, profile.clone()),
            Self::Environment(map) => assets.insert_environment(name, map.clone()),
            Self::Image(image) => assets.insert_image(name, image.clone()),
        }
    }
}

fn key(name: &str) -> [u8; 32] {
    *blake3::hash(name.as_bytes()).as_bytes()
}
