//! `brood bench export`: writes a page that runs exported programs in a browser and counts the bits
//! that differ.
//!
//! The page holds the programs, their inputs and the results of the canonical evaluator, so it
//! shows whether the graphics processor, driver and compiler of a machine keep the meaning of
//! exports. Painted materials are among the programs. Models of every kind are checked against the
//! suite of `brood_export::conformance`. The last line of the page is JSON for scripts.

use std::path::PathBuf;

use anyhow::{Context, Result};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use brood_brdf::{Input, Lighting};
use brood_eval::conformance::lit_points;
use brood_eval::{CanonicalEvaluator, Evaluator};
use brood_export::conformance::{self, StyledCall};
use brood_export::{Format, Within, export, export_material, export_within};
use brood_genome::{BirthKey, Dialect, ModelKind, OpcodeSet, Variation};
use brood_program::Program;
use brood_scene::SampleSet;
use clap::Args;
use glam::DVec2;
use serde_json::{Value, json};

use super::target::random_pairs;
use crate::{logging, output};

/// Largest absolute texture coordinate of the samples.
const TEXTURE_LIMIT: f32 = 2.0;

/// Options of `brood bench export`.
#[derive(Debug, Args)]
pub struct BenchExportArgs {
    /// HTML file to write
    #[arg(long, short, value_name = "FILE")]
    output: PathBuf,
    /// Number of random programs, half of them of the extended dialect
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=2000))]
    programs: u32,
    /// Number of direction pairs that each program is evaluated at
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=2048))]
    samples: u32,
    /// Seed of the programs and directions
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Runs the command.
pub fn run(args: &BenchExportArgs, json: bool) -> Result<()> {
    logging::start_offline();
    let set = pairs(args.seed, args.samples);
    let programs = programs(args.seed, args.programs);
    let mut tests = Vec::with_capacity(programs.len());
    let mut f = Vec::new();
    for program in &programs {
        CanonicalEvaluator::default().eval(&[program], &set, &mut f).context("evaluate")?;
        let inputs: Vec<f32> =
            program.inputs().iter().flat_map(|i| set.input(i).to_vec()).collect();
        tests.push(json!({
            "source": export(program, Format::GlslEs300),
            "within": export_within(program, Format::GlslEs300, TEXTURE_LIMIT),
            "operations": program.operations(),
            "rows": program.inputs().len(),
            "inputs": base64(&inputs),
            "f": base64(&f),
        }));
    }
    let directions: Vec<f32> = (0..set.len()).flat_map(|index| row(&set, index)).collect();
    let data = json!({
        "samples": args.samples,
        "directions": base64(&directions),
        "tests": tests,
        "styles": styles(args)?,
        "models": models(args.samples as usize),
    });
    let page = include_str!("export/page.html")
        .replace("/*script*/", include_str!("export/page.js"))
        // Escaped, so that no shader text can end the script element.
        .replace("/*data*/", &data.to_string().replace('<', "\\u003c"));
    output::write_file(&args.output, page.as_bytes())?;
    if json {
        let (path, programs) = (&args.output, args.programs);
        return output::print_json(
            &json!({ "path": path, "programs": programs, "samples": args.samples }),
        );
    }
    output::print(&format!("{}: open it in a browser\n", args.output.display()))
}

/// Styles of the suite in 1 to 8 lights, each with calls by its inputs and by structures, and the
/// colours that they return for random points.
fn styles(args: &BenchExportArgs) -> Result<Vec<Value>> {
    let mut found = Vec::new();
    for (lights, style) in (1..=Input::LIGHTS).cycle().zip(&conformance::styles()) {
        let within = Within { lights, ..Within::default() };
        let lighting = Lighting { lights, has_shadows: true };
        let set = lit_points(args.seed + lights as u64, args.samples as usize, lighting);
        let value = |row: usize| format!("at(k, {row})");
        let inputs: Vec<Input> = style.painted(lighting).inputs().iter().collect();
        let arguments: Vec<String> = (0..inputs.len()).map(value).collect();
        let code = format!("styled_program({})", arguments.join(", "));
        let mut calls = vec![StyledCall { style: style.clone(), code, inputs }];
        calls.extend(conformance::styled_calls(style, (Format::GlslEs300, lights), value));
        let calls: Result<Vec<Value>> = calls.iter().map(|call| styled_call(call, &set)).collect();
        found.push(json!({
            "source": export_material(style, Format::GlslEs300, within)?.into_text(),
            "calls": calls?,
        }));
    }
    Ok(found)
}

/// Call of a style's function with the values that it reads and the colours that it must return.
fn styled_call(call: &StyledCall, set: &SampleSet) -> Result<Value> {
    let mut colors = Vec::new();
    CanonicalEvaluator::default().eval(&[&call.style], set, &mut colors).context("evaluate")?;
    let inputs: Vec<f32> =
        call.inputs.iter().flat_map(|input| set.input(*input).to_vec()).collect();
    Ok(json!({ "code": call.code, "inputs": base64(&inputs), "f": base64(&colors) }))
}

/// Cases of the model suite with their expected values, error units and bounds.
fn models(samples: usize) -> Value {
    let pairs = conformance::pairs(samples);
    let rows: Vec<f32> = pairs
        .iter()
        .flat_map(|[wi, wo]| [wi.as_vec3().to_array(), wo.as_vec3().to_array(), [0.0; 3]].concat())
        .collect();
    let case = |case: &conformance::ModelCase| {
        let wanted = case.reference_values(&pairs);
        let f: Vec<f64> = wanted.iter().flat_map(|wanted| wanted.f.to_array()).collect();
        let unit: Vec<f64> = wanted.iter().flat_map(|wanted| wanted.unit.to_array()).collect();
        json!({
            "source": export(&case.program, Format::GlslEs300),
            "f": base64_of_doubles(&f),
            "unit": base64_of_doubles(&unit),
        })
    };
    let kind = |kind: ModelKind| {
        let bound = conformance::BOUNDS.into_iter().find(|bound| bound.kind == kind);
        let bound = bound.expect("every kind has a bound");
        let cases: Vec<Value> = conformance::cases(kind).iter().map(case).collect();
        json!({ "kind": kind.name(), "median": bound.median, "units": bound.units, "cases": cases })
    };
    json!({ "directions": base64(&rows), "kinds": ModelKind::ALL.map(kind) })
}

/// wi, wo, u, v in the local frame; the layout that the page reads.
fn row(set: &SampleSet, index: usize) -> [f32; 8] {
    let (pair, uv) = set.pair(index);
    let [wi, wo] = [pair.wi().as_vec3(), pair.wo().as_vec3()];
    [wi.x, wi.y, wi.z, wo.x, wo.y, wo.z, uv.x as f32, uv.y as f32]
}

fn programs(seed: u64, count: u32) -> Vec<Program> {
    let plain = Variation::random(Dialect::default());
    let extended = Dialect { opcodes: OpcodeSet::Extended, registers: 16, ..Dialect::default() };
    let extended = Variation::random(extended);
    let birth = |slot: u32| {
        let variation = if slot.is_multiple_of(2) { &plain } else { &extended };
        Program::lower(&variation.birth(BirthKey { seed, slot, attempt: 0 }))
    };
    (0..count).map(birth).collect()
}

/// Random direction pairs with a grid of texture positions.
fn pairs(seed: u64, count: u32) -> SampleSet {
    let uvs = (0..count).map(|k| DVec2::new(f64::from(k % 17), f64::from(k % 13)) / 8.0);
    SampleSet::from_pairs(&random_pairs(seed, count as usize), &uvs.collect::<Vec<_>>())
}

fn base64_of_doubles(values: &[f64]) -> String {
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    BASE64_STANDARD.encode(bytes)
}

fn base64(values: &[f32]) -> String {
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    BASE64_STANDARD.encode(bytes)
}
