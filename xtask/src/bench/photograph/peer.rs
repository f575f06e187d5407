//! Fits of the same photographs by Mitsuba's derivatives with Adam.
//!
//! Owns the choice of models and the command lines; `mitsuba_photograph_fit.py` owns the method.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use super::super::environment::{Environment, json_of};
use super::THREADS;

/// Model that Adam fits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Model {
    /// Mitsuba's `principled`, whatever the material is.
    Principled,
    /// The plugin that took the pictures, which measured materials do not have.
    Generating,
}

/// Result of Adam.
#[derive(Debug, Clone, Copy)]
pub struct Found {
    pub seconds: f64,
    /// Time until the loss was within 5 % of the least.
    pub seconds_to_best: f64,
    pub steps: u64,
}

impl Model {
    pub const ALL: [Self; 2] = [Self::Principled, Self::Generating];

    /// Name in tables and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Principled => "principled",
            Self::Generating => "generating",
        }
    }

    /// The models of a comma-separated list: all by default, and none for `none`.
    pub fn chosen(list: Option<&str>) -> Result<Vec<Self>> {
        let Some(list) = list else { return Ok(Self::ALL.to_vec()) };
        if list == "none" {
            return Ok(Vec::new());
        }
        let names: Vec<&str> = list.split(',').collect();
        for name in &names {
            let known = Self::ALL.iter().any(|model| model.name() == *name);
            ensure!(known, "--peers are principled, generating or none, got {name}");
        }
        Ok(Self::ALL.into_iter().filter(|model| names.contains(&model.name())).collect())
    }

    /// Fits the first photographs of one material of the list; `None` if there is no such model of
    /// the material.
    pub fn fit(
        self,
        environment: &Environment,
        (list, index): (&Path, usize),
        (pictures, seconds): (u32, u32),
        output: &Path,
    ) -> Result<Option<Found>> {
        let mut fit = environment.script("mitsuba_photograph_fit.py");
        fit.arg("fit").arg(list).args(["--index", &index.to_string(), "--threads", THREADS]);
        fit.args(["--model", self.name(), "--seconds", &seconds.to_string()]);
        fit.args(["--pictures", &pictures.to_string()]);
        let report = json_of(fit.arg("--output").arg(output))?;
        if report.get("model") == Some(&Value::Null) {
            return Ok(None);
        }
        let number = |name: &str| {
            report[name].as_f64().with_context(|| format!("the report must have {name}"))
        };
        Ok(Some(Found {
            seconds: number("seconds")?,
            seconds_to_best: number("seconds_to_best")?,
            steps: report["steps"].as_u64().context("the report must have steps")?,
        }))
    }
}

/// Fills the cache of compiled kernels on disk with those of each kind of fit.
pub fn warm(environment: &Environment, list: &Path, models: &[Model]) -> Result<()> {
    if models.is_empty() {
        return Ok(());
    }
    let names: Vec<&str> = models.iter().map(|model| model.name()).collect();
    let mut warm = environment.script("mitsuba_photograph_fit.py");
    warm.arg("warm").arg(list).args(["--models", &names.join(","), "--threads", THREADS]);
    json_of(&mut warm).context("compile the kernels of Mitsuba with Adam")?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::Model;

    #[test]
    fn models_are_chosen_by_name() {
        assert_eq!(Model::chosen(None).unwrap(), Model::ALL);
        assert!(Model::chosen(Some("none")).unwrap().is_empty());
        assert_eq!(Model::chosen(Some("generating")).unwrap(), [Model::Generating]);
        assert!(Model::chosen(Some("generating,best")).is_err());
    }
}
