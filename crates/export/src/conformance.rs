//! Conformance suite of exported models: cases, samples and error bounds, shared by every backend
//! that can run a language. Styles of painted materials have canonical bits and need no bounds.
//!
//! Values are compared with `Brdf::f` in f64. Errors are counted in *units*: the sum of the changes
//! of f when each component of the directions and each parameter of the model is rounded to f32,
//! plus half a unit in the last place of f. A narrow highlight, which a rounded direction moves by
//! its own width, has large errors but few units.

mod bound;
mod call;
mod sample;
mod style;

use brood_brdf::{Brdf, DirectionPair, Libm, Plain, PreparedModel, TableDetail};
use brood_genome::{BirthKey, Genome, Model, ModelKind, Operator, RANGE, Stream};
use brood_program::Program;
use glam::DVec3;

pub use bound::{BOUNDS, Bound, ErrorSummary, ErrorTally};
pub use call::{StyledCall, styled_calls};
pub use sample::pairs;
pub use style::styles;

/// Number of models of each kind: one with the defaults, the others random.
pub const MODELS: u32 = 13;
/// The largest value that the square of a result can have.
const MAX_F: f64 = RANGE as f64 * RANGE as f64;
/// Half a unit in the last place of f32, relative.
const ROUNDING: f64 = 1.0 / 16_777_216.0;
/// Values below this have absolute errors: displays cannot show them, and f32 soon underflows.
const MIN_F: f64 = 1e-20;

/// A test case: a model alone.
#[derive(Debug, Clone)]
pub struct ModelCase {
    /// The model.
    pub model: Model,
    /// Program with the model as its only layer.
    pub program: Program,
}

/// Reference value, and the unit of its error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceValue {
    /// f by the reference.
    pub f: DVec3,
    /// Unit of error of each channel.
    pub unit: DVec3,
}

/// Returns the models of a kind: the defaults, then random ones, in which ends of ranges are
/// frequent and all words of choices occur.
#[must_use]
pub fn cases(kind: ModelKind) -> Vec<ModelCase> {
    let case = |model: Model| {
        let genome = Genome::of_models(vec![model.clone()]).expect("one layer is a genome");
        ModelCase { model, program: Program::lower(&genome) }
    };
    let random = (1..MODELS).map(|slot| random_model(kind, slot));
    std::iter::once(Model::new(kind)).chain(random).map(case).collect()
}

/// Returns a random model. The digits of `slot` choose the words, so that all words occur.
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

/// Draws a position in a range, one in eight at an end.
fn share(stream: &mut Stream) -> f64 {
    match stream.below(16) {
        0 => 0.0,
        1 => 1.0,
        _ => f64::from(stream.unit()),
    }
}

impl ModelCase {
    /// True if the model claims to be reciprocal.
    #[must_use]
    pub fn is_reciprocal(&self) -> bool {
        self.model.prepare().claims().reciprocal
    }

    /// Returns reference value and unit for each of the pairs.
    #[must_use]
    pub fn reference_values(&self, pairs: &[[DVec3; 2]]) -> Vec<ReferenceValue> {
        let prepared = self.model.prepare();
        let of = |brdf: &dyn Brdf, [wi, wo]: [DVec3; 2]| {
            let pair = DirectionPair::new(wi, wo).expect("samples are unit to f32");
            brdf.f(&pair).clamp(DVec3::ZERO, DVec3::splat(MAX_F))
        };
        let others = self.rounded();
        pairs
            .iter()
            .map(|pair| {
                let f = of(&prepared, *pair);
                let moved = nearby_pairs(*pair).map(|near| (of(&prepared, near) - f).abs());
                let rounded = others.iter().map(|other| (of(other, *pair) - f).abs());
                let unit =
                    moved.chain(rounded).sum::<DVec3>() + ROUNDING * f.max(DVec3::splat(MIN_F));
                ReferenceValue { f, unit }
            })
            .collect()
    }

    /// The model with each parameter changed by a rounding, one at a time. Coat tables are kept.
    fn rounded(&self) -> Vec<PreparedModel> {
        let parameters =
            self.model.parameters().filter(|(parameter, _)| parameter.words().is_none());
        let tables = self.model.coat_tables(Plain::<Libm>::new(), TableDetail::Full);
        let mut models = Vec::new();
        for (parameter, old) in parameters {
            for place in 0..old.len() {
                let mut values = old.to_vec();
                // Towards the middle of the range, because the value may be at an end.
                let (low, high) = parameter.range;
                let inward = if 2.0 * values[place] > low + high { -ROUNDING } else { ROUNDING };
                let sign = if values[place] < 0.0 { -1.0 } else { 1.0 };
                values[place] *= 1.0 + sign * inward;
                if let Ok(model) = self.model.clone().with(parameter.name, &values) {
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

/// The pair with each component of its directions changed by a rounding, one at a time.
fn nearby_pairs(pair: [DVec3; 2]) -> impl Iterator<Item = [DVec3; 2]> {
    (0..6).map(move |place| {
        let mut near = pair;
        let value = &mut near[place / 3][place % 3];
        *value *= 1.0 + ROUNDING;
        near
    })
}
