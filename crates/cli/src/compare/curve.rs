//! Writes the curves of a comparison: CSV and two charts.

use std::path::Path;

use anyhow::Result;
use brood_bench::chart::{Axis, Plot, Point, ResultTable, Series};
use brood_bench::output;
use brood_inspect::CurvePoint;

use super::ComparedMaterial;

/// Writes the curves of all materials as CSV and as two charts.
pub fn write(all: &[ComparedMaterial], dir: &Path) -> Result<()> {
    let mut table = ResultTable::default();
    for found in all {
        for CurvePoint { theta_deg, albedo: [r, g, b], mirror, .. } in &found.curves {
            let rounded = |value: &f64| format!("{value:.6}").into();
            table.push([
                ("material", found.name.as_str().into()),
                ("theta_deg", (*theta_deg).into()),
                ("albedo_r", rounded(r)),
                ("albedo_g", rounded(g)),
                ("albedo_b", rounded(b)),
                ("mirror", rounded(mirror)),
            ]);
        }
    }
    output::write_file(&dir.join("curves.csv"), table.csv().as_bytes())?;
    let albedo = chart(
        all,
        ("Directional albedo", "share of the light from one direction that is reflected"),
        "directional albedo, luminance",
        |point| point.luminance,
    );
    output::write_file(&dir.join("albedo.svg"), albedo.svg().as_bytes())?;
    let mirror = chart(
        all,
        (
            "Fresnel rise",
            "f cos_i cos_o towards the mirror direction, over the same at normal incidence",
        ),
        "relative to normal incidence",
        |point| point.mirror,
    );
    output::write_file(&dir.join("fresnel.svg"), mirror.svg().as_bytes())
}

fn chart(
    all: &[ComparedMaterial],
    (title, subtitle): (&str, &str),
    y: &'static str,
    value: impl Fn(&CurvePoint) -> f64,
) -> Plot {
    let series = |found: &ComparedMaterial| {
        let point =
            |point: &CurvePoint| Point { x: point.theta_deg, y: value(point), ..Point::default() };
        let points = found.curves.iter().map(point).collect();
        Series { name: found.name.clone(), points, dots: false }
    };
    Plot {
        title: title.to_owned(),
        subtitle: subtitle.to_owned(),
        x: Axis::linear("angle of incidence, degrees"),
        y: Axis::linear(y),
        series: all.iter().map(series).collect(),
    }
}
