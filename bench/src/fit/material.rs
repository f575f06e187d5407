//! Materials to fit: entries of the weights file (nbrdf/merl.json) by name, and measurement files
//! next to it.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use brood_brdf::{Brdf, Neural};
use brood_target::{MeasuredTarget, TargetKind};

use crate::material_file::{self, MaterialFile};
use crate::output;

/// Materials of the reported figures.
const DEFAULT_MATERIALS: [&str; 20] = [
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
/// Selects every material of the weights file.
const ALL: &str = "all";

/// One material and its target.
pub struct FitMaterial {
    pub name: String,
    pub target: MeasuredTarget,
    /// Reflectance at every pair of directions, if it is known.
    pub brdf: Option<Box<dyn Brdf>>,
}

/// Folder of the materials.
pub struct MaterialFolder {
    folder: PathBuf,
    weights: Vec<u8>,
}

impl MaterialFolder {
    /// Reads the weights file.
    pub fn open(folder: &Path) -> Result<Self> {
        let weights = output::read_file(&folder.join("nbrdf/merl.json"), 64 << 20)?;
        Ok(Self { folder: folder.to_owned(), weights })
    }

    /// Names of the default materials if none is given, of all for `all`, else the given names.
    pub fn names(&self, asked: &[String]) -> Result<Vec<String>> {
        match asked {
            [] => Ok(DEFAULT_MATERIALS.map(str::to_owned).to_vec()),
            [all] if all == ALL => Ok(Neural::names(&self.weights)?),
            names => Ok(names.to_vec()),
        }
    }

    /// Reads a material of the weights file, or the measurement file of that name in the folder.
    pub fn read(&self, name: &str) -> Result<FitMaterial> {
        let path = self.folder.join(name);
        let Some(kind) = kind(&path) else {
            let neural = Neural::read(&self.weights, name).context("nbrdf/merl.json")?;
            let target = MeasuredTarget::of(&neural)?;
            return Ok(FitMaterial { name: name.to_owned(), target, brdf: Some(Box::new(neural)) });
        };
        let (target, _) = material_file::read_target(&path)?;
        // Scattered samples do not define f between them.
        let brdf = match kind {
            TargetKind::Merl | TargetKind::Rgl => match material_file::read(&path)? {
                MaterialFile::Measured(brdf, _) => Some(brdf),
                MaterialFile::Bred(_) => {
                    bail!("{} is a genome, expected a measured material", path.display())
                }
            },
            _ => None,
        };
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(FitMaterial { name: stem, target, brdf })
    }
}

fn kind(path: &Path) -> Option<TargetKind> {
    TargetKind::of_extension(path.extension()?.to_str()?)
}
