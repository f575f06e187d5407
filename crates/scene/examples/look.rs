//! Renders a mesh with a fixed material to a PNG file, to inspect meshes and OBJ files.
//!
//! `look MESH OUT.png [SIZE] [SCENE_JSON] [SAMPLES]`: MESH is a built-in name or an OBJ file. A
//! checkerboard and a highlight stretched along u show texture positions and tangents.

use std::error::Error;
use std::fs;

use brood_mesh::{BuiltinMesh, Mesh, ObjLimits, parse_obj};
use brood_scene::{SampleSet, Sampling, Scene};

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [name, out, rest @ ..] = words.as_slice() else {
        return Err("usage: look MESH OUT.png [SIZE] [SCENE_JSON] [SAMPLES]".into());
    };
    let size_px: u32 = rest.first().map_or(Ok(256), |word| word.parse())?;
    let scene: Scene =
        rest.get(1).map_or(Ok(Scene::default()), |json| serde_json::from_str(json))?;
    scene.validate()?;
    let sampling: Sampling = rest.get(2).map_or(Ok(Sampling::Adaptive), |word| word.parse())?;
    let mesh = match BuiltinMesh::ALL.into_iter().find(|mesh| mesh.name() == name) {
        Some(mesh) => Mesh::builtin(mesh),
        None => read(name)?,
    };
    let start = std::time::Instant::now();
    let samples = SampleSet::render(&mesh, &scene, size_px, sampling);
    println!(
        "{name}: {} vertices, {} triangles, {:?}, first render {:?}",
        mesh.vertex_count(),
        mesh.triangle_count(),
        samples.counts(),
        start.elapsed()
    );
    let start = std::time::Instant::now();
    let second = SampleSet::render(&mesh, &scene, size_px, sampling);
    println!("second render {:?}, at most {} bytes", start.elapsed(), second.bytes());
    let mut encoder = png::Encoder::new(fs::File::create(out)?, size_px, size_px);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header()?.write_image_data(&develop(&samples))?;
    Ok(())
}

fn read(path: &str) -> Result<Mesh, Box<dyn Error>> {
    let file = parse_obj(&fs::read(path)?, &ObjLimits::default())?;
    for warning in &file.warnings {
        println!("line {}: {}", warning.line, warning.text);
    }
    Ok(file.mesh)
}

/// Returns 8-bit grey values of the shaded samples.
fn develop(samples: &SampleSet) -> Vec<u8> {
    let image = samples.image().expect("a rendered set has an image");
    let mut pixels = vec![40u8; image.coverage.len()];
    for (pixel, covered) in pixels.iter_mut().zip(image.coverage.iter()) {
        if *covered > 0.0 {
            *pixel = 0;
        }
    }
    let irradiance = samples.irradiance()[0];
    for span in image.spans() {
        let radiance: f64 = (span.radiance_start..span.end)
            .map(|index| index as usize)
            .map(|index| brdf(samples, index) * f64::from(irradiance[index]))
            .sum();
        let shown = (radiance * f64::from(image.scale)).clamp(0.0, 1.0).powf(1.0 / 2.2);
        pixels[span.pixel as usize] = (255.0 * shown).round() as u8;
    }
    pixels
}

/// Diffuse checkerboard with an anisotropic highlight.
fn brdf(samples: &SampleSet, index: usize) -> f64 {
    let (pair, uv) = samples.pair(index);
    let h = (pair.wi() + pair.wo()).normalize();
    let exponent = (h.x / 0.3).powi(2) + (h.y / 0.08).powi(2);
    let dark = ((uv.x * 16.0).floor() + (uv.y * 16.0).floor()).rem_euclid(2.0) > 0.5;
    let diffuse = if dark { 0.08 } else { 0.13 };
    diffuse + 0.5 * (-exponent / (h.z * h.z)).exp()
}
