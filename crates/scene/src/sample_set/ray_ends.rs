//! Ends of the rays of a clear body: the points that are seen in its mirror and through it. The
//! page colours them while lights move.

use brood_light::LightAssets;
use brood_mesh::trace::Ray;
use glam::{DVec3, Vec2, Vec3};

use super::clear::WayOut;
use super::lit_angles::{LitAngles, Toggles, pixels_near};
use super::sampling::{PixelArea, Raster, Sampling};
use super::seen_point::{LeavingRay, SeenPoint};
use super::set::SampleSet;
use super::size::PictureSize;
use super::values::round_to_f32;
use crate::backdrop::places_towards;
use crate::description::Scene;
use crate::stage::Stage;

/// Number of rays of a pixel: the mirrored one and two ways through the body.
const RAYS: usize = 3;

/// Ends of the rays of the subject, as a clear body, in a square picture with a sample a pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct RayEnds {
    side: u32,
    pixels: Vec<PixelRays>,
    parts: Vec<Vec<RayEnd>>,
    angles: Vec<Vec<Vec<Toggles>>>,
}

/// Rays of a pixel: the mirrored eye ray, then at most two ways out of the body.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PixelRays {
    /// Part in which each ray ends, and the number of its end there; `None` if there is no ray.
    pub ends: [Option<(usize, usize)>; RAYS],
    /// Length of each ray inside the body, in its radii.
    pub lengths: [f32; RAYS],
    /// Share of the first way in the light of both.
    pub share: f32,
}

/// Point in which a ray ends, in the unit frame of the subject.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RayEnd {
    /// Position; on the background the place in the picture of a backdrop, right and up from the
    /// lower left corner, within [0, 1].
    pub position: Vec3,
    /// Shading normal, on the side of the ray.
    pub n: Vec3,
    /// Tangent along u.
    pub u: Vec3,
    /// Direction against the ray, along u and n x u.
    pub eye: Vec2,
    /// Texture position.
    pub uv: Vec2,
    /// n.e, depth, and the lengths of their gradients, as painted materials read them.
    pub own: [f32; 4],
}

impl RayEnds {
    /// Follows the rays of the subject with an index of refraction relative to its surroundings. A
    /// pixel whose middle misses the subject has the rays of one beside it. In a scene with
    /// shadows, finds at which angles of the light circle the lights reach each end.
    ///
    /// # Domain
    /// As [`SampleSet::ways_out`]; with shadows as [`LitAngles::trace`].
    ///
    /// # Panics
    /// As [`SampleSet::render_points`].
    #[must_use]
    pub fn trace<'a>(
        (scene, index): (&Scene, f64),
        stage: impl Into<Stage<'a>>,
        side: u32,
    ) -> Self {
        let (stage, assets) = (stage.into().with_part(0), LightAssets::default());
        let lit = scene;
        let scene = &Scene { lights: Vec::new(), shadows: false, ..scene.clone() };
        let (size_px, area) = (PictureSize::from(side), PixelArea::whole(side));
        let raster = Raster { size_px, sampling: Sampling::Fixed(1), area };
        let points = SampleSet::render_clear_points(stage.clone(), scene, &assets, raster);
        let mirrored = points.mirrored_ways(&stage, index);
        let ways = points.ways_out(&stage, index);
        let through = ways.iter().flat_map(|pair| pair.iter().flatten());
        let rays: Vec<LeavingRay> = mirrored.iter().chain(through).map(|way| way.leaving).collect();
        let (parts, ends) = ends_of(scene, &stage, (side, &rays));
        let angles = match lit.shadows {
            true => angles_of(lit, &stage, side, (&rays, &ends)),
            false => Vec::new(),
        };
        let image = points.image().expect("the set is of a picture");
        let mut pixels = vec![PixelRays::default(); (side * side) as usize];
        let mut next = mirrored.len();
        for span in image.spans() {
            let sample = span.start as usize;
            let pixel = &mut pixels[span.pixel as usize];
            let mut set = |at: usize, ray: usize, way: &WayOut| {
                pixel.ends[at] = Some(ends[ray]);
                pixel.lengths[at] = round_to_f32(way.length);
            };
            set(0, sample, &mirrored[sample]);
            for (at, way) in ways[sample].iter().flatten().enumerate() {
                set(1 + at, next, way);
                next += 1;
            }
            match ways[sample][0] {
                Some(way) => pixel.share = round_to_f32(way.share),
                // Where nothing enters a thin body, it shows its mirror instead.
                None => {
                    if index < 1.0 {
                        set(1, sample, &mirrored[sample]);
                    }
                    pixel.share = 1.0;
                }
            }
        }
        Self { side, pixels: with_edges(&pixels, side), parts, angles }
    }

    /// Side of the picture in pixels.
    #[must_use]
    pub fn side(&self) -> u32 {
        self.side
    }

    /// Rays of each pixel, row by row from the top.
    #[must_use]
    pub fn pixels(&self) -> &[PixelRays] {
        &self.pixels
    }

    /// Ends on each part: the subject itself, the other objects, the ground, and the background.
    #[must_use]
    pub fn parts(&self) -> &[Vec<RayEnd>] {
        &self.parts
    }

    /// Angles at which lights reach the ends, in sets as those of [`LitAngles::toggles`]: for each
    /// set, those of the ends on each part. Empty without shadows; on the background they mean
    /// nothing.
    #[must_use]
    pub fn angles(&self) -> &[Vec<Vec<Toggles>>] {
        &self.angles
    }
}

/// Returns the angles at which the lights of a scene reach the ends of rays: for each kind of
/// angles and each light, those of all ends of each part.
fn angles_of(
    scene: &Scene,
    stage: &Stage<'_>,
    side: u32,
    (rays, ends): (&[LeavingRay], &[(usize, usize)]),
) -> Vec<Vec<Vec<Toggles>>> {
    let rays: Vec<(LeavingRay, usize)> =
        rays.iter().zip(ends).map(|(ray, (part, _))| (*ray, *part)).collect();
    let found = LitAngles::of_rays(scene, stage, side, &rays);
    let kinds = if stage.clear().is_empty() { 1 } else { 2 };
    let lights = found.first().map_or(0, Vec::len);
    let sets = (0..kinds).flat_map(|kind| (0..lights).map(move |light| (kind, light)));
    let set = |(kind, light): (usize, usize)| {
        let mut parts = vec![Vec::new(); stage.count() + 1];
        // The ends of a part are numbered in the order of the rays.
        for (passages, (part, _)) in found.iter().zip(ends) {
            parts[*part].push(passages[light][kind]);
        }
        parts
    };
    sets.map(set).collect()
}

/// Returns the pixels, and for those without rays the rays of one beside it.
fn with_edges(pixels: &[PixelRays], side: u32) -> Vec<PixelRays> {
    let own = |x: u32, y: u32| {
        let mut near = pixels_near((x, y), side).map(|(x, y)| &pixels[(y * side + x) as usize]);
        near.find(|pixel| pixel.ends[0].is_some()).copied().unwrap_or_default()
    };
    (0..side).flat_map(|y| (0..side).map(move |x| (x, y))).map(|(x, y)| own(x, y)).collect()
}

/// Returns the ends of rays on each part, and the part and the number there of each ray.
fn ends_of(
    scene: &Scene,
    stage: &Stage<'_>,
    (side, rays): (u32, &[LeavingRay]),
) -> (Vec<Vec<RayEnd>>, Vec<(usize, usize)>) {
    let background = stage.count();
    let mut found: Vec<Option<(usize, usize)>> = vec![None; rays.len()];
    let mut parts = vec![Vec::new(); background + 1];
    let mut open: Vec<usize> = (0..rays.len()).collect();
    // Where faces coincide, pictures show the subject, else the last part.
    for part in std::iter::once(0).chain((1..background).rev()) {
        let (own, assets) = (stage.with_part(part), LightAssets::default());
        let asked: Vec<LeavingRay> = open.iter().map(|ray| rays[*ray]).collect();
        let (set, points) =
            SampleSet::points_of_rays((&own, 0), (scene, &assets), (side.into(), &asked), true);
        let back = stage.change_from(part);
        let turned = |at: Ray| back.as_ref().map_or(at, |change| change.ray(at));
        let end = |(sample, seen): (usize, &SeenPoint)| {
            let at = |direction: DVec3| turned(Ray { origin: seen.position, direction });
            let (n, wo) = (at(seen.n), set.pairs[sample].wo());
            RayEnd {
                position: n.origin.as_vec3(),
                n: n.direction.as_vec3(),
                u: at(seen.u).direction.as_vec3(),
                eye: wo.truncate().as_vec2(),
                uv: set.uvs[sample].as_vec2(),
                own: points.own[sample],
            }
        };
        parts[part] = points.seen.iter().enumerate().map(end).collect();
        let covered = set.image().expect("the set is of a picture").coverage.iter();
        let hits = open.iter().zip(covered).filter(|(_, covered)| **covered > 0.0);
        for (number, (ray, _)) in hits.enumerate() {
            found[*ray] = Some((part, number));
        }
        open.retain(|ray| found[*ray].is_none());
    }
    let missed: Vec<LeavingRay> = open.iter().map(|ray| rays[*ray]).collect();
    let places = places_towards((scene, stage), (side, &missed));
    let place = |at: Vec2| RayEnd { position: at.extend(0.0), ..RayEnd::default() };
    parts[background] = places.into_iter().map(place).collect();
    let mut next = 0..;
    let ends = found.into_iter().map(|end| end.or_else(|| Some((background, next.next()?))));
    let ends = ends.map(|end| end.expect("numbers are endless")).collect();
    (parts, ends)
}

#[cfg(test)]
#[path = "ray_ends_tests.rs"]
mod tests;
