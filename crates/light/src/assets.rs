//! IES profiles, environment maps and images that scenes and painted materials refer to by name.
//!
//! The table only stores what the caller inserts; loading files, uploads or database rows is the
//! caller's task.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::environment::EnvironmentMap;
use crate::ies::IesProfile;
use crate::image_pyramid::ImagePyramid;

/// IES profiles, environment maps and images by the names used in scenes and materials.
#[derive(Debug, Clone, Default)]
pub struct LightAssets {
    profiles: BTreeMap<String, Arc<IesProfile>>,
    environments: BTreeMap<String, Arc<EnvironmentMap>>,
    images: BTreeMap<String, Arc<ImagePyramid>>,
}

/// Asset name that a light or another part of a scene refers to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AssetRef<'a> {
    /// Name of an IES profile.
    Profile(&'a str),
    /// Name of an environment map.
    Environment(&'a str),
    /// Name of an image.
    Image(&'a str),
}

impl LightAssets {
    /// Inserts a profile, replacing the one of that name.
    pub fn insert_profile(&mut self, name: impl Into<String>, profile: Arc<IesProfile>) {
        self.profiles.insert(name.into(), profile);
    }

    /// Returns the profile of that name.
    #[must_use]
    pub fn profile(&self, name: &str) -> Option<&Arc<IesProfile>> {
        self.profiles.get(name)
    }

    /// Inserts an environment map, replacing the one of that name.
    pub fn insert_environment(&mut self, name: impl Into<String>, map: Arc<EnvironmentMap>) {
        self.environments.insert(name.into(), map);
    }

    /// Returns the environment map of that name.
    #[must_use]
    pub fn environment(&self, name: &str) -> Option<&Arc<EnvironmentMap>> {
        self.environments.get(name)
    }

    /// Inserts an image, replacing the one of that name.
    pub fn insert_image(&mut self, name: impl Into<String>, image: Arc<ImagePyramid>) {
        self.images.insert(name.into(), image);
    }

    /// Returns the image of that name.
    #[must_use]
    pub fn image(&self, name: &str) -> Option<&Arc<ImagePyramid>> {
        self.images.get(name)
    }

    /// True if both hold the same `Arc`s of profiles and environment maps under the same names,
    /// which implies equal [`LightAssets::light_hash`].
    #[must_use]
    pub fn has_same_lights(&self, other: &Self) -> bool {
        are_same(&self.profiles, &other.profiles)
            && are_same(&self.environments, &other.environments)
    }

    /// True if there is an asset of that name.
    #[must_use]
    pub fn contains(&self, name: &str) -> bool {
        self.profiles.contains_key(name)
            || self.environments.contains_key(name)
            || self.images.contains_key(name)
    }

    /// True if there are no assets.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.profiles.is_empty() && self.environments.is_empty() && self.images.is_empty()
    }

    /// Hash of the names and contents of profiles and environment maps. Cached sample sets depend
    /// on it besides scene, mesh and normal maps.
    #[must_use]
    pub fn light_hash(&self) -> blake3::Hash {
        let mut hasher = blake3::Hasher::new();
        let profiles = self.profiles.iter().map(|(name, asset)| (b'p', name, asset.content_hash()));
        let environments =
            self.environments.iter().map(|(name, asset)| (b'e', name, asset.content_hash()));
        for (kind, name, hash) in profiles.chain(environments) {
            hasher.update(&[kind]);
            hasher.update(&(name.len() as u64).to_le_bytes());
            hasher.update(name.as_bytes());
            hasher.update(hash.as_bytes());
        }
        hasher.finalize()
    }
}

/// True if both tables hold the same `Arc`s under the same names.
fn are_same<T>(a: &BTreeMap<String, Arc<T>>, b: &BTreeMap<String, Arc<T>>) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.0 == b.0 && Arc::ptr_eq(a.1, b.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_hash_changes_when_an_asset_is_added() {
        let mut assets = LightAssets::default();
        let empty = assets.light_hash();
        let text = b"TILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 60\n0 90\n0\n5 5\n";
        assets.insert_profile("a.ies", Arc::new(IesProfile::parse(text).unwrap()));
        assert_ne!(assets.light_hash(), empty);
        assert!(assets.profile("a.ies").is_some() && assets.environment("a.ies").is_none());
    }
}
