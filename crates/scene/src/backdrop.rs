//! Backdrops behind the object: the radiance of environments, or an image.

use std::f64::consts::PI;

use brood_light::{ImagePyramid, LightAssets, LightSampler, PrefilteredEnvironment};
use brood_mesh::{Mesh, UnitFrame};
use glam::{DVec2, DVec3, Vec2};
use rayon::prelude::*;

use crate::description::Scene;
use crate::sample_set::{LeavingRay, PictureSize, PixelArea, View};
use crate::stage::Stage;

/// Number of means that a pixel averages.
const TAPS: usize = 16;
/// Spacing of these means, divided by the blur.
const TAP_SPACING: f64 = 0.4;
/// Largest blur over which means are spread, in radians.
const MAX_SPACING: f64 = PI / 2.0;
/// Distance of images behind the centre of the subject, in radii of the subject.
const PLANE_RADII: f64 = 4.0;
/// Largest radiance; brighter ones are limited, so that no picture overflows.
const RADIANCE_MAX: f32 = 1e27;

/// Returns the radiance of the environments of a scene, blurred, in the pixels of an area of a
/// picture, row by row from the top.
///
/// # Units
/// W/(m2 sr); the sum over all environments of their mean radiance around the ray through the
/// middle of the pixel.
///
/// # Domain
/// A scene that [`Scene::validate`] accepts; `mesh` is its mesh, of which only the frame is
/// used. Environments whose asset is missing are black.
#[must_use]
pub fn backdrop_radiance(
    blur_deg: f64,
    (scene, mesh, assets): (&Scene, &Mesh, &LightAssets),
    size_px: PictureSize,
    area: PixelArea,
) -> Vec<[f32; 3]> {
    let frame = UnitFrame::new(mesh, scene.scale, scene.rotation_deg);
    let view = View::new(&scene.camera, &frame, size_px);
    let rows = area.y..area.y + area.height;
    let pixels = rows.flat_map(|y| (area.x..area.x + area.width).map(move |x| (x, y)));
    let towards = |pixel| view.pixel_ray(size_px, pixel, DVec2::splat(0.5)).direction;
    let towards: Vec<DVec3> = pixels.map(towards).collect();
    mean_radiance(blur_deg, (scene, assets, &frame), &towards)
}

/// Returns the radiance of the environments of a scene, blurred, in unit directions of the unit
/// frame of the stage's part.
///
/// # Units
/// As [`backdrop_radiance`].
///
/// # Domain
/// As [`backdrop_radiance`].
#[must_use]
pub fn radiance_towards(
    blur_deg: f64,
    (scene, stage, assets): (&Scene, &Stage<'_>, &LightAssets),
    towards: &[DVec3],
) -> Vec<[f32; 3]> {
    mean_radiance(blur_deg, (scene, assets, &stage.frame(scene)), towards)
}

/// Returns the colours of an image that covers a picture, in the pixels of an area, row by row from
/// the top: the image is in the middle and just large enough.
///
/// # Units
/// Display values times opacity, and opacity.
#[must_use]
pub fn backdrop_colors(
    image: &ImagePyramid,
    size_px: PictureSize,
    area: PixelArea,
) -> Vec<[f32; 4]> {
    let cover = Cover::new(image, size_px);
    let color = |at: u32| {
        let pixel = (area.x + at % area.width, area.y + at / area.width);
        cover.color(DVec2::new(f64::from(pixel.0), f64::from(pixel.1)) + 0.5)
    };
    (0..area.width * area.height).into_par_iter().with_min_len(256).map(color).collect()
}

/// Returns the colours of an image backdrop along rays that leave the stage's part. The image lies
/// on a plane behind the subject, perpendicular to the view, and fills the camera's picture as in
/// [`backdrop_colors`]. The component of a ray towards the camera is reversed. Rays that pass
/// beside the image see its nearest pixel.
///
/// # Units
/// As [`backdrop_colors`]; the rays are in the unit frame of the part.
#[must_use]
pub fn colors_towards(
    image: &ImagePyramid,
    (scene, stage): (&Scene, &Stage<'_>),
    (size_px, rays): (PictureSize, &[LeavingRay]),
) -> Vec<[f32; 4]> {
    let cover = Cover::new(image, size_px);
    let half = 0.5 * f64::from(size_px.height);
    let color = |at: DVec2| cover.color(DVec2::new(size_px.aspect() + at.x, 1.0 - at.y) * half);
    on_plane_behind((scene, stage), (size_px, rays)).map(color).collect()
}

/// Returns where rays that leave the stage's part see an image backdrop: the place in a square
/// picture, right and up from its lower left corner, within [0, 1].
///
/// # Units
/// The rays are in the unit frame of the part.
pub(crate) fn places_towards(
    (scene, stage): (&Scene, &Stage<'_>),
    (side, rays): (u32, &[LeavingRay]),
) -> Vec<Vec2> {
    let place = |at: DVec2| (0.5 * (at + 1.0)).clamp(DVec2::ZERO, DVec2::ONE).as_vec2();
    on_plane_behind((scene, stage), (side.into(), rays)).map(place).collect()
}

/// Where rays meet the plane of an image backdrop, in half heights of the picture from its middle.
fn on_plane_behind(
    (scene, stage): (&Scene, &Stage<'_>),
    (size_px, rays): (PictureSize, &[LeavingRay]),
) -> impl IndexedParallelIterator<Item = DVec2> {
    let view = View::new(&scene.camera, &stage.frame(scene), size_px);
    let (subject, radius) = stage.subject();
    let plane = (subject, PLANE_RADII / radius);
    let at = move |leaving: &LeavingRay| view.on_plane_behind(plane, leaving.ray);
    rays.par_iter().with_min_len(256).map(at)
}

/// Image that covers a picture.
struct Cover<'a> {
    image: &'a ImagePyramid,
    /// Change of the texture position over the picture, and over a pixel.
    whole: DVec2,
    pixel: DVec2,
}

impl<'a> Cover<'a> {
    fn new(image: &'a ImagePyramid, size_px: PictureSize) -> Self {
        let (width, height) = image.size();
        let wider = size_px.aspect() * f64::from(height) / f64::from(width);
        let whole = DVec2::new(wider.min(1.0), (1.0 / wider).min(1.0));
        let size = DVec2::new(f64::from(size_px.width), f64::from(size_px.height));
        Self { image, whole, pixel: whole / size }
    }

    /// Colour around a point of the picture, in pixels from its upper left corner.
    fn color(&self, at: DVec2) -> [f32; 4] {
        let from_corner = at * self.pixel;
        let uv = DVec2::new(from_corner.x, self.whole.y - from_corner.y);
        let uv = uv.clamp(DVec2::ZERO, self.whole) + 0.5 * (DVec2::ONE - self.whole);
        let footprint = [DVec2::X * self.pixel.x, DVec2::Y * self.pixel.y];
        self.image.color_within(uv, footprint)
    }
}

fn mean_radiance(
    blur_deg: f64,
    (scene, assets, frame): (&Scene, &LightAssets, &UnitFrame),
    towards: &[DVec3],
) -> Vec<[f32; 3]> {
    let lights = LightSampler::all(&scene.lights, scene.light_deg, assets, frame);
    let environments: Vec<PrefilteredEnvironment> =
        lights.iter().filter_map(LightSampler::prefiltered).collect();
    let spacing = blur_deg.to_radians();
    // Means of one level show its texels.
    let taps = taps(spacing);
    let mean = |towards: &DVec3| {
        let (across, up) = towards.any_orthonormal_pair();
        let mut sum = [0.0f32; 3];
        for light in &environments {
            let (mut us, mut vs) = ([0.0; TAPS], [0.0; TAPS]);
            for (tap, (u, v)) in taps.iter().zip(us.iter_mut().zip(&mut vs)) {
                let towards = *towards + across * tap.x + up * tap.y;
                let in_map = light.in_map(towards.normalize()).as_vec3().to_array();
                [*u, *v] = PrefilteredEnvironment::square(in_map);
            }
            let level = light.level(TAP_SPACING * spacing);
            light.radiance((&us, &vs), &[0; TAPS], level, |_, mean| {
                for (sum, mean) in sum.iter_mut().zip(mean) {
                    *sum += mean;
                }
            });
        }
        // NaN, possible for extreme maps, becomes 0.
        let mean = sum.map(|channel| channel / TAPS as f32);
        mean.map(|channel| if channel > 0.0 { channel.min(RADIANCE_MAX) } else { 0.0 })
    };
    towards.par_iter().with_min_len(256).map(mean).collect()
}

/// Returns the offsets of the means that a pixel averages: a spiral over a disc as wide as the
/// blur, for directions of length 1.
///
/// # Source
/// Vogel 1979, *A better way to construct the sunflower head*.
fn taps(spacing: f64) -> [DVec2; TAPS] {
    let golden = PI * (3.0 - 5f64.sqrt());
    let radius = libm::tan(0.5 * spacing.min(MAX_SPACING));
    std::array::from_fn(|k| {
        let at = radius * ((k as f64 + 0.5) / TAPS as f64).sqrt();
        let turn = golden * k as f64;
        DVec2::new(libm::cos(turn), libm::sin(turn)) * at
    })
}

#[cfg(test)]
mod tests {
    use brood_mesh::BuiltinMesh;

    use super::*;

    fn radiance(camera: &str, blur_deg: f64) -> Vec<[f32; 3]> {
        let lights = r#""lights": [{"kind": "environment", "image": "low-sun"}]"#;
        let scene: Scene =
            serde_json::from_str(&format!(r#"{{{lights}, "camera": {camera}}}"#)).unwrap();
        let mesh = Mesh::builtin(BuiltinMesh::Sphere);
        let (size_px, area) = (PictureSize::from(24), PixelArea::whole(24));
        let assets = LightAssets::default();
        backdrop_radiance(blur_deg, (&scene, &mesh, &assets), size_px, area)
    }

    fn spread(pixels: &[[f32; 3]]) -> f32 {
        let green = || pixels.iter().map(|pixel| pixel[1]);
        green().fold(0.0, f32::max) - green().fold(f32::MAX, f32::min)
    }

    #[test]
    fn sky_is_above_the_ground_and_blur_flattens_it() {
        let level = r#"{"orbit_deg": [0, 0], "fov_y_deg": 90}"#;
        let sharp = radiance(level, 0.0);
        assert!(sharp[2 * 24 + 12][2] > 2.0 * sharp[21 * 24 + 12][2], "the sky is brighter");
        let mut before = spread(&sharp);
        for blur_deg in [20.0, 60.0] {
            let after = spread(&radiance(level, blur_deg));
            assert!(after < before, "{blur_deg}: {after} {before}");
            before = after;
        }
    }

    #[test]
    fn parallel_rays_see_one_direction() {
        let pixels = radiance(r#"{"orthographic": 1}"#, 5.0);
        assert!(pixels.iter().all(|pixel| *pixel == pixels[0]) && pixels[0][1] > 0.0);
    }

    #[test]
    fn part_of_a_picture_has_the_pixels_of_the_whole() {
        let lights = r#"{"lights": [{"kind": "environment", "image": "studio"}]}"#;
        let scene: Scene = serde_json::from_str(lights).unwrap();
        let mesh = Mesh::builtin(BuiltinMesh::Sphere);
        let size_px = PictureSize { width: 30, height: 20 };
        let of = |area| {
            let assets = LightAssets::default();
            backdrop_radiance(10.0, (&scene, &mesh, &assets), size_px, area)
        };
        let whole = of(PixelArea::whole(size_px));
        let part = PixelArea { x: 7, y: 3, width: 11, height: 5 };
        let cut = (3..8).flat_map(|y| &whole[30 * y + 7..30 * y + 18]);
        assert!(of(part).iter().eq(cut));
    }
}
