//! Inputs of control images: their colours on the points of a picture.

use std::sync::{Arc, PoisonError};

use brood_brdf::Input;
use brood_genome::ImageHash;
use brood_program::Program;
use brood_scene::{ControlImage, SampleSet};

use crate::error::RenderError;
use crate::loaded_image::LoadedImage;
use crate::renderer::Renderer;

impl Renderer {
    /// Replaces the control images that painted materials may name.
    pub fn set_control_images(&self, images: Vec<LoadedImage>) {
        *self.control_images.lock().unwrap_or_else(PoisonError::into_inner) = images;
    }

    /// Returns an image if it is in the cache.
    #[must_use]
    pub fn cached_image(&self, hash: ImageHash) -> Option<LoadedImage> {
        let found = self.entries().get::<LoadedImage>(key(hash))?;
        Some(found.as_ref().clone())
    }

    /// Adds an image to the cache.
    pub fn cache_image(&self, image: &LoadedImage) {
        self.entries().insert(key(image.hash()), Arc::new(image.clone()), image.image().bytes());
    }

    /// Returns the points with the colours of the control images that a style reads there; `None`
    /// if it reads none.
    ///
    /// # Errors
    /// [`RenderError::Image`] if an image was not given.
    pub(crate) fn with_images(
        &self,
        points: &SampleSet,
        style: &Program,
    ) -> Result<Option<SampleSet>, RenderError> {
        let hashes = style.images();
        if hashes.is_empty() {
            return Ok(None);
        }
        let lowered = style.painted(points.lighting().expect("the samples are points"));
        let read = lowered.inputs();
        let is_read = |(number, _): &(usize, ImageHash)| {
            Input::IMAGES[*number].into_iter().any(|input| read.contains(input))
        };
        let images = self.control_images.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let find = |(number, hash): (usize, ImageHash)| {
            let found = images.iter().find(|image| image.hash() == hash);
            let found = found.ok_or_else(|| RenderError::Image(hash.to_string()))?;
            Ok((number, found.image()))
        };
        let used = hashes.into_iter().enumerate().filter(is_read).map(find);
        let used: Vec<(usize, &ControlImage)> = used.collect::<Result<_, RenderError>>()?;
        Ok((!used.is_empty()).then(|| points.with_images(&used)))
    }
}

fn key(hash: ImageHash) -> [u8; 32] {
    *blake3::Hasher::new().update(b"control image").update(hash.as_bytes()).finalize().as_bytes()
}

#[cfg(test)]
#[path = "image_inputs_tests.rs"]
mod tests;
