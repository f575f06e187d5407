//! `brood bench consumer`: writes materials in an export format, with values of f by the reference.
//!
//! A test by the program that reads the format compares its own values with these; fits, and tables
//! that brood reads, are compared here. The materials are all presets, models of all kinds, random
//! programs, programs with layers, with textures and with bumps. A file `cases.json` lists them,
//! with the reasons why some are refused.

use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use brood_brdf::{Brdf, DirectionPair, Input, Merl, Rgl};
use brood_eval::{ReferenceEvaluator, TurnedPair, express, is_anisotropic};
use brood_export::{
    Format, Within, conformance, export_material, fitted, is_limited, mean_positions,
};
use brood_genome::preset::PRESETS;
use brood_genome::{
    BirthKey, Dialect, DialectConstraints, Genome, ModelKind, OpcodeSet, Variation,
};
use brood_program::Program;
use brood_scene::SampleSet;
use clap::Args;
use glam::{DVec2, DVec3};
use serde_json::{Value, json};

use super::target::random_pairs;
use crate::{logging, output};

/// Models of each kind.
const MODELS: usize = 3;
/// Random genomes with layers, with textures, and with bumps: of each.
const SPECIAL: usize = 10;
/// Half a unit in the last place of f32 between 1/2 and 1.
const ROUNDING: f64 = 1.0 / 33_554_432.0;

/// Options of `brood bench consumer`.
#[derive(Debug, Args)]
pub struct BenchConsumerArgs {
    /// Format of the files; `brood export --help` lists them
    #[arg(long, value_name = "FORMAT")]
    format: Format,
    /// Folder to write to; made if it is not there
    #[arg(long, short, value_name = "DIR")]
    output: PathBuf,
    /// Number of random genomes, half of them of the extended dialect
    #[arg(long, value_name = "N", default_value_t = 40, value_parser = clap::value_parser!(u32).range(1..=2000))]
    genomes: u32,
    /// Number of direction pairs with values; half of them are near the mirror direction
    #[arg(long, value_name = "N", default_value_t = 2048, value_parser = clap::value_parser!(u32).range(16..=65536))]
    pairs: u32,
    /// Seed of the genomes and directions
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// A material to export.
struct Case {
    name: String,
    genome: Genome,
}

/// Runs the command.
pub fn run(args: &BenchConsumerArgs, json: bool) -> Result<()> {
    logging::start_offline();
    std::fs::create_dir_all(&args.output)
        .with_context(|| format!("create {}", args.output.display()))?;
    let pairs = pairs(args);
    let uvs: Vec<DVec2> =
        (0..pairs.len()).map(|k| DVec2::new((k % 17) as f64, (k % 13) as f64) / 17.0).collect();
    let cases = cases(args)?;
    let count = cases.len();
    let written: Vec<Value> = cases
        .into_iter()
        .enumerate()
        .map(|(place, case)| write(args, place, case, (&pairs, &uvs)))
        .collect::<Result<_>>()?;
    let rows: Vec<f64> = pairs
        .iter()
        .zip(&uvs)
        .flat_map(|(pair, uv)| {
            [pair.wi().to_array().to_vec(), pair.wo().to_array().to_vec(), uv.to_array().to_vec()]
                .concat()
        })
        .collect();
    let refused = written.iter().filter(|case| case["refused"].is_string()).count();
    let mut own: Vec<f64> = written.iter().filter_map(|case| case["own_error"].as_f64()).collect();
    own.sort_by(f64::total_cmp);
    let (median, worst) = (own.get(own.len() / 2), own.last());
    let list = json!({ "format": args.format.name(), "pairs": base64(&rows), "cases": written });
    output::write_file(&args.output.join("cases.json"), list.to_string().as_bytes())?;
    if json {
        return output::print_json(&json!({
            "path": args.output, "cases": count, "refused": refused,
            "median_own_error": median, "worst_own_error": worst,
        }));
    }
    let name = args.output.display();
    let read = median.zip(worst).map_or(String::new(), |(median, worst)| {
        format!("; read by brood, median error {median:.5}, worst {worst:.5}")
    });
    output::print(&format!("{name}: {count} materials, {refused} refused{read}\n"))
}

/// Writes a material, and returns its entry of the list.
fn write(
    args: &BenchConsumerArgs,
    place: usize,
    case: Case,
    (pairs, uvs): (&[DirectionPair], &[DVec2]),
) -> Result<Value> {
    let genome = case.genome.clone().with_limit(is_limited(args.format, None, &case.genome));
    let program = express(&genome);
    let exported = match export_material(&program, args.format, Within::default()) {
        Ok(exported) => exported,
        Err(error) => return Ok(json!({ "name": case.name, "refused": error.to_string() })),
    };
    let file = args.format.file_name(&format!("case-{place:03}"));
    output::write_file(&args.output.join(&file), &exported.bytes)?;
    if args.format.is_table() || args.format.is_fit() {
        let f = mean_values(&program, pairs);
        let made: Option<Vec<f64>> = if args.format.is_fit() {
            let fit = fitted(&program, args.format)?;
            Some(pairs.iter().flat_map(|pair| fit.f(pair).to_array()).collect())
        } else {
            read_back(args.format, &exported.bytes)?.map(|table| {
                pairs.iter().flat_map(|pair| table.f(&pair.swapped()).to_array()).collect()
            })
        };
        let own_error = made.as_ref().map(|made| change(&f, made, pairs));
        let fit = made.filter(|_| args.format.is_fit()).map(|made| base64(&made));
        return Ok(json!({
            "name": case.name, "file": file, "f": base64(&f), "note": exported.note,
            "anisotropic": is_anisotropic(&program), "own_error": own_error, "fit": fit,
        }));
    }
    if program.is_painted() {
        return Ok(json!({ "name": case.name, "file": file }));
    }
    let f = values(&program, pairs, uvs);
    let rounding: f64 = (0..8)
        .map(|place| {
            let (pairs, uvs) = moved(pairs, uvs, place);
            change(&f, &values(&program, &pairs, &uvs), &pairs)
        })
        .sum();
    Ok(json!({ "name": case.name, "file": file, "f": base64(&f), "rounding": rounding }))
}

/// As [`values`], mean over the texture positions that tables are means of.
fn mean_values(program: &Program, pairs: &[DirectionPair]) -> Vec<f64> {
    let positions = match program.inputs() {
        inputs if inputs.contains(Input::U) || inputs.contains(Input::V) => {
            mean_positions().to_vec()
        }
        _ => vec![DVec2::ZERO],
    };
    let mut sums = vec![0.0; 3 * pairs.len()];
    for position in &positions {
        let f = values(program, pairs, &vec![*position; pairs.len()]);
        sums.iter_mut().zip(f).for_each(|(sum, f)| *sum += f);
    }
    sums.into_iter().map(|sum| sum / positions.len() as f64).collect()
}

/// A table as brood reads it; `None` if it is not read as a function of any pair.
fn read_back(format: Format, bytes: &[u8]) -> Result<Option<Box<dyn Brdf>>> {
    Ok(match format {
        Format::RglBsdf => Some(Box::new(Rgl::read(bytes)?)),
        Format::Merl => Some(Box::new(Merl::read(bytes)?)),
        _ => None,
    })
}

/// Returns the pairs and texture positions with one component changed by [`ROUNDING`]: 0 to 5 are
/// those of wi and wo, 6 and 7 those of the texture position.
fn moved(pairs: &[DirectionPair], uvs: &[DVec2], place: usize) -> (Vec<DirectionPair>, Vec<DVec2>) {
    let moved = |pair: &DirectionPair| {
        let mut values = [pair.wi().to_array(), pair.wo().to_array()];
        if let Some(value) = values.as_flattened_mut().get_mut(place) {
            *value += ROUNDING;
        }
        let [wi, wo] = values.map(DVec3::from);
        DirectionPair::new(wi, wo).expect("directions are unit")
    };
    let mut uvs = uvs.to_vec();
    if place >= 6 {
        uvs.iter_mut().for_each(|uv| uv[place - 6] += ROUNDING);
    }
    (pairs.iter().map(moved).collect(), uvs)
}

/// Mean change of f cos_i, relative to its mean.
fn change(f: &[f64], other: &[f64], pairs: &[DirectionPair]) -> f64 {
    let (mut difference, mut total) = (0.0, 0.0);
    for ((f, other), pair) in f.chunks(3).zip(other.chunks(3)).zip(pairs) {
        for (f, other) in f.iter().zip(other) {
            difference += (f - other).abs() * pair.cos_i();
            total += f * pair.cos_i();
        }
    }
    if total > 0.0 { difference / total } else { 0.0 }
}

/// f of each pair: red, green, blue.
fn values(program: &Program, pairs: &[DirectionPair], uvs: &[DVec2]) -> Vec<f64> {
    let turned: Vec<TurnedPair> =
        pairs.iter().zip(uvs).map(|(pair, uv)| TurnedPair::new(program, *pair, *uv)).collect();
    let directions: Vec<DirectionPair> = turned.iter().map(|turned| turned.pair).collect();
    let set = SampleSet::from_pairs(&directions, uvs);
    let f = ReferenceEvaluator::reflectance(program, &set);
    f.iter().zip(&turned).flat_map(|(f, turned)| f.map(|value| value * turned.factor)).collect()
}

/// Pairs of directions, rounded to f32, uniform over the hemisphere; those at odd
/// places have the light near the mirror direction.
fn pairs(args: &BenchConsumerArgs) -> Vec<DirectionPair> {
    let random = random_pairs(args.seed, args.pairs as usize);
    let near = |(place, pair): (usize, DirectionPair)| {
        let mirrored = DVec3::new(-pair.wo().x, -pair.wo().y, pair.wo().z);
        let wi = (mirrored + 0.15 * (pair.wi() - DVec3::Z)).normalize();
        let is_near = place % 2 == 1 && wi.z > 0.01;
        let wi = if is_near { wi } else { pair.wi() };
        let rounded = |w: DVec3| w.as_vec3().as_dvec3();
        DirectionPair::new(rounded(wi), rounded(pair.wo())).expect("directions are unit")
    };
    random.into_iter().enumerate().map(near).collect()
}

/// Presets, models, and random genomes.
fn cases(args: &BenchConsumerArgs) -> Result<Vec<Case>> {
    let mut cases: Vec<Case> = PRESETS
        .iter()
        .map(|preset| Case { name: preset.name.to_owned(), genome: preset.genome().clone() })
        .collect();
    for kind in ModelKind::ALL {
        for (place, case) in conformance::cases(kind).into_iter().take(MODELS).enumerate() {
            let genome = Genome::of_models(vec![case.model]).context("make a genome of a model")?;
            cases.push(Case { name: format!("{}-{place}", kind.name()), genome });
        }
    }
    let extended = Dialect { opcodes: OpcodeSet::Extended, registers: 16, ..Dialect::default() };
    for slot in 0..args.genomes {
        let dialect = if slot % 2 == 0 { Dialect::default() } else { extended };
        cases.push(birth("random", &Variation::random(dialect), args.seed, slot));
    }
    let plain = Variation::random(Dialect::default());
    let layered = ModelKind::ALL.into_iter().cycle().take(SPECIAL).zip(0..);
    for (kind, slot) in layered {
        let case = birth("layered", &plain, args.seed + 1, slot);
        let models = conformance::cases(kind);
        let text = format!("{}{}", case.genome, models[1].model);
        let genome = text.parse().with_context(|| format!("add a model to {}", case.name))?;
        cases.push(Case { genome, ..case });
    }
    let births = |slot| birth("textured", &plain, args.seed + 2, slot);
    let textured = (0..10_000).map(births).filter(|case| {
        let inputs = Program::lower(&case.genome).inputs();
        inputs.contains(Input::U) || inputs.contains(Input::V)
    });
    cases.extend(textured.take(SPECIAL));
    let constraints = DialectConstraints { bumps: Some(true), ..Default::default() };
    let bumped = Variation::random(Dialect::default()).with_constraints(constraints);
    cases.extend((0..SPECIAL as u32).map(|slot| birth("bumped", &bumped, args.seed + 3, slot)));
    ensure!(!cases.is_empty(), "there is no material");
    Ok(cases)
}

fn birth(word: &str, variation: &Variation<'_>, seed: u64, slot: u32) -> Case {
    let genome = variation.birth(BirthKey { seed, slot, attempt: 0 });
    Case { name: format!("{word}-{slot}"), genome }
}

fn base64(values: &[f64]) -> String {
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    BASE64_STANDARD.encode(bytes)
}
