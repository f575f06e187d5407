//! `cargo xtask accept`: that the functions keep their promises for every f32, and that nothing random breaks anything.
//!
//! Owns how much is run: `--short` is what continuous integration can afford, `--long` is everything; `--data` adds what others rendered and
//! measured, `--peers` metrics by packages from PyPI. The work itself
//! is an example of the genome crate and `brood bench stress`; each fails by itself where something is beyond a bound.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result, bail, ensure};
use serde_json::json;

use crate::prerequisite::Prerequisites;
use crate::{bench, shell, suite};

/// Every so many bit patterns in the short form; a prime, so that no pattern of bits is left out.
const SHORT_STRIDE: u32 = 61;
/// Program x sample evaluations at each level.
const SHORT_EVALUATIONS: u64 = 10_000_000;
const LONG_EVALUATIONS: u64 = 1_000_000_000;
/// Direction pairs whose inputs are swapped.
const SHORT_PAIRS: u64 = 1_000_000;
const LONG_PAIRS: u64 = 100_000_000;
/// Largest error of a Lambert sphere against a picture by another program, whose 64 random samples a pixel leave about
/// 4e-4 of it.
const LAMBERT_RMSE: f64 = 1e-3;
/// The same of spheres with highlights, which are 1.4 to 6.5 at their brightest.
const HIGHLIGHT_RMSE: f64 = 1.6e-3;
/// Measured materials and the largest error of each, about 1.4 times what it is. The second one's highlight is 66.
const MEASURED: [(&str, f64); 4] = [
    ("paper_white", 1.3e-3),
    ("cg_sunflower", 5.2e-3),
    ("colodur_napoli_4f", 3e-4),
    ("cc_ibiza_sunset", 5e-4),
];
/// The other renderer follows light from the eye and takes the eye's direction for that of the measurement's light; it keeps values
/// below 0. Highlights of varnished films are finer than a pixel.
const MEASURED_OPTIONS: [&str; 4] = ["--swap", "--keep-negative", "--samples", "256"];
/// Plastic of refractive index 1.49 in air, as the other program integrates it.
const ROUGH_PLASTIC: &str =
    "rough-plastic\nalbedo 0.1 0.27 0.36\nior 1.489587\nroughness 0.1\ninternal mitsuba";
const PRINCIPLED: &str = "principled\nbase_color 0.6 0.2 0.1\nroughness 0.35\nsheen 0.3\nclearcoat 0.6\n\
                          clearcoat_gloss 0.8\ncoat_form mitsuba";

/// What the command line says.
#[derive(Debug, Default, PartialEq)]
struct Options {
    long: bool,
    peers: bool,
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
                "--data" => {
                    options.data = Some(words.next().context("--data needs a folder")?.into())
                }
                word => bail!("unknown option {word} of accept"),
            }
        }
        Ok(options)
    }
}

/// Builds what is needed and runs one of the forms.
pub fn run(words: &[&str]) -> Result<()> {
    let options = Options::parse(words)?;
    let target = suite::target_directory()?;
    // Ten thousand million evaluations are worth a build.
    let profile = if options.long { "release" } else { "dev" };
    let binaries = target.join(if options.long { "release" } else { "debug" });
    let build = ["build", "--locked", "--profile", profile, "--package"];
    shell::run(shell::cargo().args(build).arg("brood"))?;
    let example = ["brood-genome", "--example", "functions"];
    shell::run(shell::cargo().args(build).args(example))?;
    let found = Prerequisites::look();
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
    match &options.data {
        None => println!("without --data nothing is held against pictures from outside"),
        Some(data) => {
            step("pictures from outside", pictures(&binaries, &target, data));
            step("values from outside", oracle(data));
        }
    }
    println!("accept: {:.0} s", started.elapsed().as_secs_f64());
    ensure!(failed.is_empty(), "not accepted: {}", failed.join(", "));
    Ok(())
}

/// The short form with what a build of everything has left there.
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

/// Models that published fits are made with, and measured materials, against values by other programs.
fn oracle(data: &Path) -> Result<()> {
    let data = std::path::absolute(data).context("find the data")?;
    let mut command = shell::cargo();
    command.args(["run", "--locked", "--package", "brood-brdf", "--example", "oracle", "--"]);
    shell::run(command.arg(data))
}

fn brood(binaries: &Path) -> Command {
    shell::command(binaries.join("brood"))
}

/// Spheres under a distant light, against the same by another renderer: a genome, models and measured materials.
fn pictures(binaries: &Path, target: &Path, data: &Path) -> Result<()> {
    let folder = target.join("accept");
    std::fs::create_dir_all(&folder).context("make a folder")?;
    let scene = folder.join("scene.json");
    std::fs::write(&scene, distant_light().to_string()).context("write the scene")?;
    let cases = [
        ("lambert_0.5_0.3_0.2", lambert([0.5, 0.3, 0.2]), LAMBERT_RMSE),
        ("lambert_0.5_0.3_0.2", model("lambert\nalbedo 0.5 0.3 0.2"), LAMBERT_RMSE),
        ("ggx_gold_a0.2", model("conductor\nroughness 0.2"), HIGHLIGHT_RMSE),
        ("roughplastic_a0.1", model(ROUGH_PLASTIC), HIGHLIGHT_RMSE),
        ("principled_clearcoat", model(PRINCIPLED), HIGHLIGHT_RMSE),
    ];
    let sphere = Sphere { binaries, folder: &folder, scene: &scene, data };
    for (name, material, most) in cases {
        let file = folder.join("material.brood");
        std::fs::write(&file, &material).context("write the material")?;
        sphere.compare(name, &file, &[], most)?;
    }
    for (name, most) in MEASURED {
        let file = data.join(format!("rgl/{name}_rgb.bsdf"));
        sphere.compare(&format!("rgl_{name}"), &file, &MEASURED_OPTIONS, most)?;
    }
    Ok(())
}

/// How a sphere is rendered, and where the pictures of the other renderer are.
struct Sphere<'a> {
    binaries: &'a Path,
    folder: &'a Path,
    scene: &'a Path,
    data: &'a Path,
}

impl Sphere<'_> {
    fn compare(&self, name: &str, material: &Path, options: &[&str], most: f64) -> Result<()> {
        let wanted = self.data.join(format!("renders_mitsuba/sphere_l45_{name}.exr"));
        ensure!(wanted.is_file(), "no {}", wanted.display());
        let wanted = wanted.canonicalize().context("find the picture")?;
        let material = material.canonicalize().context("find the material")?;
        let picture = self.folder.join("sphere.exr");
        let mut render = brood(self.binaries);
        render.arg("render").arg(&material).arg("--scene").arg(self.scene).args(options);
        shell::run(render.args(["--size", "128"]).arg("--output").arg(&picture))?;
        let text = shell::output(
            brood(self.binaries).args(["diff", "--metric", "rmse"]).arg(&wanted).arg(&picture),
        )?;
        let rmse: f64 = text.trim().parse().context("read the difference")?;
        println!("{name}: RMSE {rmse:.2e}");
        ensure!(rmse <= most, "{name} is off by more than {most:e}");
        Ok(())
    }
}

/// A file of a model, from its name and its parameters.
fn model(words: &str) -> String {
    format!("brood 1\n.model {words}\n")
}

/// f = albedo / pi, without a square root to be rounded: the square is 1, the scale does the rest.
fn lambert(albedo: [f64; 3]) -> String {
    let [red, green, blue] = albedo.map(|value| value / std::f64::consts::PI);
    format!(
        "brood 1\n.dialect paper smooth registers 7 isotropic homogeneous\n.scale {red} {green} {blue}\n\
         .const C0 1 1 1 0\nMOV R0, C0\n"
    )
}

/// Light from normalise(1, 1, sqrt 2) with irradiance pi, so far away that it is parallel.
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
    fn options_are_refused_when_a_word_is_unknown_or_a_value_is_missing() {
        assert!(Options::parse(&["--all"]).is_err());
        assert!(Options::parse(&["--data"]).is_err());
    }

    #[test]
    fn form_is_short_unless_told_otherwise() {
        assert_eq!(Options::parse(&[]).unwrap(), Options::default());
        let long = Options::parse(&["--long", "--peers", "--data", "d"]).unwrap();
        assert!(long.long && long.peers && long.data.is_some());
    }

    #[test]
    fn lambert_genome_divides_by_pi() {
        assert!(lambert([1.0; 3]).contains(".scale 0.3183098861837907 "));
    }
}
