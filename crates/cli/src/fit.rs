//! `brood fit`: a search for a material that matches a measured one or pictures of one, without a server.
//!
//! Owns the options, the budget and the files; how far off what was found is, and what physics says of it, stands in `report`.

pub mod budget;
mod image;
mod log;
mod report;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use brood_eval::encode_png;
use brood_genome::{Genome, ModelKind};
use brood_inspect::Shot;
use brood_protocol::PictureFormat;
use brood_scene::Exposure;
use brood_search::{Found, MeasuredTarget, Options, Outcome, Progress, Search, Strategy};
use brood_worker::Renderer;
use clap::Args;

use crate::compare::Subject;
use crate::frame::FrameArgs;
use crate::{logging, material_file, output};
use budget::{Budget, spend};
use log::Log;
use report::Report;

const SECONDS: f64 = 10.0;

/// Options of `brood fit`.
#[derive(Debug, Args)]
pub struct FitArgs {
    /// What is to be matched: a MERL `.binary`, an RGL `.bsdf`, samples as `.csv`, a goniometer's `.brdf`, an image slice as
    /// `.exr`; with --scene a picture of that scene as `.exr`, `.hdr`, `.png` or `.jpg`; several pictures as `.json`
    pub target: PathBuf,
    /// How to search
    #[arg(long, value_name = "S", default_value_t = Strategy::Hybrid, value_parser = str::parse::<Strategy>)]
    pub strategy: Strategy,
    /// Search for that long; 10 seconds where no budget is given
    #[arg(long, value_name = "N", conflicts_with = "generations")]
    pub seconds: Option<f64>,
    /// Search for so many generations: the same result on every machine
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub generations: Option<u32>,
    /// Threads to use; all of the machine's where it is not given
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// What the search draws from
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,
    /// The material is its own mirror image, so that the fit need not tell left from right
    #[arg(long)]
    pub mirrored: bool,
    /// Models that strategy analytic may use, with commas between them; all reciprocal ones where none is named
    #[arg(long, value_name = "MODEL", value_delimiter = ',', value_parser = str::parse::<ModelKind>)]
    pub models: Vec<ModelKind>,
    /// A picture of the target's size: pixels that are looked at are white in it
    #[arg(long, value_name = "PICTURE")]
    pub mask: Option<PathBuf>,
    /// The brightness of the picture is not known: a gain is solved for
    #[arg(long)]
    pub gain: bool,
    /// An .exr is an image slice, also where there is a scene
    #[arg(long)]
    pub slice: bool,
    #[command(flatten)]
    pub frame: FrameArgs,
    /// One line of JSON a generation goes there: the best, the middle of the population, how much it differs, candidates spared
    #[arg(long, value_name = "FILE.ndjson")]
    pub log: Option<PathBuf>,
    /// Where best.brood, the front, the report and the pictures go
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
}

/// Runs the command.
pub fn run(args: &FitArgs, json: bool) -> Result<()> {
    logging::start_offline();
    let seconds = args.seconds.unwrap_or(SECONDS);
    ensure!(seconds > 0.0 && seconds <= 1e6, "--seconds is a number above 0, up to a million");
    let is_analytic = args.strategy == Strategy::Analytic;
    ensure!(args.models.is_empty() || is_analytic, "--models is for --strategy analytic");
    let renderer = Renderer::new(args.frame.backend);
    // Before the search, so that what cannot be drawn is known at once.
    let images = image::read(args, &renderer)?;
    let (target, kind) = match &images {
        Some(images) => (images.target(), "picture"),
        None => {
            args.frame.load(&renderer, PictureFormat::Png)?;
            material_file::read_target(&args.target)?
        }
    };
    output::make_dir(&args.output)?;
    let mut pool = rayon::ThreadPoolBuilder::new();
    if let Some(threads) = args.threads {
        pool = pool.num_threads(usize::from(threads));
    }
    let pool = pool.build().context("start the threads of the search")?;
    let begun = Instant::now();
    let (outcome, progress) = pool.install(|| search(args, &target, seconds))?;
    let seconds = begun.elapsed().as_secs_f64();
    let front =
        pool.install(|| Found::all(&outcome.front, &target)).context("evaluate what was found")?;
    let best = &front[outcome.best];
    write_front(&args.output, &front)?;
    output::write_file(&args.output.join("best.brood"), best.genome.to_string().as_bytes())?;
    let views = match &images {
        Some(images) => images.write(&args.output, &best.genome)?,
        None => {
            pictures(args, &renderer, &best.genome)?;
            Vec::new()
        }
    };
    let (seed, threads) = (args.seed, pool.current_num_threads());
    let report = Report::of(best, &target, kind)?;
    let run = serde_json::json!({
        "strategy": args.strategy, "seed": seed, "threads": threads, "generations": progress.generation,
        "evaluations": progress.evaluations, "seconds": seconds,
    });
    let mut told = report.json(&run);
    if let Some(images) = &images {
        told["target"]["pixels"] = serde_json::json!(images.counts());
        told["image_rmse"] = views[0]["rmse"].clone();
        told["views"] = serde_json::json!(views);
    }
    let text = serde_json::to_string_pretty(&told).context("write JSON")?;
    output::write_file(&args.output.join("report.json"), text.as_bytes())?;
    if json {
        return output::print(&format!("{text}\n"));
    }
    let of_pictures =
        images.map_or_else(String::new, |images| image::text(&views, images.counts()));
    output::print(&format!(
        "{}{of_pictures}{} generations in {seconds:.1} s on {threads} threads; {} holds best.brood, best.png beside target.png, \
         front.csv with its genomes, and report.json\n",
        report.text(),
        progress.generation,
        args.output.display(),
    ))
}

/// Searches until the budget is used up; also what the last generation came to.
fn search(args: &FitArgs, target: &MeasuredTarget, seconds: f64) -> Result<(Outcome, Progress)> {
    let FitArgs { strategy, seed, mirrored: is_mirrored, .. } = *args;
    let options = Options { strategy, seed, is_mirrored, start: Vec::new() };
    let budget = args.generations.map_or(Budget::Seconds(seconds), Budget::Generations);
    let mut search = match args.models.as_slice() {
        [] => Search::new(&target.fitted, &options),
        kinds => Search::of_kinds(&target.fitted, &options, kinds.to_vec()),
    };
    let mut log = args.log.as_deref().map(Log::create).transpose()?;
    let spinner = output::spinner("searching");
    let mut told = f64::INFINITY;
    let found = spend(&mut search, budget, |search, progress, elapsed| {
        if let Some(log) = &mut log {
            log.add(progress, &search.probe(), elapsed);
        }
        let line = format!(
            "generation {}, {:.1} s: E_log {:.5} where it was fitted, {:.5} where it was not",
            progress.generation,
            elapsed.as_secs_f64(),
            progress.fitted,
            progress.held,
        );
        // Every tenth off is news, on a terminal as elsewhere.
        if progress.held < 0.9 * told {
            told = progress.held;
            spinner.suspend(|| eprintln!("{line}"));
        }
        spinner.set_message(line);
    });
    spinner.finish_and_clear();
    log.map_or(Ok(()), Log::finish)?;
    found.context("the search found nothing")
}

/// The front as CSV and its genomes, from the longest to the shortest.
fn write_front(folder: &Path, front: &[Found]) -> Result<()> {
    let genomes = folder.join("front");
    output::make_dir(&genomes)?;
    let mut text = String::from("genome,operations,numbers,e_log_fitted,e_log\n");
    for (index, found) in front.iter().enumerate() {
        let name = format!("{index:02}.brood");
        output::write_file(&genomes.join(&name), found.genome.to_string().as_bytes())?;
        let Found { operations, numbers, fitted, e_log, .. } = found;
        text += &format!("front/{name},{operations},{numbers},{fitted},{e_log}\n");
    }
    output::write_file(&folder.join("front.csv"), text.as_bytes())
}

/// The target and what was found, at the exposure of the target.
fn pictures(args: &FitArgs, renderer: &Renderer, best: &Genome) -> Result<()> {
    let (frame, mesh) = args.frame.load(renderer, PictureFormat::Png)?;
    let mut scene = frame.scene()?;
    let assets = renderer.light_assets();
    let subjects = [Subject::read(&args.target)?, Subject::of("best", best.clone())];
    for (name, subject) in ["target.png", "best.png"].into_iter().zip(subjects) {
        let (size_px, sampling) = (args.frame.size, args.frame.samples);
        let shot = Shot { mesh: mesh.mesh(), scene: &scene, assets: &assets, size_px, sampling };
        let developed = shot.take(&subject).developed;
        scene.film.exposure = Exposure::Ev(developed.exposure_ev);
        let png = encode_png(developed.width, developed.height, &developed.rgba);
        output::write_file(&args.output.join(name), &png)?;
    }
    Ok(())
}
