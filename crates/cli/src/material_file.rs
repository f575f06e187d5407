//! Files of materials: an evolved genome, a model with its parameters, or a measured table.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use brood_brdf::{Brdf, Merl, Model, Slice};
use brood_genome::Genome;

use crate::diff::Picture;
use crate::genome_file;
use crate::output::read_file;

/// A little more than a MERL table takes.
const MERL_BYTES: u64 = 40 << 20;
const SLICE_BYTES: u64 = 4 << 20;

/// What a file holds.
pub enum Material {
    /// A program that was bred or written.
    Evolved(Box<Genome>),
    /// A model of reflectance.
    Analytic(Model),
    /// What was measured, and what kind of file that was.
    Measured(Box<dyn Brdf>, &'static str),
}

/// Reads the material that an argument names; `-` is stdin. A name that ends in .binary is a MERL table, in .exr an image slice.
pub fn read(path: &PathBuf) -> Result<Material> {
    let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    match extension.to_ascii_lowercase().as_str() {
        "binary" => {
            let merl = Merl::read(&read_file(path, MERL_BYTES)?).with_context(|| name(path))?;
            return Ok(Material::Measured(Box::new(merl), "MERL table"));
        }
        "exr" => {
            let slice = read_slice(path).with_context(|| name(path))?;
            return Ok(Material::Measured(Box::new(slice), "image slice"));
        }
        _ => {}
    }
    let bytes = genome_file::read_bytes(path)?;
    parse(&bytes).with_context(|| name(path))
}

/// Reads a model; `-` is stdin.
pub fn read_model(path: &PathBuf) -> Result<Model> {
    match read(path)? {
        Material::Analytic(model) => Ok(model),
        Material::Evolved(_) => bail!("{} holds a genome and no model", name(path)),
        Material::Measured(..) => bail!("{} was measured and is no model", name(path)),
    }
}

fn read_slice(path: &Path) -> Result<Slice> {
    // So that no large picture is decoded to be refused.
    read_file(path, SLICE_BYTES)?;
    let (width, height, pixels) = Picture::read(path)?.into_linear();
    #[expect(clippy::cast_possible_truncation, reason = "the file holds f32 or less")]
    let values = pixels.into_iter().map(|rgb| rgb.map(|value| value as f32)).collect();
    Ok(Slice::new(width as usize, height as usize, values)?)
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
