//! Pixels that show a mean over several pairs of directions: under several lights, lights with an
//! area or environments, and in highlights, which differ within a pixel.

use brood_light::{Light, LightAssets};
use brood_mesh::Mesh;
use brood_scene::{LightTerms, PictureSize, Scene};

use super::highlight::PARTS;
use crate::{LightMeans, PixelRadiance};

/// Largest number of pixels of a picture, evenly picked.
const MEANS: usize = 4096;
/// Largest number of pairs of directions that only one pixel has, of all pixels together.
const PAIRS: usize = 1 << 16;
/// Number of points of a pixel along a side, under environments alone.
const ENVIRONMENT_PARTS: u32 = 2;
/// Largest number of pixels of a picture in highlights.
const HIGHLIGHTS: usize = 512;

/// Pixels that show means, with what they show.
pub(super) type MeanPixels = Vec<(usize, PixelRadiance)>;

/// Returns the first light that shines from many directions at once.
pub(super) fn soft_light(scene: &Scene) -> Option<&Light> {
    let is_hard = |light: &Light| {
        matches!(light, Light::Point(_) | Light::Directional(_) | Light::Spot(_) | Light::Ies(_))
    };
    scene.lights.iter().find(|light| !is_hard(light))
}

/// Number of points of a pixel that is lit from several directions, along a side. Environments have
/// the same pairs at all of them.
pub(super) fn parts(scene: &Scene) -> u32 {
    let is_environment = |light: &Light| matches!(light, Light::Environment(_));
    if scene.lights.iter().all(is_environment) { ENVIRONMENT_PARTS } else { 1 }
}

/// Largest number of pixels in highlights whose means are made in a scene.
pub(super) fn most_highlights(scene: &Scene) -> usize {
    HIGHLIGHTS.min(PAIRS / (own_pairs(scene) * (PARTS * PARTS) as usize))
}

/// Number of pairs that a pixel has of its own for each of its parts.
fn own_pairs(scene: &Scene) -> usize {
    let of = |light: &Light| match light {
        Light::Environment(_) => 0,
        Light::Point(_) | Light::Directional(_) | Light::Spot(_) | Light::Ies(_) => 1,
        _ => light.samples().max(LightTerms::AREA_SAMPLES) as usize,
    };
    scene.lights.iter().map(of).sum::<usize>().max(1)
}

/// Returns the means of an even choice of pixels, over `parts` times `parts` points of each; and
/// those of them that no light reaches.
pub(super) fn means(
    mesh: &Mesh,
    (scene, assets): (&Scene, &LightAssets),
    size_px: PictureSize,
    (all, parts): (&MeanPixels, u32),
) -> (LightMeans, Vec<usize>) {
    let own = own_pairs(scene) * (parts * parts) as usize;
    let count = all.len().min(MEANS).min(PAIRS / own);
    let picked: MeanPixels = (0..count).map(|k| all[k * all.len() / count]).collect();
    let width = size_px.width as usize;
    let place = |at: usize| {
        let at = (at % width, at / width);
        let index = |value| u32::try_from(value).expect("pictures have fewer than 2^32 columns");
        (index(at.0), index(at.1))
    };
    let pixels: Vec<(u32, u32)> = picked.iter().map(|(pixel, _)| place(*pixel)).collect();
    let light = LightTerms::render(mesh, scene, assets, size_px, &pixels, parts);
    let shown: Vec<PixelRadiance> = picked.iter().map(|(_, shown)| *shown).collect();
    let (means, lit) = LightMeans::of_pixels(&light, &shown);
    let mut is_lit = vec![false; picked.len()];
    lit.into_iter().for_each(|index| is_lit[index] = true);
    let unlit = picked.iter().zip(is_lit).filter(|(_, is_lit)| !is_lit);
    (means, unlit.map(|((pixel, _), _)| *pixel).collect())
}
