//! Sweep of materials with highlights finer than a pixel: adaptive sampling against many rays.

use std::path::Path;

use anyhow::{Context, Result};
use brood_brdf::Brdf;
use brood_eval::RadianceImage;
use brood_genome::Genome;
use brood_inspect::Shot;
use brood_light::LightAssets;
use brood_mesh::{BuiltinMesh, Mesh, ObjLimits, parse_obj};
use brood_scene::{PictureSize, SampleSet, Sampling, Scene, Tangents};

use crate::chart::{Axis, Plot, Point, ResultTable, Series, cells};
use crate::measure::{fastest_ms, fastest_of_each_ms};
use crate::output;
use crate::record::Finding;

/// Name and model of each material, from wide to narrow lobes.
const MATERIALS: [(&str, &str); 7] = [
    ("Lambert", "lambert\nalbedo 0.5 0.3 0.2"),
    ("gold .2", "conductor\nroughness 0.2"),
    (
        "Ward .1 x .3",
        "ward\ndiffuse 0.3 0.2 0.1\nspecular 0.2 0.2 0.2\nalpha_x 0.1\nalpha_y 0.3\nform ward",
    ),
    (
        "principled",
        "principled\nbase_color 0.6 0.2 0.1\nroughness 0.35\nclearcoat 0.6\nclearcoat_gloss 0.8",
    ),
    ("plastic .05", "rough-plastic\nalbedo 0.1 0.27 0.36\nroughness 0.05"),
    ("gold .05", "conductor\nroughness 0.05"),
    (
        "Ward .02 x .3",
        "ward\ndiffuse 0.3 0.2 0.1\nspecular 0.2 0.2 0.2\nalpha_x 0.02\nalpha_y 0.3\nform ward",
    ),
];

/// Object and its scene.
struct Subject {
    name: &'static str,
    size_px: u32,
    mesh: Mesh,
    scene: Scene,
}

/// Measures the finding; the object of a file needs the folder of meshes.
pub fn measure(short: bool, data: Option<&Path>) -> Result<Finding> {
    // Sizes are those of the comparison with another renderer.
    let ([sphere_px, mesh_px], rays, repeats) =
        if short { ([32, 48], 255, 1) } else { ([128, 192], 1023, 5) };
    let subject = |name, size_px, mesh| Subject { name, size_px, mesh, scene: Scene::default() };
    let mut subjects = vec![
        subject("sphere", sphere_px, Mesh::builtin(BuiltinMesh::Sphere)),
        subject("knob", mesh_px, Mesh::builtin(BuiltinMesh::Knob)),
    ];
    if let Some(data) = data {
        let path = data.join("meshes/spot_triangulated.obj");
        let bytes = output::read_file(&path, 64 << 20)?;
        let file = parse_obj(&bytes, &ObjLimits::default());
        let mesh = file.with_context(|| path.display().to_string())?.mesh;
        let mut own_tangents = subject("spot, own tangents", mesh_px, mesh.clone());
        own_tangents.scene.tangents = Tangents::Triangle;
        subjects.extend([subject("spot", mesh_px, mesh), own_tangents]);
    }
    let assets = LightAssets::default();
    let bar = output::bar((subjects.len() * MATERIALS.len()) as u64, "highlights");
    let mut table = ResultTable::default();
    let mut series = Vec::new();
    for subject in &subjects {
        let Subject { name: object, size_px, mesh, scene } = subject;
        let (size_px, sampling) = (PictureSize::from(*size_px), Sampling::Adaptive);
        let shot = Shot { mesh, scene, assets: &assets, size_px, sampling };
        let fine = SampleSet::render(mesh, scene, size_px, Sampling::Fixed(rays));
        let (set_ms, set) = fastest_ms(repeats, || Ok(shot.set()))?;
        let mut points = Vec::new();
        for (index, (name, model)) in MATERIALS.iter().enumerate() {
            let genome: Genome = format!("brood 1\n.model {model}\n").parse()?;
            let models: Vec<Box<dyn Brdf>> =
                genome.layers().iter().map(|layer| -> Box<dyn Brdf> { layer.brdf() }).collect();
            let material = models.first().context("a material has a model")?;
            let reference = brood_eval::shade_brdf(&fine, material.as_ref());
            let (mut before, mut after) = (None, None);
            let [unrefined_ms, refined_ms] = fastest_of_each_ms(
                repeats,
                [
                    &mut || {
                        before = Some(brood_eval::shade_brdf(&set, material.as_ref()));
                        Ok(())
                    },
                    &mut || {
                        after = Some(shot.radiance_on(&set, material.as_ref()));
                        Ok(())
                    },
                ],
            )?;
            let (before, (after, refined)) = before.zip(after).context("pictures were made")?;
            let error =
                |image: &RadianceImage| error(image.premultiplied(), reference.premultiplied());
            let after_error = error(&after);
            table.push(cells! {
                object: *object,
                material: *name,
                rmse_over_mean: after_error,
                unrefined: error(&before),
                set_ms: set_ms,
                unrefined_ms: unrefined_ms,
                refined_ms: refined_ms,
                time_ratio: (set_ms + refined_ms) / (set_ms + unrefined_ms),
                set_samples: set.len(),
                more_samples: refined.samples as usize,
            });
            let x = (index + 1) as f64;
            points.push(Point { x, y: after_error, label: (*name).to_owned(), ..Point::default() });
            bar.inc(1);
        }
        series.push(Series::dotted(object, points.into_iter()));
    }
    bar.finish_and_clear();
    Ok(Finding {
        name: "highlight",
        note: format!(
            "adaptive sampling, {sphere_px} x {sphere_px} pixels, meshes {mesh_px} x {mesh_px}, all threads; RMSE of linear radiance over its mean, not \
             clipped, against {rays} rays per pixel; unrefined is the error without refinement; times are those of the linear \
             picture in f64, and time_ratio includes the sample set in both"
        ),
        table,
        raw: None,
        chart: Plot {
            title: "Highlights finer than a pixel".to_owned(),
            subtitle: format!(
                "adaptive, {sphere_px} x {sphere_px} pixels, meshes {mesh_px} x {mesh_px}; against {rays} rays per pixel"
            ),
            x: Axis::log("material, from wide to narrow lobes"),
            y: Axis::log("RMSE of linear radiance over its mean"),
            series,
        }
        .into(),
    })
}

/// RMSE over the mean of the reference.
fn error(picture: &[[f32; 3]], reference: &[[f32; 3]]) -> f64 {
    let pairs = || picture.as_flattened().iter().zip(reference.as_flattened());
    let squares: f64 = pairs().map(|(a, b)| f64::from(a - b).powi(2)).sum();
    let sum: f64 = pairs().map(|(_, b)| f64::from(*b)).sum();
    (squares * pairs().count() as f64).sqrt() / sum
}
