//! Fits each kind of model to measured materials, and writes the parameters of good fits as the
//! prior of `analytic`. The fits have no prior themselves.
//!
//! `cargo run --release -p brood-search --example prior -- OUTPUT WITHOUT FILE.json ...`: the files
//! hold the weights of neural materials; `WITHOUT` names materials to leave out, with commas.

use std::collections::BTreeMap;
use std::error::Error;

use brood_brdf::{ModelKind, Neural};
use brood_search::analytic::{Form, Recovery, default_kinds};
use brood_target::MeasuredTarget;
use rayon::prelude::*;

/// A fit counts if its E_log is at most this multiple of the best kind's.
const GOOD: f64 = 1.6;
/// Significant digits of the parameters.
const DIGITS: usize = 4;

/// eta, then k, of metals, for red, green and blue: silver, aluminium, copper, iron, nickel,
/// platinum, lead, molybdenum, iridium, tungsten, mercury, titanium. Fits of measured metals do not
/// determine them, because measured highlights are blurred.
///
/// # Source
/// Tables of optical constants that renderers use, rounded; not of one measurement.
const METALS: [[f64; 6]; 12] = [
    [0.16, 0.14, 0.14, 4.07, 3.19, 2.20],
    [1.52, 0.97, 0.53, 7.66, 6.46, 5.07],
    [0.27, 0.68, 1.32, 3.61, 2.62, 2.29],
    [2.91, 2.95, 2.58, 3.09, 2.93, 2.77],
    [2.01, 1.77, 1.61, 3.81, 3.25, 2.36],
    [2.44, 2.08, 1.80, 4.37, 3.72, 3.02],
    [2.53, 2.54, 1.90, 4.17, 4.18, 4.16],
    [3.74, 3.78, 3.03, 3.58, 3.52, 3.22],
    [2.56, 2.23, 1.68, 4.67, 4.31, 3.35],
    [4.37, 3.30, 3.00, 3.50, 2.60, 2.27],
    [2.40, 1.44, 0.91, 6.33, 4.37, 3.42],
    [2.74, 2.54, 2.27, 3.81, 3.43, 3.04],
];
/// Least and largest roughness of the metals. The metals have different ones, evenly spaced by
/// ratio, in an order that does not depend on eta and k.
const ROUGHNESS: [f64; 2] = [0.03, 0.6];

/// Kind, parameter values and E_log of a fit.
type Fitted = (ModelKind, Vec<f64>, f64);

fn main() -> Result<(), Box<dyn Error + Send + Sync>> {
    let mut arguments = std::env::args().skip(1);
    let output = arguments.next().ok_or("OUTPUT is missing")?;
    let without: Vec<String> =
        arguments.next().ok_or("WITHOUT is missing")?.split(',').map(str::to_owned).collect();
    let mut prior: BTreeMap<&'static str, BTreeMap<String, Vec<f64>>> = BTreeMap::new();
    for file in arguments {
        let bytes = std::fs::read(&file)?;
        let all: serde_json::Value = serde_json::from_slice(&bytes)?;
        let all = all["materials"].as_object().ok_or("the file has no materials")?;
        let names: Vec<&String> = all.keys().filter(|name| !without.contains(name)).collect();
        let fits: Vec<(String, Vec<Fitted>)> = names
            .into_par_iter()
            .map(|name| Ok((name.clone(), fits(&bytes, name)?)))
            .collect::<Result<_, Box<dyn Error + Send + Sync>>>()?;
        for (name, fits) in fits {
            let least = fits.iter().fold(f64::INFINITY, |least, fit| least.min(fit.2));
            let mut line = format!("{name}: least {least:.4}:");
            for (kind, values, error) in fits {
                if error <= GOOD * least {
                    line += &format!(" {kind}");
                    prior.entry(kind.name()).or_default().insert(name.clone(), values);
                }
            }
            println!("{line}");
        }
    }
    prior.insert(ModelKind::Conductor.name(), metals());
    for (kind, rows) in &prior {
        println!("{kind}: {} materials", rows.len());
    }
    std::fs::write(output, serde_json::to_string(&prior)? + "\n")?;
    Ok(())
}

/// Conductors of [`METALS`].
fn metals() -> BTreeMap<String, Vec<f64>> {
    let count = METALS.len();
    let of = |(k, metal): (usize, &[f64; 6])| {
        let share = ((5 * k) % count) as f64 / (count - 1) as f64;
        let roughness = ROUGHNESS[0] * (ROUGHNESS[1] / ROUGHNESS[0]).powf(share);
        let roughness = (1e3 * roughness).round() / 1e3;
        let values = metal.iter().copied().chain([roughness, 0.0, 0.0, 0.0]).collect();
        (format!("metal-{k:02}"), values)
    };
    METALS.iter().enumerate().map(of).collect()
}

fn fits(bytes: &[u8], name: &str) -> Result<Vec<Fitted>, Box<dyn Error + Send + Sync>> {
    let neural = Neural::read(bytes, name)?;
    let target = MeasuredTarget::of(&neural)?;
    let mut found = Vec::new();
    for kind in default_kinds() {
        let fit = Recovery::new(&target.fitted, Form::one(kind), 0.0).run(1, 0);
        let rounded = fit.model.parameter_values().iter();
        let rounded = rounded.map(|value| format!("{value:.DIGITS$e}").parse());
        found.push((kind, rounded.collect::<Result<_, _>>()?, fit.e_log));
    }
    Ok(found)
}
