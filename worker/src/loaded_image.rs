//! Control images with the hashes of their files.

use std::sync::Arc;

use brood_eval::{DisplayPicture, LinearPictureError, decode_display};
use brood_genome::ImageHash;
use brood_scene::ControlImage;

/// Control image with the hash of its file.
#[derive(Debug, Clone)]
pub struct LoadedImage {
    hash: ImageHash,
    image: Arc<ControlImage>,
}

impl LoadedImage {
    /// Largest width or height in pixels.
    pub const SIDE_MOST: u32 = 4096;

    /// Decodes a PNG or JPEG file.
    ///
    /// # Errors
    /// [`LinearPictureError`] if it is broken, of another format or too large.
    pub fn decode(file: &[u8]) -> Result<Self, LinearPictureError> {
        let DisplayPicture { width, height, rgba } = decode_display(file, Self::SIDE_MOST)?;
        let image = Arc::new(ControlImage::new(width, height, &rgba));
        Ok(Self { hash: ImageHash::of(file), image })
    }

    /// Returns the hash of the file.
    #[must_use]
    pub fn hash(&self) -> ImageHash {
        self.hash
    }

    /// Returns the image.
    #[must_use]
    pub fn image(&self) -> &ControlImage {
        &self.image
    }
}
