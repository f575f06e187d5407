//! Shows what each term of fits of lobes costs: fits with all of them, and with one of them left
//! out. Lobes are always reciprocal; the cost of that is the floor, the least error of a reciprocal
//! material on f as measured in both orders of light and eye.
//!
//! `cargo run --release -p brood-search --example ablation -- DATA GENERATIONS MATERIAL ...`, where
//! DATA/nbrdf/merl.json holds the weights of neural materials. Each material is given as f at 4096
//! pairs in one order of light and eye, as a table from a file is.

use std::error::Error;

use brood_brdf::{Brdf, MeasuredSamples, Neural};
use brood_eval::energy_limit;
use brood_program::Program;
use brood_search::lobes::Terms;
use brood_search::{Found, Options, Search};
use brood_target::{MeasuredTarget, Samples, draw_pairs, metric, narrow_pairs};

/// Number of given pairs, and of further ones on which errors are measured.
const GIVEN: usize = 4096;
const FURTHER: usize = 16_384;
/// Number of pairs at which the largest f is measured, to detect spikes between samples.
const NARROW: usize = 1 << 16;

/// A variant of the fit.
struct Variant {
    name: &'static str,
    terms: Terms,
}

const ALL: Terms = Terms::ALL;
const NONE: Terms = Terms { dark: false, bounds: false, albedo: false };
const VARIANTS: [Variant; 5] = [
    Variant { name: "all", terms: ALL },
    Variant { name: "no dark values", terms: Terms::BOUNDED },
    Variant { name: "no bounds", terms: Terms { bounds: false, ..ALL } },
    Variant { name: "no albedo", terms: Terms { albedo: false, ..ALL } },
    Variant { name: "none of them", terms: NONE },
];

/// Errors of a fit.
struct Row {
    fitted: f64,
    held_out: f64,
    /// On further pairs, one order.
    further: f64,
    /// Largest f over that of the target where samples are few.
    spike: f64,
    /// Divisor of the energy limit, and largest albedo of the fit before it.
    divisor: f64,
    albedo: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let data = arguments.next().ok_or("DATA is missing")?;
    let generations: u32 = arguments.next().ok_or("GENERATIONS are missing")?.parse()?;
    let bytes = std::fs::read(format!("{data}/nbrdf/merl.json"))?;
    println!("| material | variant | fitted | held out | further | largest f | divisor | albedo |");
    println!("|---|---|---|---|---|---|---|---|");
    let mut all: Vec<Vec<Row>> = VARIANTS.iter().map(|_| Vec::new()).collect();
    for name in arguments {
        let neural = Neural::read(&bytes, &name)?;
        let floor = MeasuredTarget::of(&neural)?.floor().unwrap_or(f64::NAN);
        println!("| {name} | floor | | | {floor:.5} | | | |");
        for (variant, rows) in VARIANTS.iter().zip(&mut all) {
            let row = fit(&neural, variant, generations)?;
            println!("| {name} | {} |{}", variant.name, cells(&row));
            rows.push(row);
        }
    }
    for (variant, rows) in VARIANTS.iter().zip(&all) {
        let of = |value: fn(&Row) -> f64| median(rows.iter().map(value).collect());
        let row = Row {
            fitted: of(|row| row.fitted),
            held_out: of(|row| row.held_out),
            further: of(|row| row.further),
            spike: of(|row| row.spike),
            divisor: of(|row| row.divisor),
            albedo: of(|row| row.albedo),
        };
        println!("| median | {} |{}", variant.name, cells(&row));
    }
    Ok(())
}

fn cells(row: &Row) -> String {
    let Row { fitted, held_out, further, spike, divisor, albedo } = row;
    format!(
        " {fitted:.5} | {held_out:.5} | {further:.5} | {spike:.2} | {divisor:.3} | {albedo:.3} |"
    )
}

fn fit(neural: &Neural, of: &Variant, generations: u32) -> Result<Row, Box<dyn Error>> {
    let given = draw_pairs(GIVEN, 11).into_iter().map(|pair| (pair, neural.f(&pair)));
    let target = MeasuredTarget::of_samples(&MeasuredSamples::new(given.collect())?)?;
    let mut search =
        Search::with_terms(&target.fitted, &Options::default(), of.terms).reporting(&target.held);
    (0..generations).for_each(|_| {
        search.step();
    });
    let outcome = search.finish().ok_or("the search found nothing")?;
    let front = Found::all(&outcome.front, &target)?;
    let best = &front[Found::best(&front, &outcome)];
    let program = Program::lower(&best.genome);
    let albedo = energy_limit(&program).albedo;
    let program = if best.divisor > 1.0 { program.divided(best.divisor) } else { program };
    let pairs = draw_pairs(FURTHER, 12);
    let values = pairs.iter().map(|pair| neural.f(pair).to_array().map(|f| f.max(0.0))).collect();
    let wanted = Samples::new(pairs.clone(), values);
    let found = Samples::of_program(&program, pairs)?;
    let narrow = Samples::of_program(&program, narrow_pairs(NARROW, 3))?.largest();
    Ok(Row {
        fitted: best.fitted,
        held_out: best.e_log,
        further: metric::e_log(&wanted.weighted(), &found.weighted()),
        spike: narrow / Samples::of(neural, narrow_pairs(NARROW, 3)).largest(),
        divisor: best.divisor,
        albedo,
    })
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
