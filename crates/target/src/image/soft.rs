//! Pixels that light reaches from several directions: under several lights, lights with an area, or
//! environments. What they show of the material is a mean over these directions.

use brood_light::{Light, LightAssets};
use brood_mesh::Mesh;
use brood_scene::{LightTerms, PictureSize, Scene};

use crate::LightMeans;

/// Largest number of pixels of a picture, evenly picked.
const MEANS: usize = 4096;
/// Largest number of pairs of directions that only one pixel has, of all pixels together.
const PAIRS: usize = 1 << 16;

/// A pixel that is lit from several directions.
#[derive(Debug, Clone, Copy)]
pub(super) struct SeveralPixel {
    pub(super) pixel: usize,
    pub(super) radiance: [f64; 3],
    /// True for channels of which not only a lower bound is known.
    pub(super) is_known: [bool; 3],
}

/// Returns the first light that shines from many directions at once.
pub(super) fn soft_light(scene: &Scene) -> Option<&Light> {
    let is_hard = |light: &Light| {
        matches!(light, Light::Point(_) | Light::Directional(_) | Light::Spot(_) | Light::Ies(_))
    };
    scene.lights.iter().find(|light| !is_hard(light))
}

/// Returns the means of an even choice of pixels, and those of them that no light reaches.
pub(super) fn means(
    mesh: &Mesh,
    (scene, assets): (&Scene, &LightAssets),
    size_px: PictureSize,
    all: &[SeveralPixel],
) -> (LightMeans, Vec<usize>) {
    let own_pairs = |light: &Light| match light {
        Light::Environment(_) => 0,
        Light::Point(_) | Light::Directional(_) | Light::Spot(_) | Light::Ies(_) => 1,
        _ => light.samples().max(LightTerms::AREA_SAMPLES) as usize,
    };
    let own: usize = scene.lights.iter().map(own_pairs).sum();
    let count = all.len().min(MEANS).min(PAIRS / own.max(1));
    let picked: Vec<SeveralPixel> = (0..count).map(|k| all[k * all.len() / count]).collect();
    let width = size_px.width as usize;
    let place = |at: usize| {
        let at = (at % width, at / width);
        let index = |value| u32::try_from(value).expect("pictures have fewer than 2^32 columns");
        (index(at.0), index(at.1))
    };
    let pixels: Vec<(u32, u32)> = picked.iter().map(|one| place(one.pixel)).collect();
    let light = LightTerms::render(mesh, scene, assets, size_px, &pixels);
    let radiance: Vec<([f64; 3], [bool; 3])> =
        picked.iter().map(|one| (one.radiance, one.is_known)).collect();
    let (means, lit) = LightMeans::of_pixels(&light, &radiance);
    let mut is_lit = vec![false; picked.len()];
    lit.into_iter().for_each(|index| is_lit[index] = true);
    let unlit = picked.iter().zip(is_lit).filter(|(_, is_lit)| !is_lit);
    (means, unlit.map(|(one, _)| one.pixel).collect())
}
