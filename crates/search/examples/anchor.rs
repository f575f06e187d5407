//! Makes the table of anchors of believable programs: fits measured materials with the structure of
//! believable programs.
//!
//! `cargo run --release -p brood-search --example anchor -- DATA > anchors.csv`, where
//! DATA/nbrdf/merl.json holds the weights of neural materials. Errors go to standard error.

use std::error::Error;

use brood_brdf::Neural;
use brood_genome::believable::{self, Class, TERMS, WEIGHTS};
use brood_search::lobes::{Restricted, fit_restricted};
use brood_target::MeasuredTarget;

/// Words in names of materials, with the class that they mean; the first that fits counts.
const WORDS: [(&str, Class); 24] = [
    ("metallic-paint", Class::MetallicPaint),
    ("gold-paint", Class::MetallicPaint),
    ("color-changing", Class::MetallicPaint),
    ("two-layer", Class::MetallicPaint),
    ("fabric", Class::Cloth),
    ("paint", Class::Paint),
    ("rubber", Class::Rubber),
    ("latex", Class::Rubber),
    ("foam", Class::Rubber),
    ("cherry", Class::Wood),
    ("maple", Class::Wood),
    ("fruitwood", Class::Wood),
    ("pine", Class::Wood),
    ("oak", Class::Wood),
    ("walnut", Class::Wood),
    ("jasper", Class::Stone),
    ("obsidian", Class::Stone),
    ("aventurnine", Class::Stone),
    ("alumina-oxide", Class::Stone),
    ("bronze", Class::Metal),
    ("alumini", Class::Metal),
    ("steel", Class::Metal),
    ("ss440", Class::Metal),
    ("tungsten", Class::Metal),
];
/// Other metals; what remains is plastic.
const METALS: [&str; 3] = ["chrome", "nickel", "silicon-nitrade"];
/// Materials without a fit below this error are left out.
const WORST: f64 = 0.1;

struct Row {
    class: Class,
    weights: [f64; WEIGHTS],
    levels: [f64; TERMS],
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let data = arguments.next().ok_or("DATA is missing")?;
    let bytes = std::fs::read(format!("{data}/nbrdf/merl.json"))?;
    let how = restricted();
    let mut rows = Vec::new();
    for name in Neural::names(&bytes)? {
        let target = MeasuredTarget::of(&Neural::read(&bytes, &name)?)?;
        let (parameters, error) = fit_restricted(&target.fitted, &how, 1);
        let row = row(&name, &how, &parameters);
        eprintln!("{name} {error:.4} {} {:.1?}", row.class.name(), row.levels);
        if error < WORST {
            rows.push(row);
        }
    }
    rows.sort_by_key(|row| row.class as u8);
    println!("class, weights, levels of the terms");
    for row in &rows {
        let values = row.weights.iter().chain(&row.levels);
        let values: Vec<String> = values.map(|value| format!("{value:.2}")).collect();
        println!("{},{}", row.class.name(), values.join(","));
    }
    Ok(())
}

/// Fit in which only the weights of believable programs are free.
fn restricted() -> Restricted {
    let shape = believable::shape();
    let (mut start, mut spread) = (vec![0.0; shape.len()], vec![0.0; shape.len()]);
    for weight in believable::weights() {
        start[weight.index] = weight.start;
        spread[weight.index] = weight.spread;
    }
    Restricted { shape, start, spread }
}

fn class(name: &str) -> Class {
    let known = WORDS.iter().find(|(word, _)| name.contains(word)).map(|(_, class)| *class);
    let metal = METALS.contains(&name).then_some(Class::Metal);
    known.or(metal).unwrap_or(Class::Plastic)
}

fn row(name: &str, how: &Restricted, parameters: &[f64]) -> Row {
    let shape = &how.shape;
    let all = believable::weights();
    let mut weights = std::array::from_fn(|at| parameters[all[at].index]);
    let mean = |term: usize| {
        let colour = |channel: usize| parameters[shape.colour(term, channel)];
        (0..3).map(colour).sum::<f64>() / 3.0
    };
    let mut levels = std::array::from_fn(mean);
    believable::assign_roles(&mut weights, &mut levels);
    Row { class: class(name), weights, levels }
}
