//! GENOME arguments: a `.brood` text or a JSON file, or stdin.

use std::io::Read;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use brood_genome::Genome;

use crate::output::read_file;

/// More than any genome of 1024 instructions takes.
const LIMIT_BYTES: u64 = 1 << 20;

/// Reads the genome that an argument names; `-` is stdin.
pub fn read(path: &PathBuf) -> Result<Genome> {
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

/// What is in the file, or comes from stdin.
pub fn read_bytes(path: &PathBuf) -> Result<Vec<u8>> {
    if path != Path::new("-") {
        return read_file(path, LIMIT_BYTES);
    }
    let mut bytes = Vec::new();
    let stdin = std::io::stdin().lock();
    stdin.take(LIMIT_BYTES + 1).read_to_end(&mut bytes).context("read the genome from stdin")?;
    ensure!(bytes.len() as u64 <= LIMIT_BYTES, "a genome has at most {LIMIT_BYTES} bytes");
    Ok(bytes)
}

/// A genome as text or JSON.
pub fn parse(bytes: &[u8]) -> Result<Genome> {
    let text = std::str::from_utf8(bytes).context("a genome is UTF-8 text")?;
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
    fn error_carries_line_and_column() {
        let error = format!(
            "{:#}",
            parse(b"brood 1\n.dialect paper smooth registers 7\nFOO R1\n").unwrap_err()
        );
        assert!(error.contains("line 3, column 1"), "{error}");
    }
}
