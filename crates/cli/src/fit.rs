//! `brood fit`: searches for a material that matches a measured one, or pictures of one, without a
//! server.
//!
//! Owns the options, the budget and the files. The errors and physical measures of the result are
//! computed in `report`.

mod image;
mod log;
mod report;
mod spread;

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use brood_bench::budget::{FitBudget, spend};
use brood_bench::chart::Cell;
use brood_bench::{logging, material_file, output};
use brood_eval::encode_png;
use brood_genome::{Genome, ModelKind};
use brood_inspect::Shot;
use brood_protocol::PictureFormat;
use brood_scene::{ClipFrom, Exposure, PixelArea, Refine};
use brood_search::{Found, Options, Outcome, Progress, Search, Spread};
use brood_target::{MeasuredTarget, Objective, PixelCounts, Strategy};
use brood_worker::Renderer;
use clap::Args;

use crate::compare::NamedMaterial;
use crate::frame::FrameArgs;
use crate::front;
use log::Log;
use report::Report;
use spread::SpreadReport;

/// Default budget in seconds, and the least that is left to the search after scenes were corrected.
const SECONDS: f64 = 10.0;
const LEAST_SECONDS: f64 = 0.01;

/// Strategy, or `None` for `auto`. An alias, because clap takes an `Option` as an argument that may
/// be absent.
type StrategyChoice = Option<Strategy>;

/// Options of `brood fit`.
#[derive(Debug, Args)]
pub struct FitArgs {
    /// Target to match: a MERL `.binary`, an RGL `.bsdf`, samples as `.csv`, a goniometer's
    /// `.brdf`, an image slice as `.exr`; with --scene a picture of that scene as `.exr`, `.hdr`,
    /// `.png` or `.jpg`; several pictures as `.json`
    pub target: PathBuf,
    /// Search strategy: lobes, analytic, gp or hybrid; auto is analytic for pictures and hybrid for
    /// measurements
    #[arg(long, value_name = "S", default_value = "auto", value_parser = Strategy::choice)]
    pub strategy: StrategyChoice,
    /// Error that lobes minimise: `seen`, their default, is E_log with differences of dark values
    /// added, which pictures show; `e_log` is E_log alone, which the other strategies minimise
    #[arg(long, value_name = "O", value_parser = str::parse::<Objective>)]
    pub objective: Option<Objective>,
    /// Time budget in seconds; 10 if no budget is given
    #[arg(long, value_name = "N", conflicts_with = "generations")]
    pub seconds: Option<f64>,
    /// Budget as a number of generations; gives the same result on every machine
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub generations: Option<u32>,
    /// Number of threads; all cores by default
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Seed of the search
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,
    /// Treat the material as its own mirror image, so that the fit does not distinguish left from
    /// right
    #[arg(long)]
    pub mirrored: bool,
    /// Models for strategy analytic, comma-separated; all reciprocal ones by default
    #[arg(long, value_name = "MODEL", value_delimiter = ',', value_parser = str::parse::<ModelKind>)]
    pub models: Vec<ModelKind>,
    /// Picture of the target's size whose white pixels are used
    #[arg(long, value_name = "PICTURE")]
    pub mask: Option<PathBuf>,
    /// Solve for a gain, because the brightness of the picture is unknown
    #[arg(long)]
    pub gain: bool,
    /// Code of 8 bits from which a channel of the picture counts as clipped; `auto` finds it from
    /// plateaus, `off` uses every pixel
    #[arg(long, value_name = "CODE", default_value_t = ClipFrom::Auto, value_parser = str::parse::<ClipFrom>)]
    pub clip_from: ClipFrom,
    /// Part of the picture to use: first column and row, width and height in pixels; the scene
    /// describes this part
    #[arg(long, value_name = "X,Y,W,H", value_parser = str::parse::<PixelArea>)]
    pub crop: Option<PixelArea>,
    /// Uncertainties within which the scene of the picture is corrected, as JSON such as
    /// '{"light_deg": 2, "camera_deg": 1}'
    #[arg(long, value_name = "JSON", value_parser = refine)]
    pub refine: Option<Refine>,
    /// Read an .exr as an image slice, even with --scene
    #[arg(long)]
    pub slice: bool,
    #[command(flatten)]
    pub frame: FrameArgs,
    /// File for one line of JSON per generation: best and median error, diversity and repeats of
    /// the population
    #[arg(long, value_name = "FILE.ndjson")]
    pub log: Option<PathBuf>,
    /// Folder for best.brood, the front, the report and the pictures
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
}

/// Runs the command.
pub fn run(args: &FitArgs, json: bool) -> Result<()> {
    logging::start_offline();
    let seconds = args.seconds.unwrap_or(SECONDS);
    ensure!(
        seconds > 0.0 && seconds <= 1e6,
        "--seconds must be above 0 and at most 1000000, got {seconds}"
    );
    let renderer = Renderer::new(args.frame.backend);
    // Loaded before the search, so that a bad scene fails at once.
    let mut images = image::read(args, &renderer)?;
    let strategy = args.strategy.unwrap_or(Strategy::of_target(images.is_some()));
    if let Some(images) = &images {
        let PixelCounts { used, several_lights, .. } = images.counts();
        strategy.check_pixels(used, several_lights)?;
    }
    let objective = strategy.objective(args.objective)?;
    let is_analytic = strategy == Strategy::Analytic;
    ensure!(args.models.is_empty() || is_analytic, "--models needs --strategy analytic");
    let measured = match &images {
        Some(_) => None,
        None => {
            args.frame.load_alone(&renderer, PictureFormat::Png)?;
            Some(material_file::read_target(&args.target)?)
        }
    };
    output::make_dir(&args.output)?;
    let mut pool = rayon::ThreadPoolBuilder::new();
    if let Some(threads) = args.threads {
        pool = pool.num_threads(usize::from(threads));
    }
    let pool = pool.build().context("start the threads of the search")?;
    let begun = Instant::now();
    images = images.map(|images| pool.install(|| images.calibrated())).transpose()?;
    let (target, kind) = match (&images, measured) {
        (Some(images), _) => (images.target(), "picture"),
        (None, measured) => measured.expect("a target is pictures or a measurement"),
    };
    let rest = (seconds - begun.elapsed().as_secs_f64()).max(LEAST_SECONDS);
    let Searched { outcome, progress, spread } =
        pool.install(|| search(args, (strategy, objective), &target, rest))?;
    let seconds = begun.elapsed().as_secs_f64();
    let front =
        pool.install(|| Found::all(&outcome.front, &target)).context("evaluate the front")?;
    let best = &front[Found::best(&front, &outcome)];
    // From the longest to the shortest genome.
    front::write(&args.output, front.iter().map(row))?;
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
        "strategy": strategy.name(), "objective": objective.name(), "seed": seed, "threads": threads, "generations": progress.generation,
        "evaluations": progress.evaluations, "seconds": seconds,
    });
    let spread = images.as_ref().zip(spread).map(|(images, spread)| {
        let seen = (images.first(), &target);
        pool.install(|| SpreadReport::write(&spread, seen, &args.output))
    });
    let spread = spread.transpose()?;
    let mut report_json = report.json(&run);
    if let Some(spread) = &spread {
        report_json["spread"] = spread.json.clone();
    }
    if let Some(images) = &images {
        report_json["target"]["pixels"] = serde_json::json!(images.counts());
        report_json["corrections"] = image::corrections(images.corrections());
        report_json["image_rmse"] = views[0]["rmse"].clone();
        report_json["views"] = serde_json::json!(views);
    }
    let text = serde_json::to_string_pretty(&report_json).context("write JSON")?;
    output::write_file(&args.output.join("report.json"), text.as_bytes())?;
    if json {
        return output::print(&format!("{text}\n"));
    }
    let pictures_text = images.map_or_else(String::new, |images| {
        image::corrections_text(images.corrections()) + &image::text(&views, images.counts())
    });
    let spread_text = spread.map_or_else(String::new, |spread| spread.text);
    output::print(&format!(
        "{}{pictures_text}{spread_text}{} generations in {seconds:.1} s on {threads} threads; {} holds best.brood, best.png beside target.png, \
         front.csv with its genomes, and report.json\n",
        report.text(),
        progress.generation,
        args.output.display(),
    ))
}

/// Reads uncertainties.
fn refine(text: &str) -> Result<Refine, String> {
    let refine: Refine = serde_json::from_str(text).map_err(|error| error.to_string())?;
    refine.validate().map_err(|error| error.to_string())?;
    Ok(refine)
}

/// Genome and columns of front.csv.
fn row(found: &Found) -> (&Genome, [(&'static str, Cell); 4]) {
    let columns = [
        ("operations", found.operations.into()),
        ("numbers", found.parameters.into()),
        ("e_log_fitted", found.fitted.into()),
        ("e_log", found.e_log.into()),
    ];
    (&found.genome, columns)
}

/// Result of a search.
struct Searched {
    outcome: Outcome,
    /// Progress of the last generation.
    progress: Progress,
    /// Materials that match as well; `None` if the strategy has no probabilities.
    spread: Option<Spread>,
}

/// Searches until the budget is spent.
fn search(
    args: &FitArgs,
    (strategy, objective): (Strategy, Objective),
    target: &MeasuredTarget,
    seconds: f64,
) -> Result<Searched> {
    let FitArgs { seed, mirrored: is_mirrored, .. } = *args;
    let options = Options { strategy, seed, is_mirrored, objective, ..Options::default() };
    let budget = args.generations.map_or(FitBudget::Seconds(seconds), FitBudget::Generations);
    let mut search = match args.models.as_slice() {
        [] => Search::new(&target.fitted, &options),
        kinds => Search::with_kinds(&target.fitted, &options, kinds.to_vec()),
    }
    .reporting(&target.held);
    let mut log = args.log.as_deref().map(Log::create).transpose()?;
    let spinner = output::spinner("searching");
    let mut printed = f64::INFINITY;
    let found = spend(&mut search, budget, |search, progress, elapsed| {
        if let Some(log) = &mut log {
            log.add(progress, &search.probe(), elapsed);
        }
        let line = format!(
            "generation {}, {:.1} s: E_log {:.5} on fitted samples, {:.5} on held-back samples",
            progress.generation,
            elapsed.as_secs_f64(),
            progress.fitted,
            progress.held,
        );
        // A line is printed whenever the error has dropped by a tenth, on a terminal and elsewhere.
        if progress.held < 0.9 * printed {
            printed = progress.held;
            spinner.suspend(|| eprintln!("{line}"));
        }
        spinner.set_message(line);
    });
    spinner.finish_and_clear();
    log.map_or(Ok(()), Log::finish)?;
    let (outcome, progress) = found.context("the search found nothing")?;
    Ok(Searched { outcome, progress, spread: Spread::of(&search) })
}

/// Writes pictures of the target and of the best genome, at the exposure of the target.
fn pictures(args: &FitArgs, renderer: &Renderer, best: &Genome) -> Result<()> {
    let (frame, mesh) = args.frame.load_alone(renderer, PictureFormat::Png)?;
    let mut scene = frame.scene()?;
    let assets = renderer.light_assets();
    let subjects = [NamedMaterial::read(&args.target)?, NamedMaterial::of("best", best.clone())];
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
