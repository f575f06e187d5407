//! `brood image`: prints the hashes by which genomes name control images; and the images given with
//! `--image`.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use brood_bench::output::{self, read_file};
use brood_worker::LoadedImage;
use clap::Args;
use serde_json::json;

const IMAGE_BYTES: u64 = 64 << 20;

/// Options of `brood image`.
#[derive(Debug, Args)]
pub struct ImageArgs {
    /// PNG or JPEG files of at most 4096 pixels a side; - is stdin
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
}

/// Runs the command.
pub fn run(args: &ImageArgs, json: bool) -> Result<()> {
    let mut lines = Vec::new();
    for path in &args.files {
        let loaded = read(path)?;
        let (width, height) = loaded.image().size();
        lines.push((loaded.hash().to_string(), width, height, path));
    }
    if json {
        let line = |(hash, width, height, path): &(String, u32, u32, &PathBuf)| json!({"image": hash, "width": width, "height": height, "file": path});
        return output::print_json(&lines.iter().map(line).collect::<Vec<_>>());
    }
    let line = |(hash, width, height, path): &(String, u32, u32, &PathBuf)| {
        format!("{hash}  {width} x {height}  {}\n", path.display())
    };
    output::print(&lines.iter().map(line).collect::<String>())
}

/// Reads a control image.
pub fn read(path: &Path) -> Result<LoadedImage> {
    let file = read_file(path, IMAGE_BYTES)?;
    LoadedImage::decode(&file).with_context(|| path.display().to_string())
}
