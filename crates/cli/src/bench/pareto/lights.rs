//! Samples of a light at each place: lights with an area, environments and ambient light, each against many samples.

use std::sync::Arc;

use anyhow::Result;
use brood_brdf::{Brdf, Model, ModelKind};
use brood_eval::{model_reflectance, shade};
use brood_scene::{
    AREA_SAMPLES, BuiltinMesh, ENVIRONMENT_SAMPLES, EnvironmentMap, LightAssets, Mesh, PixelArea,
    Raster, SampleSet, Sampling, Scene,
};

use crate::bench::measure::{fastest_ms, one_thread};
use crate::bench::record::Finding;
use crate::chart::{Axis, Plot, Point, Scale, Series, Table};
use crate::output;

/// How much is measured.
struct Extent {
    size_px: u32,
    most: u32,
    reference: u32,
    repeats: u32,
}

/// Lights that are shown in one chart.
struct Group {
    name: &'static str,
    title: &'static str,
    lights: &'static [(&'static str, &'static str)],
    default: u32,
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
        default: AREA_SAMPLES,
    },
    Group {
        name: "light-samples-environment",
        title: "Samples of light from all around",
        lights: &[
            ("environment", r#"{"kind": "environment", "image": "sky""#),
            ("ambient", r#"{"kind": "ambient""#),
        ],
        default: ENVIRONMENT_SAMPLES,
    },
];

/// One light on one material, for one number of samples.
struct Shot {
    series: String,
    samples: u32,
    time_ms: f64,
    error: f64,
    /// Distance of the reference from one of half as many samples.
    floor: f64,
}

/// One finding for each group.
pub fn measure(short: bool) -> Result<Vec<Finding>> {
    let extent = if short {
        Extent { size_px: 24, most: 16, reference: 64, repeats: 1 }
    } else {
        Extent { size_px: 96, most: 256, reference: 1024, repeats: 2 }
    };
    let glossy = Model::new(ModelKind::CookTorrance).with("roughness", &[0.3])?;
    let materials = [("", Model::new(ModelKind::Lambert).brdf()), (", GGX", glossy.brdf())];
    let mut assets = LightAssets::default();
    assets.insert_environment("sky", Arc::new(sky()?));
    let bar = output::spinner("samples of lights");
    let mut findings = Vec::new();
    for group in GROUPS {
        let mut shots = Vec::new();
        for (light, json) in group.lights {
            for (material, brdf) in &materials {
                bar.tick();
                let name = format!("{light}{material}");
                shots.extend(sweep(&name, json, &**brdf, &assets, &extent)?);
            }
        }
        findings.push(finding(&group, &shots, &extent));
    }
    bar.finish_and_clear();
    Ok(findings)
}

/// A sky that darkens downwards, a sun of 4 degrees in it, and a dim ground.
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

fn sweep(
    series: &str,
    light: &str,
    brdf: &dyn Brdf,
    assets: &LightAssets,
    extent: &Extent,
) -> Result<Vec<Shot>> {
    let mesh = Mesh::builtin(BuiltinMesh::Sphere);
    let picture = |samples: u32| -> Result<Vec<f64>> {
        let json = format!(r#"{{"lights": [{light}, "samples": {samples}}}]}}"#);
        let scene: Scene = serde_json::from_str(&json)?;
        let area = PixelArea::whole(extent.size_px);
        let raster = Raster { size_px: extent.size_px, sampling: Sampling::Fixed(1), area };
        let set = SampleSet::render_lit(&mesh, &scene, assets, raster);
        let mut f = Vec::new();
        model_reflectance(brdf, &set, &mut f);
        let image = shade(&set, &f);
        Ok(image.premultiplied().as_flattened().iter().map(|c| f64::from(*c)).collect())
    };
    let reference = picture(extent.reference)?;
    let floor = relative(&picture(extent.reference / 2)?, &reference);
    let pool = one_thread()?;
    let mut shots = Vec::new();
    let mut samples = 1;
    while samples <= extent.most {
        let (time_ms, pixels) = pool.install(|| fastest_ms(extent.repeats, || picture(samples)))?;
        let error = relative(&pixels, &reference);
        shots.push(Shot { series: series.to_owned(), samples, time_ms, error, floor });
        samples *= 2;
    }
    Ok(shots)
}

/// Root mean square difference over the mean of the reference, where that is not black.
fn relative(pixels: &[f64], reference: &[f64]) -> f64 {
    let lit = || pixels.iter().zip(reference).filter(|(_, reference)| **reference > 0.0);
    let count = lit().count().max(1) as f64;
    let squares: f64 = lit().map(|(own, reference)| (own - reference) * (own - reference)).sum();
    let mean = reference.iter().sum::<f64>() / count;
    (squares / count).sqrt() / mean
}

fn finding(group: &Group, shots: &[Shot], extent: &Extent) -> Finding {
    let mut table = Table::new(&[
        "knob",
        "value",
        "time_ms",
        "error",
        "error_metric",
        "light",
        "reference_error",
        "default",
    ]);
    for shot in shots {
        table.push([
            "samples of a light".into(),
            shot.samples.to_string().into(),
            shot.time_ms.into(),
            shot.error.into(),
            "RMSE over mean".into(),
            shot.series.as_str().into(),
            shot.floor.into(),
            if shot.samples == group.default { "yes" } else { "" }.into(),
        ]);
    }
    let point = |shot: &Shot| Point {
        x: f64::from(shot.samples),
        y: shot.error,
        chosen: shot.samples == group.default,
        ..Point::default()
    };
    let mut series: Vec<Series> = Vec::new();
    for shot in shots {
        match series.last_mut() {
            Some(last) if last.name == shot.series => last.points.push(point(shot)),
            _ => series.push(Series {
                name: shot.series.clone(),
                dots: true,
                points: vec![point(shot)],
            }),
        }
    }
    let Extent { size_px, reference, .. } = extent;
    let chart = Plot {
        title: group.title.to_owned(),
        subtitle: format!(
            "Lambert, or GGX of roughness 0.3: sphere, {size_px} x {size_px} pixels, without shadows; against {reference} samples"
        ),
        x: Axis { title: "samples at each place", scale: Scale::Log },
        y: Axis { title: "RMSE of radiance over its mean", scale: Scale::Log },
        series,
    };
    Finding {
        name: group.name,
        note: format!(
            "Lambert, or where said GGX of roughness 0.3: sphere at {size_px} x {size_px}, one ray a pixel, no shadows; RMSE of linear radiance over its mean, against {reference} \
             samples, which differ from half as many by reference_error; sampled, evaluated and shaded on one thread"
        ),
        table,
        raw: None,
        chart: chart.svg(),
    }
}
