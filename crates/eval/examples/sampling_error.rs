//! Prints error and time of each way to sample a picture: `sampling_error [SIZE]
//! [REFERENCE_SAMPLES] [GENOMES]`.
//!
//! RMSE is over red, green and blue of all pixels, linear, premultiplied, exposure applied. The
//! largest difference is of 8-bit codes where both pictures fully cover the pixel. One reference
//! picture per genome and mesh.

use std::time::Instant;

use brood_eval::{
    CanonicalEvaluator, Evaluator, Gain, RadianceImage, develop_samples, encode_png, encode_srgb,
    shade,
};
use brood_genome::{BirthKey, Dialect, Genome, Variation};
use brood_light::{DirectionalLight, Light};
use brood_mesh::{BuiltinMesh, Mesh};
use brood_program::Program;
use brood_scene::{Camera, Exposure, OrthographicCamera, PixelArea, SampleSet, Sampling, Scene};

const MODES: [Sampling; 5] = [
    Sampling::Fixed(1),
    Sampling::Fixed(4),
    Sampling::Fixed(16),
    Sampling::Fixed(64),
    Sampling::Adaptive,
];
/// Lambertian genome of albedo 0.8: f is the square of the register.
const LAMBERT: &str = "brood 1
.dialect paper smooth registers 7 isotropic homogeneous
.const C0 0.50462651 0.50462651 0.50462651 0
MOV R0, C0
";

fn main() {
    let numbers: Vec<u32> =
        std::env::args().skip(1).map(|word| word.parse().expect("a number")).collect();
    let number = |index: usize, default| numbers.get(index).copied().unwrap_or(default);
    let (size_px, reference, genomes) = (number(0, 128), number(1, 1024), number(2, 20));
    let random = Variation::random(Dialect::default());
    let programs: Vec<Program> = (0..genomes)
        .map(|slot| Program::lower(&random.birth(BirthKey { seed: 1, slot, attempt: 0 })))
        .collect();
    for name in [BuiltinMesh::Sphere, BuiltinMesh::Knob] {
        println!("{} at {size_px} px, {genomes} random genomes", name.name());
        table(&Mesh::builtin(name), &Scene::default(), size_px, reference, &programs);
    }
    let sphere = Mesh::builtin(BuiltinMesh::Sphere);
    let programs = match LAMBERT.parse::<Genome>() {
        Ok(genome) => vec![Program::lower(&genome)],
        Err(error) => panic!("the Lambert genome cannot be read: {error}"),
    };
    println!("Lambert sphere of albedo 0.8 in directional light, orthographic, at {size_px} px");
    table(&sphere, &lambert_scene(), size_px, reference, &programs);
}

/// The unit sphere over [-1.05, 1.05]^2 in parallel light of irradiance pi from (1, 1, sqrt 2).
fn lambert_scene() -> Scene {
    let direction = Some([-0.5, -0.5, -std::f64::consts::FRAC_1_SQRT_2]);
    let mut scene = Scene {
        camera: Camera::Orthographic(OrthographicCamera { orthographic: 1.05 }),
        lights: vec![Light::Directional(DirectionalLight { direction, strength: None })],
        ..Scene::default()
    };
    scene.film.exposure = Exposure::Ev(0.0);
    scene
}

fn table(mesh: &Mesh, scene: &Scene, size_px: u32, samples: u32, programs: &[Program]) {
    let references = references(mesh, scene, size_px, samples, programs);
    println!(
        "{:>9} {:>9} {:>9} {:>8} {:>9} {:>8} {:>8} {:>8} {:>8} {:>8}",
        "samples",
        "rmse",
        "worst",
        "8-bit",
        "set ms",
        "eval us",
        "shade us",
        "film us",
        "png us",
        "shaded"
    );
    for mode in MODES {
        let start = Instant::now();
        let set = SampleSet::render(mesh, scene, size_px, mode);
        let set_ms = start.elapsed().as_secs_f64() * 1e3;
        let (mut sum, mut worst, mut code) = (0.0, 0.0f64, 0);
        let mut times = [f64::INFINITY; 4];
        let mut f = Vec::new();
        let least = |time: &mut f64, work: &mut dyn FnMut()| {
            for _ in 0..5 {
                let start = Instant::now();
                work();
                *time = time.min(start.elapsed().as_secs_f64() * 1e6);
            }
        };
        for (program, reference) in programs.iter().zip(&references) {
            let evaluator = CanonicalEvaluator::default();
            least(&mut times[0], &mut || {
                evaluator.eval(&[program], &set, &mut f).expect("the CPU evaluates");
            });
            least(&mut times[1], &mut || drop(std::hint::black_box(shade(&set, &f))));
            let gain = Gain::new(scene.film.exposure, &set, &f);
            let mut developed = develop_samples(&set, &f, gain);
            least(&mut times[2], &mut || {
                let gain = Gain::new(scene.film.exposure, &set, &f);
                developed = develop_samples(&set, &f, gain);
            });
            least(&mut times[3], &mut || {
                drop(std::hint::black_box(encode_png(size_px, size_px, &developed.rgba)));
            });
            let (rmse, difference) = difference(&shade(&set, &f), reference, gain.ev);
            sum += rmse;
            worst = worst.max(rmse);
            code = code.max(difference);
        }
        let mean = sum / programs.len() as f64;
        let [eval, shade, film, png] = times;
        println!(
            "{:>9} {mean:>9.2e} {worst:>9.2e} {code:>8} {set_ms:>9.1} {eval:>8.0} {shade:>8.0} {film:>8.0} {png:>8.0} {:>8}",
            mode.to_string(),
            set.len()
        );
    }
}

/// Radiance and coverage of every pixel.
type Reference = Vec<([f64; 3], f64)>;

/// Renders reference pictures row by row, because one set of all samples would not fit in memory.
fn references(
    mesh: &Mesh,
    scene: &Scene,
    size_px: u32,
    samples: u32,
    programs: &[Program],
) -> Vec<Reference> {
    let mut references = vec![Reference::new(); programs.len()];
    let mut f = Vec::new();
    for y in 0..size_px {
        let area = PixelArea { x: 0, y, width: size_px, height: 1 };
        let set = SampleSet::render_area(mesh, scene, size_px, samples, area);
        for (program, reference) in programs.iter().zip(&mut references) {
            CanonicalEvaluator::default().eval(&[program], &set, &mut f).expect("it evaluates");
            let image = shade(&set, &f);
            let pixels = image.premultiplied().iter().zip(image.coverage());
            reference.extend(pixels.map(|(p, c)| (p.map(f64::from), f64::from(*c))));
        }
    }
    references
}

/// Returns the RMSE and the largest difference of codes.
fn difference(image: &RadianceImage, reference: &Reference, ev: f64) -> (f64, u8) {
    let factor = libm::exp2(ev);
    let (mut sum, mut code) = (0.0, 0);
    let pixels = image.premultiplied().iter().zip(image.coverage()).zip(reference);
    for ((own, coverage), (expected, whole)) in pixels {
        for (own, expected) in own.iter().zip(expected) {
            let (own, expected) = (f64::from(*own) * factor, expected * factor);
            // Values above 1 are shown as 1.
            sum += (own.min(1.0) - expected.min(1.0)).powi(2);
            if *coverage >= 1.0 && *whole >= 1.0 {
                code = code.max(encode_srgb(own as f32).abs_diff(encode_srgb(expected as f32)));
            }
        }
    }
    ((sum / (3 * reference.len()) as f64).sqrt(), code)
}
