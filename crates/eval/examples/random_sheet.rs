//! Renders random genomes on a built-in mesh as a contact sheet: `random_sheet MESH SEED FILE`.

use std::time::Instant;

use brood_eval::{
    CanonicalEvaluator, Evaluator, Level, SheetCell, develop, encode_png, shade, sheet,
};
use brood_genome::{Dialect, Output, Variation};
use brood_mesh::{BuiltinMesh, Mesh};
use brood_program::{BroodRequest, Program, make_brood};
use brood_scene::{Exposure, SampleSet, Scene};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [mesh, seed, file] = &arguments[..] else {
        eprintln!("usage: random_sheet MESH SEED FILE");
        std::process::exit(2);
    };
    let builtin = BuiltinMesh::ALL.into_iter().find(|m| m.name() == mesh).expect("a built-in mesh");
    let output = Output::saturation(0.65).expect("0.65 is a saturation");
    let variation = Variation::random(Dialect::default()).with_output(Some(output));
    let seed = seed.parse().expect("a seed");
    let mut clock = Instant::now();
    let mut lap = |what: &str| {
        println!("{what}: {:.2} ms", clock.elapsed().as_secs_f64() * 1e3);
        clock = Instant::now();
    };
    let brood = make_brood(&BroodRequest { variation, count: 40, seed, distinct: true });
    lap("births");
    let set = SampleSet::render(&Mesh::builtin(builtin), &Scene::default(), 256, 1);
    lap("mesh and samples");
    let programs: Vec<&Program> = brood.iter().map(|child| &child.program).collect();
    let mut f = Vec::new();
    CanonicalEvaluator::default().eval(&programs, &set, &mut f).expect("the CPU evaluates");
    lap("first evaluation (fills inputs)");
    for level in Level::available() {
        let evaluator = CanonicalEvaluator::with_level(level);
        evaluator.eval(&programs, &set, &mut f).expect("the CPU evaluates");
        lap(level.name());
    }
    let images: Vec<_> =
        f.chunks(3 * set.len()).map(|f| develop(&shade(&set, f), Exposure::Auto)).collect();
    lap("shading and film");
    let bytes: usize = images.iter().map(|i| encode_png(i.width, i.height, &i.rgba).len()).sum();
    lap("PNG");
    println!("{} samples, {:?}, {bytes} bytes of PNG", set.len(), set.counts());
    let cells: Vec<_> = images
        .iter()
        .map(|i| SheetCell { width: i.width, height: i.height, rgba: &i.rgba })
        .collect();
    let (width, height, rgba) = sheet(&cells, None, 128, 6);
    std::fs::write(file, encode_png(width, height, &rgba)).expect("the file can be written");
}
