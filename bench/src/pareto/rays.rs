//! Sweep of every fixed number of samples per pixel: the error must fall with each step.

use std::path::Path;

use anyhow::{Context, Result};
use brood_genome::Genome;
use brood_mesh::{BuiltinMesh, Mesh};
use brood_program::Program;
use brood_scene::{SampleSet, Sampling, Scene};
use rayon::prelude::*;

use crate::chart::{Axis, Cell, Plot, Point, Quartiles, ResultTable, Series, cells};
use crate::measure::{difference, median, programs};
use crate::output;
use crate::picture::{self, Mode, ModeRenderer, ReferenceRender};
use crate::published::Published;
use crate::record::Finding;

/// Measured metals, by published fits of the SGD model.
const METALS: [&str; 3] = ["alum-bronze", "aluminium", "chrome"];

/// Amount of work of the sweep.
struct Workload {
    size_px: u32,
    /// Samples per pixel are 1 to this number.
    most: u32,
    reference_samples: u16,
}

/// Materials on a mesh, measured together.
struct Subject {
    name: String,
    mesh: BuiltinMesh,
    programs: Vec<Program>,
}

/// Quartiles of the error over the materials of a subject, by samples per pixel.
struct Curve {
    name: String,
    materials: usize,
    errors: Vec<(u32, Quartiles)>,
    reference_rmse: f64,
}

/// Measures the finding with a random material of each seed; metals need the folder of published
/// fits.
pub fn measure(short: bool, seeds: &[u64], data: Option<&Path>) -> Result<Finding> {
    let workload = if short {
        Workload { size_px: 16, most: 16, reference_samples: 255 }
    } else {
        Workload { size_px: 32, most: 1024, reference_samples: 16383 }
    };
    let random = |mesh: BuiltinMesh| Subject {
        name: mesh.name().to_owned(),
        mesh,
        programs: seeds.iter().flat_map(|seed| programs(*seed, 1)).collect(),
    };
    let mut subjects = vec![random(BuiltinMesh::Sphere), random(BuiltinMesh::Knob)];
    if let Some(data) = data {
        let published = Published::read(&data.join("tables"))?;
        for name in METALS {
            let model = published
                .model("sgd", name)
                .with_context(|| format!("no published fit of {name}"))?;
            let programs = vec![Program::lower(&Genome::of_models(vec![model.clone()])?)];
            subjects.push(Subject { name: name.to_owned(), mesh: BuiltinMesh::Sphere, programs });
        }
    }
    let bar = output::bar(subjects.len() as u64, "samples per pixel");
    let curve = |subject: &Subject| {
        let curve = curve(subject, &workload);
        bar.inc(1);
        curve
    };
    let curves: Vec<Curve> = subjects.iter().map(curve).collect::<Result<_>>()?;
    bar.finish_and_clear();
    Ok(finding(&curves, seeds.len(), &workload))
}

fn curve(subject: &Subject, workload: &Workload) -> Result<Curve> {
    let (mesh, scene) = (Mesh::builtin(subject.mesh), Scene::default());
    let size_px = workload.size_px;
    let reference = ReferenceRender {
        mesh: &mesh,
        scene: &scene,
        size_px,
        samples: workload.reference_samples,
    };
    let programs: Vec<&Program> = subject.programs.iter().collect();
    let exact = reference.pictures(&programs, || ());
    let halves = reference.halved().pictures(&programs, || ());
    // One exposure for all numbers of rays.
    let default = Mode::default();
    let mut renderer =
        ModeRenderer::new(&mesh, &scene, size_px, (default, default.set(&mesh, &scene, size_px)));
    let evs: Vec<f64> =
        programs.iter().map(|program| Ok(renderer.picture(program)?.1)).collect::<Result<_>>()?;
    let exposed = |pictures: &[Vec<[f64; 3]>]| -> Vec<Vec<[f64; 3]>> {
        pictures.iter().zip(&evs).map(|(picture, ev)| picture::expose(picture, *ev)).collect()
    };
    let (exact, halves) = (exposed(&exact), exposed(&halves));
    let rmse = |a: &[[f64; 3]], b: &[[f64; 3]]| difference(a, b, 1.0).rmse;
    let reference_rmse = median(exact.iter().zip(&halves).map(|(a, b)| rmse(a, b)));
    let error = |sampling: Sampling| {
        let set = SampleSet::render(&mesh, &scene, size_px, sampling);
        let mut f = Vec::new();
        let mut errors = Vec::new();
        for ((program, exact), ev) in programs.iter().zip(&exact).zip(&evs) {
            let image = picture::canonical(&set, program, &mut f)?;
            errors.push(rmse(&picture::exposed(image.premultiplied(), *ev), exact));
        }
        Ok((sampling.min_rays(), Quartiles::of(&errors)))
    };
    // Numbers that are rounded up to another have its picture.
    let mut samplings: Vec<Sampling> = (1..=workload.most).map(Sampling::from).collect();
    samplings.dedup();
    let errors = samplings.into_par_iter().map(error).collect::<Result<_>>()?;
    let (name, materials) = (subject.name.clone(), programs.len());
    Ok(Curve { name, materials, errors, reference_rmse })
}

impl Curve {
    /// Number of errors above the least so far, and the largest ratio to it.
    fn rises(&self) -> (usize, f64) {
        let (mut least, mut rises, mut largest) = (f64::INFINITY, 0, 1.0f64);
        for (_, error) in &self.errors {
            rises += usize::from(error.median > least);
            largest = largest.max(error.median / least);
            least = least.min(error.median);
        }
        (rises, largest)
    }

    fn at(&self, samples: u32) -> f64 {
        let found = self.errors.iter().find(|(number, _)| *number == samples);
        found.map_or(f64::NAN, |found| found.1.median)
    }
}

fn finding(curves: &[Curve], seeds: usize, workload: &Workload) -> Finding {
    let Workload { size_px, most, reference_samples } = workload;
    let (mut table, mut raw) = (ResultTable::default(), ResultTable::default());
    for curve in curves {
        let (rises, largest_rise) = curve.rises();
        table.push(cells! {
            subject: curve.name.clone(),
            materials: curve.materials,
            rmse_1: curve.at(1),
            rmse_4: curve.at(4),
            rmse_16: curve.at(16),
            rmse_64: curve.at(64),
            rmse_256: curve.at(256),
            rmse_1024: curve.at(1024),
            steps: curve.errors.len(),
            above_least: rises,
            largest_rise: largest_rise,
            reference_rmse: curve.reference_rmse,
        });
        for (samples, error) in &curve.errors {
            let rmse = Cell::Quartiles(*error);
            let samples = *samples as usize;
            raw.push(cells! { subject: curve.name.clone(), samples: samples, rmse: rmse });
        }
    }
    Finding {
        name: "rays",
        note: format!(
            "every number of samples per pixel from 1 to {most}, rounded up to a power of two as pictures do it, \
             {size_px} x {size_px} pixels; median RMSE of linear light after \
             exposure, clamped to 0..1, against {reference_samples} rays in f64; the sphere and the knob have a random \
             material of each of {seeds} seeds; above_least counts powers with a \
             larger error than a lower power has, largest_rise is the largest ratio to the least error of lower powers"
        ),
        table,
        raw: Some(raw),
        chart: Plot {
            title: "Every number of samples per pixel".to_owned(),
            subtitle: format!(
                "{size_px} x {size_px} pixels, median and quartiles of {seeds} random materials on sphere and knob; \
                 against {reference_samples} rays in f64"
            ),
            x: Axis::log("samples per pixel"),
            y: Axis::log("RMSE of linear light after exposure"),
            series: curves.iter().map(series).collect(),
        }
        .into(),
    }
}

fn series(curve: &Curve) -> Series {
    let points = curve.errors.iter().map(|(samples, error)| Point {
        x: f64::from(*samples),
        y: error.median,
        y_spread: error.spread(),
        ..Point::default()
    });
    Series { name: curve.name.clone(), points: points.collect(), dots: false }
}
