//! Programs and sample sets of the suite.

use brood_brdf::DirectionPair;
use brood_genome::{
    BirthKey, Dialect, Genome, Model, ModelKind, OpcodeSet, Output, Parametrisation, Stream,
    Variation,
};
use brood_program::Program;
use brood_scene::SampleSet;
use glam::{DVec2, DVec3};

/// Returns programs of every dialect: `count` random ones of each, and hand-written corner cases.
#[must_use]
pub fn programs(count: u64) -> Vec<Program> {
    let paper = Dialect::default();
    let dialects = [
        paper,
        Dialect { parametrisation: Parametrisation::Paper, ..paper },
        Dialect { opcodes: OpcodeSet::Extended, registers: 10, ..paper },
        Dialect { isotropic: true, homogeneous: true, registers: 4, length: 30, ..paper },
        Dialect { registers: 16, length: 400, ..paper },
    ];
    let mut programs: Vec<Program> = corners();
    for (index, dialect) in dialects.into_iter().enumerate() {
        for seed in 0..count {
            let key = BirthKey { seed, slot: index as u32, attempt: 0 };
            let output =
                (seed % 4 == 1).then(|| Output::saturation(0.65).expect("0.65 is in 0..1"));
            let genome = Variation::random(dialect).with_output(output).birth(key);
            programs.push(Program::lower(&genome));
        }
    }
    programs
}

/// Returns a model of every kind alone, and some over programs and behind output stages.
#[must_use]
pub fn layered_programs() -> Vec<Program> {
    let mut programs: Vec<Program> = ModelKind::ALL
        .into_iter()
        .map(|kind| Genome::of_models(vec![Model::new(kind)]).expect("one model is enough"))
        .map(|genome| Program::lower(&genome))
        .collect();
    let texts = [
        ".model conductor\nroughness 0.0001\n.model lambert",
        ".scale 0.5 2 0\n.offset 0 0 0.25\n.dialect paper smooth registers 7\nMUL R0, R0, R1\n.model ward\nalpha_y 0.5",
        ".dialect paper smooth registers 7 isotropic\nMOV R0, R1\n.model ward\nalpha_y 0.5\n.model phong",
    ];
    programs.extend(texts.iter().map(|text| {
        let genome: Genome = format!("brood 1\n{text}\n").parse().expect("the cases are valid");
        Program::lower(&genome)
    }));
    programs
}

/// Returns a random program of a dialect that depends on the seed; half of the programs have
/// constants up to the ends of the range.
#[must_use]
pub fn wild_program(seed: u64) -> Program {
    let paper = Dialect::default();
    let dialect = match seed % 4 {
        0 | 1 => paper,
        2 => Dialect { parametrisation: Parametrisation::Paper, ..paper },
        _ => Dialect { opcodes: OpcodeSet::Extended, registers: 10, ..paper },
    };
    let key = BirthKey { seed, slot: u32::MAX, attempt: 0 };
    let genome = Variation::random(dialect).birth(key);
    if seed % 8 < 4 {
        return Program::lower(&genome);
    }
    let mut constants = Box::new(*genome.constants());
    for constant in constants.iter_mut().flatten() {
        *constant *= brood_genome::RANGE / 2.0;
    }
    let instructions = genome.instructions().to_vec();
    let genome = Genome::new(dialect, instructions, constants, Output::IDENTITY);
    Program::lower(
        &genome.expect("constants of at most 2 times half the range are within the range"),
    )
}

/// Returns a random model of a kind; a quarter of its numbers are at the ends of their ranges.
#[must_use]
pub fn wild_model(kind: ModelKind, seed: u64) -> Model {
    let key = BirthKey { seed, slot: u32::from(kind.number()), attempt: 0 };
    let mut stream = Stream::new(key, brood_genome::Operator::RandomLayers);
    kind.parameters().iter().fold(Model::new(kind), |model, parameter| {
        let mut number = || match parameter.words() {
            Some(words) => {
                let count = u32::try_from(words.len()).expect("there are few words");
                f64::from(stream.below(count))
            }
            None => parameter.at_share(match stream.below(8) {
                0 => 0.0,
                1 => 1.0,
                _ => f64::from(stream.unit()),
            }),
        };
        let values: Vec<f64> = (0..parameter.count()).map(|_| number()).collect();
        model.with(parameter.name, &values).expect("values are drawn from the range")
    })
}

/// Corner cases: only a constant, only an input, black, as bright as possible, everything clamped,
/// an output stage.
fn corners() -> Vec<Program> {
    let texts = [
        "MOV R0, C0",
        "MOV R0, R0",
        "MUL R0, R0, C1",
        "MUL R1, C2, R1\nMUL R0, R1, R1",
        "EX2 R0, C2.x",
        "EX2 R1, R1.z\nMUL R1, R1, R1\nMUL R0, R1, C2\nSUB R0, R0, R1",
        ".matrix 0.5 0.25 0.25 0 2 0 0.125 0 65504\n.scale 1 0.5 3\n.offset 0.25 0 1\nMOV R0, R2",
    ];
    let head = "brood 1\n.dialect paper smooth registers 7\n.const C0 0.5 -0.25 2 0\n.const C2 65504 -65504 65504 65504\n";
    let lower = |text: &&str| {
        let genome: Genome = format!("{head}{text}\n").parse().expect("the corner cases are valid");
        Program::lower(&genome)
    };
    texts.iter().map(lower).collect()
}

/// Returns sets of sizes around a block, of ordinary and of numerically difficult directions, with
/// texture coordinates from tiny to the ends of the range.
#[must_use]
pub fn sample_sets() -> Vec<SampleSet> {
    [0, 1, 255, 256, 257, 5000].map(sample_set).into_iter().collect()
}

fn sample_set(size: usize) -> SampleSet {
    hard_samples(77, size)
}

/// Returns numerically difficult directions and texture coordinates: half of the directions grazing
/// or at the pole, a third of the pairs equal or opposite in azimuth, coordinates from 1e-30 to the
/// ends of the range.
#[must_use]
pub fn hard_samples(seed: u64, size: usize) -> SampleSet {
    let key = BirthKey { seed, slot: size as u32, attempt: 0 };
    let mut stream = Stream::new(key, brood_genome::Operator::RandomConstants);
    let mut pairs = Vec::with_capacity(size);
    let mut uvs = Vec::with_capacity(size);
    while pairs.len() < size {
        let wi = direction(&mut stream);
        let wo = match stream.below(6) {
            0 => wi,
            1 => DVec3::new(-wi.x, -wi.y, wi.z),
            _ => direction(&mut stream),
        };
        pairs.push(DirectionPair::new(wi, wo).expect("directions are unit"));
        uvs.push(DVec2::new(coordinate(&mut stream), coordinate(&mut stream)));
    }
    SampleSet::from_pairs(&pairs, &uvs)
}

/// Returns a direction in the upper hemisphere: half grazing, some at the pole.
fn direction(stream: &mut Stream) -> DVec3 {
    let mut component = || f64::from(2.0 * stream.unit() - 1.0);
    let (x, y, z) = (component(), component(), component().abs());
    let z = match stream.below(8) {
        0..4 => z * 1e-5,
        4 => return DVec3::Z,
        _ => z,
    };
    DVec3::new(x, y, z).try_normalize().unwrap_or(DVec3::Z)
}

fn coordinate(stream: &mut Stream) -> f64 {
    let value = f64::from(2.0 * stream.unit() - 1.0);
    match stream.below(8) {
        0 => value * 65504.0,
        1 => value * 1e-30,
        2 => 0.0,
        3 => value * 700.0,
        _ => value,
    }
}
