//! Fits of lobes to measured materials: E_log on held-out samples after some generations, then the front.
//!
//! `cargo run --release -p brood-search --example lobes -- DATA GENERATIONS [MATERIAL ...]`, DATA/nbrdf/merl.json being weights of
//! neural materials.

use std::error::Error;
use std::time::Instant;

use brood_brdf::Neural;
use brood_program::Program;
use brood_search::lobes::{Fit, Lobes, Shape};
use brood_search::{Samples, draw_pairs, metric};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let data = arguments.next().ok_or("DATA is missing")?;
    let generations: u32 = arguments.next().ok_or("GENERATIONS are missing")?.parse()?;
    let bytes = std::fs::read(format!("{data}/nbrdf/merl.json"))?;
    for name in arguments {
        let neural = Neural::read(&bytes, &name)?;
        let train = Samples::of(&neural, draw_pairs(4096, 1));
        let test = Samples::of(&neural, draw_pairs(16384, 2));
        let begun = Instant::now();
        let shapes = vec![Shape::new(4, 5, false), Shape::new(6, 7, false)];
        let mut fit = Fit::new(&train, shapes, 1);
        let show = |what: &str, lobes: &Lobes| -> Result<(), Box<dyn Error>> {
            let (on_train, on_test) = (e_log(lobes, &train)?, e_log(lobes, &test)?);
            let operations = Program::lower(&lobes.genome()?.with_limit(false)).steps().len();
            let (shape, elapsed) = (lobes.shape(), begun.elapsed().as_secs_f64());
            println!(
                "{name} {elapsed:6.2} s, {what}: E_log {on_train:.5} train, {on_test:.5} test; {} units, {} terms, {} numbers, {operations} operations",
                shape.units,
                shape.terms,
                lobes.free(),
            );
            Ok(())
        };
        for generation in 1..=generations {
            let progress = fit.step();
            if generation.is_power_of_two() || generation == generations {
                let what = format!("generation {generation:3}, held back {:.5}", progress.held);
                show(&what, fit.best().ok_or("there is none")?)?;
            }
        }
        let outcome = fit.finish().ok_or("there is none")?;
        show("best", &outcome.front[outcome.best].lobes)?;
        for (at, fitted) in outcome.front.iter().enumerate().step_by(4) {
            show(&format!("front {at:2}, {:.5}", fitted.fitted), &fitted.lobes)?;
        }
    }
    Ok(())
}

/// E_log of the program.
fn e_log(lobes: &Lobes, samples: &Samples) -> Result<f64, Box<dyn Error>> {
    let program = Program::lower(&lobes.genome()?.with_limit(false));
    let found = Samples::of_program(&program, samples.pairs().to_vec())?;
    Ok(metric::e_log(&samples.weighted(), &found.weighted()))
}
