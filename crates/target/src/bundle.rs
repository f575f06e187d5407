//! File format that bundles pictures of known scenes with everything they need: scenes, meshes,
//! light profiles, environments, pictures and masks.
//!
//! Owns the encoding (postcard after a version) and its size limits. The server makes a bundle of
//! an upload and stores it under its hash, so that a target keeps its meaning when meshes and light
//! files change; workers and the server read it. It is in this crate because target files of every
//! kind are read here.

use std::collections::BTreeMap;
use std::sync::Arc;

use brood_eval::decode_environment;
use brood_light::{IesProfile, LightAssets};
use brood_mesh::{BuiltinMesh, Mesh};
use brood_scene::{ClipFrom, MeshRef, PixelArea, Refine, Sampling, Scene};
use serde::{Deserialize, Serialize};

use crate::known::{KnownView, Pictures, PicturesError, ViewError, ViewSetup};
use crate::{MeasuredTarget, Samples};

/// Prefix of every file; the digit is the version.
const MAGIC: &[u8; 17] = b"brood pictures/5\n";
/// Prefix of files without [`PictureBundle::environments`]. Bundles without such files are written
/// so, and keep their hash.
const MAGIC_BUILTIN: &[u8; 17] = b"brood pictures/4\n";
/// Prefix of files without [`BundledView::refine`]. Bundles of exact scenes are written so, and
/// keep their hash.
const MAGIC_EXACT: &[u8; 17] = b"brood pictures/3\n";
/// Prefix of files without [`BundledView::crop`]. Bundles without crops are written so, and keep
/// their hash.
const MAGIC_WHOLE: &[u8; 17] = b"brood pictures/2\n";
/// Prefix of files without [`BundledView::clip_from`], in whose pictures only code 255 is clipped.
/// Bundles with that setting alone are written so, and keep their hash.
const MAGIC_LARGEST: &[u8; 17] = b"brood pictures/1\n";
/// Largest file in bytes: pictures of 64 MiB with several large meshes.
const BYTES_MOST: usize = 256 << 20;
/// Largest number of views in a file.
const VIEWS_MOST: usize = 16;

/// Pictures with everything that they were made with.
#[derive(Debug, Clone, Default)]
pub struct PictureBundle {
    /// Views in their order.
    pub views: Vec<BundledView>,
    /// Photometric profile files by the names that the scenes use.
    pub profiles: BTreeMap<String, Vec<u8>>,
    /// Files of environments by the names that the scenes use.
    pub environments: BTreeMap<String, Vec<u8>>,
}

/// A view of a bundle.
#[derive(Debug, Clone)]
pub struct BundledView {
    /// Camera, lights and film.
    pub scene: Scene,
    /// Mesh; `None` if the scene names a built-in one.
    pub mesh: Option<Arc<Mesh>>,
    /// Sampling of its pixels.
    pub sampling: Sampling,
    /// True if its brightness is unknown.
    pub is_gain_unknown: bool,
    /// Code from which a channel counts as clipped.
    pub clip_from: ClipFrom,
    /// Part of the picture that the scene describes; `None` for all of it.
    pub crop: Option<PixelArea>,
    /// True if it is held out of the fit.
    pub is_held_out: bool,
    /// Uncertainties within which the scene may be corrected.
    pub refine: Refine,
    /// Encoded picture.
    pub picture: Vec<u8>,
    /// Encoded mask.
    pub mask: Option<Vec<u8>>,
}

/// Error of encoding or decoding a bundle.
#[derive(Debug, thiserror::Error)]
pub enum BundleError {
    /// The file has another format or version.
    #[error("this is no picture bundle of the supported version")]
    Version,
    /// The file cannot be decoded.
    #[error("the pictures cannot be read: {0}")]
    Malformed(String),
    /// The file is too large.
    #[error(
        "pictures, masks, meshes, profiles and environments take {0} bytes; at most {BYTES_MOST} \
         are allowed"
    )]
    TooLarge(usize),
    /// No or too many views.
    #[error("a target has 1 to {VIEWS_MOST} pictures, got {0}")]
    Views(usize),
    /// The mesh of a view is missing; contains the index of the view.
    #[error("the mesh in the scene of picture {0} is missing")]
    Mesh(usize),
    /// A view has a mesh of its own, but its scene selects the poles of the built-in sphere;
    /// contains the index of the view.
    #[error(
        "the scene of picture {0} has \"sphere_pole\": \"z\", but the picture has its own mesh"
    )]
    NotSphere(usize),
    /// The scene of a view has other objects or a ground; contains the index of the view.
    #[error("the scene of picture {0} has other objects or a ground; a target shows one object")]
    Surroundings(usize),
    /// A light's profile is invalid.
    #[error("the profile of a light cannot be read: {0}")]
    Profile(String),
    /// A light's environment is invalid.
    #[error("the environment of a light cannot be read: {0}")]
    Environment(String),
    /// Readable, but not usable as a target.
    #[error(transparent)]
    Pictures(#[from] PicturesError),
}

/// Borrowed form for encoding; every mesh is stored once.
#[derive(Serialize)]
struct Written<'a> {
    meshes: Vec<&'a Mesh>,
    profiles: Vec<(&'a str, Octets<'a>)>,
    views: Vec<WrittenView<'a>>,
}

#[derive(Serialize)]
struct WrittenView<'a> {
    /// JSON, because scenes have fields that need a self-describing format.
    scene: String,
    mesh: Option<u32>,
    sampling: Sampling,
    is_gain_unknown: bool,
    is_held_out: bool,
    picture: Octets<'a>,
    mask: Option<Octets<'a>>,
}

/// Bytes that are serialised as one slice instead of one by one.
struct Octets<'a>(&'a [u8]);

impl Serialize for Octets<'_> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(self.0)
    }
}

/// Form for decoding.
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
    /// Largest number of views in a bundle.
    pub const VIEWS_MOST: usize = VIEWS_MOST;

    /// Encodes the bundle. Equal views give equal bytes.
    ///
    /// # Errors
    /// Returns [`BundleError`] if the number of views is out of range, a mesh is missing, or the
    /// result is too large.
    pub fn encode(&self) -> Result<Vec<u8>, BundleError> {
        self.check()?;
        let mut meshes: Vec<&Arc<Mesh>> = Vec::new();
        let mut mesh_indices = Vec::with_capacity(self.views.len());
        for view in &self.views {
            let Some(mesh) = &view.mesh else {
                mesh_indices.push(None);
                continue;
            };
            let known = meshes.iter().position(|known| same(known, mesh));
            let number = known.unwrap_or_else(|| {
                meshes.push(mesh);
                meshes.len() - 1
            });
            mesh_indices.push(Some(u32::try_from(number).expect("there are few views")));
        }
        let views = self.views.iter().zip(mesh_indices).map(|(view, mesh)| WrittenView {
            scene: serde_json::to_string(&view.scene).expect("scenes serialise as JSON"),
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
        let settings: Vec<ClipFrom> = self.views.iter().map(|view| view.clip_from).collect();
        let crops: Vec<Option<PixelArea>> = self.views.iter().map(|view| view.crop).collect();
        let is_exact = self.views.iter().all(|view| view.refine.is_exact());
        let json = |view: &BundledView| {
            serde_json::to_string(&view.refine).expect("numbers serialise as JSON")
        };
        let refine = || -> Vec<String> { self.views.iter().map(json).collect() };
        let environments: Vec<(&str, Octets<'_>)> =
            self.environments.iter().map(|(name, bytes)| (name.as_str(), Octets(bytes))).collect();
        let bytes = if !environments.is_empty() {
            let all = (environments, refine(), settings, crops, written);
            postcard::to_extend(&all, MAGIC.to_vec())
        } else if !is_exact {
            postcard::to_extend(&(refine(), settings, crops, written), MAGIC_BUILTIN.to_vec())
        } else if crops.iter().any(Option::is_some) {
            postcard::to_extend(&(settings, crops, written), MAGIC_EXACT.to_vec())
        } else if settings.iter().all(|setting| *setting == ClipFrom::LARGEST) {
            postcard::to_extend(&written, MAGIC_LARGEST.to_vec())
        } else {
            postcard::to_extend(&(settings, written), MAGIC_WHOLE.to_vec())
        };
        let bytes = bytes.expect("plain data serialises");
        if bytes.len() > BYTES_MOST {
            return Err(BundleError::TooLarge(bytes.len()));
        }
        Ok(bytes)
    }

    /// Decodes a bundle.
    ///
    /// # Errors
    /// Returns [`BundleError`] if the bytes are no bundle of this version, are damaged or too
    /// large, or a mesh is missing.
    pub fn decode(bytes: &[u8]) -> Result<Self, BundleError> {
        if bytes.len() > BYTES_MOST {
            return Err(BundleError::TooLarge(bytes.len()));
        }
        let malformed = |error: String| BundleError::Malformed(error);
        let Contents { environments, refine, settings, crops, read } = contents(bytes)?;
        let counts = [refine.len(), settings.len(), crops.len()];
        if counts != [read.views.len(); 3] {
            let [refine, settings, crops] = counts;
            return Err(malformed(format!(
                "{refine} uncertainties, {settings} settings of clipping, {crops} crops"
            )));
        }
        let meshes: Vec<Arc<Mesh>> = read.meshes.into_iter().map(Arc::new).collect();
        let [profiles, environments] = [read.profiles, environments].map(|files| {
            files.into_iter().map(|(name, bytes)| (name.to_owned(), bytes.to_vec())).collect()
        });
        let mut views = Vec::with_capacity(read.views.len().min(VIEWS_MOST));
        let settings = settings.into_iter().zip(crops).zip(refine);
        for (index, (view, ((clip_from, crop), refine))) in
            read.views.into_iter().zip(settings).enumerate()
        {
            let refine: Refine =
                serde_json::from_str(&refine).map_err(|error| malformed(error.to_string()))?;
            refine.validate().map_err(|error| malformed(error.to_string()))?;
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
                clip_from,
                crop,
                is_held_out: view.is_held_out,
                refine,
                picture: view.picture.to_vec(),
                mask: view.mask.map(<[u8]>::to_vec),
            });
        }
        let bundle = Self { views, profiles, environments };
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
        if let Some(index) = self.views.iter().position(lacks) {
            return Err(BundleError::Mesh(index));
        }
        let is_other = |view: &BundledView| {
            view.scene.builtin() == Some(BuiltinMesh::SphereZ) && view.mesh.is_some()
        };
        let is_among = |view: &BundledView| view.scene.has_surroundings();
        if let Some(index) = self.views.iter().position(is_among) {
            return Err(BundleError::Surroundings(index));
        }
        match self.views.iter().position(is_other) {
            Some(index) => Err(BundleError::NotSphere(index)),
            None => Ok(()),
        }
    }

    /// Parses the assets that the lights refer to.
    ///
    /// # Errors
    /// Returns [`BundleError::Profile`] or [`BundleError::Environment`] if a file is invalid.
    pub fn assets(&self) -> Result<LightAssets, BundleError> {
        let mut assets = LightAssets::default();
        for (name, bytes) in &self.profiles {
            let profile = IesProfile::parse(bytes);
            let profile = profile.map_err(|error| BundleError::Profile(error.to_string()))?;
            assets.insert_profile(name, Arc::new(profile));
        }
        for (name, bytes) in &self.environments {
            let map = decode_environment(bytes);
            let map = map.map_err(|error| BundleError::Environment(error.to_string()))?;
            assets.insert_environment(name, Arc::new(map));
        }
        Ok(assets)
    }

    /// Decodes all pictures as a target.
    ///
    /// # Errors
    /// Returns [`BundleError`] if a profile or a picture cannot be read, or the pictures are no
    /// target.
    pub fn target(&self) -> Result<(Pictures, MeasuredTarget), BundleError> {
        let assets = self.assets()?;
        let views = self.views.iter().map(|view| view.read(&assets));
        Ok(Pictures::gather(views)?)
    }
}

impl BundledView {
    /// Decodes this view alone.
    ///
    /// # Errors
    /// Returns [`ViewError`] if the picture or the mask cannot be read, or is no target.
    pub fn read(&self, assets: &LightAssets) -> Result<(KnownView, Samples), ViewError> {
        let mesh = match (&self.mesh, self.scene.builtin()) {
            (Some(mesh), _) => mesh.clone(),
            (None, Some(name)) => Arc::new(Mesh::builtin(name)),
            (None, None) => unreachable!("a bundle's meshes have been checked"),
        };
        let setting = ViewSetup {
            scene: self.scene.clone(),
            mesh,
            assets: assets.clone(),
            sampling: self.sampling,
            is_gain_unknown: self.is_gain_unknown,
            clip_from: self.clip_from,
            crop: self.crop,
            is_held_out: self.is_held_out,
            refine: self.refine,
        };
        KnownView::read(setting, &self.picture, self.mask.as_deref())
    }
}

/// Contents of a file: one of each setting for a view, and the views.
struct Contents<'a> {
    environments: Vec<(&'a str, &'a [u8])>,
    /// JSON of [`BundledView::refine`].
    refine: Vec<String>,
    settings: Vec<ClipFrom>,
    crops: Vec<Option<PixelArea>>,
    read: Read<'a>,
}

/// Decodes a file of any version.
fn contents(bytes: &[u8]) -> Result<Contents<'_>, BundleError> {
    if let Some(body) = bytes.strip_prefix(MAGIC) {
        let (environments, refine, settings, crops, read) = decoded(body)?;
        return Ok(Contents { environments, refine, settings, crops, read });
    }
    let environments = Vec::new();
    if let Some(body) = bytes.strip_prefix(MAGIC_BUILTIN) {
        let (refine, settings, crops, read) = decoded(body)?;
        return Ok(Contents { environments, refine, settings, crops, read });
    }
    type Whole<'a> = (Vec<ClipFrom>, Read<'a>);
    let (settings, crops, read) = if let Some(body) = bytes.strip_prefix(MAGIC_EXACT) {
        decoded(body)?
    } else if let Some(body) = bytes.strip_prefix(MAGIC_WHOLE) {
        let (settings, read): Whole<'_> = decoded(body)?;
        (settings, vec![None; read.views.len()], read)
    } else {
        let body = bytes.strip_prefix(MAGIC_LARGEST).ok_or(BundleError::Version)?;
        let read: Read<'_> = decoded(body)?;
        let count = read.views.len();
        (vec![ClipFrom::LARGEST; count], vec![None; count], read)
    };
    let refine = vec!["{}".to_owned(); read.views.len()];
    Ok(Contents { environments, refine, settings, crops, read })
}

/// Decodes a whole file after its prefix.
fn decoded<'a, T: Deserialize<'a>>(body: &'a [u8]) -> Result<T, BundleError> {
    match postcard::take_from_bytes(body) {
        Ok((read, [])) => Ok(read),
        Ok((_, rest)) => Err(BundleError::Malformed(format!("{} bytes too many", rest.len()))),
        Err(error) => Err(BundleError::Malformed(error.to_string())),
    }
}

fn same(one: &Arc<Mesh>, other: &Arc<Mesh>) -> bool {
    Arc::ptr_eq(one, other) || one.content_hash() == other.content_hash()
}

#[cfg(test)]
#[path = "bundle_tests.rs"]
mod tests;
