//! Files that lights refer to, kept from job to job: profiles and environments by the names that scenes have for them.

use std::sync::Arc;

use brood_eval::decode_environment;
use brood_protocol::LightAssetKind;
use brood_scene::{EnvironmentMap, IesProfile, LightAssets};
use moka::sync::Cache;

/// So many files stay; an environment may take a hundred megabytes.
const KEPT: u64 = 8;

/// What has been read. Clones share it.
#[derive(Clone)]
pub(crate) struct Lamps {
    kept: Cache<String, Lamp>,
}

#[derive(Clone)]
enum Lamp {
    Profile(Arc<IesProfile>),
    Environment(Arc<EnvironmentMap>),
}

impl Default for Lamps {
    fn default() -> Self {
        Self { kept: Cache::new(KEPT) }
    }
}

impl Lamps {
    /// Adds the file of that name to the assets of a scene; false where it is not here.
    pub(crate) fn take(&self, name: &str, assets: &mut LightAssets) -> bool {
        match self.kept.get(name) {
            None => return false,
            Some(Lamp::Profile(profile)) => assets.insert_profile(name, profile),
            Some(Lamp::Environment(map)) => assets.insert_environment(name, map),
        }
        true
    }

    /// Reads a file and keeps it.
    pub(crate) fn keep(
        &self,
        name: String,
        kind: LightAssetKind,
        bytes: &[u8],
    ) -> Result<(), String> {
        let lamp = match kind {
            LightAssetKind::Profile => {
                Lamp::Profile(Arc::new(IesProfile::parse(bytes).map_err(|e| e.to_string())?))
            }
            LightAssetKind::Environment => {
                Lamp::Environment(Arc::new(decode_environment(bytes).map_err(|e| e.to_string())?))
            }
        };
        self.kept.insert(name, lamp);
        Ok(())
    }
}
