//! `cargo xtask accept`: checks the functions for every f32, and random programs for errors.
//!
//! Owns the amount of work: `--short` fits continuous integration, `--long` is complete; `--data`
//! adds renders and measurements by other programs, `--peers` adds metrics by packages from PyPI,
//! `--client` adds a generated client of the API, `--exports` programs that read exported
//! materials. The checks are an example of the genome crate and `brood bench stress`. A check fails
//! if a bound is exceeded; the others still run.

mod client;
mod exports;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result, bail, ensure};
use serde_json::json;

use crate::bench::material;
use crate::prerequisite::Prerequisites;
use crate::{bench, shell, suite};

/// Stride over the bit patterns in the short form; a prime, so that every bit varies.
const SHORT_STRIDE: u32 = 61;
/// Number of program x sample evaluations at each level.
const SHORT_EVALUATIONS: u64 = 10_000_000;
const LONG_EVALUATIONS: u64 = 1_000_000_000;
/// Number of direction pairs whose inputs are swapped.
const SHORT_PAIRS: u64 = 1_000_000;
const LONG_PAIRS: u64 = 100_000_000;
/// Largest RMSE of a Lambert sphere against a picture by another program, whose 64 random samples
/// per pixel account for about 4e-4 of it.
const LAMBERT_RMSE: f64 = 1e-3;
/// Largest RMSE of spheres with highlights, whose brightest values are 1.4 to 6.5.
const HIGHLIGHT_RMSE: f64 = 1.6e-3;
/// Measured materials with the largest allowed RMSE of each, about 1.4 times the measured one. The
/// second one's highlight is 66.
const MEASURED: [(&str, f64); 4] = [
    ("paper_white", 1.3e-3),
    ("cg_sunflower", 5.2e-3),
    ("colodur_napoli_4f", 3e-4),
    ("cc_ibiza_sunset", 5e-4),
];
/// The other renderer traces from the eye, uses the eye's direction as the measurement's light
/// direction, and keeps values below 0. Highlights of varnished films are finer than a pixel, hence
/// 256 samples.
const MEASURED_OPTIONS: [&str; 4] = ["--swap", "--keep-negative", "--samples", "256"];

/// Options of the command line.
#[derive(Debug, Default, PartialEq)]
struct Options {
    long: bool,
    peers: bool,
    client: bool,
    exports: bool,
    /// Formats of `exports`; all if empty.
    formats: Vec<String>,
    /// Random genomes in each format, if not the format's own number.
    genomes: Option<u32>,
    data: Option<PathBuf>,
}

impl Options {
    fn parse(words: &[&str]) -> Result<Self> {
        let mut options = Self::default();
        let mut words = words.iter();
        while let Some(word) = words.next() {
            match *word {
                "--short" => options.long = false,
                "--long" => options.long = true,
                "--peers" => options.peers = true,
                "--client" => options.client = true,
                "--exports" => options.exports = true,
                "--formats" => {
                    let formats = words.next().context("--formats needs names")?;
                    options.formats = formats.split(',').map(str::to_owned).collect();
                    options.exports = true;
                }
                "--genomes" => {
                    let count = words.next().and_then(|count| count.parse().ok());
                    options.genomes = Some(count.context("--genomes needs a number")?);
                    options.exports = true;
                }
                "--data" => {
                    options.data = Some(words.next().context("--data needs a folder")?.into())
                }
                word => bail!("unknown option {word} of accept"),
            }
        }
        Ok(options)
    }
}

/// Builds the binaries and runs the short or the long form.
pub fn run(words: &[&str]) -> Result<()> {
    let options = Options::parse(words)?;
    let target = suite::target_directory()?;
    // 10^10 evaluations justify a release build.
    let profile = if options.long { "release" } else { "dev" };
    let binaries = target.join(if options.long { "release" } else { "debug" });
    let build = ["build", "--locked", "--profile", profile, "--package"];
    shell::run(shell::cargo().args(build).arg("brood"))?;
    let example = ["brood-genome", "--example", "functions"];
    shell::run(shell::cargo().args(build).args(example))?;
    let found = Prerequisites::find();
    let started = Instant::now();
    let mut failed = Vec::new();
    let mut step = |name: &str, outcome: Result<()>| {
        if let Err(error) = outcome {
            eprintln!("{name} failed: {error:#}");
            failed.push(name.to_owned());
        }
    };
    step("functions", functions(&binaries, options.long));
    step("stress", stress(&binaries, &found, options.long));
    if options.peers {
        step("metrics", bench::metrics(&binaries.join("brood")));
    }
    if options.exports {
        step("exports", exports::run(&binaries, &target, &options.formats, options.genomes));
    }
    if options.client {
        step("generated client", client::run(&binaries.join("brood"), &target));
    }
    match &options.data {
        None => println!("no --data: skipping the comparison with pictures of other renderers"),
        Some(data) => {
            step("pictures of other renderers", pictures(&binaries, &target, data));
            step("values of other programs", oracle(data));
        }
    }
    println!("accept: {:.0} s", started.elapsed().as_secs_f64());
    ensure!(failed.is_empty(), "not accepted: {}", failed.join(", "));
    Ok(())
}

/// Runs the short form with the binaries of a previous full build.
pub fn short(target: &Path, found: &Prerequisites) -> Result<()> {
    let binaries = target.join("debug");
    functions(&binaries, false).and(stress(&binaries, found, false))
}

fn functions(binaries: &Path, long: bool) -> Result<()> {
    let stride = if long { 1 } else { SHORT_STRIDE };
    let mut command = shell::command(binaries.join("examples/functions"));
    shell::run(command.args(["--stride", &stride.to_string()]))
}

fn stress(binaries: &Path, found: &Prerequisites, long: bool) -> Result<()> {
    let (evaluations, pairs) =
        if long { (LONG_EVALUATIONS, LONG_PAIRS) } else { (SHORT_EVALUATIONS, SHORT_PAIRS) };
    let mut command: Command = brood(binaries);
    found.apply(&mut command);
    command.args(["bench", "stress", "--evaluations", &evaluations.to_string()]);
    shell::run(command.args(["--pairs", &pairs.to_string()]))
}

/// Compares models and measured materials with values computed by other programs.
fn oracle(data: &Path) -> Result<()> {
    let data = std::path::absolute(data).context("resolve --data")?;
    let mut command = shell::cargo();
    command.args(["run", "--locked", "--package", "brood-brdf", "--example", "oracle", "--"]);
    shell::run(command.arg(data))
}

fn brood(binaries: &Path) -> Command {
    shell::command(binaries.join("brood"))
}

/// Compares spheres under a distant light with those of another renderer: a genome, models and
/// measured materials.
fn pictures(binaries: &Path, target: &Path, data: &Path) -> Result<()> {
    let folder = target.join("accept");
    std::fs::create_dir_all(&folder).context("create the folder")?;
    let scene = folder.join("scene.json");
    std::fs::write(&scene, distant_light().to_string()).context("write the scene")?;
    let cases = [
        ("lambert_0.5_0.3_0.2", lambert([0.5, 0.3, 0.2]), LAMBERT_RMSE),
        ("lambert_0.5_0.3_0.2", model(&material::lambert()), LAMBERT_RMSE),
        ("ggx_gold_a0.2", model(&material::gold()), HIGHLIGHT_RMSE),
        ("roughplastic_a0.1", model(&material::rough_plastic()), HIGHLIGHT_RMSE),
        ("principled_clearcoat", model(&material::principled()), HIGHLIGHT_RMSE),
    ];
    let sphere = Sphere { binaries, folder: &folder, scene: &scene, data };
    for (name, material, rmse_max) in cases {
        let file = folder.join("material.brood");
        std::fs::write(&file, &material).context("write the material")?;
        sphere.compare(name, &file, &[], rmse_max)?;
    }
    for (name, rmse_max) in MEASURED {
        let file = data.join(format!("rgl/{name}_rgb.bsdf"));
        sphere.compare(&format!("rgl_{name}"), &file, &MEASURED_OPTIONS, rmse_max)?;
    }
    Ok(())
}

/// Folders and files of the comparison.
struct Sphere<'a> {
    binaries: &'a Path,
    folder: &'a Path,
    scene: &'a Path,
    data: &'a Path,
}

impl Sphere<'_> {
    fn compare(&self, name: &str, material: &Path, options: &[&str], rmse_max: f64) -> Result<()> {
        let expected = self.data.join(format!("renders_mitsuba/sphere_l45_{name}.exr"));
        ensure!(expected.is_file(), "{} is missing", expected.display());
        let expected = expected.canonicalize().context("resolve the picture")?;
        let material = material.canonicalize().context("resolve the material")?;
        let picture = self.folder.join("sphere.exr");
        let mut render = brood(self.binaries);
        render.arg("render").arg(&material).arg("--scene").arg(self.scene).args(options);
        shell::run(render.args(["--size", "128"]).arg("--output").arg(&picture))?;
        let text = shell::output(
            brood(self.binaries).args(["diff", "--metric", "rmse"]).arg(&expected).arg(&picture),
        )?;
        let rmse: f64 = text.trim().parse().context("read the difference")?;
        println!("{name}: RMSE {rmse:.2e}");
        ensure!(rmse <= rmse_max, "{name}: RMSE {rmse:.2e} is above the limit of {rmse_max:e}");
        Ok(())
    }
}

/// Text of a material file with the model of a pair.
fn model(pair: &material::Pair) -> String {
    format!("brood 1\n.model {}\n", pair.model)
}

/// f = albedo / pi without a rounded square root: the square is 1, and the scale gives f.
fn lambert(albedo: [f64; 3]) -> String {
    let [red, green, blue] = albedo.map(|value| value / std::f64::consts::PI);
    format!(
        "brood 1\n.dialect paper smooth registers 7 isotropic homogeneous\n.scale {red} {green} {blue}\n\
         .const C0 1 1 1 0\nMOV R0, C0\n"
    )
}

/// Light from normalise(1, 1, sqrt 2) with irradiance pi, distant enough to be parallel.
fn distant_light() -> serde_json::Value {
    let distance = 1e5;
    let position = [0.5, 0.5, std::f64::consts::FRAC_1_SQRT_2].map(|part: f64| part * distance);
    let intensity = [std::f64::consts::PI * distance * distance; 3];
    json!({
        "mesh": "sphere",
        "camera": {"orthographic": 1.05},
        "lights": [{"kind": "point", "position": position, "intensity": intensity}],
    })
}

#[cfg(test)]
mod tests {
    use super::{Options, lambert};

    #[test]
    fn options_are_rejected_when_a_word_is_unknown_or_a_value_is_missing() {
        assert!(Options::parse(&["--all"]).is_err());
        assert!(Options::parse(&["--data"]).is_err());
        assert!(Options::parse(&["--formats"]).is_err());
        assert!(Options::parse(&["--genomes", "many"]).is_err());
    }

    #[test]
    fn form_is_short_by_default() {
        assert_eq!(Options::parse(&[]).unwrap(), Options::default());
        let long =
            Options::parse(&["--long", "--peers", "--client", "--exports", "--data", "d"]).unwrap();
        assert!(long.long && long.peers && long.client && long.exports && long.data.is_some());
        let some = Options::parse(&["--formats", "hlsl,gltf", "--genomes", "200"]).unwrap();
        assert!(some.exports && some.formats == ["hlsl", "gltf"] && some.genomes == Some(200));
    }

    #[test]
    fn lambert_genome_divides_by_pi() {
        assert!(lambert([1.0; 3]).contains(".scale 0.3183098861837907 "));
    }
}
