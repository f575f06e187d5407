//! `cargo xtask bench photographs`: materials recovered from photographs, as they look under other
//! lights and on another object.
//!
//! Pictures are taken by Mitsuba, never by brood, of materials that brood does not know. Owns
//! objects, cameras, lights and grades, the order of the work and the table.

mod material;
mod stage;

use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use serde_json::{Value, json};

use self::material::Material;
use self::stage::{Grade, Object};
use super::environment::{Environment, Peer, json_of};
use super::{Options, Task, paragraphs, require_all, write_report};
use crate::{shell, suite};

/// Seconds of a fit, if not chosen.
const SECONDS: u32 = 20;
/// Threads of a fit.
const THREADS: &str = "2";
/// Samples of a pixel, of either program.
const SAMPLES: u32 = 64;
/// The same in an environment, which Mitsuba samples at random.
const ENVIRONMENT_SAMPLES: u32 = 576;
/// File of the environment in the folder of data.
const ENVIRONMENT: &str = "env/mitsuba_docs_envmap.hdr";
const SIZE_PX: u32 = 192;
/// Reason why measured materials and the mesh are missing.
const NO_DATA: &str = "measured materials, the mesh spot and the environment: they need --data";

/// One material on one object, photographed in one way.
struct Photograph {
    material: Material,
    object: Object,
    grade: Grade,
    folder: PathBuf,
}

/// Relative RMSE of the fit's pictures.
struct Row {
    material: &'static str,
    object: &'static str,
    grade: Grade,
    /// Under the lights that the photographs do not show.
    unseen: Vec<f64>,
    /// Largest errors over the pictures, in degrees, if scenes were corrected: of lights as the
    /// camera sees them, and of cameras.
    scene_deg: Option<(f64, Option<f64>)>,
    seconds: f64,
}

/// Runs the comparison.
pub fn run(words: &[&str]) -> Result<()> {
    let options = Options::parse(Task::Photographs, words)?;
    let data = options.data.as_ref().map(|data| data.canonicalize().context("resolve --data"));
    let data = data.transpose()?;
    let folder = suite::target_directory()?.join("peers/photographs");
    let photographs = photographs(&options, data.as_deref(), &folder)?;
    let mut environment = Environment::prepare(&options, &[Peer::Mitsuba])?;
    let mut missing = std::mem::take(&mut environment.missing);
    ensure!(environment.has(Peer::Mitsuba), "Mitsuba takes the pictures: {}", missing.join("; "));
    if folder.exists() {
        std::fs::remove_dir_all(&folder).context("empty the folder of photographs")?;
    }
    std::fs::create_dir_all(&folder).context("create the folder of photographs")?;
    match &data {
        None => missing.push(NO_DATA.to_owned()),
        Some(data) => {
            let mesh = data.join("meshes/spot_triangulated.obj");
            shell::run(environment.script("mesh_forms.py").arg(mesh).arg(&folder))?;
            for photograph in &photographs {
                photograph.copy_light(data)?;
            }
        }
    }
    let count = options.pictures.unwrap_or(1);
    let list = folder.join("photographs.json");
    let jobs: Vec<Value> = photographs.iter().map(|each| each.job(&folder, count)).collect();
    std::fs::write(&list, json!(jobs).to_string()).context("write the list of photographs")?;
    let mut make = environment.script("mitsuba_photographs.py");
    json_of(make.arg("make").arg(&list).args(["--threads", THREADS]))?;
    let mut rows = Vec::new();
    for photograph in &photographs {
        match photograph.row(&environment, &options, &folder) {
            Ok(row) => {
                println!("{}", row.line());
                rows.push(row);
            }
            Err(error) => missing.push(format!("{}: {error:#}", photograph.name())),
        }
    }
    let strategy = options.strategy.as_deref().unwrap_or("by default");
    let machine = environment.machine();
    let seconds = options.seconds.unwrap_or(SECONDS);
    let text = markdown(&rows, (strategy, seconds, count), &missing)?;
    let report = json!({
        "machine": machine, "strategy": strategy, "seconds": seconds, "pictures": count,
        "rows": rows.iter().map(Row::json).collect::<Vec<_>>(), "missing": missing,
    });
    write_report(&options.out, "photographs", &report, &text)?;
    require_all(options.require, &missing)
}

/// Every material on every object in every grade that was asked for.
fn photographs(options: &Options, data: Option<&Path>, folder: &Path) -> Result<Vec<Photograph>> {
    let wanted = |list: &Option<String>, name: &str| {
        list.as_ref().is_none_or(|list| list.split(',').any(|each| each == name))
    };
    let mut found = Vec::new();
    for grade in Grade::ALL.into_iter().filter(|grade| wanted(&options.grades, grade.name())) {
        for object in Object::ALL {
            for material in material::all(data) {
                let needs_data = object.mesh().is_some() || grade.light_file().is_some();
                if (needs_data && data.is_none()) || !wanted(&options.materials, material.name) {
                    continue;
                }
                let name = format!("{} {} {}", material.name, object.name(), grade.name());
                let folder = folder.join(name.replace(' ', "-"));
                found.push(Photograph { material, object, grade, folder });
            }
        }
    }
    let grades = Grade::ALL.map(Grade::name).join(", ");
    let materials: Vec<&str> = material::all(data).iter().map(|material| material.name).collect();
    ensure!(!found.is_empty(), "grades are {grades}; materials are {}", materials.join(", "));
    Ok(found)
}

impl Photograph {
    fn name(&self) -> String {
        format!("{}, {}, {}", self.material.name, self.object.name(), self.grade.name())
    }

    /// Copies the file of the light to the pictures.
    fn copy_light(&self, data: &Path) -> Result<()> {
        let Some(file) = self.grade.light_file() else { return Ok(()) };
        std::fs::create_dir_all(&self.folder).context("create the folder of a photograph")?;
        std::fs::copy(data.join(ENVIRONMENT), self.folder.join(file))
            .context("copy the environment")?;
        Ok(())
    }

    /// Description for the script that takes the pictures.
    fn job(&self, folder: &Path, count: u32) -> Value {
        json!({
            "name": self.name(), "folder": self.folder, "bsdf": self.material.bsdf,
            "mesh": self.object.mesh().map(|mesh| folder.join(mesh)),
            "size_px": SIZE_PX, "test_samples": SAMPLES,
            "samples": match self.grade {
                Grade::Environment => ENVIRONMENT_SAMPLES,
                _ => SAMPLES,
            },
            "pictures": (0..count as usize).map(|k| self.object.picture(k, self.grade))
                .collect::<Vec<_>>(),
            "tests": self.object.tests(),
        })
    }

    /// Fits the photographs, and compares pictures of the result.
    fn row(&self, environment: &Environment, options: &Options, meshes: &Path) -> Result<Row> {
        let result = self.folder.join("result");
        let mut fit = environment.brood();
        fit.arg("fit").arg(self.folder.join("target.json")).arg("--output").arg(&result);
        let seconds = options.seconds.unwrap_or(SECONDS).to_string();
        fit.args(["--seconds", &seconds, "--threads", THREADS, "--json"]);
        if let Some(strategy) = &options.strategy {
            fit.args(["--strategy", strategy]);
        }
        let report = json_of(&mut fit)?;
        let seconds =
            report["search"]["seconds"].as_f64().context("the report must have seconds")?;
        let mut pairs = Vec::new();
        for k in 1..=self.object.tests().len() {
            let picture = result.join(format!("test-{k}.exr"));
            let mut render = environment.brood();
            render.arg("render").arg(result.join("best.brood"));
            render.arg("--scene").arg(self.folder.join(format!("test-{k}.json")));
            if let Some(mesh) = self.object.mesh() {
                render.arg("--mesh").arg(meshes.join(mesh));
            }
            render.args(["--size", &SIZE_PX.to_string(), "--samples", &SAMPLES.to_string()]);
            shell::output(render.arg("--output").arg(&picture))?;
            pairs.push([self.folder.join(format!("test-{k}.exr")), picture]);
        }
        let list = result.join("pairs.json");
        std::fs::write(&list, json!(pairs).to_string()).context("write the list of pictures")?;
        let scores = json_of(environment.script("mitsuba_photographs.py").arg("score").arg(&list))?;
        let unseen = scores["relative_rmse"].as_array().context("the script must print errors")?;
        let errors = |count: usize| {
            let mut largest: Option<(f64, Option<f64>)> = None;
            for k in 0..count {
                let number = if k == 0 { String::new() } else { format!("-{}", k + 1) };
                let path = result.join(format!("scene{number}.json"));
                let Ok(text) = std::fs::read_to_string(&path) else { return Ok(None) };
                let scene = serde_json::from_str(&text).context("read a corrected scene")?;
                let error = self.object.scene_error(&scene, k);
                let (light, camera) = error.context("a corrected scene must have eye and light")?;
                let (most, of_camera) = largest.unwrap_or_default();
                largest = Some((light.max(most), camera.map(|e| e.max(of_camera.unwrap_or(0.0)))));
            }
            anyhow::Ok(largest)
        };
        let scene_deg = errors(options.pictures.unwrap_or(1) as usize)?;
        Ok(Row {
            scene_deg,
            material: self.material.name,
            object: self.object.name(),
            grade: self.grade,
            unseen: unseen.iter().filter_map(Value::as_f64).collect(),
            seconds,
        })
    }
}

impl Row {
    /// Error over all unseen lights: root of the mean square.
    fn error(&self) -> f64 {
        let squares: f64 = self.unseen.iter().map(|error| error * error).sum();
        (squares / self.unseen.len() as f64).sqrt()
    }

    fn line(&self) -> String {
        let Self { material, object, grade, .. } = self;
        format!("{material}, {object}, {}: {:.3}", grade.name(), self.error())
    }

    fn json(&self) -> Value {
        json!({
            "material": self.material, "object": self.object, "grade": self.grade.name(),
            "relative_rmse": self.error(), "by_light": self.unseen, "seconds": self.seconds,
            "light_deg": self.scene_deg.map(|(light, _)| light),
            "camera_deg": self.scene_deg.and_then(|(_, camera)| camera),
        })
    }
}

/// Median of errors; NaN if there are none.
fn median(mut errors: Vec<f64>) -> f64 {
    errors.sort_by(f64::total_cmp);
    let middle = errors.len() / 2;
    match errors.len() {
        0 => f64::NAN,
        odd if odd % 2 == 1 => errors[middle],
        _ => 0.5 * (errors[middle - 1] + errors[middle]),
    }
}

fn markdown(
    rows: &[Row],
    (strategy, seconds, pictures): (&str, u32, u32),
    missing: &[String],
) -> Result<String> {
    let mut text = format!(
        "# Materials from photographs, under other lights\n\n\
         Pictures of {SIZE_PX} x {SIZE_PX} pixels by Mitsuba, {pictures} of each material, one point light in each, or an environment. `brood fit`, \
         strategy {strategy}, {seconds} s on {THREADS} threads. Errors are RMSE / mean of Mitsuba's own pictures under three other \
         lights (root of the mean square of the three). The scene of misaligned pictures is stated with its uncertainties; \
         errors of the corrected scene are those of the light as the camera sees it and of the camera.\n\n\
         | material | object | grade | error | by light | light, camera off by degrees |\n|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let lights: Vec<String> = row.unseen.iter().map(|error| format!("{error:.3}")).collect();
        let (object, grade) = (row.object, row.grade.name());
        let (name, error, lights) = (row.material, row.error(), lights.join(", "));
        let degrees = |value: f64| format!("{value:.2}");
        let scene = row.scene_deg.map(|(light, camera)| {
            [degrees(light), camera.map_or_else(String::new, degrees)].join(", ")
        });
        let scene = scene.unwrap_or_default();
        writeln!(text, "| {name} | {object} | {grade} | {error:.3} | {lights} | {scene} |")?;
    }
    text.push_str("\n| grade | object | median | worst | light, camera off by degrees, medians |\n|---|---|---|---|---|\n");
    for grade in Grade::ALL {
        for object in Object::ALL {
            let of = |row: &&Row| row.grade == grade && row.object == object.name();
            let errors: Vec<f64> = rows.iter().filter(of).map(Row::error).collect();
            if errors.is_empty() {
                continue;
            }
            let worst = errors.iter().copied().fold(0.0, f64::max);
            let scenes: Vec<(f64, Option<f64>)> =
                rows.iter().filter(of).filter_map(|row| row.scene_deg).collect();
            let light = median(scenes.iter().map(|(light, _)| *light).collect());
            let camera = median(scenes.iter().filter_map(|(_, camera)| *camera).collect());
            let off =
                |value: f64| if value.is_nan() { "".to_owned() } else { format!("{value:.2}") };
            let scene = [off(light), off(camera)].join(", ");
            let (grade, object) = (grade.name(), object.name());
            writeln!(
                text,
                "| {grade} | {object} | {:.3} | {worst:.3} | {scene} |",
                median(errors)
            )?;
        }
    }
    Ok(text + &paragraphs(missing))
}
