//! Runs a strategy on measured materials: prints E_log on held-out samples after some generations,
//! then the front.
//!
//! `cargo run --release -p brood-search --example strategy -- DATA STRATEGY GENERATIONS [MATERIAL
//! ...]`, where DATA/nbrdf/merl.json holds the weights of neural materials.

use std::error::Error;
use std::time::Instant;

use brood_brdf::Neural;
use brood_program::Program;
use brood_search::{Candidate, Found, Options, Search};
use brood_target::{MeasuredTarget, Samples, Strategy, metric, narrow_pairs};

/// Number of pairs at which the largest f is measured, to detect spikes between samples.
const NARROW: usize = 1 << 16;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let data = arguments.next().ok_or("DATA is missing")?;
    let strategy: Strategy = arguments.next().ok_or("STRATEGY is missing")?.parse()?;
    let generations: u32 = arguments.next().ok_or("GENERATIONS are missing")?.parse()?;
    let bytes = std::fs::read(format!("{data}/nbrdf/merl.json"))?;
    for name in arguments {
        let neural = Neural::read(&bytes, &name)?;
        let target = MeasuredTarget::of(&neural)?;
        let own = Samples::of(&neural, narrow_pairs(NARROW, 3)).largest();
        println!(
            "{name}: largest f {own:.3} where samples are few, {:.3} on samples",
            target.fitted.largest()
        );
        let options = Options { strategy, seed: 1, is_mirrored: false, ..Options::default() };
        let begun = Instant::now();
        let show = |what: &str, candidate: &Candidate| -> Result<(), Box<dyn Error>> {
            let program = Program::lower(&candidate.genome);
            let (on_train, on_test) =
                (e_log(&program, &target.fitted)?, e_log(&program, &target.held)?);
            let largest = Samples::of_program(&program, narrow_pairs(NARROW, 3))?.largest();
            println!(
                "{name} {:6.2} s, {what}: E_log {on_train:.5} train, {on_test:.5} test; {} parameters, {} operations, largest f {:.2} of the target's",
                begun.elapsed().as_secs_f64(),
                candidate.parameters,
                program.operations(),
                largest / own,
            );
            Ok(())
        };
        let mut search = Search::new(&target.fitted, &options).reporting(&target.held);
        for generation in 1..=generations {
            let progress = search.step();
            if generation.is_power_of_two() || generation == generations {
                let what = format!(
                    "generation {generation:3}, {} evaluations, held back {:.5}",
                    progress.evaluations, progress.held
                );
                show(&what, &search.best().ok_or("there is none")?)?;
            }
        }
        let outcome = search.finish().ok_or("there is none")?;
        let front = Found::all(&outcome.front, &target)?;
        show("best", &outcome.front[Found::best(&front, &outcome)])?;
        for (at, candidate) in outcome.front.iter().enumerate().step_by(4) {
            show(&format!("front {at:2}"), candidate)?;
        }
    }
    Ok(())
}

/// E_log of the program.
fn e_log(program: &Program, samples: &Samples) -> Result<f64, Box<dyn Error>> {
    let found = Samples::of_program(program, samples.pairs().to_vec())?;
    Ok(metric::e_log(&samples.weighted(), &found.weighted()))
}
