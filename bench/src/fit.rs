//! `brood bench fit`: error of fits of measured materials within time budgets, compared with
//! published fits of the same materials on the same held-out samples. Also writes the samples as
//! CSV for other programs.

mod material;
mod unseen;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use brood_brdf::ModelKind;
use brood_eval::{energy_limit, express};
use brood_export::samples_csv;
use brood_search::{Found, Options, Search};
use brood_target::{MeasuredTarget, Samples, Strategy, metric, narrow_pairs};
use clap::Args;
use rayon::ThreadPool;

use super::published::Published;
use super::record::{CommonArgs, Finding, SeedsArgs};
use crate::budget::{FitBudget, spend};
use crate::chart::{Axis, Bar, BarChart, Group, ResultTable, cells};
use crate::output;
use material::{FitMaterial, MaterialFolder};
use unseen::{Studio, ViewDifference};

/// Seconds for the fit of two lobes; it has few parameters and longer runs change nothing.
const TWO_LOBES_SECONDS: f64 = 5.0;
/// Number of direction pairs searched for spikes.
const NARROW: usize = 1 << 16;

/// Options of `brood bench fit`.
#[derive(Debug, Args)]
pub struct BenchFitArgs {
    /// Folder with nbrdf/merl.json, tables/ and any named measurement files
    data: PathBuf,
    /// Materials by name in nbrdf/merl.json, or measurement files in the folder, comma-separated;
    /// `all` for every material of merl.json; by default the 20 reported ones
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    materials: Vec<String>,
    /// Time budgets in seconds, comma-separated, each fitted from scratch
    #[arg(long, value_name = "N", value_delimiter = ',', default_values_t = [1.0, 5.0, 25.0])]
    seconds: Vec<f64>,
    /// Number of threads
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: u16,
    #[command(flatten)]
    seeds: SeedsArgs,
    #[command(flatten)]
    common: CommonArgs,
}

/// Results of one material.
struct Row {
    material: String,
    /// Lower bound of E_log for reciprocal fits.
    floor: f64,
    /// One for each budget.
    runs: Vec<Run>,
    /// E_log of each published fit, by the name of its source.
    published: Vec<(&'static str, Option<f64>)>,
    /// E_log of two microfacet lobes over a diffuse part.
    two_lobes: f64,
}

/// One fit.
struct Run {
    /// Time budget in seconds.
    budget: f64,
    /// Time taken, in seconds.
    seconds: f64,
    /// E_log on held-out samples.
    e_log: f64,
    operations: usize,
    generations: u32,
    /// Largest f over that of the target, among pairs where samples are sparse ([`narrow_pairs`]).
    spike: f64,
    /// Number of these pairs whose f changes when light and eye are swapped.
    not_reciprocal: usize,
    /// Smallest f among these pairs.
    least_f: f64,
    max_albedo: f64,
    /// Difference between pictures of fit and material.
    unseen: ViewDifference,
    /// PNG of these pictures; `None` if the material is known only at its samples.
    picture: Option<Vec<u8>>,
}

/// Runs the command.
pub fn run(args: &BenchFitArgs, json: bool) -> Result<()> {
    let budget = |seconds: &f64| (0.01..=1e5).contains(seconds);
    ensure!(args.seconds.iter().all(budget), "--seconds must be from 0.01 to 100000");
    let source = MaterialFolder::open(&args.data)?;
    let published = Published::read(&args.data.join("tables"))?;
    let folder = args.common.start()?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(usize::from(args.threads)).build();
    let pool = pool.context("start the threads of the fits")?;
    let (studio, mut materials) = (Studio::new(), Vec::new());
    for name in source.names(&args.materials)? {
        let material = source.read(&name)?;
        if let Some(out) = &args.common.out {
            write_samples(out, &material.name, &material.target)?;
        }
        materials.push(material);
    }
    let of_seed = |seed| Ok(vec![of_seed(args, (&materials, &published), (&pool, &studio), seed)?]);
    let finding = args.seeds.measure(args.common.seed, false, of_seed)?.remove(0);
    folder.finish_table(&finding, json)
}

/// Fits every material with one seed; pictures are those of the last seed.
fn of_seed(
    args: &BenchFitArgs,
    (materials, published): (&[FitMaterial], &Published),
    (pool, studio): (&ThreadPool, &Studio),
    seed: u64,
) -> Result<Finding> {
    let mut rows = Vec::new();
    for measured in materials {
        let FitMaterial { name, target, .. } = measured;
        let run = |seconds: &f64| pool.install(|| fit_once(measured, studio, *seconds, seed));
        let runs = args.seconds.iter().map(run).collect::<Result<Vec<_>>>()?;
        let picture = runs.last().and_then(|run| run.picture.as_ref());
        if let (Some(out), Some(picture)) = (&args.common.out, picture) {
            let pictures = out.join("pictures");
            output::make_dir(&pictures)?;
            output::write_file(&pictures.join(format!("{name}.png")), picture)?;
        }
        let published = published.e_log(name, &target.held)?;
        let two_lobes = pool.install(|| two_lobes(target, seed))?;
        let floor = target.floor().unwrap_or(0.0);
        let row = Row { material: name.clone(), floor, runs, published, two_lobes };
        eprintln!("{}", line(&row));
        rows.push(row);
    }
    Ok(Finding {
        name: "fit",
        note: format!("{} threads; E_log on held-out samples", args.threads),
        table: table(&rows),
        raw: Some(table(&rows)),
        chart: chart(&rows, args).into(),
    })
}

/// Fits a material within a budget and measures the result.
fn fit_once(measured: &FitMaterial, studio: &Studio, budget: f64, seed: u64) -> Result<Run> {
    let FitMaterial { target, brdf, .. } = measured;
    let begun = Instant::now();
    let strategy = Strategy::Lobes;
    let options = Options { strategy, seed, ..Options::default() };
    let mut search = Search::new(&target.fitted, &options).reporting(&target.held);
    let (outcome, progress) = spend(&mut search, FitBudget::Seconds(budget), |_, _, _| {})
        .context("the fit found nothing")?;
    let generations = progress.generation;
    let seconds = begun.elapsed().as_secs_f64();
    let front = Found::all(&outcome.front, target)?;
    let genome = &front[Found::best(&front, &outcome)].genome;
    let program = express(genome);
    let found = Samples::of_program(&program, target.held.pairs().to_vec())?;
    let narrow = narrow_pairs(NARROW, 3);
    let swapped = narrow.iter().map(|pair| pair.swapped()).collect();
    let (here, there) =
        (Samples::of_program(&program, narrow.clone())?, Samples::of_program(&program, swapped)?);
    let bits = here.values().iter().zip(there.values());
    let (unseen, picture) = match brdf {
        Some(brdf) => studio.compare(&**brdf, genome).map(|(unseen, png)| (unseen, Some(png)))?,
        None => (ViewDifference::UNKNOWN, None),
    };
    let wanted_largest = match brdf {
        Some(brdf) => Samples::of(&**brdf, narrow).largest(),
        None => target.fitted.largest(),
    };
    let values = || here.values().iter().chain(there.values()).flatten();
    ensure!(values().all(|f| f.is_finite()), "a fit returned a non-finite f");
    Ok(Run {
        budget,
        seconds,
        e_log: metric::e_log(&target.held.weighted(), &found.weighted()),
        operations: program.steps().len(),
        generations,
        spike: here.largest() / wanted_largest,
        not_reciprocal: bits.filter(|(a, b)| a != b).count(),
        least_f: values().copied().fold(f64::INFINITY, f64::min),
        max_albedo: energy_limit(&program).albedo,
        unseen,
        picture,
    })
}

/// E_log of the usual fit: one or two microfacet lobes, each over a diffuse part, without the
/// energy limit.
fn two_lobes(target: &MeasuredTarget, seed: u64) -> Result<f64> {
    let strategy = Strategy::Analytic;
    let options = Options { strategy, seed, ..Options::default() };
    let mut search = Search::with_kinds(&target.fitted, &options, vec![ModelKind::CookTorrance]);
    let (outcome, _) = spend(&mut search, FitBudget::Seconds(TWO_LOBES_SECONDS), |_, _, _| {})
        .context("the fit of microfacet lobes found nothing")?;
    let genome = outcome.front[outcome.best].genome.clone().with_limit(false);
    let found = Samples::of_program(&express(&genome), target.held.pairs().to_vec())?;
    Ok(metric::e_log(&target.held.weighted(), &found.weighted()))
}

/// Writes the fitted and the held-out samples as CSV.
fn write_samples(out: &Path, name: &str, target: &MeasuredTarget) -> Result<()> {
    let folder = out.join("samples");
    output::make_dir(&folder)?;
    for (part, samples) in [("fitted", &target.fitted), ("held", &target.held)] {
        let text = samples_csv(samples.pairs().iter().zip(samples.values().iter().copied()));
        output::write_file(&folder.join(format!("{name}-{part}.csv")), text.as_bytes())?;
    }
    Ok(())
}

fn line(row: &Row) -> String {
    let runs = row.runs.iter().map(|run| format!("{:.5} after {:.1} s", run.e_log, run.seconds));
    let published = row.published.iter().map(|(name, e_log)| match e_log {
        Some(e_log) => format!("{name} {e_log:.5}"),
        None => format!("no {name}"),
    });
    let two_lobes = format!("two lobes of microfacets {:.5}", row.two_lobes);
    let all: Vec<String> = runs.chain(published).chain([two_lobes]).collect();
    format!("{}: {}", row.material, all.join(", "))
}

fn table(rows: &[Row]) -> ResultTable {
    let mut table = ResultTable::default();
    for row in rows {
        for run in &row.runs {
            let cells = cells! {
                material: row.material.as_str(),
                budget_seconds: run.budget,
                e_log: run.e_log,
                seconds: run.seconds,
                generations: run.generations,
                operations: run.operations,
                largest_over_target: run.spike,
                not_reciprocal: run.not_reciprocal,
                least_f: run.least_f,
                max_albedo: run.max_albedo,
                unseen_itp: run.unseen.itp,
                unseen_flip: run.unseen.flip,
                reciprocal_floor: row.floor,
            };
            // Materials without a published fit.
            let published = row.published.iter().map(|(_, e_log)| e_log.unwrap_or(f64::NAN).into());
            let published = ["e_log_sgd", "e_log_abc", "e_log_ward"].into_iter().zip(published);
            let last = ("e_log_ggx2", row.two_lobes.into());
            table.push(cells.into_iter().chain(published).chain([last]));
        }
    }
    table
}

fn chart(rows: &[Row], args: &BenchFitArgs) -> BarChart {
    let group = |row: &Row| {
        let own = row.runs.last().map(|run| run.e_log);
        let all = own.into_iter().chain(row.published.iter().filter_map(|(_, e_log)| *e_log));
        let bar = |(series, value): (usize, f64)| Bar { series, value, ..Bar::default() };
        Group { name: row.material.clone(), bars: all.enumerate().map(bar).collect() }
    };
    BarChart::new(
        "Fits of measured materials, E_log on held-out samples",
        format!(
            "from top: brood fit on {} threads after its longest budget, published fits of SGD, ABC and Ward",
            args.threads
        ),
        Axis::log("E_log"),
        rows.iter().map(group),
    )
}
