//! Errors of a fit's pictures against Mitsuba's own.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde_json::{Value, json};

use super::super::environment::{Environment, json_of};
use super::stage::Test;

/// Errors of one picture.
#[derive(Debug, Clone, Copy)]
pub struct Score {
    /// Root mean square error over the reference's mean.
    pub relative_rmse: f64,
    /// Mean HDR-FLIP.
    pub flip: f64,
    /// Mean Delta E_ITP, exposed for the reference's bright parts on a display of 100 cd/m2.
    pub itp: f64,
}

/// Errors of all pictures of a fit.
#[derive(Debug, Clone)]
pub struct Scores {
    /// Under the lights that the photographs do not show.
    pub lights: Vec<Score>,
    /// On the mesh that they do not show; `None` without the folder of data.
    pub mesh: Option<Score>,
}

impl Scores {
    /// Compares `<test>.exr` of two folders.
    pub fn compare(
        environment: &Environment,
        tests: &[Test],
        wanted: &Path,
        found: &Path,
    ) -> Result<Self> {
        let pairs: Vec<_> = tests
            .iter()
            .map(|test| [wanted, found].map(|folder| folder.join(format!("{}.exr", test.name))))
            .collect();
        let list = found.join("pairs.json");
        std::fs::write(&list, json!(pairs).to_string()).context("write the list of pictures")?;
        let printed =
            json_of(environment.script("mitsuba_photographs.py").arg("score").arg(&list))?;
        let numbers = |name: &str| -> Result<Vec<f64>> {
            let list = printed[name].as_array().with_context(|| format!("read {name}"))?;
            let numbers: Vec<f64> = list.iter().filter_map(Value::as_f64).collect();
            ensure!(numbers.len() == tests.len(), "the script must print a {name} of each picture");
            Ok(numbers)
        };
        let (errors, whites) = (numbers("relative_rmse")?, numbers("white_cd_m2")?);
        let diff = |pair: &[std::path::PathBuf; 2], options: &[&str]| -> Result<f64> {
            let mut diff = environment.brood();
            diff.arg("diff").args(options).arg("--json").args(pair);
            json_of(&mut diff)?["value"].as_f64().context("brood diff must print a value")
        };
        let mut scores = Self { lights: Vec::new(), mesh: None };
        for (k, test) in tests.iter().enumerate() {
            let white = whites[k].clamp(1e-3, 1e4).to_string();
            let score = Score {
                relative_rmse: errors[k],
                flip: diff(&pairs[k], &["--metric", "flip"])?,
                itp: diff(&pairs[k], &["--metric", "itp", "--white", &white])?,
            };
            if test.is_unseen_mesh {
                scores.mesh = Some(score);
            } else {
                scores.lights.push(score);
            }
        }
        Ok(scores)
    }

    /// Relative RMSE over all unseen lights: root of the mean square.
    pub fn error(&self) -> f64 {
        self.mean(|score| score.relative_rmse.powi(2)).sqrt()
    }

    /// Mean FLIP over all unseen lights.
    pub fn flip(&self) -> f64 {
        self.mean(|score| score.flip)
    }

    /// Mean Delta E_ITP over all unseen lights.
    pub fn itp(&self) -> f64 {
        self.mean(|score| score.itp)
    }

    /// Relative RMSE on the unseen mesh.
    pub fn mesh_error(&self) -> Option<f64> {
        self.mesh.map(|score| score.relative_rmse)
    }

    fn mean(&self, of: impl Fn(&Score) -> f64) -> f64 {
        self.lights.iter().map(of).sum::<f64>() / self.lights.len() as f64
    }

    pub fn json(&self) -> Value {
        let each = |of: fn(&Score) -> f64| self.lights.iter().map(of).collect::<Vec<f64>>();
        json!({
            "relative_rmse": self.error(), "by_light": each(|score| score.relative_rmse),
            "flip": each(|score| score.flip), "itp": each(|score| score.itp),
            "unseen_mesh": self.mesh.map(|score| json!({
                "relative_rmse": score.relative_rmse, "flip": score.flip, "itp": score.itp,
            })),
        })
    }
}
