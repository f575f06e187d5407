//! What is fitted: materials of the file of weights by their names, and files of measurements beside it.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use brood_brdf::{Brdf, Neural};
use brood_search::{MeasuredTarget, TargetKind};

use crate::material_file::{self, Material};
use crate::output;

/// The materials that figures are told of.
const USUAL: [&str; 20] = [
    "alum-bronze",
    "aluminium",
    "black-obsidian",
    "blue-acrylic",
    "chrome",
    "delrin",
    "gold-metallic-paint",
    "green-fabric",
    "light-red-paint",
    "pearl-paint",
    "red-plastic",
    "white-diffuse-bball",
    "blue-metallic-paint",
    "teflon",
    "nickel",
    "pvc",
    "yellow-paint",
    "white-paint",
    "pink-fabric",
    "steel",
];
/// Stands for every material of the file of weights.
const ALL: &str = "all";

/// One of them.
pub struct Measured {
    pub name: String,
    pub target: MeasuredTarget,
    /// Where it is known at every pair of directions.
    pub brdf: Option<Box<dyn Brdf>>,
}

/// The folder they are in.
pub struct Source {
    folder: PathBuf,
    weights: Vec<u8>,
}

impl Source {
    /// Reads the file of weights.
    pub fn open(folder: &Path) -> Result<Self> {
        let weights = output::read_file(&folder.join("nbrdf/merl.json"), 64 << 20)?;
        Ok(Self { folder: folder.to_owned(), weights })
    }

    /// The usual ones where none is named, or all.
    pub fn names(&self, asked: &[String]) -> Result<Vec<String>> {
        match asked {
            [] => Ok(USUAL.map(str::to_owned).to_vec()),
            [all] if all == ALL => Ok(Neural::names(&self.weights)?),
            names => Ok(names.to_vec()),
        }
    }

    /// A material of the file of weights, or the file of that name in the folder.
    pub fn read(&self, name: &str) -> Result<Measured> {
        let path = self.folder.join(name);
        let Some(kind) = kind(&path) else {
            let neural = Neural::read(&self.weights, name).context("nbrdf/merl.json")?;
            let target = MeasuredTarget::of(&neural)?;
            return Ok(Measured { name: name.to_owned(), target, brdf: Some(Box::new(neural)) });
        };
        let (target, _) = material_file::read_target(&path)?;
        // Scattered samples say nothing of what lies between them.
        let brdf = match kind {
            TargetKind::Merl | TargetKind::Rgl => match material_file::read(&path)? {
                Material::Measured(brdf, _) => Some(brdf),
                Material::Bred(_) => bail!("{} is a genome", path.display()),
            },
            _ => None,
        };
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Measured { name: stem, target, brdf })
    }
}

fn kind(path: &Path) -> Option<TargetKind> {
    TargetKind::of_extension(path.extension()?.to_str()?)
}
