//! Lambert sphere used to compare renderers: every sampling mode, on one thread.
//!
//! The reference is the f64 picture of this program at 4096 samples per pixel.

use std::f64::consts::PI;

use anyhow::{Context, Result};
use brood_genome::Genome;
use brood_light::Light;
use brood_mesh::{BuiltinMesh, Mesh};
use brood_program::Program;
use brood_scene::{Camera, OrthographicCamera, Scene};
use glam::DVec3;
use serde::Serialize;

use crate::chart::{Axis, Cell, Plot, Point, ResultTable, Series, cells};
use crate::measure::{difference, fastest_ms, one_thread};
use crate::output;
use crate::picture::{self, Mode, ReferenceRender};
use crate::record::Folder;

/// Half the side of the view.
const HALF: f64 = 1.05;
/// Far enough that the light is parallel and even to 1e-6.
const LIGHT_DISTANCE: f64 = 4e6;

#[derive(Serialize)]
struct Report<'a> {
    scene: &'static str,
    size_px: u32,
    albedo: f64,
    light: &'static str,
    error_metric: &'static str,
    reference_samples: u16,
    /// RMSE between the reference and one with half as many samples: an estimate of the reference's
    /// own error.
    reference_rmse: f64,
    rows: &'a ResultTable,
}

/// Measures, prints, and writes lambert-sphere.{json,csv,svg}.
pub fn run(short: bool, folder: &Folder, json: bool) -> Result<()> {
    let (size_px, reference_samples, repeats) = if short { (64, 256, 3) } else { (256, 4096, 25) };
    let program = lambert()?;
    let (mesh, scene) = (Mesh::builtin(BuiltinMesh::Sphere), scene());
    let reference_render =
        ReferenceRender { mesh: &mesh, scene: &scene, size_px, samples: reference_samples };
    let bar =
        output::bar(reference_render.steps() + reference_render.halved().steps(), "reference");
    let reference = reference_render.pictures(&[&program], || bar.inc(1)).remove(0);
    let half = reference_render.halved().pictures(&[&program], || bar.inc(1)).remove(0);
    bar.finish_and_clear();
    let reference_rmse = difference(&half, &reference, f64::INFINITY).rmse;
    let pool = one_thread()?;
    let mut table = ResultTable::default();
    let mut points = Vec::new();
    for mode in Mode::all() {
        let (set_ms, set) =
            pool.install(|| fastest_ms(3, || Ok(mode.set(&mesh, &scene, size_px))))?;
        let mut f = Vec::new();
        let (picture_ms, image) =
            pool.install(|| fastest_ms(repeats, || picture::canonical(&set, &program, &mut f)))?;
        let rmse =
            difference(&picture::exposed(image.premultiplied(), 0.0), &reference, f64::INFINITY)
                .rmse;
        table.push(cells! {
            mode: mode.name(),
            rmse: rmse,
            picture_ms_one_thread: picture_ms,
            set_ms_one_thread: set_ms,
            samples: set.len(),
            default: Cell::yes_if(mode.is_default()),
        });
        points.push(Point {
            x: picture_ms,
            y: rmse,
            label: mode.name(),
            is_default: mode.is_default(),
            is_detached: mode.is_adaptive(),
            ..Point::default()
        });
    }
    let report = Report {
        scene: "lambert-sphere",
        size_px,
        albedo: 1.0,
        light: "parallel from normalise(1, 1, sqrt 2), irradiance pi",
        error_metric: "RMSE of linear radiance over all pixels and channels",
        reference_samples,
        reference_rmse,
        rows: &table,
    };
    let chart = chart(points, size_px, reference_samples);
    folder.write("lambert-sphere.csv", &table.csv())?;
    folder.write("lambert-sphere.svg", &chart.svg())?;
    folder.add_json("lambert-sphere", &report)?;
    if json {
        return output::print_json(&report);
    }
    output::print(&format!(
        "Lambert sphere, {size_px} x {size_px}, one thread; RMSE against {reference_samples} samples in f64, which differ \
         from half as many by {reference_rmse:.1e}\n{}",
        table.text()
    ))
}

/// Program of f = 1 / pi.
fn lambert() -> Result<Program> {
    let root = libm::sqrt(1.0 / PI) as f32;
    let text = format!(
        "brood 1\n.dialect paper smooth registers 7\n.const C0 {root} 0 0 0\nMOV R0, C0.x\n"
    );
    let genome: Genome = text.parse().context("read the Lambert material")?;
    Ok(Program::lower(&genome))
}

fn scene() -> Scene {
    let position = DVec3::new(1.0, 1.0, 2f64.sqrt()).normalize() * LIGHT_DISTANCE;
    Scene {
        camera: Camera::Orthographic(OrthographicCamera { orthographic: HALF }),
        lights: vec![Light::point_at(position.to_array())],
        ..Scene::default()
    }
}

fn chart(points: Vec<Point>, size_px: u32, reference_samples: u16) -> Plot {
    Plot {
        title: "Lambert sphere: samples per pixel".to_owned(),
        subtitle: format!(
            "{size_px} x {size_px} pixels, one thread, sample set precomputed; RMSE against {reference_samples} samples in f64"
        ),
        x: Axis::log("time of a picture, ms"),
        y: Axis::log("RMSE of linear radiance"),
        series: vec![Series::dotted("modes", points.into_iter())],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lambert_sphere_is_the_cosine_on_a_black_background() {
        let (mesh, scene) = (Mesh::builtin(BuiltinMesh::Sphere), scene());
        let reference = ReferenceRender { mesh: &mesh, scene: &scene, size_px: 64, samples: 4 };
        let picture = reference.pictures(&[&lambert().unwrap()], || ()).remove(0);
        let brightest = picture.iter().map(|rgb| rgb[0]).fold(0.0, f64::max);
        assert!((brightest - 1.0).abs() < 2e-3 && picture[0] == [0.0; 3], "{brightest}");
        // At the pixel in the middle n is z, and cos_i is sqrt(1/2).
        assert!((picture[32 * 64 + 32][0] - 0.5f64.sqrt()).abs() < 0.02);
        // The light comes from the upper right.
        assert!(picture[15 * 64 + 47][0] > 0.9 && picture[50 * 64 + 14][0] < 0.1);
    }
}
