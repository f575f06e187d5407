//! GENOME arguments: a `.brood` or JSON file, or stdin.

use std::path::Path;

use anyhow::{Context, Result, bail};
use brood_genome::Genome;

use crate::output::read_input;

/// Upper bound of a genome of 1024 instructions.
const LIMIT_BYTES: u64 = 1 << 20;

/// Reads the genome at `path`; `-` is stdin.
///
/// # Errors
/// If the file cannot be read or is not a genome.
pub fn read(path: &Path) -> Result<Genome> {
    let bytes = read_bytes(path)?;
    let name = || {
        if path == Path::new("-") {
            "the genome from stdin".to_owned()
        } else {
            path.display().to_string()
        }
    };
    parse(&bytes).with_context(name)
}

/// Reads the genome of a BRDF at `path`, for uses that a painted material does not have.
///
/// # Errors
/// As [`read`], and if the genome is a painted material.
pub fn read_brdf(path: &Path) -> Result<Genome> {
    let genome = read(path)?;
    if genome.is_painted() {
        bail!("{}: a painted material is not a BRDF", path.display());
    }
    Ok(genome)
}

/// Reads the bytes of the file or of stdin.
///
/// # Errors
/// If the file cannot be read or is longer than any genome.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    read_input(path, LIMIT_BYTES)
}

/// Parses a genome as text or JSON.
///
/// # Errors
/// Returns the line and column, or the path in JSON, that is not a genome.
pub fn parse(bytes: &[u8]) -> Result<Genome> {
    let text = std::str::from_utf8(bytes).context("a genome must be UTF-8 text")?;
    if text.trim_start_matches('\u{feff}').trim_start().starts_with('{') {
        let json = serde_json::from_str(text.trim_start_matches('\u{feff}'))?;
        return Ok(Genome::from_json(json)?);
    }
    Ok(text.parse()?)
}

#[cfg(test)]
mod tests {
    use brood_genome::{BirthKey, Dialect, Variation};

    use super::*;

    #[test]
    fn text_and_json_give_the_same_genome() {
        let key = BirthKey { seed: 4, slot: 0, attempt: 0 };
        let genome = Variation::random(Dialect::default()).birth(key);
        assert_eq!(parse(genome.to_string().as_bytes()).unwrap(), genome);
        assert_eq!(parse(genome.to_json().to_string().as_bytes()).unwrap(), genome);
    }

    #[test]
    fn error_names_line_and_column() {
        let error = format!(
            "{:#}",
            parse(b"brood 1\n.dialect paper smooth registers 7\nFOO R1\n").unwrap_err()
        );
        assert!(error.contains("line 3, column 1"), "{error}");
    }
}
