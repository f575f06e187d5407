//! What every renderer's compiler must make of exported models: cases, samples and a table of bounds, exported so that each
//! backend that can run a language holds it to the same values.
//!
//! Values are held against `Brdf::f` in f64. An error is counted in *units*: by how much f changes, summed, when each component
//! of the directions and each number of the model is rounded to f32, plus half a unit of the last place of f itself. So a
//! highlight that a rounding of the direction moves by its own width has large errors and few units of them.

mod bound;
mod sample;

use brood_brdf::{Brdf, DirectionPair, Libm, Plain, PreparedModel, TableDetail};
use brood_genome::{BirthKey, Genome, Model, ModelKind, Operator, RANGE, Stream};
use brood_program::Program;
use glam::DVec3;

pub use bound::{BOUNDS, Bound, Figures, Tally};
pub use sample::pairs;

/// Models of each kind: one with the defaults, the others random.
pub const MODELS: u32 = 13;
/// As large as the square of a result can be.
const MOST: f64 = RANGE as f64 * RANGE as f64;
/// Half a unit of the last place, relative.
const ROUNDING: f64 = 1.0 / 16_777_216.0;
/// Below this errors are absolute: no display shows it, and f32 soon ends.
const LEAST: f64 = 1e-20;

/// A model, alone.
#[derive(Debug, Clone)]
pub struct Case {
    /// The model.
    pub model: Model,
    /// A program of it alone.
    pub program: Program,
}

/// What a value should be, and what one unit of error is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wanted {
    /// The reference's.
    pub f: DVec3,
    /// Of each channel.
    pub unit: DVec3,
}

/// Models of a kind: the default, then random ones in whose numbers ends of the ranges are frequent; all words of choices come up.
#[must_use]
pub fn cases(kind: ModelKind) -> Vec<Case> {
    let case = |model: Model| {
        let genome = Genome::of_models(vec![model.clone()]).expect("one layer is a genome");
        Case { model, program: Program::lower(&genome) }
    };
    let random = (1..MODELS).map(|slot| random_model(kind, slot));
    std::iter::once(Model::new(kind)).chain(random).map(case).collect()
}

fn random_model(kind: ModelKind, slot: u32) -> Model {
    let mut stream = Stream::new(BirthKey { seed: 7, slot, attempt: 0 }, Operator::RandomConstants);
    let mut turn = slot;
    kind.parameters().iter().fold(Model::new(kind), |model, parameter| {
        let values: Vec<f64> = match parameter.words() {
            Some(words) => {
                let count = u32::try_from(words.len()).expect("choices are few");
                let word = turn % count;
                turn /= count;
                vec![f64::from(word)]
            }
            None => {
                (0..parameter.count()).map(|_| parameter.at_share(share(&mut stream))).collect()
            }
        };
        model.with(parameter.name, &values).expect("shares are within the range")
    })
}

/// A share of a range, one in eight at an end.
fn share(stream: &mut Stream) -> f64 {
    match stream.below(16) {
        0 => 0.0,
        1 => 1.0,
        _ => f64::from(stream.unit()),
    }
}

impl Case {
    /// Whether the source promises the same for exchanged directions.
    #[must_use]
    pub fn is_reciprocal(&self) -> bool {
        self.model.prepare().claims().reciprocal
    }

    /// What the case is worth on each of the pairs.
    #[must_use]
    pub fn wanted(&self, pairs: &[[DVec3; 2]]) -> Vec<Wanted> {
        let prepared = self.model.prepare();
        let of = |brdf: &dyn Brdf, [wi, wo]: [DVec3; 2]| {
            let pair = DirectionPair::new(wi, wo).expect("samples are unit to f32");
            brdf.f(&pair).clamp(DVec3::ZERO, DVec3::splat(MOST))
        };
        let others = self.rounded();
        pairs
            .iter()
            .map(|pair| {
                let f = of(&prepared, *pair);
                let moved = nearby(*pair).map(|near| (of(&prepared, near) - f).abs());
                let rounded = others.iter().map(|other| (of(other, *pair) - f).abs());
                let unit =
                    moved.chain(rounded).sum::<DVec3>() + ROUNDING * f.max(DVec3::splat(LEAST));
                Wanted { f, unit }
            })
            .collect()
    }

    /// The model with each of its numbers off by a rounding; tables stay what they are.
    fn rounded(&self) -> Vec<PreparedModel> {
        let parameters =
            self.model.parameters().filter(|(parameter, _)| parameter.words().is_none());
        let tables = self.model.coat_tables(Plain::<Libm>::new(), TableDetail::Full);
        let mut models = Vec::new();
        for (parameter, numbers) in parameters {
            for place in 0..numbers.len() {
                let mut numbers = numbers.to_vec();
                // Towards the middle of the range, which may end at the number.
                let (low, high) = parameter.range;
                let inward = if 2.0 * numbers[place] > low + high { -ROUNDING } else { ROUNDING };
                let sign = if numbers[place] < 0.0 { -1.0 } else { 1.0 };
                numbers[place] *= 1.0 + sign * inward;
                if let Ok(model) = self.model.clone().with(parameter.name, &numbers) {
                    models.push(match &tables {
                        Some(tables) => model.prepare_with(tables),
                        None => model.prepare(),
                    });
                }
            }
        }
        models
    }
}

/// The pair with each component of its directions off by a rounding.
fn nearby(pair: [DVec3; 2]) -> impl Iterator<Item = [DVec3; 2]> {
    (0..6).map(move |place| {
        let mut near = pair;
        let value = &mut near[place / 3][place % 3];
        *value *= 1.0 + ROUNDING;
        near
    })
}
