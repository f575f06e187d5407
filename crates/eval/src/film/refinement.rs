//! Refinement of linear radiance: more rays in pixels whose highlights are finer than a pixel.
//!
//! Developed pictures refine rough pixels ([`super::rough_tiles`]), where display codes decide.
//! Linear pictures also hold what a display clips, and the pixels of edges, whose rays share the
//! reflectance of a few directions. Here a pixel gets more rays until its value settles.

use std::ops::Range;

use brood_scene::{SampleSet, Sampling};

use super::exposure::Gain;
use crate::radiance::{RadianceImage, shade_each};

/// Numbers of rays, each tried where the one before changed the pixel.
const RAYS: [u16; 4] = [5, 17, 65, 257];
/// Index in [`RAYS`] of the first number for pixels at edges: fewer rays measure an edge worse than
/// adaptive sampling did.
const EDGE_START: usize = 1;
/// Difference in codes from the mean of two neighbours above which a pixel with one ray is rough,
/// as in developed pictures. Codes are 255 times the square root of exposed radiance, close to sRGB
/// but not clipped.
const ROUGH_CODES: f32 = 12.0;
/// Change by more rays at which a pixel has settled, in exposed radiance, or relative to it where
/// it is above the display's white.
const SETTLED: f32 = 0.02;
/// Slope of the half vector along an axis below which a sample at an edge is near the centre or the
/// ridge of a highlight.
const NEAR_MIRROR: f64 = 0.25;

/// Number of pixels and samples that a refinement evaluated.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Refinement {
    /// Pixels with more rays than those of the set.
    pub pixels: u64,
    /// Samples evaluated for them.
    pub samples: u64,
}

/// Pixel to refine.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    /// Index in the image of the set.
    index: usize,
    /// Irradiance of a pixel at an edge, integrated by adaptive sampling better than by a few more
    /// rays; these then measure only the mean reflectance. `None` in a pixel with one ray.
    edge: Option<[f32; 3]>,
}

/// Refines the radiance of a picture that was sampled adaptively; other pictures stay unchanged.
///
/// `trace` returns samples of some pixels of the whole picture, columns and rows, with that number
/// of rays as [`SampleSet::render_pixels`] does; `eval` evaluates the material on samples.
///
/// # Errors
/// Those of `eval`.
///
/// # Panics
/// If `image` is not that of `set` and `f`.
pub fn refine_radiance<E>(
    image: &mut RadianceImage,
    (set, f): (&SampleSet, &[f32]),
    gain: Gain,
    trace: impl Fn(u16, &[(u32, u32)]) -> SampleSet,
    mut eval: impl FnMut(&SampleSet, &mut Vec<f32>) -> Result<(), E>,
) -> Result<Refinement, E> {
    let layout = set.image().expect("the samples are those of a picture");
    let mut done = Refinement::default();
    if layout.sampling != Sampling::Adaptive {
        return Ok(done);
    }
    let mut pending = candidates(image, (set, f), gain);
    done.pixels = pending.len() as u64;
    let mut fine_f = Vec::new();
    for (step, rays) in RAYS.into_iter().enumerate() {
        let (now, mut next): (Vec<_>, Vec<_>) =
            pending.into_iter().partition(|pixel| pixel.edge.is_none() || step >= EDGE_START);
        let place = |pixel: &Candidate| {
            let index = u32::try_from(pixel.index).expect("a picture has fewer than 2^32 pixels");
            (layout.area.x + index % layout.width, layout.area.y + index / layout.width)
        };
        let places: Vec<(u32, u32)> = now.iter().map(place).collect();
        if !places.is_empty() {
            let fine = trace(rays, &places);
            eval(&fine, &mut fine_f)?;
            done.samples += fine.len() as u64;
            let coverage = &fine.image().expect("pixels were traced").coverage;
            let mut found = vec![[0.0; 3]; now.len()];
            shade_each(&fine, &fine_f, |k, radiance| found[k] = radiance);
            let mut irradiance = vec![[0.0; 3]; now.len()];
            fine_f.fill(1.0);
            shade_each(&fine, &fine_f, |k, sum| irradiance[k] = sum);
            for (k, pixel) in now.iter().enumerate() {
                let ratio = |own: f32, fine: f32| if fine > 0.0 { own / fine } else { 0.0 };
                let scale = match pixel.edge {
                    Some(own) => [0, 1, 2].map(|c| ratio(own[c], irradiance[k][c])),
                    None => [ratio(image.coverage()[pixel.index], coverage[k]); 3],
                };
                // Rays may miss what covers a sliver of the pixel.
                if scale == [0.0; 3] {
                    continue;
                }
                let found = [0, 1, 2].map(|c| found[k][c] * scale[c]);
                let before = image.premultiplied()[pixel.index];
                if differ(before, found, gain) {
                    next.push(*pixel);
                }
                image.put(pixel.index, found);
            }
        }
        pending = next;
    }
    Ok(done)
}

/// Returns pixels that may have highlights finer than their samples.
fn candidates(image: &RadianceImage, (set, f): (&SampleSet, &[f32]), gain: Gain) -> Vec<Candidate> {
    let layout = set.image().expect("the samples are those of a picture");
    let mut found = Vec::new();
    for run in &layout.runs {
        let is_edge = run.samples != run.centre;
        for span in run.spans() {
            let index = span.pixel as usize;
            let samples = span.radiance_start as usize..span.end as usize;
            let needed = if is_edge {
                samples.clone().any(|sample| is_near_mirror(set, sample))
                    || is_uneven((set, f), samples, gain)
            } else {
                is_rough(image, index, gain)
            };
            if needed {
                let samples = span.radiance_start as usize..span.end as usize;
                let sum = |irradiance: &[f32]| irradiance[samples.clone()].iter().sum::<f32>();
                let edge = is_edge.then(|| set.irradiance().map(sum));
                found.push(Candidate { index, edge });
            }
        }
    }
    found
}

/// True if the pixel is off the mean of two opposite neighbours.
fn is_rough(image: &RadianceImage, index: usize, gain: Gain) -> bool {
    let (width, height) = (image.width() as usize, image.height() as usize);
    let (x, y) = (index % width, index / width);
    let value = |index: usize| {
        let coverage = image.coverage()[index];
        (coverage > 0.0).then(|| image.premultiplied()[index].map(|channel| channel / coverage))
    };
    let off_mean = |before: usize, after: usize| {
        let (Some(before), Some(after)) = (value(before), value(after)) else { return false };
        let own = image.premultiplied()[index];
        (0..3).any(|c| {
            let mean = 0.5 * (code(before[c], gain) + code(after[c], gain));
            (mean - code(own[c], gain)).abs() > ROUGH_CODES
        })
    };
    (x > 0 && x + 1 < width && off_mean(index - 1, index + 1))
        || (y > 0 && y + 1 < height && off_mean(index - width, index + width))
}

/// True if the half vector of a sample is near the normal along an axis of the surface.
fn is_near_mirror(set: &SampleSet, sample: usize) -> bool {
    let (pair, _) = set.pair(sample);
    let half = pair.wi() + pair.wo();
    half.x.abs().min(half.y.abs()) < NEAR_MIRROR * half.z
}

/// True if the reflectance of a pixel's samples differs so much that their number matters.
fn is_uneven((set, f): (&SampleSet, &[f32]), samples: Range<usize>, gain: Gain) -> bool {
    (0..3).any(|channel| {
        let f = &f[channel * set.len()..][samples.clone()];
        let irradiance = &set.irradiance()[channel][samples.clone()];
        let all: f32 = irradiance.iter().sum();
        let radiance: f32 = f.iter().zip(irradiance).map(|(f, e)| f * e).sum();
        let mean = if all > 0.0 { radiance / all } else { 0.0 };
        let spread: f32 = f.iter().zip(irradiance).map(|(f, e)| (f - mean).abs() * e).sum();
        is_off(radiance, radiance + spread, gain)
    })
}

fn differ(a: [f32; 3], b: [f32; 3], gain: Gain) -> bool {
    a.into_iter().zip(b).any(|(a, b)| is_off(a, b, gain))
}

/// True if two radiances differ by more than [`SETTLED`].
fn is_off(a: f32, b: f32, gain: Gain) -> bool {
    (a - b).abs() * gain.factor > SETTLED * (b * gain.factor).max(1.0)
}

/// Returns the unclipped code of a radiance.
fn code(radiance: f32, gain: Gain) -> f32 {
    255.0 * (radiance * gain.factor).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use brood_genome::Genome;
    use brood_light::LightAssets;
    use brood_mesh::{BuiltinMesh, Mesh};
    use brood_program::Program;
    use brood_scene::Scene;

    use super::*;
    use crate::{CanonicalEvaluator, Evaluator, shade};

    const SIZE_PX: u32 = 64;

    fn reflectance(program: &Program, set: &SampleSet) -> Vec<f32> {
        let mut f = Vec::new();
        CanonicalEvaluator::default().eval(&[program], set, &mut f).unwrap();
        f
    }

    /// Picture of a model on a mesh before and after refinement, and with 1023 rays per pixel.
    fn pictures(mesh: BuiltinMesh, model: &str) -> ([Vec<[f32; 3]>; 3], Refinement) {
        let (mesh, scene) = (Mesh::builtin(mesh), Scene::default());
        let genome: Genome = format!("brood 1\n.model {model}\n").parse().unwrap();
        let program = Program::lower(&genome);
        let set = SampleSet::render(&mesh, &scene, SIZE_PX, Sampling::Adaptive);
        let f = reflectance(&program, &set);
        let mut image = shade(&set, &f);
        let before = image.premultiplied().to_vec();
        let gain = Gain::new(scene.film, &set, &f);
        let assets = LightAssets::default();
        let refined = refine_radiance(
            &mut image,
            (&set, &f),
            gain,
            |rays, pixels| {
                SampleSet::render_pixels(&mesh, &scene, &assets, (SIZE_PX.into(), rays), pixels)
            },
            |set, f| -> Result<(), Infallible> {
                *f = reflectance(&program, set);
                Ok(())
            },
        );
        let fine = SampleSet::render(&mesh, &scene, SIZE_PX, Sampling::Fixed(1023));
        let reference = shade(&fine, &reflectance(&program, &fine)).premultiplied().to_vec();
        let Ok(refined) = refined;
        ([before, image.premultiplied().to_vec(), reference], refined)
    }

    /// RMSE relative to the mean of the reference.
    fn error(picture: &[[f32; 3]], reference: &[[f32; 3]]) -> f64 {
        let pairs = || picture.as_flattened().iter().zip(reference.as_flattened());
        let squares: f64 = pairs().map(|(a, b)| f64::from(a - b).powi(2)).sum();
        let mean: f64 = pairs().map(|(_, b)| f64::from(*b)).sum();
        (squares * pairs().count() as f64).sqrt() / mean
    }

    #[test]
    fn narrow_highlights_are_refined_to_a_small_error() {
        let ward = |alpha: &str| {
            format!("ward\ndiffuse 0.3 0.2 0.1\nspecular 0.2 0.2 0.2\n{alpha}\nform ward")
        };
        for (mesh, model) in [
            (BuiltinMesh::Sphere, ward("alpha_x 0.02\nalpha_y 0.3")),
            (BuiltinMesh::Sphere, "conductor\nroughness 0.05".to_owned()),
            (BuiltinMesh::Knob, ward("alpha_x 0.1\nalpha_y 0.3")),
            (BuiltinMesh::Knob, "conductor\nroughness 0.1".to_owned()),
        ] {
            let ([before, after, reference], refined) = pictures(mesh, &model);
            let (before, after) = (error(&before, &reference), error(&after, &reference));
            assert!(before > 0.04, "{model}: {before} shows nothing");
            assert!(after < 0.03, "{model}: {before} before, {after} after, {refined:?}");
            assert!(refined.pixels > 0 && refined.samples > refined.pixels);
        }
    }

    #[test]
    fn even_reflectance_changes_no_pixel() {
        let ([before, after, _], _) = pictures(BuiltinMesh::Knob, "lambert\nalbedo 0.5 0.3 0.2");
        for (before, after) in before.as_flattened().iter().zip(after.as_flattened()) {
            assert!((before - after).abs() <= 1e-5 * before, "{before} {after}");
        }
    }
}
