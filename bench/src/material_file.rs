//! Material files: a genome of programs and models, or a measured table.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail};
use brood_brdf::{Brdf, Rgl};
use brood_genome::Genome;
use brood_target::{MeasuredFile, MeasuredTarget, TargetFile, TargetKind};

use crate::genome_file;
use crate::output::read_file;

/// Slightly above the size of a MERL table.
const MERL_BYTES: u64 = 40 << 20;
/// A hundred times the size of RGL's isotropic materials in RGB; anisotropic ones have more
/// azimuths.
const RGL_BYTES: u64 = 128 << 20;
/// The largest number of samples that is read, with about thirty wavelengths each.
const SAMPLES_BYTES: u64 = 128 << 20;
/// Largest of the limits above that a target may use.
const TARGET_BYTES: u64 = 128 << 20;

/// Contents of a material file.
pub enum MaterialFile {
    /// Genome: a program, models, or both.
    Bred(Box<Genome>),
    /// Measured reflectance and the kind of its table.
    Measured(Box<dyn Brdf>, &'static str),
}

/// Reads the material at `path`; `-` is stdin. The file extension selects a measured format.
///
/// # Errors
/// If the file cannot be read or is not of the format of its extension.
pub fn read(path: &Path) -> Result<MaterialFile> {
    let Some(kind) = TargetKind::of_extension(&extension(path)) else {
        return Ok(MaterialFile::Bred(Box::new(genome_file::read(path)?)));
    };
    let bytes = read_file(path, limit_bytes(kind))?;
    let MeasuredFile { brdf, skipped, rows } =
        MeasuredFile::read(kind, &bytes).with_context(|| name(path))?;
    if skipped > 0 {
        warn_skipped(path, skipped, rows);
    }
    Ok(MaterialFile::Measured(brdf, kind.words()))
}

/// Like [`read`], for uses that a painted material does not have.
///
/// # Errors
/// As [`read`], and if the genome is a painted material.
pub fn read_brdf(path: &Path) -> Result<MaterialFile> {
    match read(path)? {
        MaterialFile::Bred(genome) if genome.is_painted() => {
            bail!("{}: a painted material is not a BRDF", name(path))
        }
        material => Ok(material),
    }
}

/// Like [`read`]; `keep_negative` keeps values below 0, which only RGL tables have.
///
/// # Errors
/// As [`read`], and if `keep_negative` is given for another format.
pub fn read_with(path: &Path, keep_negative: bool) -> Result<MaterialFile> {
    if !keep_negative {
        return read(path);
    }
    let kind = TargetKind::Rgl;
    if TargetKind::of_extension(&extension(path)) != Some(kind) {
        bail!("--keep-negative needs an RGL .bsdf, got {}", name(path));
    }
    let rgl = Rgl::read(&read_file(path, RGL_BYTES)?).with_context(|| name(path))?;
    Ok(MaterialFile::Measured(Box::new(rgl.keep_negative()), kind.words()))
}

fn limit_bytes(kind: TargetKind) -> u64 {
    match kind {
        TargetKind::Merl => MERL_BYTES,
        TargetKind::Rgl => RGL_BYTES,
        TargetKind::Samples | TargetKind::Cornell => SAMPLES_BYTES,
        TargetKind::Slice | TargetKind::Image => TARGET_BYTES,
    }
}

/// Reads the target of a search; also returns the kind of its table.
///
/// # Errors
/// If the file cannot be read or is not of the format of its extension.
pub fn read_target(path: &Path) -> Result<(MeasuredTarget, &'static str)> {
    let Some(kind) = TargetKind::of_extension(&extension(path)) else {
        let is_file = path != Path::new("-");
        if is_file {
            // A missing file is reported as missing, whatever its name.
            fs::metadata(path).with_context(|| format!("read {}", name(path)))?;
        }
        let what = match is_file && genome_file::read(path).is_ok() {
            true => "is a genome already",
            false => "has no file extension of a target",
        };
        bail!(
            "{} {what}; a target is a MERL .binary, an RGL .bsdf, samples as .csv, a goniometer's .brdf, or an image slice as \
             .exr",
            name(path)
        );
    };
    let bytes = read_file(path, TARGET_BYTES)?;
    let TargetFile { target, skipped, rows, .. } =
        TargetFile::read(kind, &bytes).with_context(|| name(path))?;
    if skipped > 0 {
        warn_skipped(path, skipped, rows);
    }
    Ok((target, kind.words()))
}

fn extension(path: &Path) -> String {
    let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    extension.to_ascii_lowercase()
}

/// Prints the number of unusable samples on stderr.
fn warn_skipped(path: &Path, skipped: usize, all: usize) {
    eprintln!("{}: {skipped} of {all} samples are not above the surface", name(path));
}

fn name(path: &Path) -> String {
    if path == Path::new("-") { "stdin".to_owned() } else { path.display().to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measured_formats_are_recognised_by_file_extension() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| {
            let path = folder.path().join(name);
            fs::write(&path, text).unwrap();
            path
        };
        let csv = write("a.CSV", "wix,wiy,wiz,wox,woy,woz,r,g,b\n0,0,1,0,0,1,1,1,1\n");
        assert!(matches!(read(&csv).unwrap(), MaterialFile::Measured(_, "scattered samples")));
        let text = write("a.brdf", "1 550 0 0 0 0 0.5");
        assert!(matches!(
            read(&text).unwrap(),
            MaterialFile::Measured(_, "goniometer measurements")
        ));
        let error_of = |path: &Path| format!("{:#}", read(path).err().unwrap());
        assert!(
            error_of(&write("b.brdf", "analytic\n"))
                .contains("b.brdf: this .brdf file is a formula")
        );
        assert!(error_of(&write("b.bsdf", "tensor")).contains("it ends within its head"));
        assert!(error_of(&write("b.csv", "r,g,b\n")).contains("column wix"));
    }

    #[test]
    fn target_error_gives_the_reason_when_the_file_is_no_target() {
        let folder = tempfile::tempdir().unwrap();
        let refused = |path: &Path| format!("{:#}", read_target(path).err().unwrap());
        for name in ["nofile", "nofile.brood"] {
            let words = refused(&folder.path().join(name));
            assert!(words.starts_with("read ") && words.contains("No such file"), "{words}");
        }
        let write = |name: &str, bytes: &[u8]| {
            let path = folder.path().join(name);
            fs::write(&path, bytes).unwrap();
            path
        };
        let large = vec![0; 2 << 20];
        for bytes in [b"wix,wiy\n".as_slice(), &[0xff, 0], &large] {
            let words = refused(&write("table", bytes));
            assert!(
                words.contains("no file extension of a target") && words.contains(".csv"),
                "{words}"
            );
        }
        let gold = brood_genome::preset::Preset::find("gold").unwrap().genome().to_string();
        let words = refused(&write("gold.brood", gold.as_bytes()));
        assert!(words.contains("is a genome already"), "{words}");
    }
}
