//! Files of materials: an evolved genome, or a model with its parameters.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use brood_brdf::Model;
use brood_genome::Genome;

use crate::genome_file;

/// What a file holds.
pub enum Material {
    /// A program that was bred or written.
    Evolved(Box<Genome>),
    /// A model of reflectance.
    Analytic(Model),
}

/// Reads the material that an argument names; `-` is stdin.
pub fn read(path: &PathBuf) -> Result<Material> {
    let bytes = genome_file::read_bytes(path)?;
    parse(&bytes).with_context(|| name(path))
}

/// Reads a model; `-` is stdin.
pub fn read_model(path: &PathBuf) -> Result<Model> {
    match read(path)? {
        Material::Analytic(model) => Ok(model),
        Material::Evolved(_) => bail!("{} holds a genome and no model", name(path)),
    }
}

fn name(path: &Path) -> String {
    if path == Path::new("-") { "stdin".to_owned() } else { path.display().to_string() }
}

fn parse(bytes: &[u8]) -> Result<Material> {
    if genome_file::holds_model(bytes) {
        let text = std::str::from_utf8(bytes).context("a material is UTF-8 text")?;
        return Ok(Material::Analytic(text.parse()?));
    }
    Ok(Material::Evolved(Box::new(genome_file::parse(bytes)?)))
}

#[cfg(test)]
mod tests {
    use brood_brdf::ModelKind;

    use super::*;

    #[test]
    fn files_hold_genomes_or_models() {
        let model = Model::new(ModelKind::Ward);
        let read = parse(model.to_string().as_bytes()).unwrap();
        assert!(matches!(read, Material::Analytic(read) if read == model));
        let genome = b"brood 1\n.dialect paper smooth registers 7\nMOV R0, R1\n";
        assert!(matches!(parse(genome).unwrap(), Material::Evolved(_)));
        let error = parse(b"brood 1\n.model ward\nalpha 1\n").err().unwrap().to_string();
        assert!(error.starts_with("line 3: ward has no parameter alpha"), "{error}");
    }
}
