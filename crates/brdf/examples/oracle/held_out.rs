//! Error of the interpolation of scattered samples at held-out samples, for models and for
//! measurements.

use std::path::Path;

use brood_brdf::{Brdf, DirectionPair, MeasuredSamples, Model, ModelKind, Scattered};
use glam::DVec3;

use crate::{Failure, Spread, files, pairs};

/// Number of samples of a model, and of held-out samples.
const COUNT: usize = 4096;
/// Models with bounds of the median and of the 99th percentile of relative errors.
const MODELS: [(&str, f64, f64); 7] = [
    ("lambert", 1e-9, 1e-9),
    ("oren-nayar", 1e-4, 1e-2),
    ("conductor\nroughness 0.2", 3e-4, 1e-2),
    ("conductor\nroughness 0.05", 5e-4, 0.1),
    ("rough-plastic\nroughness 0.1", 3e-4, 0.05),
    ("principled", 3e-4, 1e-2),
    ("ward", 3e-4, 0.05),
];

/// Prints the errors. Returns true if those of the models are within their bounds. Measurements
/// have no bounds: they are neither exactly reciprocal nor dense where they are bright.
pub fn check(data: &Path) -> Result<bool, Failure> {
    let mut good = true;
    for (text, median, most) in MODELS {
        let mut lines = text.lines();
        let kind: ModelKind = lines.next().unwrap_or_default().parse()?;
        let model = lines.try_fold(Model::new(kind), |model, line| {
            let (name, values) = line.split_once(' ').unwrap_or((line, ""));
            model.with_text(name, values)
        })?;
        let model = model.brdf();
        let rows = |from: usize| -> Vec<(DirectionPair, DVec3)> {
            directions(from).map(|pair| (pair, model.f(&pair))).take(COUNT).collect()
        };
        let spread = compare(rows(0), &rows(1 << 20))?;
        println!("held out of {}: {spread}", text.replace('\n', ", "));
        good &= spread.median <= median && spread.most <= most;
    }
    let measured = [("oracle", ".csv", "rgl_mitsuba"), ("cornell", "_rgb.csv", "")];
    for (folder, ending, prefix) in measured {
        for (name, path) in files(&data.join(folder), ending)? {
            if !name.starts_with(prefix) {
                continue;
            }
            let rows = pairs(&path)?.into_iter().map(|(pair, rgb)| (pair, DVec3::from_array(rgb)));
            let above = rows.filter(|(pair, _)| pair.cos_i() > 0.0 && pair.cos_o() > 0.0);
            let (asked, known): (Vec<_>, Vec<_>) =
                above.enumerate().partition(|(k, _)| k * 7 % 10 == 0);
            let plain = |rows: Vec<(usize, _)>| rows.into_iter().map(|(_, row)| row).collect();
            let (asked, known): (Vec<_>, Vec<_>) = (plain(asked), plain(known));
            println!("a tenth held out of {name}: {}", compare(known, &asked)?);
        }
    }
    Ok(good)
}

fn compare(
    known: Vec<(DirectionPair, DVec3)>,
    asked: &[(DirectionPair, DVec3)],
) -> Result<Spread, Failure> {
    let mut brightest: Vec<f64> = known.iter().map(|(_, rgb)| rgb.max_element()).collect();
    brightest.sort_by(f64::total_cmp);
    // Limits relative errors of nearly black values.
    let floor = 0.01 * brightest[brightest.len() / 2];
    let scattered = Scattered::new(&MeasuredSamples::new(known)?);
    let error = |(pair, rgb): &(DirectionPair, DVec3)| {
        let wanted = rgb.max(DVec3::ZERO);
        ((scattered.f(pair) - wanted).abs() / wanted.max(DVec3::splat(floor))).to_array()
    };
    Spread::of(asked.iter().flat_map(error).collect())
}

/// Pairs of an additive sequence; every second one near the highlight.
fn directions(from: usize) -> impl Iterator<Item = DirectionPair> {
    let direction = |z: f64, turns: f64| {
        let sine = (1.0 - z * z).sqrt();
        let (sin, cos) = libm::sincos(turns * std::f64::consts::TAU);
        DVec3::new(sine * cos, sine * sin, z)
    };
    (from..).filter_map(move |k| {
        let steps = [0.856_674_9, 0.733_891_9, 0.628_707, 0.538_598];
        let [a, b, c, d] = steps.map(|step| ((k + 1) as f64 * step).fract());
        let wi = direction(a.sqrt(), b);
        let wo = if k.is_multiple_of(2) {
            direction(c.sqrt(), d)
        } else {
            let normal = direction(libm::cos(0.6 * c * c), d);
            2.0 * wi.dot(normal) * normal - wi
        };
        (wo.z > 0.02 && wi.z > 0.02).then(|| DirectionPair::new(wi, wo).ok()).flatten()
    })
}
