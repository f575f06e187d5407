//! Refinement of linear radiance: more rays in pixels whose highlights are finer than a pixel.
//!
//! Developed pictures refine rough pixels ([`super::rough_tiles`]), where display codes decide.
//! Linear pictures also hold what a display clips, and the pixels of edges, whose rays share the
//! reflectance of a few directions. Here a pixel gets more rays until its value settles.

use std::ops::Range;

use brood_scene::{PixelArea, SampleSet, Sampling};

use super::exposure::Gain;
use crate::radiance::{RadianceImage, shade_each};

/// Numbers of rays. A pixel gets each number until it settles.
const RAYS: [u16; 4] = [5, 17, 65, 257];
/// Largest number of rays traced at once. One takes up to some hundred samples of 100 bytes.
const RAYS_AT_ONCE: usize = 1 << 14;
/// Index in [`RAYS`] of the first number that sets the value of a pixel at an edge. Fewer rays
/// measure an edge worse than adaptive sampling, so they only decide if more are needed.
const EDGE_START: usize = 1;
/// Error at which a pixel has settled, in exposed radiance: 5 codes of the display's white.
const SETTLED: f32 = 0.02;
/// The same as a share of the pixel's radiance, for highlights far above white. The brightest
/// pixels make most of the error of a linear picture.
const SETTLED_SHARE: f32 = 0.002;
/// [`SETTLED`] before [`EDGE_START`]. It is smaller because many pixels are at edges and their
/// errors add up.
const EDGE_SETTLED: f32 = 0.002;
/// Difference in codes from the mean of two neighbours above which a pixel with one ray is rough,
/// as in developed pictures. Codes are 255 times the square root of exposed radiance, close to sRGB
/// but not clipped.
const ROUGH_CODES: f32 = 12.0;
/// Distance from the mean of two neighbours, divided by the error of one ray: with second
/// derivative d the distance is d / 2 and the mean of a pixel is off by d / 24.
const CURVED: f32 = 12.0;
/// Mean deviation from the mean radiance of a pixel at an edge above which the number of its rays
/// matters, relative to the radiance where that is above white.
const UNEVEN_SHARE: f32 = 0.02;
/// Possible error of the mean of n rays, divided by their standard deviation and n^-3/4. For the
/// area of a half-plane this ratio is 0.5 (docs/maths/film.md). Highlights are smoother than edges.
const DEVIATION_SHARE: f32 = 0.05;
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
    eval: impl FnMut(&SampleSet, &mut Vec<f32>) -> Result<(), E>,
) -> Result<Refinement, E> {
    let layout = set.image().expect("the samples are those of a picture");
    if layout.sampling != Sampling::Adaptive {
        return Ok(Refinement::default());
    }
    let pending = candidates(image, (set, f), gain);
    refine(image, (layout.area, gain), pending, trace, eval)
}

/// Refines the pixels with one ray of an adaptive picture whose samples are not kept, as
/// [`refine_radiance`] does. `area`: that of the image in the whole picture; `lone`: true for
/// pixels with one ray.
///
/// # Errors
/// Those of `eval`.
///
/// # Panics
/// If the image is not one of `area`.
pub fn refine_lone_rays<E>(
    image: &mut RadianceImage,
    (area, lone): (PixelArea, &[bool]),
    gain: Gain,
    trace: impl Fn(u16, &[(u32, u32)]) -> SampleSet,
    eval: impl FnMut(&SampleSet, &mut Vec<f32>) -> Result<(), E>,
) -> Result<Refinement, E> {
    assert_eq!((image.width(), image.height()), (area.width, area.height), "the area is another");
    let rough = (0..lone.len()).filter(|index| lone[*index] && is_rough(image, *index, gain));
    let pending = rough.map(|index| Candidate { index, edge: None }).collect();
    refine(image, (area, gain), pending, trace, eval)
}

/// Gives each candidate more rays until it settles.
fn refine<E>(
    image: &mut RadianceImage,
    (area, gain): (PixelArea, Gain),
    mut pending: Vec<Candidate>,
    trace: impl Fn(u16, &[(u32, u32)]) -> SampleSet,
    mut eval: impl FnMut(&SampleSet, &mut Vec<f32>) -> Result<(), E>,
) -> Result<Refinement, E> {
    let mut done = Refinement { pixels: pending.len() as u64, samples: 0 };
    let mut fine_f = Vec::new();
    for (step, rays) in RAYS.into_iter().enumerate() {
        if pending.is_empty() {
            break;
        }
        let place = |pixel: &Candidate| {
            let index = u32::try_from(pixel.index).expect("a picture has fewer than 2^32 pixels");
            (area.x + index % area.width, area.y + index / area.width)
        };
        let mut next = Vec::new();
        for group in pending.chunks((RAYS_AT_ONCE / usize::from(rays)).max(1)) {
            let places: Vec<(u32, u32)> = group.iter().map(place).collect();
            let fine = trace(rays, &places);
            eval(&fine, &mut fine_f)?;
            done.samples += fine.len() as u64;
            let coverage = &fine.image().expect("pixels were traced").coverage;
            let mut found = vec![[0.0; 3]; group.len()];
            shade_each(&fine, &fine_f, |k, radiance| found[k] = radiance);
            let possible_errors = possible_errors(&fine, &fine_f);
            let mut irradiance = vec![[0.0; 3]; group.len()];
            fine_f.fill(1.0);
            shade_each(&fine, &fine_f, |k, sum| irradiance[k] = sum);
            for (k, pixel) in group.iter().enumerate() {
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
                let is_probe = pixel.edge.is_some() && step < EDGE_START;
                let settled = if is_probe { EDGE_SETTLED } else { SETTLED };
                let is_off = |c: usize| {
                    let value = found[c] * gain.factor;
                    (before[c] * gain.factor - value).abs() > tolerance(value, settled)
                        || possible_errors[k][c] * scale[c] * gain.factor
                            > tolerance(value, SETTLED)
                };
                if (0..3).any(is_off) {
                    next.push(*pixel);
                }
                if !is_probe {
                    image.put(pixel.index, found);
                }
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

/// True if the pixel differs from the mean of two opposite neighbours by [`ROUGH_CODES`], or in
/// radiance by more than [`CURVED`] times the tolerance. The second test finds slopes that are
/// linear in codes, the square root of radiance, but curved in radiance.
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
            let [before, own, after] = [before, own, after].map(|value| value[c] * gain.factor);
            (0.5 * (code(before) + code(after)) - code(own)).abs() > ROUGH_CODES
                || (0.5 * (before + after) - own).abs() > CURVED * tolerance(own, SETTLED)
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
        spread * gain.factor > SETTLED.max(UNEVEN_SHARE * (radiance + spread) * gain.factor)
    })
}

/// Returns the error that the mean of each pixel's rays may have, see [`DEVIATION_SHARE`].
///
/// The means of two numbers of rays can be equal by chance, so equal means alone do not settle a
/// pixel.
fn possible_errors(set: &SampleSet, f: &[f32]) -> Vec<[f32; 3]> {
    let layout = set.image().expect("pixels were traced");
    let mut errors = vec![[0.0; 3]; layout.coverage.len()];
    for span in layout.spans() {
        let samples = span.radiance_start as usize..span.end as usize;
        errors[span.pixel as usize] = [0, 1, 2].map(|channel| {
            let f = &f[channel * set.len()..][samples.clone()];
            let irradiance = &set.irradiance()[channel][samples.clone()];
            let radiance = f.iter().zip(irradiance).map(|(f, e)| f * e);
            let (sum, squares) =
                radiance.fold((0.0, 0.0), |(sum, squares), l| (sum + l, squares + l * l));
            let mean: f32 = sum * layout.scale;
            let variance = (squares * layout.scale - mean * mean).max(0.0);
            DEVIATION_SHARE * variance.sqrt() * layout.scale.powf(0.75)
        });
    }
    errors
}

/// Returns the largest error at which an exposed radiance has settled.
fn tolerance(exposed: f32, settled: f32) -> f32 {
    settled.max(SETTLED_SHARE * exposed)
}

/// Returns the unclipped code of an exposed radiance.
fn code(exposed: f32) -> f32 {
    255.0 * exposed.max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::convert::Infallible;

    use brood_genome::Genome;
    use brood_light::LightAssets;
    use brood_mesh::{BuiltinMesh, Mesh};
    use brood_program::Program;
    use brood_scene::{PictureSize, Scene};

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
                SampleSet::render_pixels(
                    &mesh,
                    &scene,
                    &assets,
                    (SIZE_PX.into(), rays),
                    pixels,
                    None,
                )
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
            assert!(after < 0.02, "{model}: {before} before, {after} after, {refined:?}");
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

    /// Reflectance in stripes much finer than pixels.
    fn stripes(set: &SampleSet, f: &mut Vec<f32>) -> Result<(), Infallible> {
        let stripe = |sample| (900.0 * set.pair(sample).0.wi().x).floor().rem_euclid(2.0) as f32;
        let all: Vec<f32> = (0..set.len()).map(stripe).collect();
        *f = all.repeat(3);
        Ok(())
    }

    #[test]
    fn many_pixels_are_traced_in_groups_with_the_values_of_pixels_alone() {
        let mesh = Mesh::builtin(BuiltinMesh::Sphere);
        let (scene, assets) = (Scene::default(), LightAssets::default());
        let size_px = PictureSize::from(SIZE_PX);
        let set = SampleSet::render(&mesh, &scene, SIZE_PX, Sampling::Adaptive);
        let mut f = Vec::new();
        stripes(&set, &mut f).unwrap();
        let rough = shade(&set, &f);
        let gain = Gain::fixed(0.0);
        let calls = RefCell::new(Vec::new());
        let refined = |lone: &[bool]| {
            let mut image = rough.clone();
            let trace = |rays, pixels: &[(u32, u32)]| {
                calls.borrow_mut().push(usize::from(rays) * pixels.len());
                SampleSet::render_pixels(&mesh, &scene, &assets, (size_px, rays), pixels, None)
            };
            let area = PixelArea::whole(size_px);
            refine_lone_rays(&mut image, (area, lone), gain, trace, stripes).unwrap();
            image
        };
        let is_inside = |pixel: usize| rough.coverage()[pixel] >= 1.0;
        let lone: Vec<bool> = (0..rough.coverage().len()).map(is_inside).collect();
        let all = refined(&lone);
        let counts = calls.take();
        assert!(counts.iter().all(|rays| *rays <= RAYS_AT_ONCE), "{counts:?}");
        assert!(counts.len() > 2 * RAYS.len(), "{counts:?}");
        let is_changed =
            |pixel: &usize| all.premultiplied()[*pixel] != rough.premultiplied()[*pixel];
        let changed: Vec<usize> = (0..lone.len()).filter(is_changed).collect();
        assert!(changed.len() > 200, "{}", changed.len());
        for pixel in changed.into_iter().step_by(50) {
            let alone: Vec<bool> = (0..lone.len()).map(|other| other == pixel).collect();
            assert_eq!(refined(&alone).premultiplied()[pixel], all.premultiplied()[pixel]);
        }
    }
}
