//! Output of the commands: files written atomically, text on stdout, progress on stderr.

use std::fs;
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::time::Duration;

use anyhow::{Context, Result};
use brood_protocol::random_bytes;
use indicatif::{MultiProgress, ProgressBar, ProgressStyle};
use serde::Serialize;

/// Writes a file atomically: readers see the old content or the new one.
///
/// # Errors
/// Returns the path that cannot be written.
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

/// Unused name in the folder of `path` for a file that is renamed to `path` later.
///
/// # Errors
/// If `path` has no file name, or the system gives no random bytes.
pub fn name_beside(path: &Path) -> Result<PathBuf> {
    let name = path.file_name().context("the output must be a file name")?;
    let tag = u64::from_le_bytes(random_bytes().context("draw a random name")?);
    Ok(folder(path).join(format!(".{}.{tag:016x}", name.to_string_lossy())))
}

/// Creates a directory and its parents if missing.
///
/// # Errors
/// Returns the path that cannot be created.
pub fn make_dir(dir: &Path) -> Result<()> {
    fs::create_dir_all(dir).with_context(|| format!("create the directory {}", dir.display()))
}

/// Reads a whole file of at most `limit_bytes`.
///
/// # Errors
/// If the file cannot be read or is longer.
pub fn read_file(path: &Path, limit_bytes: u64) -> Result<Vec<u8>> {
    let context = || format!("read {}", path.display());
    let length = fs::metadata(path).with_context(context)?.len();
    anyhow::ensure!(
        length <= limit_bytes,
        "{} has {length} bytes, more than the limit of {limit_bytes}",
        path.display()
    );
    fs::read(path).with_context(context)
}

/// Reads a whole file of at most `limit_bytes`; `-` is stdin.
///
/// # Errors
/// If the file cannot be read or is longer.
pub fn read_input(path: &Path, limit_bytes: u64) -> Result<Vec<u8>> {
    if path != Path::new("-") {
        return read_file(path, limit_bytes);
    }
    let mut bytes = Vec::new();
    let stdin = std::io::stdin().lock();
    stdin.take(limit_bytes + 1).read_to_end(&mut bytes).context("read stdin")?;
    anyhow::ensure!(
        bytes.len() as u64 <= limit_bytes,
        "stdin has more than the limit of {limit_bytes} bytes"
    );
    Ok(bytes)
}

/// Prints a text to stdout; a closed pipe is not an error.
///
/// # Errors
/// If stdout fails, except because its reader has closed it.
pub fn print(text: &str) -> Result<()> {
    print_bytes(text.as_bytes())
}

/// Writes bytes to stdout, as [`print`].
///
/// # Errors
/// As [`print`].
pub fn print_bytes(bytes: &[u8]) -> Result<()> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(bytes).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error).context("print"),
        _ => Ok(()),
    }
}

/// Prints a value as one line of JSON.
///
/// # Errors
/// As [`print`].
pub fn print_json(value: &impl Serialize) -> Result<()> {
    print(&format!("{}\n", serde_json::to_string(value).context("write JSON")?))
}

/// All progress on stderr, one line below another.
static PROGRESS: LazyLock<MultiProgress> = LazyLock::new(MultiProgress::new);

/// Progress bar on stderr; hidden if stderr is not a terminal.
pub fn bar(steps: u64, what: &'static str) -> ProgressBar {
    let bar = ProgressBar::new(steps).with_message(what);
    let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}");
    bar.set_style(style.expect("the template is valid"));
    PROGRESS.add(bar)
}

/// Spinner on stderr for work of unknown length; hidden if stderr is not a terminal.
pub fn spinner(what: &'static str) -> ProgressBar {
    let spinner = PROGRESS.add(ProgressBar::new_spinner().with_message(what));
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
    fn file_is_replaced_atomically_and_leaves_no_other_file() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.txt");
        write_file(&path, b"first").unwrap();
        write_file(&path, b"2").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"2");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
        assert!(write_file(&dir.path().join("no/a.txt"), b"").is_err());
    }
}
