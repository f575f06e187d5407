//! Measures what the prior of `analytic` is worth for a material that is not among those that made
//! it.
//!
//! `cargo run --release -p brood-search --example left_out -- STEP FILE.json ...`: the files hold
//! the weights of neural materials, of which every STEP-th is photographed in one light. Each is
//! fitted without a prior, with one by the other materials, and with one by all.

mod photographed;

use brood_search::analytic::PriorMaterials;
use photographed::{Failure, each, error, searched};

fn main() -> Result<(), Failure> {
    let mut errors = Vec::new();
    each(|name, material, scene| {
        let of = |prior| -> Result<f64, Failure> {
            let (_, _, search) = searched(material, &[scene], prior)?;
            Ok(error(material, &search))
        };
        let found = [
            of(PriorMaterials::None)?,
            of(PriorMaterials::Without(name.to_owned()))?,
            of(PriorMaterials::All)?,
        ];
        let [none, others, all] = found;
        println!(
            "{name}: error over all directions {none:.4} without, {others:.4} by the others, {all:.4} by all"
        );
        errors.push(found);
        Ok(())
    })?;
    let median = |of: &dyn Fn(&[f64; 3]) -> f64| {
        let mut all: Vec<f64> = errors.iter().map(of).collect();
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    };
    let medians = [0, 1, 2].map(|which: usize| median(&|all| all[which]));
    let better = errors.iter().filter(|[none, others, _]| others < none).count();
    println!(
        "{} materials: medians {medians:.4?}; by the others better than without for {better}, error over that without {:.3} in the median; by all over by the others {:.3}",
        errors.len(),
        median(&|all| all[1] / all[0]),
        median(&|all| all[2] / all[1])
    );
    Ok(())
}
