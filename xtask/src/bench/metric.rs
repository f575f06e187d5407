//! Picture metrics compared with other packages: FLIP, SSIM and Delta E_ITP of two rendered
//! materials.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;

use super::environment::{Environment, Peer, json_of};
use super::{Options, Task};
use crate::{shell, suite};

/// Metrics with their largest relative difference. Published colour matrices and display curves
/// have only four digits, and edges pass through such a curve when they are composited over black.
const METRICS: [(&str, f64); 3] = [("flip", 1e-3), ("ssim", 1e-4), ("itp", 1e-3)];
/// Two materials that differ in colour, in highlights and in grain.
const MODELS: [&str; 2] = ["gold", "coated"];

/// Compares the metrics; fails if a package cannot be installed.
pub fn run(brood: &Path) -> Result<()> {
    let brood = brood.to_str().context("the path of brood must be UTF-8")?;
    let options = Options::parse(Task::Pictures, &["--brood", brood])?;
    let environment = Environment::prepare(&options, &[Peer::Metrics])?;
    if let [first, ..] = environment.missing.as_slice() {
        bail!("{first}");
    }
    let folder = suite::target_directory()?.join("accept");
    std::fs::create_dir_all(&folder).context("create the folder")?;
    let pictures = [0, 1].map(|index| folder.join(format!("metric-{index}.png")));
    for (name, picture) in MODELS.iter().zip(&pictures) {
        render(&environment, name, picture)?;
    }
    let theirs = json_of(environment.script("metrics.py").args(&pictures))?;
    for (metric, tolerance) in METRICS {
        let mut diff = environment.brood();
        diff.args(["diff", "--metric", metric]).args(&pictures);
        let own = shell::output(&mut diff)?;
        let own = own.lines().next().unwrap_or_default();
        let own: f64 = own.parse().context("read the difference")?;
        let other = theirs
            .get(metric)
            .and_then(Value::as_f64)
            .context("metrics.py must print the metric")?;
        println!("{metric}: {own:.6}, reference package {other:.6}");
        let difference = (own - other).abs() / other.abs();
        ensure!(
            difference <= tolerance,
            "{metric}: relative difference {difference:.1e} is above the limit of {tolerance:.0e}"
        );
    }
    Ok(())
}

fn render(environment: &Environment, model: &str, picture: &PathBuf) -> Result<()> {
    let text = shell::output(environment.brood().args(["model", "show", model]))?;
    let file = picture.with_extension("brood");
    std::fs::write(&file, text).context("write the material")?;
    let mut render = environment.brood();
    render.args(["render", "--size", "128", "--output"]).arg(picture).arg(&file);
    shell::run(&mut render)
}
