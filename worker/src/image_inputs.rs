//! Inputs of control images: their colours on the points of a picture.

use brood_brdf::Input;
use brood_genome::ImageHash;
use brood_light::ImagePyramid;
use brood_program::Program;
use brood_scene::SampleSet;

use crate::error::RenderError;
use crate::renderer::Renderer;

impl Renderer {
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
        let assets = self.light_assets();
        let find = |(number, hash): (usize, ImageHash)| {
            let name = hash.to_string();
            let found = assets.image(&name).map(|image| (number, &**image));
            found.ok_or(RenderError::Image(name))
        };
        let used = hashes.into_iter().enumerate().filter(is_read).map(find);
        let used: Vec<(usize, &ImagePyramid)> = used.collect::<Result<_, RenderError>>()?;
        Ok((!used.is_empty()).then(|| points.with_images(&used)))
    }
}

#[cfg(test)]
#[path = "image_inputs_tests.rs"]
mod tests;
