//! Measures if the spread of fits of pictures is right: how often it contains the measured material
//! at directions that the pictures do not show, and if the advised next picture tells more than
//! others.
//!
//! `cargo run --release -p brood-search --example spread -- STEP FILE.json ...`: the files hold the
//! weights of neural materials, of which every STEP-th is photographed. The prior is that of the
//! others.

mod photographed;

use brood_brdf::{Brdf, DirectionPair};
use brood_scene::Scene;
use brood_search::analytic::PriorMaterials;
use brood_search::{Spread, SpreadMap};
use brood_target::{Samples, draw_pairs};
use photographed::{Failure, each, error, searched};

/// Number of other second pictures.
const OTHERS: usize = 5;

fn main() -> Result<(), Failure> {
    let (mut contained, mut ratios, mut known) = (Vec::new(), Vec::new(), Vec::new());
    let (mut errors, mut better) = (Vec::new(), 0);
    each(|name, material, scene| {
        let found = measured(material, name, scene)?;
        let [before, advised, random] = found.with_next;
        println!(
            "{name}: error over all directions {before:.4}, with the advised picture {advised:.4}, with another {random:.4}; {:.0} % within the spread, error {:.4}, spread {:.4}; seen {:.0} %",
            100.0 * found.contained,
            found.error,
            found.spread,
            100.0 * found.contained_seen
        );
        better += usize::from(advised < random);
        errors.push(found.with_next);
        contained.push(found.contained);
        known.push(found.contained_seen);
        ratios.push(found.error / found.spread);
        Ok(())
    })?;
    let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len() as f64;
    ratios.sort_by(f64::total_cmp);
    let medians = [0, 1, 2].map(|which: usize| {
        let mut of: Vec<f64> = errors.iter().map(|all| all[which]).collect();
        of.sort_by(f64::total_cmp);
        of[of.len() / 2]
    });
    println!(
        "the advised picture is better than another for {better} of {}; medians of errors {medians:.4?}",
        errors.len()
    );
    println!(
        "{} materials: {:.1} % within the spread where nothing is seen, {:.1} % elsewhere; error over spread {:.2} in the median",
        contained.len(),
        100.0 * mean(&contained),
        100.0 * mean(&known),
        ratios[ratios.len() / 2]
    );
    Ok(())
}

struct Measured {
    /// Share of the values at unseen directions that the spread contains, and at seen ones.
    contained: f64,
    contained_seen: f64,
    /// E_log of the best at unseen directions, and the spread there.
    error: f64,
    spread: f64,
    /// E_log over all directions of the best of one picture, and with a second one: the advised,
    /// and others (the median).
    with_next: [f64; 3],
}

fn measured(material: &dyn Brdf, name: &str, scene: &Scene) -> Result<Measured, Failure> {
    let prior = || PriorMaterials::Without(name.to_owned());
    let (pictures, target, search) = searched(material, &[scene], prior())?;
    let spread = Spread::of(&search).ok_or("the search has no spread")?;
    let all = spread.next_pictures(&pictures.views[0])?;
    // Evenly from the list, which is sorted by what they would tell.
    let others = (0..OTHERS).map(|k| &all[(2 * k + 1) * all.len() / (2 * OTHERS)].scene);
    // A picture with too few lit pixels tells nothing.
    let before = error(material, &search);
    let after = |next: &Scene| match searched(material, &[scene, next], prior()) {
        Ok((_, _, search)) => error(material, &search),
        Err(_) => before,
    };
    let advised = after(&all[0].scene);
    let mut others: Vec<f64> = others.map(after).collect();
    others.sort_by(f64::total_cmp);
    let with_next = [before, advised, others[OTHERS / 2]];
    let map = spread.map(&target.fitted)?;
    let (seen, unseen): (Vec<DirectionPair>, Vec<DirectionPair>) =
        draw_pairs(4000, 7).into_iter().partition(|pair| is_seen(&map, pair));
    let [(contained, error, deviation), (contained_seen, _, _)] = [unseen, seen].map(|pairs| {
        let wanted = logs(&Samples::of(material, pairs.clone()));
        let rows: Vec<Vec<f32>> = spread
            .programs()
            .iter()
            .map(|program| {
                logs(
                    &Samples::of_program(program, pairs.clone())
                        .expect("the CPU runs every program"),
                )
            })
            .collect();
        let [low, high] = Spread::range(&rows);
        let within = (0..wanted.len())
            .filter(|at| (low[*at] - 1e-4..=high[*at] + 1e-4).contains(&wanted[*at]))
            .count();
        let number = wanted.len().max(1) as f64;
        let (mut error, mut variance) = (0.0, 0.0);
        for at in 0..wanted.len() {
            let mean = rows.iter().map(|row| f64::from(row[at])).sum::<f64>() / rows.len() as f64;
            error += (f64::from(wanted[at]) - mean).powi(2);
            let squares = rows.iter().map(|row| (f64::from(row[at]) - mean).powi(2));
            variance += squares.sum::<f64>() / rows.len() as f64;
        }
        (within as f64 / number, (error / number).sqrt(), (variance / number).sqrt())
    });
    Ok(Measured { contained, contained_seen, error, spread: deviation, with_next })
}

fn is_seen(map: &SpreadMap, pair: &DirectionPair) -> bool {
    let half = (pair.wi() + pair.wo()).normalize();
    let cell = |cosine: f64| {
        ((cosine.min(1.0).acos().to_degrees() / 90.0 * SpreadMap::CELLS as f64) as usize)
            .min(SpreadMap::CELLS - 1)
    };
    map.seen[cell(half.dot(pair.wi())) * SpreadMap::CELLS + cell(half.z)] > 0.0
}

#[expect(clippy::cast_possible_truncation, reason = "compared at the precision of programs")]
fn logs(samples: &Samples) -> Vec<f32> {
    samples.weighted().as_flattened().iter().map(|f| f.max(0.0).ln_1p() as f32).collect()
}
