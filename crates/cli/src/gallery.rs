//! `brood model gallery`: pictures of every model, of layers and of lights, with a page of captions
//! and a contact sheet.
//!
//! Owns the options, the rendering and the files; `exhibit` lists the pictures, `page` writes the
//! page. One version writes the same bytes on every machine.

mod exhibit;
mod page;

use std::path::PathBuf;

use anyhow::{Context, Result};
use brood_bench::{logging, output};
use brood_eval::{Developed, SheetCell, express, sheet};
use brood_protocol::{Backend, Frame, MeshSource, PictureFormat};
use brood_scene::Sampling;
use brood_worker::Renderer;
use clap::Args;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use serde_json::json;

use exhibit::Exhibit;

/// Side of a picture in pixels.
const SIZE_PX: u32 = 112;
/// Side of a cell of the contact sheet.
const CELL_PX: u32 = 80;
const GAP_PX: u32 = 4;
/// Folder of the pictures, relative to the page.
const FOLDER: &str = "pictures/gallery";
const SHEET: &str = "pictures/gallery.png";

/// Options of `brood model gallery`.
#[derive(Debug, Args)]
pub struct GalleryArgs {
    /// Folder for gallery.md and pictures/
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

/// Runs the command.
pub fn run(args: &GalleryArgs, json: bool) -> Result<()> {
    logging::start_offline();
    let sections = exhibit::sections()?;
    let all: Vec<&Exhibit> = sections.iter().flat_map(|section| &section.exhibits).collect();
    output::make_dir(&args.output.join(FOLDER))?;
    let bar = output::bar(all.len() as u64, "pictures");
    let renderer = Renderer::new(Backend::Cpu);
    let mut pictures = Vec::with_capacity(all.len());
    for exhibit in &all {
        let picture = render(&renderer, exhibit)?;
        let file = args.output.join(FOLDER).join(exhibit.file());
        output::write_file(&file, &encode(picture.width, picture.height, &picture.rgba)?)?;
        pictures.push(picture);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let cells: Vec<SheetCell<'_>> = pictures
        .iter()
        .map(|Developed { width, height, rgba, .. }| SheetCell {
            width: *width,
            height: *height,
            rgba,
        })
        .collect();
    let (width, height, rgba) = sheet(&cells, None, CELL_PX, GAP_PX);
    output::write_file(&args.output.join(SHEET), &encode(width, height, &rgba)?)?;
    let page = args.output.join("gallery.md");
    output::write_file(&page, page::markdown(&sections).as_bytes())?;
    if json {
        let names: Vec<String> = all.iter().map(|exhibit| exhibit.file()).collect();
        return output::print_json(&json!({ "page": page, "pictures": names }));
    }
    output::print(&format!("{} pictures, {}\n", all.len(), page.display()))
}

fn render(renderer: &Renderer, exhibit: &Exhibit) -> Result<Developed> {
    let Some(name) = exhibit.scene.builtin() else {
        anyhow::bail!("{} must be shown on a built-in mesh", exhibit.name)
    };
    renderer.set_light_assets(exhibit.assets.clone());
    let (mesh, how) = (renderer.builtin(name), (PictureFormat::Png, Backend::Cpu));
    let sampling = Sampling::default();
    let frame = Frame::new(&exhibit.scene, MeshSource::Builtin, SIZE_PX, sampling, how);
    let program = express(&exhibit.genome);
    let picture = renderer.develop(&frame, &mesh, &[&program])?.pop();
    picture.context("one program has one picture")
}

/// Encodes a PNG at the best compression, because these files are stored in the repository.
fn encode(width: u32, height: u32, rgba: &[u8]) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive)
        .write_image(rgba, width, height, ExtendedColorType::Rgba8)
        .context("encode the PNG")?;
    Ok(bytes)
}
