//! Sweep of the samples per light at each shading point, for area lights, environments and ambient
//! light.

use std::sync::Arc;

use anyhow::Result;
use brood_brdf::{Brdf, Model, ModelKind};
use brood_eval::shade_brdf;
use brood_light::{AREA_SAMPLES, ENVIRONMENT_SAMPLES, EnvironmentMap, LightAssets};
use brood_mesh::{BuiltinMesh, Mesh};
use brood_scene::{PixelArea, Raster, SampleSet, Sampling, Scene};

use crate::chart::{Axis, Cell, Plot, Point, ResultTable, Series, cells};
use crate::measure::{fastest_ms, one_thread};
use crate::output;
use crate::record::Finding;

/// Amount of work of the sweep.
struct Workload {
    size_px: u32,
    samples_max: u32,
    reference_samples: u32,
    repeats: u32,
}

/// Lights that share a chart.
struct Group {
    name: &'static str,
    title: &'static str,
    /// Name and JSON of each light, without its samples and closing brace.
    lights: &'static [(&'static str, &'static str)],
    /// Samples that the product uses.
    default_samples: u32,
}

const GROUPS: [Group; 2] = [
    Group {
        name: "light-samples-area",
        title: "Samples of a light with an area",
        lights: &[
            ("sphere", r#"{"kind": "sphere", "radius": 1"#),
            ("disk", r#"{"kind": "disk", "radius": 1"#),
            ("rectangle", r#"{"kind": "rectangle", "width": 2, "height": 1"#),
        ],
        default_samples: AREA_SAMPLES,
    },
    Group {
        name: "light-samples-environment",
        title: "Samples of light from all around",
        lights: &[
            ("environment", r#"{"kind": "environment", "image": "sky""#),
            ("ambient", r#"{"kind": "ambient""#),
        ],
        default_samples: ENVIRONMENT_SAMPLES,
    },
];

/// Result for one light, one material and one number of samples.
struct LightResult {
    series: String,
    samples: u32,
    time_ms: f64,
    error: f64,
    /// Distance of the reference from one with half as many samples.
    reference_error: f64,
}

/// Measures one finding for each group.
pub fn measure(short: bool) -> Result<Vec<Finding>> {
    let workload = if short {
        Workload { size_px: 24, samples_max: 16, reference_samples: 64, repeats: 1 }
    } else {
        Workload { size_px: 96, samples_max: 256, reference_samples: 1024, repeats: 2 }
    };
    let glossy = Model::new(ModelKind::CookTorrance).with("roughness", &[0.3])?;
    let materials = [("", Model::new(ModelKind::Lambert).brdf()), (", GGX", glossy.brdf())];
    let mut assets = LightAssets::default();
    assets.insert_environment("sky", Arc::new(sky()?));
    let bar = output::spinner("samples of lights");
    let mut findings = Vec::new();
    for group in GROUPS {
        let mut results = Vec::new();
        for (light, json) in group.lights {
            for (material, brdf) in &materials {
                bar.tick();
                let name = format!("{light}{material}");
                results.extend(sweep(&name, json, &**brdf, &assets, &workload)?);
            }
        }
        findings.push(finding(&group, &results, &workload));
    }
    bar.finish_and_clear();
    Ok(findings)
}

/// Sky that darkens downwards, with a sun of 4 degrees and a dim ground.
fn sky() -> Result<EnvironmentMap> {
    let (width, height) = (256usize, 128usize);
    let pixel = |index: usize| {
        let (x, y) = (index % width, index / width);
        let up = 1.0 - 2.0 * (y as f32 + 0.5) / height as f32;
        let sun = x.abs_diff(150) <= 1 && y.abs_diff(32) <= 1;
        match (sun, up > 0.0) {
            (true, _) => [600.0, 560.0, 500.0],
            (_, true) => [0.4 + 0.3 * up, 0.6 + 0.4 * up, 1.0],
            (_, false) => [0.15, 0.13, 0.1],
        }
    };
    Ok(EnvironmentMap::new(width, height, (0..width * height).map(pixel).collect())?)
}

/// Measures one light and one material at growing numbers of samples.
fn sweep(
    series: &str,
    light: &str,
    brdf: &dyn Brdf,
    assets: &LightAssets,
    workload: &Workload,
) -> Result<Vec<LightResult>> {
    let mesh = Mesh::builtin(BuiltinMesh::Sphere);
    let picture = |samples: u32| -> Result<Vec<f64>> {
        let json = format!(r#"{{"lights": [{light}, "samples": {samples}}}]}}"#);
        let scene: Scene = serde_json::from_str(&json)?;
        let area = PixelArea::whole(workload.size_px);
        let raster =
            Raster { size_px: workload.size_px.into(), sampling: Sampling::Fixed(1), area };
        let set = SampleSet::render_with_assets(&mesh, &scene, assets, raster);
        let image = shade_brdf(&set, brdf);
        Ok(image.premultiplied().as_flattened().iter().map(|c| f64::from(*c)).collect())
    };
    let reference = picture(workload.reference_samples)?;
    let reference_error = relative(&picture(workload.reference_samples / 2)?, &reference);
    let pool = one_thread()?;
    let mut results = Vec::new();
    let mut samples = 1;
    while samples <= workload.samples_max {
        let (time_ms, pixels) =
            pool.install(|| fastest_ms(workload.repeats, || picture(samples)))?;
        let error = relative(&pixels, &reference);
        let series = series.to_owned();
        results.push(LightResult { series, samples, time_ms, error, reference_error });
        samples *= 2;
    }
    Ok(results)
}

/// Root mean square difference over the mean of the reference, taken where the reference is not
/// black.
fn relative(pixels: &[f64], reference: &[f64]) -> f64 {
    let lit = || pixels.iter().zip(reference).filter(|(_, reference)| **reference > 0.0);
    let count = lit().count().max(1) as f64;
    let squares: f64 = lit().map(|(own, reference)| (own - reference) * (own - reference)).sum();
    let mean = reference.iter().sum::<f64>() / count;
    (squares / count).sqrt() / mean
}

fn finding(group: &Group, results: &[LightResult], workload: &Workload) -> Finding {
    let mut table = ResultTable::default();
    for result in results {
        table.push(cells! {
            knob: "samples of a light",
            value: result.samples.to_string(),
            time_ms: result.time_ms,
            error: result.error,
            error_metric: "RMSE over mean",
            light: result.series.as_str(),
            reference_error: result.reference_error,
            default: Cell::yes_if(result.samples == group.default_samples),
        });
    }
    let point = |result: &LightResult| Point {
        x: f64::from(result.samples),
        y: result.error,
        is_default: result.samples == group.default_samples,
        ..Point::default()
    };
    let mut series: Vec<Series> = Vec::new();
    for result in results {
        match series.last_mut() {
            Some(last) if last.name == result.series => last.points.push(point(result)),
            _ => series.push(Series::dotted(&result.series, [point(result)].into_iter())),
        }
    }
    let Workload { size_px, reference_samples, .. } = workload;
    let chart = Plot {
        title: group.title.to_owned(),
        subtitle: format!(
            "Lambert, or GGX of roughness 0.3: sphere, {size_px} x {size_px} pixels, without shadows; against {reference_samples} samples"
        ),
        x: Axis::log("samples per light at each point"),
        y: Axis::log("RMSE of radiance over its mean"),
        series,
    };
    Finding {
        name: group.name,
        note: format!(
            "Lambert, or GGX of roughness 0.3 (marked): sphere at {size_px} x {size_px}, one ray per pixel, no shadows; RMSE of linear \
             radiance over its mean, against {reference_samples} \
             samples, which differ from half as many by reference_error; sampling, evaluation and shading on one thread"
        ),
        table,
        raw: None,
        chart: chart.into(),
    }
}
