//! Ablation of the parameters of [`Population`]: E_log of genetic programs on measured materials,
//! for each variant, as a ratio to the default at equal processor time.
//!
//! `cargo run --release -p brood-search --example population -- DATA SECONDS SEEDS VARIANTS
//! MATERIAL...`
//!
//! DATA/nbrdf/merl.json holds the weights of neural materials; VARIANTS are names separated by
//! commas, or `all`. Each run has one thread, and its seconds are processor seconds of that thread,
//! so that other load on the machine does not change the results.

use std::collections::BTreeMap;
use std::error::Error;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use brood_brdf::Neural;
use brood_program::Program;
use brood_search::{Options, Population, Search};
use brood_target::{MeasuredTarget, Samples, Strategy, metric};

type Result<T> = std::result::Result<T, Box<dyn Error + Send + Sync>>;

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let data = arguments.next().ok_or("DATA is missing")?;
    let seconds: f64 = arguments.next().ok_or("SECONDS are missing")?.parse()?;
    let seeds: u64 = arguments.next().ok_or("SEEDS are missing")?.parse()?;
    let names = arguments.next().ok_or("VARIANTS are missing")?;
    let bytes = std::fs::read(format!("{data}/nbrdf/merl.json"))?;
    let target = |name: String| -> Result<(String, MeasuredTarget)> {
        let target = MeasuredTarget::of(&Neural::read(&bytes, &name)?)?;
        Ok((name, target))
    };
    let targets = arguments.map(target).collect::<Result<Vec<_>>>()?;
    let is_asked = |(what, _): &(String, Population)| {
        names == "all" || what == "default" || names.split(',').any(|name| name == what)
    };
    let variants: Vec<_> = variants().into_iter().filter(is_asked).collect();
    let mut runs = Vec::new();
    for (name, target) in &targets {
        for seed in 1..=seeds {
            runs.extend(
                variants.iter().map(|(what, population)| (what, name, target, seed, *population)),
            );
        }
    }
    let (next, found) = (AtomicUsize::new(0), Mutex::new(BTreeMap::new()));
    println!("variant,material,seed,e_log,generations,evaluations");
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                while let Some((what, name, target, seed, population)) =
                    runs.get(next.fetch_add(1, Ordering::Relaxed))
                {
                    let run = run(target, *seed, *population, seconds);
                    let (e_log, generations, evaluations) = run.expect("the run ends");
                    println!("{what},{name},{seed},{e_log},{generations},{evaluations}");
                    let key = ((*what).clone(), (*name).clone(), *seed);
                    found.lock().expect("no run panicked").insert(key, e_log);
                }
            });
        }
    });
    let found = found.into_inner()?;
    for (what, _) in &variants {
        let ratio = |((_, name, seed), e_log): (&(String, String, u64), &f64)| {
            (e_log / found[&("default".to_owned(), name.clone(), *seed)]).ln()
        };
        let own: Vec<f64> = found.iter().filter(|((of, _, _), _)| of == what).map(ratio).collect();
        let mean = own.iter().sum::<f64>() / own.len() as f64;
        let square = own.iter().map(|log| (log - mean).powi(2)).sum::<f64>();
        let error = (square / (own.len() * (own.len() - 1).max(1)) as f64).sqrt();
        println!(
            "{what}: {:.3} of the default E_log, within a factor of {:.3}",
            mean.exp(),
            error.exp()
        );
    }
    Ok(())
}

/// Returns held-out E_log of the best, generations and evaluations.
fn run(
    target: &MeasuredTarget,
    seed: u64,
    population: Population,
    seconds: f64,
) -> Result<(f64, u32, u64)> {
    let options = Options { strategy: Strategy::Gp, seed, is_mirrored: true, ..Options::default() };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    pool.install(|| {
        let begun = Instant::now();
        let spent = || processor_seconds().unwrap_or_else(|| begun.elapsed().as_secs_f64());
        let mut search = Search::with_population(&target.fitted, &options, population);
        let mut progress = search.step();
        while spent() < seconds {
            progress = search.step();
        }
        let best = search.best().ok_or("nothing was found")?;
        let program = Program::lower(&best.genome);
        let found = Samples::of_program(&program, target.held.pairs().to_vec())?;
        let e_log = metric::e_log(&target.held.weighted(), &found.weighted());
        Ok((e_log, progress.generation, progress.evaluations))
    })
}

/// Processor seconds of this thread, if the system reports them.
fn processor_seconds() -> Option<f64> {
    #[cfg(unix)]
    {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
        Duration::try_from(time).ok().map(|time| time.as_secs_f64())
    }
    #[cfg(not(unix))]
    None
}

fn variants() -> Vec<(String, Population)> {
    let default = Population::DEFAULT;
    let mut all = vec![("default".to_owned(), default)];
    let mut add = |name: &str, population| all.push((name.to_owned(), population));
    add("islands 2", Population { islands: 2, ..default });
    add("islands 8", Population { islands: 8, ..default });
    add("kept 32", Population { kept: 32, ..default });
    add("kept 128", Population { kept: 128, ..default });
    add("children 96", Population { children: 96, ..default });
    add("children 384", Population { children: 384, ..default });
    add("first 2048", Population { first: 2048, ..default });
    add("tuned 2", Population { tuned: 2, ..default });
    add("tuned 16", Population { tuned: 16, ..default });
    add("steps 3", Population { steps: 3, ..default });
    add("steps 12", Population { steps: 12, ..default });
    add("tournament 2", Population { tournament: 2, ..default });
    add("tournament 6", Population { tournament: 6, ..default });
    add("lexicase 0", Population { lexicase: 0.0, ..default });
    add("lexicase 1", Population { lexicase: 1.0, ..default });
    add("crossed 0.1", Population { crossed: 0.1, ..default });
    add("crossed 0.7", Population { crossed: 0.7, ..default });
    add("migration 4", Population { migration: 4, ..default });
    add("migration 64", Population { migration: 64, ..default });
    add("stale 20", Population { stale: 20, ..default });
    add("stale 160", Population { stale: 160, ..default });
    // Combination of the variants that were better alone.
    let together = Population { islands: 8, tuned: 2, crossed: 0.7, lexicase: 1.0, ..default };
    add("together", together);
    add("together, stale 160", Population { stale: 160, ..together });
    all
}
