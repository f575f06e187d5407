//! Pictures of known scenes as one file, which needs nothing else: scenes, meshes, profiles of lights, pictures and masks.
//!
//! Owns the form of that file (postcard behind a version) and its bound. The server makes it of an upload and stores it under its hash, so that a
//! target means the same whatever happens to meshes and files of lights; workers and the server itself read it. It stands here because a
//! target's file is read in this crate, whatever its kind, and both have this crate.

use std::collections::BTreeMap;
use std::sync::Arc;

use brood_scene::{IesProfile, LightAssets, Mesh, MeshRef, Sampling, Scene};
use serde::{Deserialize, Serialize};

use super::known::{KnownView, Pictures, PicturesError, Setting, ViewError};
use super::{MeasuredTarget, Samples};

/// Opens every file; the digit is the version.
const MAGIC: &[u8; 17] = b"brood pictures/1\n";
/// Most bytes of a file: pictures of 64 MiB with several large meshes.
const BYTES_MOST: usize = 256 << 20;
/// Most views of a file.
const VIEWS_MOST: usize = 16;

/// Pictures with everything that they were made with.
#[derive(Debug, Clone, Default)]
pub struct PictureBundle {
    /// The views, in their order.
    pub views: Vec<BundledView>,
    /// Files of photometric profiles by the names that scenes have for them. Lights that shine from an environment are in no target.
    pub profiles: BTreeMap<String, Vec<u8>>,
}

/// One of them.
#[derive(Debug, Clone)]
pub struct BundledView {
    /// How the mesh is seen and lit.
    pub scene: Scene,
    /// The mesh, where the scene names no built-in one.
    pub mesh: Option<Arc<Mesh>>,
    /// How its pixels were sampled.
    pub sampling: Sampling,
    /// Whether its brightness is not known.
    pub is_gain_unknown: bool,
    /// Whether nothing is fitted to it.
    pub is_held_out: bool,
    /// The file of the picture.
    pub picture: Vec<u8>,
    /// The file of the mask.
    pub mask: Option<Vec<u8>>,
}

/// Why bytes are no bundle, or cannot be one.
#[derive(Debug, thiserror::Error)]
pub enum BundleError {
    /// Something else, or of another version.
    #[error("these are no pictures of this version")]
    Version,
    /// Broken.
    #[error("the pictures cannot be read: {0}")]
    Malformed(String),
    /// Too many bytes.
    #[error("pictures, masks, meshes and profiles take {0} bytes; {BYTES_MOST} is the most")]
    TooLarge(usize),
    /// No or too many views.
    #[error("a target has 1 to {VIEWS_MOST} pictures, not {0}")]
    Views(usize),
    /// A view without its mesh.
    #[error("the scene of picture {0} names a mesh that is not there")]
    Mesh(usize),
    /// A profile that is none.
    #[error("the profile of a light cannot be read: {0}")]
    Profile(String),
    /// Readable, and still nothing to match.
    #[error(transparent)]
    Pictures(#[from] PicturesError),
}

/// As it is written: every mesh once.
#[derive(Serialize)]
struct Written<'a> {
    meshes: Vec<&'a Mesh>,
    profiles: Vec<(&'a str, Octets<'a>)>,
    views: Vec<WrittenView<'a>>,
}

#[derive(Serialize)]
struct WrittenView<'a> {
    /// JSON: scenes have fields that other forms cannot tell apart.
    scene: String,
    mesh: Option<u32>,
    sampling: Sampling,
    is_gain_unknown: bool,
    is_held_out: bool,
    picture: Octets<'a>,
    mask: Option<Octets<'a>>,
}

/// Bytes that are written at once, not one by one.
struct Octets<'a>(&'a [u8]);

impl Serialize for Octets<'_> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(self.0)
    }
}

/// As it is read.
#[derive(Deserialize)]
struct Read<'a> {
    meshes: Vec<Mesh>,
    #[serde(borrow)]
    profiles: Vec<(&'a str, &'a [u8])>,
    #[serde(borrow)]
    views: Vec<ReadView<'a>>,
}

#[derive(Deserialize)]
struct ReadView<'a> {
    scene: &'a str,
    mesh: Option<u32>,
    sampling: Sampling,
    is_gain_unknown: bool,
    is_held_out: bool,
    picture: &'a [u8],
    #[serde(borrow)]
    mask: Option<&'a [u8]>,
}

impl PictureBundle {
    /// Most views of a bundle.
    pub const VIEWS_MOST: usize = VIEWS_MOST;

    /// The file. Equal views give equal bytes.
    pub fn encode(&self) -> Result<Vec<u8>, BundleError> {
        self.check()?;
        let mut meshes: Vec<&Arc<Mesh>> = Vec::new();
        let mut numbers = Vec::with_capacity(self.views.len());
        for view in &self.views {
            let Some(mesh) = &view.mesh else {
                numbers.push(None);
                continue;
            };
            let known = meshes.iter().position(|known| same(known, mesh));
            let number = known.unwrap_or_else(|| {
                meshes.push(mesh);
                meshes.len() - 1
            });
            numbers.push(Some(u32::try_from(number).expect("there are few views")));
        }
        let views = self.views.iter().zip(numbers).map(|(view, mesh)| WrittenView {
            scene: serde_json::to_string(&view.scene).expect("a scene is finite numbers and words"),
            mesh,
            sampling: view.sampling,
            is_gain_unknown: view.is_gain_unknown,
            is_held_out: view.is_held_out,
            picture: Octets(&view.picture),
            mask: view.mask.as_deref().map(Octets),
        });
        let profiles = self.profiles.iter().map(|(name, bytes)| (name.as_str(), Octets(bytes)));
        let written = Written {
            views: views.collect(),
            profiles: profiles.collect(),
            meshes: meshes.into_iter().map(|mesh| &**mesh).collect(),
        };
        let bytes = postcard::to_extend(&written, MAGIC.to_vec()).expect("plain data serialises");
        if bytes.len() > BYTES_MOST {
            return Err(BundleError::TooLarge(bytes.len()));
        }
        Ok(bytes)
    }

    /// Reads a file.
    pub fn decode(bytes: &[u8]) -> Result<Self, BundleError> {
        if bytes.len() > BYTES_MOST {
            return Err(BundleError::TooLarge(bytes.len()));
        }
        let body = bytes.strip_prefix(MAGIC).ok_or(BundleError::Version)?;
        let malformed = |error: String| BundleError::Malformed(error);
        let read: Read<'_> = match postcard::take_from_bytes(body) {
            Ok((read, [])) => read,
            Ok((_, rest)) => return Err(malformed(format!("{} bytes too many", rest.len()))),
            Err(error) => return Err(malformed(error.to_string())),
        };
        let meshes: Vec<Arc<Mesh>> = read.meshes.into_iter().map(Arc::new).collect();
        let profiles = read.profiles.into_iter();
        let profiles = profiles.map(|(name, bytes)| (name.to_owned(), bytes.to_vec())).collect();
        let mut views = Vec::with_capacity(read.views.len().min(VIEWS_MOST));
        for (index, view) in read.views.into_iter().enumerate() {
            let scene: Scene =
                serde_json::from_str(view.scene).map_err(|error| malformed(error.to_string()))?;
            scene.validate().map_err(|error| malformed(error.to_string()))?;
            let mesh = match view.mesh {
                None => None,
                Some(number) => {
                    let mesh = usize::try_from(number).ok().and_then(|number| meshes.get(number));
                    Some(mesh.ok_or(BundleError::Mesh(index))?.clone())
                }
            };
            views.push(BundledView {
                scene,
                mesh,
                sampling: view.sampling,
                is_gain_unknown: view.is_gain_unknown,
                is_held_out: view.is_held_out,
                picture: view.picture.to_vec(),
                mask: view.mask.map(<[u8]>::to_vec),
            });
        }
        let bundle = Self { views, profiles };
        bundle.check()?;
        Ok(bundle)
    }

    fn check(&self) -> Result<(), BundleError> {
        if !(1..=VIEWS_MOST).contains(&self.views.len()) {
            return Err(BundleError::Views(self.views.len()));
        }
        let lacks = |view: &BundledView| {
            matches!(view.scene.mesh, MeshRef::Uploaded(_)) && view.mesh.is_none()
        };
        match self.views.iter().position(lacks) {
            Some(index) => Err(BundleError::Mesh(index)),
            None => Ok(()),
        }
    }

    /// What the lights of the scenes refer to.
    pub fn assets(&self) -> Result<LightAssets, BundleError> {
        let mut assets = LightAssets::default();
        for (name, bytes) in &self.profiles {
            let profile = IesProfile::parse(bytes);
            let profile = profile.map_err(|error| BundleError::Profile(error.to_string()))?;
            assets.insert_profile(name, Arc::new(profile));
        }
        Ok(assets)
    }

    /// All of it as a target.
    pub fn target(&self) -> Result<(Pictures, MeasuredTarget), BundleError> {
        let assets = self.assets()?;
        let views = self.views.iter().map(|view| view.read(&assets));
        Ok(Pictures::gather(views)?)
    }
}

impl BundledView {
    /// Reads the view alone.
    pub fn read(&self, assets: &LightAssets) -> Result<(KnownView, Samples), ViewError> {
        let mesh = match (&self.mesh, &self.scene.mesh) {
            (Some(mesh), _) => mesh.clone(),
            (None, MeshRef::Builtin(name)) => Arc::new(Mesh::builtin(*name)),
            (None, MeshRef::Uploaded(_)) => unreachable!("a bundle's meshes have been checked"),
        };
        let setting = Setting {
            scene: self.scene.clone(),
            mesh,
            assets: assets.clone(),
            sampling: self.sampling,
            is_gain_unknown: self.is_gain_unknown,
            is_held_out: self.is_held_out,
        };
        KnownView::read(setting, &self.picture, self.mask.as_deref())
    }
}

fn same(one: &Arc<Mesh>, other: &Arc<Mesh>) -> bool {
    Arc::ptr_eq(one, other) || one.content_hash() == other.content_hash()
}

#[cfg(test)]
#[path = "bundle_tests.rs"]
mod tests;
