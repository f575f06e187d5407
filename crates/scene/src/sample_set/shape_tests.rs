//! Tests of pictures that are not square.

use std::f64::consts::PI;

use brood_mesh::{BuiltinMesh, Mesh};

use super::{PictureSize, PixelArea, PixelSpan, SampleSet, Sampling};
use crate::{Camera, LookAtCamera, OrbitCamera, OrthographicCamera, Scene};

fn scene(camera: Camera) -> Scene {
    Scene { camera, ..Scene::default() }
}

fn orbit(distance: Option<f64>) -> Camera {
    Camera::Orbit(OrbitCamera { orbit_deg: [40.0, 25.0], distance, fov_y_deg: 35.0 })
}

fn cameras() -> [Camera; 4] {
    let look_at = LookAtCamera {
        eye: [3.0, 2.0, 4.0],
        target: [0.1; 3],
        up: [0.0, 1.0, 0.0],
        fov_y_deg: 28.0,
    };
    [
        orbit(None),
        orbit(Some(4.5)),
        Camera::LookAt(look_at),
        Camera::Orthographic(OrthographicCamera { orthographic: 1.2 }),
    ]
}

/// Samples of a pixel: coverage, and per sample the cosines and the red irradiance, as bits.
type Pixel = (u32, Vec<[u64; 3]>);

/// Returns the pixels of a part of a picture.
fn pixels(set: &SampleSet, part: PixelArea) -> Vec<Pixel> {
    let image = set.image().unwrap();
    let mut spans: Vec<Option<PixelSpan>> = vec![None; image.coverage.len()];
    image.spans().for_each(|span| spans[span.pixel as usize] = Some(span));
    let bits = |sample: u32| {
        let (pair, _) = set.pair(sample as usize);
        let red = set.irradiance()[0][sample as usize];
        [pair.cos_i().to_bits(), pair.cos_o().to_bits(), u64::from(red.to_bits())]
    };
    let places = (part.y..part.y + part.height)
        .flat_map(|y| (part.x..part.x + part.width).map(move |x| (y * image.width + x) as usize));
    places
        .map(|place| {
            let samples = spans[place].map_or(0..0, |span| span.start..span.end);
            (image.coverage[place].to_bits(), samples.map(bits).collect())
        })
        .collect()
}

/// Largest difference of the coverage of two parts.
fn coverage_difference(a: &[Pixel], b: &[Pixel]) -> f32 {
    let differences = a.iter().zip(b).map(|(a, b)| f32::from_bits(a.0) - f32::from_bits(b.0));
    differences.fold(0.0, |largest, difference| largest.max(difference.abs()))
}

/// The centres of the pixels are multiples of 1/64, so the rays through them have the same bits.
#[test]
fn middle_of_a_wider_picture_is_the_square_picture() {
    let mesh = Mesh::builtin(BuiltinMesh::Knob);
    let size = PictureSize { width: 96, height: 64 };
    let middle = PixelArea { x: 16, y: 0, width: 64, height: 64 };
    for camera in cameras() {
        let scene = scene(camera);
        let parts = |sampling| {
            let square = SampleSet::render(&mesh, &scene, 64, sampling);
            let wide = SampleSet::render(&mesh, &scene, size, sampling);
            let image = wide.image().unwrap();
            assert_eq!((image.width, image.height, image.size_px), (96, 64, size));
            (pixels(&square, PixelArea::whole(64)), pixels(&wide, middle))
        };
        let (square, wide) = parts(Sampling::Fixed(1));
        assert!(square.iter().filter(|pixel| pixel.0 > 0).count() > 500);
        assert!(square == wide, "{:?}", scene.camera);
        let (square, wide) = parts(Sampling::Adaptive);
        let difference = coverage_difference(&square, &wide);
        assert!(difference < 1e-4, "{:?} {difference}", scene.camera);
    }
}

#[test]
fn tall_picture_is_the_middle_of_the_square_one_from_the_same_eye() {
    let mesh = Mesh::builtin(BuiltinMesh::Knob);
    let size = PictureSize { width: 32, height: 64 };
    let middle = PixelArea { x: 16, y: 0, width: 32, height: 64 };
    for camera in cameras().into_iter().skip(1) {
        let scene = scene(camera);
        let square = SampleSet::render(&mesh, &scene, 64, 1);
        let tall = SampleSet::render(&mesh, &scene, size, 1);
        let whole = pixels(&tall, PixelArea::whole(size));
        assert!(whole == pixels(&square, middle), "{:?}", scene.camera);
    }
}

#[test]
fn default_distance_frames_the_sphere_within_the_shorter_side() {
    let mesh = Mesh::builtin(BuiltinMesh::Sphere);
    let half_fov = 17.5f64.to_radians();
    for (width, height) in [(300, 300), (400, 300), (300, 400), (150, 450), (450, 150)] {
        let size = PictureSize { width, height };
        let set = SampleSet::render(&mesh, &scene(orbit(None)), size, Sampling::Adaptive);
        let covered: f64 = set.image().unwrap().coverage.iter().map(|c| f64::from(*c)).sum();
        let narrower = (half_fov.tan() * size.aspect().min(1.0)).atan();
        let share = (narrower.sin() / 1.04).asin().tan() / narrower.tan();
        let expected = 0.5 * f64::from(size.shorter()) * share;
        let radius = (covered / PI).sqrt();
        assert!((radius - expected).abs() < 0.1, "{size}: {radius} {expected}");
    }
}

#[test]
fn area_has_the_pixels_of_the_whole_picture() {
    let mesh = Mesh::builtin(BuiltinMesh::Knob);
    for (width, height) in [(75, 40), (40, 75)] {
        let size = PictureSize { width, height };
        let area = PixelArea { x: width / 3, y: height / 4, width: width / 2, height: height / 2 };
        for sampling in [Sampling::Adaptive, Sampling::Fixed(3)] {
            let scene = scene(orbit(None));
            let whole = SampleSet::render(&mesh, &scene, size, sampling);
            let part = SampleSet::render_area(&mesh, &scene, size, sampling, area);
            let own = PixelArea { x: 0, y: 0, ..area };
            assert!(pixels(&part, own) == pixels(&whole, area), "{size} {sampling}");
        }
    }
}
