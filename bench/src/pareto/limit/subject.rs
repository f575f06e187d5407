//! Random subjects of the energy limit: programs of several dialects, single models of every kind
//! over their whole ranges, and programs with layers.

use brood_brdf::{Model, ModelKind, Parametrisation};
use brood_genome::{BirthKey, Dialect, Genome, OpcodeSet, Operator, Stream, Variation};
use brood_program::Program;

/// Share of the values of a parameter that are at either end of its range.
const ENDS: f64 = 0.1;
/// Largest number of layers of a program.
const LAYERS: u32 = 4;

/// Kind of a subject.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SubjectKind {
    /// A program without layers.
    Program,
    /// One model.
    Model,
    /// A program with one to four layers.
    Layered,
}

/// A drawn subject.
#[derive(Debug)]
pub struct DrawnSubject {
    /// Kind of the subject.
    pub group: SubjectKind,
    /// Dialect, kind of the model, or number of layers.
    pub about: String,
    /// The subject without the energy limit.
    pub program: Program,
}

impl SubjectKind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Program, Self::Model, Self::Layered];

    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Program => "programs",
            Self::Model => "models",
            Self::Layered => "programs with layers",
        }
    }
}

/// Draws `count` subjects: two in five programs, two in five models, one in five both.
pub fn subjects(seed: u64, count: u32) -> impl Iterator<Item = DrawnSubject> {
    (0..count).map(move |slot| {
        let key = BirthKey { seed, slot, attempt: 0 };
        let mut draw = Draw(Stream::new(key, Operator::RandomLayers));
        match slot % 5 {
            0 | 3 => {
                let (about, genome) = genome(seed, slot, (slot / 5 * 2 + slot % 5 / 3) as usize);
                let program = Program::lower(&genome);
                DrawnSubject { group: SubjectKind::Program, about, program }
            }
            1 | 4 => {
                let kinds = ModelKind::ALL;
                let kind = kinds[(slot / 5 * 2 + slot % 5 / 4) as usize % kinds.len()];
                let genome = Genome::of_models(vec![draw.model(kind)]);
                let program = Program::lower(&genome.expect("one model is a genome"));
                DrawnSubject { group: SubjectKind::Model, about: kind.to_string(), program }
            }
            _ => {
                let layers: Vec<Model> = (0..1 + slot / 5 % LAYERS)
                    .map(|_| {
                        let kind = draw.below(ModelKind::ALL.len());
                        draw.model(ModelKind::ALL[kind])
                    })
                    .collect();
                let about = format!("{} layers", layers.len());
                let (_, genome) = genome(seed, slot, (slot / 5) as usize);
                let genome = Genome::layered(
                    *genome.dialect(),
                    genome.instructions().to_vec(),
                    Box::new(*genome.constants()),
                    *genome.output(),
                    layers,
                );
                let genome = genome.expect("a random genome takes four layers");
                let program = Program::lower(&genome);
                DrawnSubject { group: SubjectKind::Layered, about, program }
            }
        }
    })
}

/// Random genome of one of the dialects, and the name of the dialect.
fn genome(seed: u64, slot: u32, dialect: usize) -> (String, Genome) {
    let paper = Dialect::default();
    let extended = Dialect { opcodes: OpcodeSet::Extended, registers: 10, ..paper };
    let form = Parametrisation::Paper;
    let dialects = [
        ("paper", paper),
        ("paper, its parametrisation", Dialect { parametrisation: form, ..paper }),
        ("extended", extended),
        (
            "extended, isotropic, homogeneous",
            Dialect { isotropic: true, homogeneous: true, ..extended },
        ),
        (
            "extended, paper's parametrisation, long",
            Dialect { parametrisation: form, registers: 16, length: 300, ..extended },
        ),
    ];
    let (name, dialect) = dialects[dialect % dialects.len()];
    let genome = Variation::random(dialect).birth(BirthKey { seed, slot, attempt: 0 });
    (name.to_owned(), genome)
}

/// Random numbers of one subject.
struct Draw(Stream);

impl Draw {
    fn below(&mut self, count: usize) -> usize {
        self.0.below(u32::try_from(count).expect("a short list")) as usize
    }

    /// A model with random values on the scales of its parameters; one in five is at an end.
    fn model(&mut self, kind: ModelKind) -> Model {
        kind.parameters().iter().fold(Model::new(kind), |model, parameter| {
            let mut value = || match parameter.words() {
                Some(words) => self.below(words.len()) as f64,
                None => {
                    let share = (f64::from(self.0.unit()) - ENDS) / (1.0 - 2.0 * ENDS);
                    parameter.at_share(share)
                }
            };
            let values: Vec<f64> = (0..parameter.count()).map(|_| value()).collect();
            model.with(parameter.name, &values).expect("values are within their ranges")
        })
    }
}
