//! How results leave: whole files by rename, whole texts to stdout, progress on a terminal's stderr.

use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, Result};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

/// Writes a file so that nobody ever sees a part of it.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<()> {
    let context = || format!("write {}", path.display());
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(folder(path)).with_context(context)?;
    file.write_all(bytes).with_context(context)?;
    file.persist(path).map_err(|e| e.error).with_context(context)?;
    Ok(())
}

/// A free name beside `path` for something that is to be renamed to it.
pub fn name_beside(path: &Path) -> Result<PathBuf> {
    let name = path.file_name().context("the output is a directory, not a file")?;
    let mut random = [0; 8];
    getrandom::fill(&mut random).context("draw a random name")?;
    let tag = u64::from_le_bytes(random);
    Ok(folder(path).join(format!(".{}.{tag:016x}", name.to_string_lossy())))
}

/// Makes a directory where it is missing.
pub fn make_dir(dir: &Path) -> Result<()> {
    fs::create_dir_all(dir).with_context(|| format!("make the directory {}", dir.display()))
}

/// Reads a whole file of at most `limit_bytes`.
pub fn read_file(path: &Path, limit_bytes: u64) -> Result<Vec<u8>> {
    let context = || format!("read {}", path.display());
    let length = fs::metadata(path).with_context(context)?.len();
    anyhow::ensure!(
        length <= limit_bytes,
        "{} has {length} bytes; at most {limit_bytes} are read",
        path.display()
    );
    fs::read(path).with_context(context)
}

/// Prints a text; a reader that has seen enough is no error.
pub fn print(text: &str) -> Result<()> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error).context("print"),
        _ => Ok(()),
    }
}

/// Prints a value as one line of JSON.
pub fn print_json(value: &impl Serialize) -> Result<()> {
    print(&format!("{}\n", serde_json::to_string(value).context("write JSON")?))
}

/// A bar on a terminal's stderr, nothing elsewhere.
pub fn bar(steps: u64, what: &'static str) -> ProgressBar {
    let bar = ProgressBar::new(steps).with_message(what);
    let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}");
    bar.set_style(style.expect("the template is valid"));
    bar
}

/// A spinner on a terminal's stderr, for work of unknown length.
pub fn spinner(what: &'static str) -> ProgressBar {
    let spinner = ProgressBar::new_spinner().with_message(what);
    spinner.enable_steady_tick(Duration::from_millis(200));
    spinner
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn file_is_replaced_whole_and_nothing_is_left_beside_it() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.txt");
        write_file(&path, b"first").unwrap();
        write_file(&path, b"2").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"2");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
        assert!(write_file(&dir.path().join("no/a.txt"), b"").is_err());
    }
}
