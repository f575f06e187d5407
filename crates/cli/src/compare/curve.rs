//! Writes the curves of a comparison: CSV and two charts.

use std::path::Path;

use anyhow::Result;
use brood_inspect::CurvePoint;

use super::ComparedMaterial;
use crate::chart::{Axis, Plot, Point, Scale, Series};
use crate::output;

/// Writes the curves of all materials as CSV and as two charts.
pub fn write(all: &[ComparedMaterial], dir: &Path) -> Result<()> {
    let mut csv = String::from("material,theta_deg,albedo_r,albedo_g,albedo_b,mirror\n");
    for found in all {
        for CurvePoint { theta_deg, albedo: [r, g, b], mirror, .. } in &found.curves {
            let name = quoted(&found.name);
            csv += &format!("{name},{theta_deg},{r:.6},{g:.6},{b:.6},{mirror:.6}\n");
        }
    }
    output::write_file(&dir.join("curves.csv"), csv.as_bytes())?;
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
        x: Axis { title: "angle of incidence, degrees", scale: Scale::Linear },
        y: Axis { title: y, scale: Scale::Linear },
        series: all.iter().map(series).collect(),
    }
}

/// Escapes a name for CSV.
fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}
