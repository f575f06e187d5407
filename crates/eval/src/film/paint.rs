//! Pictures of painted materials: colours of a display, without exposure, tone or transfer curve.

use brood_scene::SampleSet;
use rayon::prelude::*;

use super::alpha;
use super::developed::Developed;
use super::srgb::decode_srgb;
use crate::radiance::{RadianceImage, shade, shade_each};

/// Develops colours on a set of points ([`SampleSet::render_points`]): means over each pixel in
/// display values.
///
/// # Shapes
/// As [`shade`].
///
/// # Panics
/// As [`shade`].
#[must_use]
pub fn develop_colors(set: &SampleSet, colors: &[f32]) -> Developed {
    let layout = set.image().expect("the samples are those of a picture");
    let mut rgba = vec![0; 4 * layout.coverage.len()];
    shade_each(set, colors, |pixel, premultiplied| {
        let coverage = layout.coverage[pixel];
        if coverage > 0.0 {
            let codes = premultiplied.map(|channel| alpha((channel / coverage).min(1.0)));
            rgba[4 * pixel..4 * pixel + 3].copy_from_slice(&codes);
            rgba[4 * pixel + 3] = alpha(coverage);
        }
    });
    Developed { width: layout.width, height: layout.height, rgba, exposure_ev: 0.0 }
}

/// Returns the linear light of the picture that [`develop_colors`] develops, before it is rounded
/// to codes.
///
/// # Panics
/// As [`shade`].
#[must_use]
pub fn linear_colors(set: &SampleSet, colors: &[f32]) -> RadianceImage {
    let mut image = shade(set, colors);
    let linear = |(color, coverage): (&[f32; 3], &f32)| {
        let decoded = |channel| coverage * decode_srgb(f64::from(channel / coverage)) as f32;
        (*coverage > 0.0).then(|| color.map(decoded))
    };
    let pixels = image.premultiplied().par_iter().zip(image.coverage());
    let pixels: Vec<Option<[f32; 3]>> = pixels.with_min_len(1024).map(linear).collect();
    for (pixel, linear) in pixels.into_iter().enumerate() {
        if let Some(linear) = linear {
            image.put(pixel, linear);
        }
    }
    image
}
