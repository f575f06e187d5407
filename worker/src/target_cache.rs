//! Cache of parsed target files and of the pictures in them, for rendering. Derived and bounded.

use std::sync::Arc;

use brood_brdf::Brdf;
use brood_light::LightAssets;
use brood_protocol::TargetSource;
use brood_target::{BundledView, KnownView, MeasuredFile, PictureBundle, TargetKind};
use moka::sync::Cache;

use crate::error::RenderError;

/// Capacity for parsed files, in KiB.
const FILES_KIB: u64 = 160 << 10;
/// Capacity for decoded pictures with the sample sets of their scenes, in KiB.
const VIEWS_KIB: u64 = 192 << 10;

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
    files: Cache<[u8; 32], (Arc<LoadedTarget>, u32)>,
    views: Cache<([u8; 32], u32), Arc<KnownView>>,
}

impl TargetCache {
    pub(crate) fn new() -> Self {
        let file = |_: &_, file: &(Arc<LoadedTarget>, u32)| file.1;
        let view = |_: &_, view: &Arc<KnownView>| kib(view.bytes());
        Self {
            files: Cache::builder().max_capacity(FILES_KIB).weigher(file).build(),
            views: Cache::builder().max_capacity(VIEWS_KIB).weigher(view).build(),
        }
    }

    /// Returns a parsed file if it is in the cache.
    pub(crate) fn get(&self, hash: &[u8; 32]) -> Option<Arc<LoadedTarget>> {
        self.files.get(hash).map(|(file, _)| file)
    }

    /// Parses a file and caches it, once for concurrent callers. The error is the parser's message.
    pub(crate) fn parse(
        &self,
        source: &TargetSource,
        bytes: &[u8],
    ) -> Result<Arc<LoadedTarget>, Arc<String>> {
        let read = || Ok((Arc::new(LoadedTarget::read(&source.kind, bytes)?), kib(bytes.len())));
        self.files.try_get_with(source.hash, read).map(|(file, _)| file)
    }

    /// Returns a decoded picture with the statuses of its pixels.
    pub(crate) fn view(
        &self,
        source: &TargetSource,
        target: &LoadedTarget,
    ) -> Result<Arc<KnownView>, RenderError> {
        let (picture, assets) = target.picture(source.view)?;
        let key = (source.hash, source.view.unwrap_or_default());
        if let Some(view) = self.views.get(&key) {
            return Ok(view);
        }
        let read = picture.read(assets).map_err(|error| RenderError::Target(error.to_string()))?;
        let view = Arc::new(read.0);
        self.views.insert(key, view.clone());
        Ok(view)
    }
}

fn kib(bytes: usize) -> u32 {
    u32::try_from(bytes / 1024 + 1).unwrap_or(u32::MAX)
}
