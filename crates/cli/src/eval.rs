//! `brood eval`: prints the reflectance of a material for given direction pairs.

use std::fmt::Write;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use brood_bench::material_file::{self, MaterialFile};
use brood_bench::{logging, output};
use brood_brdf::{Brdf, DirectionPair, pairs_from_csv};
use brood_eval::{TurnedPair, energy_limit};
use brood_program::Program;
use brood_protocol::Backend;
use brood_scene::SampleSet;
use brood_worker::Renderer;
use clap::Args;
use glam::DVec2;
use serde_json::json;

const LIMIT_BYTES: u64 = 1 << 30;
/// Rows evaluated at once, to bound memory.
const BATCH: usize = 1 << 18;

/// Directions to the light and to the eye, and the texture position.
type Row = (DirectionPair, [f64; 2]);

/// Options of `brood eval`.
#[derive(Debug, Args)]
pub struct EvalArgs {
    /// Material: a `.brood` or JSON file of a genome or a model, a MERL `.binary`, an RGL `.bsdf`,
    /// samples as `.csv`, a goniometer's `.brdf`, or an image slice as `.exr`; - is stdin
    pub genome: PathBuf,
    /// CSV of direction pairs with the columns wix, wiy, wiz, wox, woy, woz, and optionally u, v; -
    /// is stdin
    pub pairs: PathBuf,
    /// Evaluator: auto, cpu, gpu or reference
    #[arg(long, default_value = "auto")]
    pub backend: Backend,
    /// Apply the energy limit even if the genome does not: divide by the largest albedo if that is
    /// above 1
    #[arg(long)]
    pub limit: bool,
    /// Keep negative values of RGL tables (colours outside the display's gamut), as other renderers
    /// do; by default they become 0
    #[arg(long)]
    pub keep_negative: bool,
}

/// Runs the command.
pub fn run(args: &EvalArgs, json: bool) -> Result<()> {
    logging::start_offline();
    let stdin = Path::new("-");
    ensure!(
        args.genome != stdin || args.pairs != stdin,
        "only one of the two files can be - (stdin)"
    );
    let genome = match material_file::read_with(&args.genome, args.keep_negative)? {
        MaterialFile::Bred(genome) => *genome,
        MaterialFile::Measured(brdf, kind) => return run_brdf(args, &*brdf, kind, json),
    };
    if genome.is_painted() {
        bail!("{}: a painted material is not a BRDF", args.genome.display());
    }
    let limited = args.limit || genome.is_limited();
    let mut program = Program::lower(&genome);
    let limit = limited.then(|| energy_limit(&program));
    if let Some(limit) = limit.filter(|limit| limit.divisor > 1.0) {
        program = program.divided(limit.divisor);
    }
    let rows = read_rows(&args.pairs)?;
    let renderer = Renderer::new(args.backend);
    let mut values = Vec::with_capacity(rows.len());
    for rows in rows.chunks(BATCH) {
        values.extend(evaluate(&renderer, args.backend, &program, rows)?);
    }
    if json {
        let limit = limit.map(|limit| {
            json!({
                "albedo": limit.albedo,
                "bound": limit.bound(),
                "error_bound": limit.error_bound,
                "divisor": limit.divisor,
                "theta_deg": limit.theta_deg,
            })
        });
        let report = json!({ "backend": renderer.report(), "f": values, "limit": limit });
        return output::print_json(&report);
    }
    if let Some(limit) = &limit {
        eprintln!(
            "energy limit: divided by {:.6}; albedo at most {:.6} (theta_i {:.2} degrees), {:.1e} of it allowed for the search",
            limit.divisor,
            limit.bound(),
            limit.theta_deg,
            limit.error_bound,
        );
    }
    output::print(&table(&values))
}

/// Runs the command for a measured material, in f64.
fn run_brdf(args: &EvalArgs, brdf: &dyn Brdf, kind: &str, json: bool) -> Result<()> {
    ensure!(
        !args.limit,
        "--limit needs a genome; `brood model albedo` prints the albedo of measured materials"
    );
    let rows = read_rows(&args.pairs)?;
    let values: Vec<[f64; 3]> = rows.iter().map(|(pair, _)| brdf.f(pair).to_array()).collect();
    if json {
        return output::print_json(&json!({ "measured": kind, "f": values }));
    }
    output::print(&table(&values))
}

fn table<T: std::fmt::Display>(values: &[[T; 3]]) -> String {
    let mut text = String::from("r,g,b\n");
    for [r, g, b] in values {
        writeln!(text, "{r},{g},{b}").expect("writing to a string cannot fail");
    }
    text
}

/// f of each row; 0 if a direction is not above the surface.
fn evaluate(
    renderer: &Renderer,
    backend: Backend,
    program: &Program,
    rows: &[Row],
) -> Result<Vec<[f32; 3]>> {
    let turned: Vec<TurnedPair> =
        rows.iter().map(|(pair, uv)| TurnedPair::new(program, *pair, (*uv).into())).collect();
    let pairs: Vec<DirectionPair> = turned.iter().map(|turned| turned.pair).collect();
    let uvs: Vec<DVec2> = rows.iter().map(|(_, uv)| (*uv).into()).collect();
    let f = renderer.reflectance(backend, &[program], &SampleSet::from_pairs(&pairs, &uvs))?;
    let count = rows.len();
    let value = |(index, (pair, _)): (usize, &Row)| {
        if pair.cos_i() <= 0.0 || pair.cos_o() <= 0.0 {
            return [0.0; 3];
        }
        let factor = turned[index].factor as f32;
        [0, 1, 2].map(|channel| factor * f[channel * count + index])
    };
    Ok(rows.iter().enumerate().map(value).collect())
}

/// Reads the direction pairs with their texture positions, which are 0 without the columns u and v.
fn read_rows(path: &Path) -> Result<Vec<Row>> {
    pairs_from_csv(&read_text(path)?, [("u", false), ("v", false)])
        .with_context(|| path.display().to_string())
}

fn read_text(path: &Path) -> Result<String> {
    let bytes = output::read_input(path, LIMIT_BYTES)?;
    String::from_utf8(bytes).with_context(|| format!("{} is not UTF-8 text", path.display()))
}
