//! Pictures of the objects beside the one that is bred.

use brood_scene::{Film, PixelArea};

use super::developed::Developed;
use super::exposure::Gain;
use super::srgb::{curve, decode_srgb};
use super::{alpha, tone};
use crate::radiance::RadianceImage;

/// Linear pictures of the other objects of a scene and of its ground, which all materials of a
/// brood share. All objects together cover each pixel at most once.
#[derive(Debug, Clone, Default)]
pub struct Surroundings {
    /// Objects whose material is a BRDF: radiance.
    pub lit: Option<RadianceImage>,
    /// Painted objects: linear light of the display.
    pub painted: Option<RadianceImage>,
    /// Exposure of the lit objects in EV; `None` for that of the picture, which painted pictures
    /// do not have.
    pub ev: Option<f64>,
}

impl Surroundings {
    /// Adds the picture of an object.
    ///
    /// # Panics
    /// If it has another size than those before.
    pub fn add(&mut self, image: RadianceImage, is_painted: bool) {
        let own = if is_painted { &mut self.painted } else { &mut self.lit };
        match own {
            Some(sum) => sum.put_beside(&image),
            None => *own = Some(image),
        }
    }

    /// Returns a part of the pictures; `area` counts from the upper left corner of these.
    ///
    /// # Panics
    /// If the area is not within the pictures.
    #[must_use]
    pub fn crop(&self, area: PixelArea) -> Self {
        let cut = |image: &Option<RadianceImage>| image.as_ref().map(|image| image.crop(area));
        Self { lit: cut(&self.lit), painted: cut(&self.painted), ev: self.ev }
    }

    /// Size in memory.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let images = [&self.lit, &self.painted];
        images.into_iter().flatten().map(|image| 20 * image.coverage().len()).sum()
    }

    /// Adds the objects to a linear picture.
    ///
    /// # Panics
    /// If the picture has another size.
    pub fn join(&self, picture: &mut RadianceImage) {
        for image in [&self.lit, &self.painted].into_iter().flatten() {
            picture.put_beside(image);
        }
        let gaps = gaps(picture.coverage(), picture.width() as usize);
        if !gaps.is_empty() {
            picture.close(&gaps);
        }
    }

    /// Adds the objects to a developed picture. Colours are mixed in linear light,
    /// each by what it covers of the pixel.
    ///
    /// # Panics
    /// If the picture has another size.
    pub fn develop_beside(&self, picture: &mut Developed, film: Film) {
        let gain = Gain::fixed(self.ev.unwrap_or(picture.exposure_ev)).with_tone(film.tone);
        let exposed = |channel: f32| tone::apply(gain.tone, channel * gain.factor).clamp(0.0, 1.0);
        for (image, is_lit) in [(&self.lit, true), (&self.painted, false)] {
            let Some(image) = image else { continue };
            let (width, height) = (picture.width, picture.height);
            assert_eq!((image.width(), image.height()), (width, height), "pictures of one size");
            let others = image.premultiplied().iter().zip(image.coverage());
            let pixels = picture.rgba.as_chunks_mut::<4>().0.iter_mut();
            for (pixel, (premultiplied, coverage)) in pixels.zip(others) {
                let own = f32::from(pixel[3]) / 255.0;
                if *coverage <= 0.0 || pixel[3] == u8::MAX {
                    continue;
                }
                let all = own + coverage;
                for c in 0..3 {
                    let other = premultiplied[c] / coverage;
                    let other = if is_lit { exposed(other) } else { other };
                    let before = decode_srgb(f64::from(pixel[c]) / 255.0) as f32;
                    pixel[c] = curve().encode((own * before + coverage * other) / all);
                }
                pixel[3] = alpha(all.min(1.0));
            }
        }
        let pixels = picture.rgba.as_chunks::<4>().0;
        let coverage: Vec<f32> = pixels.iter().map(|pixel| f32::from(pixel[3]) / 255.0).collect();
        for pixel in gaps(&coverage, picture.width as usize) {
            picture.rgba[4 * pixel + 3] = u8::MAX;
        }
    }
}

/// Returns the pixels that objects seem to cover in part although they cover all around: each
/// object places its rays along its own edges, so what several cover of a pixel may not add up to
/// all of it.
fn gaps(coverage: &[f32], width: usize) -> Vec<usize> {
    let height = coverage.len() / width.max(1);
    let is_gap = |pixel: &usize| {
        let (x, y) = (pixel % width, pixel / width);
        let near = |at: usize, side: usize| at.saturating_sub(1)..(at + 2).min(side);
        let mut around = near(y, height).flat_map(|y| near(x, width).map(move |x| y * width + x));
        coverage[*pixel] < 1.0 && around.all(|pixel| coverage[pixel] > 0.5)
    };
    (0..coverage.len()).filter(is_gap).collect()
}

#[cfg(test)]
mod tests {
    use brood_mesh::{BuiltinMesh, Mesh};
    use brood_scene::{SampleSet, Sampling, Scene};

    use super::*;
    use crate::radiance::shade;

    /// Picture of a white disc that covers part of some pixels.
    fn disc() -> RadianceImage {
        let mesh = Mesh::builtin(BuiltinMesh::Sphere);
        let set = SampleSet::render(&mesh, &Scene::default(), 16, Sampling::Fixed(64));
        shade(&set, &vec![0.0; 3 * set.len()])
    }

    #[test]
    fn gaps_are_covered_all_around() {
        let mut coverage = vec![1.0; 5 * 4];
        (coverage[7], coverage[4], coverage[3], coverage[15]) = (0.7, 0.2, 0.9, 0.8);
        // The fourth is beside the fifth, which is nearly clear.
        assert_eq!(gaps(&coverage, 5), [7, 15]);
    }

    #[test]
    fn objects_fill_what_the_picture_leaves() {
        let mut image = disc();
        for pixel in 0..image.coverage().len() {
            image.put(pixel, [0.25 * image.coverage()[pixel]; 3]);
        }
        let (coverage, pixels) = (image.coverage().to_vec(), image.coverage().len());
        for (is_painted, ev) in [(false, 1.0), (true, 5.0)] {
            let mut around = Surroundings::default();
            around.add(image.clone(), is_painted);
            let rgba: Vec<u8> =
                (0..pixels).flat_map(|k| [0, 0, 0, if k % 2 == 0 { 0 } else { 51 }]).collect();
            let mut picture = Developed { width: 16, height: 16, rgba, exposure_ev: ev };
            around.develop_beside(&mut picture, Film::default());
            let light = if is_painted { 0.25 } else { 0.5 };
            let own = |k: usize| if k.is_multiple_of(2) { 0.0 } else { 0.2 };
            let codes = (0..pixels).map(|k| alpha((own(k) + coverage[k]).min(1.0)));
            let shares: Vec<f32> = codes.map(|code| f32::from(code) / 255.0).collect();
            let gaps = gaps(&shares, 16);
            for (k, pixel) in picture.rgba.as_chunks::<4>().0.iter().enumerate() {
                let all = own(k) + coverage[k];
                let is_closed = gaps.contains(&k);
                assert_eq!(pixel[3], if is_closed { 255 } else { alpha(all.min(1.0)) }, "{k}");
                if all > 0.0 {
                    let expected = curve().encode(coverage[k] * light / all);
                    assert!(pixel[0].abs_diff(expected) <= 1, "{k}: {pixel:?} {expected}");
                }
            }
        }
    }
}
