//! Curves over the angle of incidence: how much is reflected in all, and how bright the mirror direction is.

use std::path::Path;

use anyhow::Result;
use brood_eval::{Quadrature, around, channel_albedos, pair};
use glam::DVec3;
use serde_json::{Value, json};

use super::Found;
use super::subject::Subject;
use crate::chart::{Axis, Plot, Point, Scale, Series};
use crate::output;

/// Degrees of incidence.
const THETA_DEG: [f64; 20] = [
    0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0, 50.0, 55.0, 60.0, 65.0, 70.0, 75.0,
    80.0, 83.0, 86.0, 88.0,
];
/// Order of the quadratures.
const ORDER: usize = 64;
/// What the eye makes of linear red, green and blue (Rec. 709).
const LUMINANCE: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);

/// Curves of one material.
pub struct Curves {
    /// Directional albedo of the channels at each angle.
    pub albedo: Vec<[f64; 3]>,
    /// f towards the mirror direction times cos_i cos_o, over the same at normal incidence: for facets of one shape F G over
    /// that of the normal. 0 where nothing is reflected at the normal.
    pub mirror: Vec<f64>,
}

impl Curves {
    pub fn of(subject: &Subject) -> Self {
        let albedo = THETA_DEG.map(|theta| albedo(subject, theta)).to_vec();
        let pairs: Vec<_> = THETA_DEG
            .iter()
            .map(|theta| {
                let (sin, cos) = libm::sincos(theta.to_radians());
                pair(around(sin, cos, 0.0), around(sin, cos, 0.5))
            })
            .collect();
        let bright: Vec<f64> = subject
            .f(&pairs)
            .into_iter()
            .zip(&pairs)
            .map(|(f, pair)| luminance(f) * pair.cos_i() * pair.cos_o())
            .collect();
        let normal = bright[0];
        let over = |value: f64| if normal > 0.0 { value / normal } else { 0.0 };
        Self { albedo, mirror: bright.into_iter().map(over).collect() }
    }

    /// The value of a curve at the angle nearest to that one.
    pub fn at(values: &[f64], theta_deg: f64) -> f64 {
        let off = |index: &usize| (THETA_DEG[*index] - theta_deg).abs();
        let nearest = (0..values.len()).min_by(|a, b| off(a).total_cmp(&off(b)));
        values[nearest.expect("there are angles")]
    }

    /// Both as JSON.
    pub fn report(&self) -> Value {
        let rows = THETA_DEG.iter().zip(&self.albedo).zip(&self.mirror);
        let row = |((theta, albedo), mirror): ((&f64, &[f64; 3]), &f64)| json!({ "theta_deg": theta, "albedo": albedo, "mirror": mirror });
        rows.map(row).collect()
    }
}

/// Directional albedo of the channels.
pub fn albedo(subject: &Subject, theta_deg: f64) -> [f64; 3] {
    match subject.either() {
        Ok(program) => channel_albedos(program, theta_deg, ORDER),
        Err(brdf) => {
            let (sin, cos) = libm::sincos(theta_deg.to_radians());
            let (wi, rule) = (around(sin, cos, 0.0), Quadrature::new(ORDER));
            let f: Vec<DVec3> = rule.directions().iter().map(|wo| brdf.f(&pair(wi, *wo))).collect();
            [0, 1, 2].map(|channel| rule.integrate(f.iter().map(|f| f[channel])))
        }
    }
}

/// Luminance of a colour.
pub fn luminance(rgb: [f64; 3]) -> f64 {
    LUMINANCE.dot(DVec3::from(rgb))
}

/// The curves of all materials as CSV and as two charts.
pub fn write(all: &[Found], dir: &Path) -> Result<()> {
    let mut csv = String::from("material,theta_deg,albedo_r,albedo_g,albedo_b,mirror\n");
    for found in all {
        let rows = THETA_DEG.iter().zip(&found.curves.albedo).zip(&found.curves.mirror);
        for ((theta, [r, g, b]), mirror) in rows {
            csv += &format!("{},{theta},{r:.6},{g:.6},{b:.6},{mirror:.6}\n", quoted(&found.name));
        }
    }
    output::write_file(&dir.join("curves.csv"), csv.as_bytes())?;
    let albedo = chart(
        all,
        ("How much is reflected", "the share of light from one direction that is sent back in all"),
        "directional albedo, luminance",
        |curves| curves.albedo.iter().map(|rgb| luminance(*rgb)).collect(),
    );
    output::write_file(&dir.join("albedo.svg"), albedo.svg().as_bytes())?;
    let mirror = chart(
        all,
        (
            "How the mirror direction brightens",
            "f cos_i cos_o towards the mirror direction, over the same at normal incidence",
        ),
        "over that at the normal",
        |curves| curves.mirror.clone(),
    );
    output::write_file(&dir.join("fresnel.svg"), mirror.svg().as_bytes())
}

fn chart(
    all: &[Found],
    (title, subtitle): (&str, &str),
    y: &'static str,
    values: impl Fn(&Curves) -> Vec<f64>,
) -> Plot {
    let series = |found: &Found| {
        let points = THETA_DEG.iter().zip(values(&found.curves));
        let points = points.map(|(x, y)| Point { x: *x, y, ..Point::default() }).collect();
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

/// A name as a cell of CSV.
fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}
