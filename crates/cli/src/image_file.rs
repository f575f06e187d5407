//! `brood image`: prints the hashes by which genomes name control images; and the images given with
//! `--image`.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use brood_bench::output::{self, read_file};
use brood_eval::decode_image;
use brood_genome::ImageHash;
use brood_light::ImagePyramid;
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
        let (hash, image) = read(path)?;
        let (width, height) = image.size();
        lines.push((hash.to_string(), width, height, path));
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

/// Reads an image and the hash of its file.
pub fn read(path: &Path) -> Result<(ImageHash, ImagePyramid)> {
    let file = read_file(path, IMAGE_BYTES)?;
    let image = decode_image(&file).with_context(|| path.display().to_string())?;
    Ok((ImageHash::of(&file), image))
}
