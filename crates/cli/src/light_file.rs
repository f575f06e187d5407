//! Files named by a scene: IES profiles, environment pictures and images, relative to the scene's
//! folder.

use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, Result};
use brood_bench::output::read_file;
use brood_eval::decode_environment;
use brood_light::{AssetRef, IesProfile, LightAssets};
use brood_scene::Scene;

use crate::image_file;

const PROFILE_BYTES: u64 = 16 << 20;
const ENVIRONMENT_BYTES: u64 = 512 << 20;

/// Reads the assets of a scene; names are paths relative to `folder`.
pub fn read(scene: &Scene, folder: &Path) -> Result<LightAssets> {
    let mut assets = LightAssets::default();
    for (asset, _) in scene.assets() {
        match asset {
            AssetRef::Profile(name) if assets.profile(name).is_none() => {
                let path = folder.join(name);
                let profile = IesProfile::parse(&read_file(&path, PROFILE_BYTES)?)
                    .with_context(|| path.display().to_string())?;
                assets.insert_profile(name, Arc::new(profile));
            }
            AssetRef::Environment(name) if assets.environment(name).is_none() => {
                let path = folder.join(name);
                let map = decode_environment(&read_file(&path, ENVIRONMENT_BYTES)?)
                    .with_context(|| path.display().to_string())?;
                assets.insert_environment(name, Arc::new(map));
            }
            AssetRef::Image(name) if assets.image(name).is_none() => {
                let (_, image) = image_file::read(&folder.join(name))?;
                assets.insert_image(name, Arc::new(image));
            }
            AssetRef::Profile(_) | AssetRef::Environment(_) | AssetRef::Image(_) => {}
        }
    }
    Ok(assets)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_paths_relative_to_the_folder_of_the_scene() {
        let folder = tempfile::tempdir().unwrap();
        let text = "TILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 60\n0 90\n0\n5 5\n";
        std::fs::write(folder.path().join("a.ies"), text).unwrap();
        let scene = |name: &str| -> Scene {
            let json = format!(r#"{{"lights": [{{"kind": "ies", "profile": "{name}"}}]}}"#);
            serde_json::from_str(&json).unwrap()
        };
        let assets = read(&scene("a.ies"), folder.path()).unwrap();
        assert!(assets.profile("a.ies").is_some());
        assert!(read(&scene("b.ies"), folder.path()).is_err());
        assert!(read(&Scene::default(), folder.path()).unwrap().is_empty());
    }
}
