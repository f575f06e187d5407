//! Cache of parsed target files and of the pictures in them, for rendering. Derived and bounded.

use std::sync::Arc;

use brood_brdf::Brdf;
use brood_light::LightAssets;
use brood_protocol::TargetSource;
use brood_target::{BundledView, KnownView, MeasuredFile, PictureBundle, TargetKind};

use crate::bounded_cache::BoundedCache;
use crate::error::RenderError;

/// Parsed file of a target.
pub(crate) enum LoadedTarget {
    /// Measured material.
    Measured(Box<dyn Brdf>),
    /// Encoded pictures, and the files of their scenes' lights.
    Pictures(PictureBundle, LightAssets),
}

impl LoadedTarget {
    /// Parses a file of this kind. The error is the parser's message.
    fn read(kind: &str, bytes: &[u8]) -> Result<Self, String> {
        let kind: TargetKind =
            kind.parse().map_err(|_| "server and worker are of different versions".to_owned())?;
        Ok(match kind {
            TargetKind::Image => {
                let bundle = PictureBundle::decode(bytes).map_err(|error| error.to_string())?;
                let assets = bundle.assets().map_err(|error| error.to_string())?;
                Self::Pictures(bundle, assets)
            }
            _ => Self::Measured(
                MeasuredFile::read(kind, bytes).map_err(|error| error.to_string())?.brdf,
            ),
        })
    }

    /// Returns a picture of the target and the files of its scene's lights.
    pub(crate) fn picture(
        &self,
        view: Option<u32>,
    ) -> Result<(&BundledView, &LightAssets), RenderError> {
        let missing = || RenderError::Missing("the target has no such picture".to_owned());
        let Self::Pictures(bundle, assets) = self else { return Err(missing()) };
        let index = view.and_then(|n| usize::try_from(n).ok()).ok_or_else(missing)?;
        Ok((bundle.views.get(index).ok_or_else(missing)?, assets))
    }
}

/// Targets of one renderer.
pub(crate) struct TargetCache {
    entries: BoundedCache,
}

impl TargetCache {
    pub(crate) fn new(entries: BoundedCache) -> Self {
        Self { entries }
    }

    /// Returns a parsed file if it is in the cache.
    pub(crate) fn get(&self, hash: &[u8; 32]) -> Option<Arc<LoadedTarget>> {
        self.entries.get(*hash)
    }

    /// Parses a file and caches it, once for concurrent callers. The error is the parser's message.
    pub(crate) fn parse(
        &self,
        source: &TargetSource,
        bytes: &[u8],
    ) -> Result<Arc<LoadedTarget>, Arc<String>> {
        let read = || Ok((Arc::new(LoadedTarget::read(&source.kind, bytes)?), bytes.len()));
        self.entries.get_or_make(source.hash, read)
    }

    /// Returns a decoded picture with the statuses of its pixels.
    pub(crate) fn view(
        &self,
        source: &TargetSource,
        target: &LoadedTarget,
    ) -> Result<Arc<KnownView>, RenderError> {
        let (picture, assets) = target.picture(source.view)?;
        let mut hasher = blake3::Hasher::new();
        hasher.update(&source.hash);
        hasher.update(&source.view.unwrap_or_default().to_le_bytes());
        let key = *hasher.finalize().as_bytes();
        if let Some(view) = self.entries.get(key) {
            return Ok(view);
        }
        let read = picture.read(assets).map_err(|error| RenderError::Target(error.to_string()))?;
        let view = Arc::new(read.0);
        self.entries.insert(key, view.clone(), view.bytes());
        Ok(view)
    }
}
