//! Sweep of light from environments: prefiltered, and sampled with growing numbers of samples.

use anyhow::{Context, Result};
use brood_eval::{
    CanonicalEvaluator, Developed, EvalError, Evaluator, Gain, GatheredLight, RadianceImage,
    develop_exposed, is_anisotropic, is_prefilterable, lobe_tables, shade, shade_prefiltered,
};
use brood_genome::{Genome, preset::Preset};
use brood_light::{BuiltinEnvironment, LightAssets};
use brood_mesh::{BuiltinMesh, Mesh};
use brood_program::Program;
use brood_scene::{Exposure, LobeShape, PixelArea, Raster, SampleSet, Sampling, Scene};

use crate::chart::{Axis, Cell, Plot, Point, ResultTable, Series, cells};
use crate::measure::{fastest_ms, one_thread};
use crate::output;
use crate::record::Finding;

/// Models: name, and their lines of genome text.
const MODELS: [(&str, &str); 5] = [
    ("Lambert", "lambert\nalbedo 0.6 0.4 0.2"),
    ("metal 0.3", "conductor\nroughness 0.3"),
    ("metal 0.1", "conductor\nroughness 0.1"),
    ("plastic", "rough-plastic\nroughness 0.15"),
    ("streak", "ward\nspecular 0.5 0.5 0.5\nalpha_x 0.06\nalpha_y 0.3"),
];
/// Presets that vary over the surface.
const PRESETS: [&str; 2] = ["marble", "brushed-metal"];
/// Rays per pixel of the reference.
const REFERENCE_RAYS: u16 = 16;

/// Amount of work of the sweep.
struct Workload {
    size_px: u32,
    samples: &'static [u32],
    /// Samples of the reference for each of its rays.
    reference_samples: u32,
    repeats: u32,
}

/// Result for one environment, one material and one way.
struct Outcome {
    series: String,
    way: String,
    /// Milliseconds of the first picture of a view, and of one more material.
    first_ms: f64,
    more_ms: f64,
    /// RMSE in codes.
    error: f64,
    is_default: bool,
}

/// Measures the finding.
pub fn measure(short: bool) -> Result<Vec<Finding>> {
    let workload = if short {
        Workload { size_px: 24, samples: &[4], reference_samples: 16, repeats: 1 }
    } else {
        let samples = &[4, 16, 64];
        Workload { size_px: 64, samples, reference_samples: 256, repeats: 2 }
    };
    let bar = output::spinner("light from environments");
    let mut outcomes = Vec::new();
    for environment in BuiltinEnvironment::ALL {
        let model = |(name, model): &(&'static str, &str)| -> Result<(&'static str, Genome)> {
            Ok((*name, format!("brood 1\n.model {model}\n").parse()?))
        };
        let models = MODELS.iter().map(model);
        let preset = |name: &&'static str| -> Result<(&'static str, Genome)> {
            let preset = Preset::find(name).with_context(|| format!("no preset {name}"))?;
            Ok((*name, preset.genome().clone()))
        };
        for material in models.chain(PRESETS.iter().map(preset)) {
            bar.tick();
            let (name, genome) = material?;
            let series = format!("{name}, {}", environment.name());
            outcomes.extend(sweep(&series, environment, &Program::lower(&genome), &workload)?);
        }
    }
    bar.finish_and_clear();
    Ok(vec![finding(&outcomes, &workload)])
}

/// Measures one environment and one material in every way.
fn sweep(
    series: &str,
    environment: BuiltinEnvironment,
    program: &Program,
    workload: &Workload,
) -> Result<Vec<Outcome>> {
    let (mesh, assets) = (Mesh::builtin(BuiltinMesh::Sphere), LightAssets::default());
    let size_px = workload.size_px;
    let scene = |samples: u32| -> Result<Scene> {
        let image = environment.name();
        let light =
            format!(r#"{{"kind": "environment", "image": "{image}", "samples": {samples}}}"#);
        Ok(serde_json::from_str(&format!(r#"{{"lights": [{light}]}}"#))?)
    };
    let raster = |sampling: Sampling| Raster {
        size_px: size_px.into(),
        sampling,
        area: PixelArea::whole(size_px),
    };
    let shaded = |set: &SampleSet| -> Result<RadianceImage> {
        let mut f = Vec::new();
        CanonicalEvaluator::default().eval(&[program], set, &mut f)?;
        Ok(shade(set, &f))
    };
    let fine = raster(Sampling::Fixed(REFERENCE_RAYS));
    let many = scene(workload.reference_samples)?;
    let reference = shaded(&SampleSet::render_with_assets(&mesh, &many, &assets, fine))?;
    let gain = Gain::of_image(Exposure::Auto, &reference);
    let reference = develop_exposed(&reference, gain);
    let pool = one_thread()?;
    let mut outcomes = Vec::new();
    for samples in workload.samples {
        let scene = scene(*samples)?;
        let make =
            || SampleSet::render_with_assets(&mesh, &scene, &assets, raster(Sampling::Adaptive));
        let (first_ms, _) = pool.install(|| fastest_ms(workload.repeats, || shaded(&make())))?;
        let set = make();
        let (more_ms, image) = pool.install(|| fastest_ms(workload.repeats, || shaded(&set)))?;
        outcomes.push(Outcome {
            series: series.to_owned(),
            way: format!("{samples} samples"),
            first_ms,
            more_ms,
            error: code_error(&develop_exposed(&image, gain), &reference),
            is_default: false,
        });
    }
    let scene = scene(1)?;
    if !is_prefilterable(program) {
        let lobes = if is_anisotropic(program) { LobeShape::Any } else { LobeShape::Round };
        let how = raster(Sampling::Adaptive);
        let make = || SampleSet::render_direct(&mesh, &scene, &assets, how, lobes);
        let (first_ms, _) = pool.install(|| fastest_ms(workload.repeats, || shaded(&make())))?;
        let set = make();
        let (more_ms, image) = pool.install(|| fastest_ms(workload.repeats, || shaded(&set)))?;
        outcomes.push(Outcome {
            series: series.to_owned(),
            way: format!("{} means", lobes.samples()),
            first_ms,
            more_ms,
            error: code_error(&develop_exposed(&image, gain), &reference),
            is_default: true,
        });
        return Ok(outcomes);
    }
    let gathered = || {
        let how = raster(Sampling::Adaptive);
        let (set, light) = SampleSet::render_prefiltered(&mesh, &scene, &assets, how);
        let kept = GatheredLight::new(&light);
        (set, light, kept)
    };
    let prefiltered = |(set, light, kept): &(_, _, _)| -> Result<RadianceImage> {
        let eval =
            |programs: &[&Program], set: &SampleSet, f: &mut Vec<f32>| -> Result<(), EvalError> {
                CanonicalEvaluator::default().eval(programs, set, f)
            };
        let tables = lobe_tables(&[program], eval)?;
        let mut image = shaded(set)?;
        let pixels = image.coverage().len();
        image.add(&shade_prefiltered(&[&tables[0]], light, Some(kept), pixels)[0]);
        Ok(image)
    };
    let view = gathered();
    let (first_ms, _) =
        pool.install(|| fastest_ms(workload.repeats, || prefiltered(&gathered())))?;
    let (more_ms, image) = pool.install(|| fastest_ms(workload.repeats, || prefiltered(&view)))?;
    outcomes.push(Outcome {
        series: series.to_owned(),
        way: "prefiltered".to_owned(),
        first_ms,
        more_ms,
        error: code_error(&develop_exposed(&image, gain), &reference),
        is_default: true,
    });
    Ok(outcomes)
}

/// Root mean square difference in codes of the pixels that both pictures cover fully and whose
/// neighbours are covered.
fn code_error(own: &Developed, reference: &Developed) -> f64 {
    let (width, height) = (own.width as usize, own.height as usize);
    let is_inside = |x: usize, y: usize| {
        let alpha = |x: usize, y: usize| {
            own.rgba[4 * (y * width + x) + 3].min(reference.rgba[4 * (y * width + x) + 3])
        };
        (y - 1..=y + 1).all(|y| (x - 1..=x + 1).all(|x| alpha(x, y) == 255))
    };
    let (mut squares, mut count) = (0.0, 0usize);
    for y in 1..height - 1 {
        for x in (1..width - 1).filter(|x| is_inside(*x, y)) {
            let at = 4 * (y * width + x);
            for (own, reference) in own.rgba[at..at + 3].iter().zip(&reference.rgba[at..at + 3]) {
                squares += f64::from(own.abs_diff(*reference)).powi(2);
                count += 1;
            }
        }
    }
    (squares / count.max(1) as f64).sqrt()
}

fn finding(outcomes: &[Outcome], workload: &Workload) -> Finding {
    let mut table = ResultTable::default();
    let mut series: Vec<Series> = Vec::new();
    for outcome in outcomes {
        table.push(cells! {
            knob: "light from an environment",
            value: outcome.way.as_str(),
            time_ms: outcome.first_ms,
            more_ms: outcome.more_ms,
            error: outcome.error,
            error_metric: "RMSE in codes",
            series: outcome.series.as_str(),
            default: Cell::yes_if(outcome.is_default),
        });
        let point = Point {
            x: outcome.more_ms,
            y: outcome.error,
            is_default: outcome.is_default,
            ..Point::default()
        };
        match series.last_mut() {
            Some(last) if last.name == outcome.series => last.points.push(point),
            _ => series.push(Series::dotted(&outcome.series, std::iter::once(point))),
        }
    }
    let Workload { size_px, reference_samples, .. } = workload;
    let samples = u32::from(REFERENCE_RAYS) * reference_samples;
    let chart = Plot {
        title: "Light from environments".to_owned(),
        subtitle: format!("sphere, {size_px} x {size_px} pixels; against {samples} samples"),
        x: Axis::log("milliseconds of one more material"),
        y: Axis::log("RMSE in codes"),
        series,
    };
    Finding {
        name: "environment",
        note: format!(
            "Sphere at {size_px} x {size_px}, adaptive, without shadows, automatic exposure; RMSE in codes of pixels \
             away from the silhouette, against {samples} samples of each pixel; time of the first picture of a view, and of \
             one more material (more_ms); the last way of each row is the default; one thread"
        ),
        table,
        raw: None,
        chart: chart.into(),
    }
}
