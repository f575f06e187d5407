//! One model from one random start: what inverse rendering of a known kind of material does.

use brood_brdf::Model;
use brood_genome::{BirthKey, Operator, Stream};

use super::Form;
use super::batch::{Batch, some_of};
use super::climb::{Climb, Plan};
use super::evolve::{Start, evolve};
use super::residual::{Bench, Space};
use crate::Samples;

/// Samples of the first steps, and of the last.
const FEW: usize = 192;
const MANY: usize = 768;
const STEPS: usize = 60;
const LAST_STEPS: usize = 20;
/// Starts that are drawn at most; each so many an evolution strategy takes over.
const STARTS: u32 = 40;
const EVOLVE: u32 = 8;
const EVOLVE_GENERATIONS: usize = 120;
/// How far off the first steps may end for the last to be worth it, in E_log.
const NEAR: f64 = 2e-2;

/// Samples of a material whose kind is known.
pub struct Recovery {
    space: Space,
    few: Batch,
    many: Batch,
    /// E_log that is good enough.
    enough: f64,
}

/// What a start has come to.
#[derive(Debug, Clone, PartialEq)]
pub struct Recovered {
    /// The model.
    pub model: Model,
    /// E_log on the samples that were looked at.
    pub e_log: f64,
    /// Models that were held against samples.
    pub evaluations: u64,
    /// Places that were started from: 1 where the first led there.
    pub starts: u32,
}

impl Recovery {
    /// Prepares to look for models of one form.
    #[must_use]
    pub fn new(samples: &Samples, form: Form, enough: f64) -> Self {
        let all: Vec<usize> = (0..samples.len()).collect();
        let few = Batch::new(samples, &some_of(samples, &all, FEW)).with_least(samples);
        let many = Batch::new(samples, &some_of(samples, &all, MANY)).with_least(samples);
        Self { space: Space::new(form), few, many, enough }
    }

    /// From the random start of that number, and from further ones where it leads nowhere; the same for the same seed and number.
    #[must_use]
    pub fn run(&self, seed: u64, number: u32) -> Recovered {
        let mut bench = Bench::new();
        let space = &self.space;
        let enough = self.enough * self.enough;
        let (mut best, mut evaluations): (Option<Climb>, u64) = (None, 0);
        let mut starts = 0;
        while starts < STARTS {
            let key = BirthKey { seed, slot: number, attempt: starts };
            let mut stream = Stream::new(key, Operator::Analytic);
            starts += 1;
            let mut climb = Climb::new(drawn(space, &mut stream));
            if starts.is_multiple_of(EVOLVE) {
                climb = self.evolved(&mut bench, climb, &mut stream);
            }
            climb.refine(&mut bench, space, &self.few, Plan::coarse(STEPS));
            if climb.error < NEAR * NEAR {
                climb.refine(
                    &mut bench,
                    space,
                    &self.many,
                    Plan { enough, ..Plan::full(LAST_STEPS) },
                );
            }
            evaluations += climb.tries;
            if best.as_ref().is_none_or(|best| climb.error < best.error) {
                best = Some(climb);
            }
            if best.as_ref().is_some_and(|best| best.error <= enough) {
                break;
            }
        }
        let best = best.expect("there was a start");
        let model = space.models(&best.x).remove(0);
        Recovered { model, e_log: best.error.sqrt(), evaluations, starts }
    }

    fn evolved(&self, bench: &mut Bench, climb: Climb, stream: &mut Stream) -> Climb {
        let (space, few) = (&self.space, &self.few);
        let bounds: Vec<(f64, f64)> = space.coordinates.iter().map(|c| c.bounds).collect();
        let start =
            Start { x: &climb.x, bounds: &bounds, sigma: 0.3, generations: EVOLVE_GENERATIONS };
        let mut tries = climb.tries;
        let (x, error) = evolve(&start, stream, |x| {
            tries += 1;
            bench.error(space, x, few, brood_brdf::TableDetail::Coarse) / few.total
        });
        Climb { x, error, tries }
    }

    /// How many numbers are looked for.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.space.len()
    }
}

/// A random place.
pub(super) fn drawn(space: &Space, stream: &mut Stream) -> Vec<f64> {
    space.coordinates.iter().map(|coordinate| coordinate.start(f64::from(stream.unit()))).collect()
}

#[cfg(test)]
mod tests {
    use brood_brdf::ModelKind;

    use super::*;
    use crate::draw_pairs;

    /// A model with drawn numbers, not too far out.
    fn truth(kind: ModelKind, number: u32) -> Model {
        let key = BirthKey { seed: 77, slot: number, attempt: 0 };
        let mut stream = Stream::new(key, Operator::RandomLayers);
        let space = Space::new(Form::one(kind));
        space.models(&drawn(&space, &mut stream)).remove(0)
    }

    #[test]
    fn models_are_recovered_from_their_samples() {
        for kind in [
            ModelKind::OrenNayar,
            ModelKind::CookTorrance,
            ModelKind::Conductor,
            ModelKind::Coated,
            ModelKind::RoughPlastic,
            ModelKind::Principled,
            ModelKind::Ward,
            ModelKind::AshikhminShirley,
            ModelKind::Abc,
        ] {
            for number in 0..3 {
                let truth = truth(kind, number);
                let samples = Samples::of(&*truth.brdf(), draw_pairs(2000, 5));
                let found = Recovery::new(&samples, Form::one(kind), 1e-6).run(1, number);
                assert!(found.e_log < 1e-5, "{truth}{found:?}");
            }
        }
    }
}
