//! Control images on the points of painted materials, as columns of inputs.

use brood_brdf::Input;
use glam::Vec2;
use rayon::prelude::*;

use super::SampleSet;
use brood_light::ImagePyramid;

impl SampleSet {
    /// Returns a copy of a set of points with the colours of control images at the texture
    /// position of each, averaged over the part of the pixel that it stands for. `images` are by
    /// their number in [`Input::IMAGES`].
    ///
    /// # Panics
    /// If a number is not one of [`Input::IMAGES`].
    #[must_use]
    pub fn with_images(&self, images: &[(usize, &ImagePyramid)]) -> Self {
        let columns = images.iter().flat_map(|(number, image)| {
            let color = |index: usize| {
                let footprint = self.footprints.get(index).copied().unwrap_or_default();
                image.color(self.uvs[index], footprint.map(Vec2::as_dvec2))
            };
            let colors: Vec<[f32; 4]> = (0..self.len()).into_par_iter().map(color).collect();
            (0..4).map(move |channel| {
                let values = colors.iter().map(|color| color[channel]).collect();
                (Input::IMAGES[*number][channel], values)
            })
        });
        self.with_columns(columns)
    }
}

#[cfg(test)]
mod tests {
    use brood_light::LightAssets;
    use brood_mesh::{BuiltinMesh, Mesh};

    use super::*;
    use crate::{PixelArea, Raster, Sampling, Scene};

    fn points(mesh: BuiltinMesh, sampling: Sampling) -> SampleSet {
        let size_px = 48.into();
        let raster = Raster { size_px, sampling, area: PixelArea::whole(size_px) };
        let (mesh, scene) = (Mesh::builtin(mesh), Scene::default());
        SampleSet::render_points(&mesh, &scene, &LightAssets::default(), raster)
    }

    /// Red rises with u, green with v.
    fn ramp(side: u32) -> ImagePyramid {
        let code = |at: u32| (255 * at / (side - 1)) as u8;
        let pixel = |at: u32| [code(at % side), code(side - 1 - at / side), 0, 255];
        let rgba: Vec<u8> = (0..side * side).flat_map(pixel).collect();
        ImagePyramid::new(side, side, &rgba)
    }

    #[test]
    fn colours_are_those_at_the_texture_position() {
        let image = ramp(64);
        for sampling in [Sampling::Adaptive, Sampling::Fixed(4)] {
            let set = points(BuiltinMesh::Sphere, sampling).with_images(&[(2, &image)]);
            let [red, green, blue, opacity] = Input::IMAGES[2].map(|input| set.input(input));
            let mut far = 0;
            for index in 0..set.len() {
                let (_, uv) = set.pair(index);
                let off = (f64::from(red[index]) - uv.x).abs();
                let off = off.max((f64::from(green[index]) - uv.y).abs());
                far += usize::from(off > 0.06);
                assert!(blue[index] == 0.0 && (opacity[index] - 1.0).abs() < 1e-6);
            }
            // At the pole and the seam, a pixel sees many columns.
            assert!(far < set.len() / 10, "{far} of {}", set.len());
        }
    }

    #[test]
    fn footprints_are_as_wide_as_the_part_of_a_pixel() {
        let mean = |sampling| {
            let set = points(BuiltinMesh::Sphere, sampling);
            let lengths = set.footprints.iter().map(|pair| f64::from(pair[0].length()));
            lengths.sum::<f64>() / set.len() as f64
        };
        let (one, many) = (mean(Sampling::Fixed(1)), mean(Sampling::Fixed(16)));
        assert!((one / many / 4.0 - 1.0).abs() < 0.2, "{one} {many}");
        // Groups of points stand for their whole pixel; at the limb there are more of them.
        let grouped = mean(Sampling::Adaptive);
        assert!((1.0..3.0).contains(&(grouped / one)), "{grouped} {one}");
    }
}
