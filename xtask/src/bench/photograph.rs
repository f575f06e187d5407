//! `cargo xtask bench photographs`: materials recovered from photographs, as they look under other
//! lights and on another object.
//!
//! Pictures are taken by Mitsuba, never by brood, of materials that brood does not know. Mitsuba's
//! derivatives with Adam fit the same pictures. Owns the order of the work and brood's fits; the
//! files below own materials, scenes, the peers, errors, tables and charts.

mod chart;
mod material;
mod peer;
mod score;
mod stage;
mod table;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use serde_json::{Value, json};

use self::material::Material;
use self::peer::Model;
use self::score::Scores;
use self::stage::{Grade, Object, Test};
use self::table::{Heading, OwnFit, Row};
use super::environment::{Environment, Peer, json_of};
use super::{Options, Task, require_all, write_report};
use crate::{shell, suite};

/// Seconds of a fit, if not chosen.
const SECONDS: u32 = 20;
/// Threads of a fit.
const THREADS: &str = "2";
/// Samples of a pixel of Mitsuba's pictures. Highlights of smooth metals on meshes are narrower
/// than pixels: by 64 samples, two pictures of chrome on the teapot differ by 1.4 times their mean.
const SAMPLES: u32 = 1024;
/// The same of brood's pictures, whose samples are more even.
const OWN_SAMPLES: u32 = 256;
/// Samples of a pixel of photographs in an environment, which has no narrow light.
const ENVIRONMENT_SAMPLES: u32 = 576;
/// File of the environment in the folder of data.
const ENVIRONMENT: &str = "env/mitsuba_docs_envmap.hdr";
const SIZE_PX: u32 = 192;
/// Reason why measured materials and the mesh are missing.
const NO_DATA: &str = "measured materials, the mesh spot and the environment: they need --data";

/// One material on one object, photographed in one way, once or several times.
struct Photograph {
    material: Material,
    object: Object,
    grade: Grade,
    folder: PathBuf,
    tests: Vec<Test>,
}

/// Settings that the fits of a run share.
struct Work<'a> {
    environment: &'a Environment,
    options: &'a Options,
    /// Folder of the meshes.
    meshes: &'a Path,
    /// List of the photographs.
    list: &'a Path,
    models: &'a [Model],
    /// Seconds of brood's fits, in ascending order; those of the peers' are the last.
    seconds: &'a [u32],
}

/// Runs the comparison.
pub fn run(words: &[&str]) -> Result<()> {
    let options = Options::parse(Task::Photographs, words)?;
    let data = options.data.as_ref().map(|data| data.canonicalize().context("resolve --data"));
    let data = data.transpose()?;
    let models = Model::chosen(options.peers.as_deref())?;
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
            let meshes = data.join("meshes");
            let mut forms = environment.script("mesh_forms.py");
            forms.arg(meshes.join("spot_triangulated.obj")).arg(&folder);
            shell::run(forms.arg("--other").arg(meshes.join("teapot_newell_nouv.obj")))?;
            for photograph in &photographs {
                photograph.copy_light(data)?;
            }
        }
    }
    let pictures = options.pictures.clone().unwrap_or_else(|| vec![1]);
    let list = folder.join("photographs.json");
    let most = pictures.iter().copied().max().unwrap_or(1);
    let jobs: Vec<Value> = photographs.iter().map(|each| each.job(&folder, most)).collect();
    std::fs::write(&list, json!(jobs).to_string()).context("write the list of photographs")?;
    let mut make = environment.script("mitsuba_photographs.py");
    json_of(make.arg("make").arg(&list).args(["--threads", THREADS]))?;
    peer::warm(&environment, &list, &models)?;
    let seconds = options.seconds.clone().unwrap_or_else(|| vec![SECONDS]);
    let work = Work {
        environment: &environment,
        options: &options,
        meshes: &folder,
        list: &list,
        models: &models,
        seconds: &seconds,
    };
    let mut rows = Vec::new();
    for (index, photograph) in photographs.iter().enumerate() {
        for &count in &pictures {
            match photograph.row(&work, (index, count), &mut missing) {
                Ok(row) => {
                    println!("{}", row.line());
                    rows.push(row);
                }
                Err(error) => missing.push(format!("{}: {error:#}", photograph.name())),
            }
        }
    }
    let strategy = options.strategy.as_deref().unwrap_or("by default");
    let machine = environment.machine();
    let heading = Heading { strategy, seconds: &seconds, pictures: &pictures };
    let text = table::markdown(&rows, &heading, &missing)?;
    let report = json!({
        "machine": machine, "strategy": strategy, "seconds": seconds, "pictures": pictures,
        "rows": rows.iter().map(Row::json).collect::<Vec<_>>(), "missing": missing,
    });
    write_report(&options.out, "photographs", &report, &text)?;
    chart::draw(&environment, &rows, &heading, &shell::root().join(&options.out))?;
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
                // A sphere sends no light to itself.
                if grade == Grade::Interreflected && object.mesh().is_none() {
                    continue;
                }
                let needs_data = object.mesh().is_some() || grade.light_file().is_some();
                if (needs_data && data.is_none()) || !wanted(&options.materials, material.name) {
                    continue;
                }
                let name = format!("{} {} {}", material.name, object.name(), grade.name());
                let folder = folder.join(name.replace(' ', "-"));
                let tests = object.tests(data.is_some());
                found.push(Photograph { material, object, grade, folder, tests });
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
            "tests": self.tests.iter().map(|test| json!({
                "name": test.name, "scene": test.scene,
                "mesh": test.object.mesh().map(|mesh| folder.join(mesh)),
            })).collect::<Vec<_>>(),
        })
    }

    /// Writes a target of the first photographs alone.
    fn target(&self, count: u32) -> Result<PathBuf> {
        let text = std::fs::read_to_string(self.folder.join("target.json"))
            .context("read the target of all photographs")?;
        let mut target: Value = serde_json::from_str(&text).context("parse the target")?;
        let views = target["views"].as_array_mut().context("the target must have views")?;
        views.truncate(count as usize);
        let path = self.folder.join(format!("target-{count}.json"));
        std::fs::write(&path, target.to_string()).context("write the target")?;
        Ok(path)
    }

    /// Fits the first photographs by all programs, and compares pictures of the results.
    fn row(
        &self,
        work: &Work<'_>,
        (index, count): (usize, u32),
        missing: &mut Vec<String>,
    ) -> Result<Row> {
        let target = self.target(count)?;
        let each = work.seconds.iter().map(|&seconds| self.own_fit(work, &target, count, seconds));
        let fits: Vec<OwnFit> = each.collect::<Result<_>>()?;
        let mut peers = Vec::new();
        for &model in work.models {
            match self.peer(work, (index, count), model) {
                Ok(found) => peers.extend(found),
                Err(error) => {
                    missing.push(format!("{}, {}: {error:#}", self.name(), model.name()));
                }
            }
        }
        Ok(Row {
            material: self.material.name,
            object: self.object.name(),
            grade: self.grade,
            pictures: count,
            fits,
            peers,
        })
    }

    /// Fits the target by brood, and compares pictures of the result.
    fn own_fit(&self, work: &Work<'_>, target: &Path, count: u32, limit_s: u32) -> Result<OwnFit> {
        let Work { environment, options, .. } = *work;
        let result = self.folder.join(format!("result-{count}-{limit_s}"));
        let mut fit = environment.brood();
        fit.arg("fit").arg(target).arg("--output").arg(&result);
        fit.args(["--seconds", &limit_s.to_string(), "--threads", THREADS, "--json"]);
        if let Some(strategy) = &options.strategy {
            fit.args(["--strategy", strategy]);
        }
        let report = json_of(&mut fit)?;
        let seconds =
            report["search"]["seconds"].as_f64().context("the report must have seconds")?;
        for test in &self.tests {
            let mut render = environment.brood();
            render.arg("render").arg(result.join("best.brood"));
            render.arg("--scene").arg(self.folder.join(format!("{}.json", test.name)));
            if let Some(mesh) = test.object.mesh() {
                render.arg("--mesh").arg(work.meshes.join(mesh));
            }
            render.args(["--size", &SIZE_PX.to_string(), "--samples", &OWN_SAMPLES.to_string()]);
            let picture = result.join(format!("{}.exr", test.name));
            shell::output(render.arg("--output").arg(picture))?;
        }
        Ok(OwnFit {
            limit_s,
            seconds,
            scores: Scores::compare(environment, &self.tests, &self.folder, &result)?,
            scene_deg: self.scene_deg(&result, count as usize)?,
        })
    }

    /// Adam's fit; `None` if the material has no such model.
    fn peer(
        &self,
        work: &Work<'_>,
        (index, count): (usize, u32),
        model: Model,
    ) -> Result<Option<(Model, peer::Found, Scores)>> {
        let output = self.folder.join(format!("{}-{count}", model.name()));
        let list = (work.list, index);
        let seconds = work.seconds.iter().copied().max().unwrap_or(SECONDS);
        let Some(found) = model.fit(work.environment, list, (count, seconds), &output)? else {
            return Ok(None);
        };
        let scores = Scores::compare(work.environment, &self.tests, &self.folder, &output)?;
        Ok(Some((model, found, scores)))
    }

    /// Largest errors of the corrected scenes in degrees, of light and camera; `None` if the fit
    /// corrected none.
    fn scene_deg(&self, result: &Path, count: usize) -> Result<Option<(f64, Option<f64>)>> {
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
        Ok(largest)
    }
}
