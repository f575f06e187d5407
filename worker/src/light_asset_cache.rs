//! Cache of parsed light assets: IES profiles and environment maps, by the names that scenes use.

use std::sync::Arc;

use brood_eval::decode_environment;
use brood_light::{EnvironmentMap, IesProfile, LightAssets};
use brood_protocol::LightAssetKind;
use moka::sync::Cache;

/// Number of cached assets. An environment map may take 100 MB.
const CAPACITY: u64 = 8;

/// Shared cache; clones refer to the same entries.
#[derive(Clone)]
pub(crate) struct LightAssetCache {
    entries: Cache<String, LightAsset>,
}

#[derive(Clone)]
enum LightAsset {
    Profile(Arc<IesProfile>),
    Environment(Arc<EnvironmentMap>),
}

impl Default for LightAssetCache {
    fn default() -> Self {
        Self { entries: Cache::new(CAPACITY) }
    }
}

impl LightAssetCache {
    /// Adds a cached asset to `assets`. Returns false if it is not in the cache.
    pub(crate) fn add_to(&self, name: &str, assets: &mut LightAssets) -> bool {
        match self.entries.get(name) {
            None => return false,
            Some(LightAsset::Profile(profile)) => assets.insert_profile(name, profile),
            Some(LightAsset::Environment(map)) => assets.insert_environment(name, map),
        }
        true
    }

    /// Parses a file and caches it. The error is the parser's message.
    pub(crate) fn parse_and_insert(
        &self,
        name: String,
        kind: LightAssetKind,
        bytes: &[u8],
    ) -> Result<(), String> {
        let asset = match kind {
            LightAssetKind::Profile => {
                LightAsset::Profile(Arc::new(IesProfile::parse(bytes).map_err(|e| e.to_string())?))
            }
            LightAssetKind::Environment => LightAsset::Environment(Arc::new(
                decode_environment(bytes).map_err(|e| e.to_string())?,
            )),
        };
        self.entries.insert(name, asset);
        Ok(())
    }
}
