//! `cargo xtask bench pictures`: brood's models compared with the same materials in Mitsuba, by
//! pictures.
//!
//! Owns the order of the work: mesh variants, brood's pictures, the peer's pictures and their
//! differences. `case` lists what is rendered; differences are judged against the peer's own noise,
//! which its script measures.

mod case;
pub mod material;
mod page;
mod recorded;
mod row;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use serde_json::{Value, json};

use self::case::{Case, Material};
use self::row::Row;
use super::environment::{Environment, Peer, json_of};
use super::{Options, Task, require_all, write_report};
use crate::{shell, suite};

/// Reason why meshes and recorded pictures are missing.
const NO_DATA: &str = "spot and recorded pictures: they need --data";

/// Runs the comparison.
pub fn run(words: &[&str]) -> Result<()> {
    let options = Options::parse(Task::Pictures, words)?;
    let mut environment = Environment::prepare(&options, &[Peer::Mitsuba])?;
    let mut missing = std::mem::take(&mut environment.missing);
    let mut rows = Vec::new();
    if environment.has(Peer::Mitsuba) {
        let folder = Folder::make(suite::target_directory()?.join("peers/pictures"))?;
        let mut cases = case::fresh(options.data.is_some());
        match &options.data {
            None => missing.push(NO_DATA.to_owned()),
            Some(data) => {
                let data = data.canonicalize().context("resolve --data")?;
                folder.make_meshes(&environment, &data)?;
                cases.extend(recorded::cases(&data));
            }
        }
        rows = folder.compare(&environment, &cases, &mut missing)?;
    }
    let machine = environment.machine();
    let text = page::markdown(&rows, &missing, &machine);
    let report = json!({
        "machine": machine,
        "rows": rows.iter().map(Row::json).collect::<Vec<_>>(),
        "missing": missing,
    });
    write_report(&options.out, "pictures", &report, &text)?;
    require_all(options.require, &missing)
}

/// Folder of the files passed between the programs.
struct Folder(PathBuf);

impl Folder {
    fn make(path: PathBuf) -> Result<Self> {
        std::fs::create_dir_all(&path).context("create the folder for pictures")?;
        Ok(Self(path))
    }

    fn make_meshes(&self, environment: &Environment, data: &Path) -> Result<()> {
        let mesh = data.join("meshes/spot_triangulated.obj");
        ensure!(mesh.is_file(), "{} is missing", mesh.display());
        shell::run(environment.script("mesh_forms.py").arg(mesh).arg(&self.0))
    }

    /// Renders all cases with both programs; cases that brood cannot render are skipped.
    fn compare(
        &self,
        environment: &Environment,
        cases: &[Case],
        missing: &mut Vec<String>,
    ) -> Result<Vec<Row>> {
        let mut rendered = Vec::new();
        for case in cases {
            println!("{}", case.name());
            match self.render(environment, case) {
                Ok(job) => rendered.push((case, job)),
                Err(error) => missing.push(format!("{}: {error:#}", case.name())),
            }
        }
        let jobs = self.0.join("cases.json");
        let list: Vec<&Value> = rendered.iter().map(|(_, job)| job).collect();
        std::fs::write(&jobs, json!(list).to_string()).context("write the cases")?;
        let mut script = environment.script("mitsuba_against.py");
        let answer = json_of(script.arg(&jobs).arg("--pictures").arg(&self.0))?;
        let found = answer["rows"].as_array().context("the peer's output must have rows")?;
        ensure!(found.len() == rendered.len(), "expected one row per case, got {}", found.len());
        rendered.iter().zip(found).map(|((case, _), found)| Row::new(case, found)).collect()
    }

    /// Renders a case with brood; returns the job description for the peer.
    fn render(&self, environment: &Environment, case: &Case) -> Result<Value> {
        let name = case.file_name();
        let second = self.0.join(case::SECOND);
        std::fs::write(&second, format!("brood 1\n.model {}\n", case::second().model))
            .context("write the material of the second object")?;
        let scene = self.0.join(format!("{name}.json"));
        std::fs::write(&scene, case.scene.to_string()).context("write the scene")?;
        let mut command = environment.brood();
        command.arg("render");
        match &case.material {
            Material::Model(words) => {
                let file = self.0.join(format!("{name}.brood"));
                let text = format!("brood 1\n.model {words}\n");
                std::fs::write(&file, text).context("write the material")?;
                command.arg(file)
            }
            // The peer traces from the eye, uses the eye's direction as the measurement's light
            // direction, and keeps values below 0.
            Material::Measured(file) => command.arg(file).args(["--swap", "--keep-negative"]),
        };
        let mesh = case.mesh.map(|mesh| self.0.join(format!("{mesh}.obj")));
        if let Some(mesh) = &mesh {
            command.arg("--mesh").arg(mesh);
        }
        let picture = self.0.join(format!("{name}.exr"));
        command.arg("--scene").arg(&scene).arg("--output").arg(&picture);
        command.args(["--size", &case.size_px.to_string()]);
        shell::output(command.args(["--samples", &case.samples.to_string()]))?;
        Ok(json!({
            "name": name,
            "scene": case.scene,
            "mesh": mesh,
            "others": case.others,
            "bsdf": case.bsdf,
            "size_px": case.size_px,
            "samples": case.peer_samples,
            "sampler": case.peer_sampler,
            "picture": picture,
            "recorded": case.recorded,
        }))
    }
}
