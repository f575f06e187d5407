//! Files of Python are accepted by Python.

use std::io::Write;
use std::process::{Command, Stdio};

use brood_eval::express;
use brood_export::{Format, Within, conformance, export_material};
use brood_genome::preset::PRESETS;
use brood_genome::{BirthKey, Dialect, DialectConstraints, Genome, ModelKind, Variation};

/// Reads files that are separated by zeros, and compiles each.
const COMPILE: &str =
    "import sys\nfor text in sys.stdin.read().split('\\0'): compile(text, 'file', 'exec')\n";

#[test]
fn plugins_for_mitsuba_are_valid_python() {
    let presets = PRESETS.iter().step_by(4).map(|preset| preset.genome().clone());
    let model = |kind| Genome::of_models(vec![conformance::cases(kind)[1].model.clone()]).unwrap();
    let constraints = DialectConstraints { bumps: Some(true), ..Default::default() };
    let bumped = Variation::random(Dialect::default()).with_constraints(constraints);
    let bumped = (0..3).map(|slot| bumped.birth(BirthKey { seed: 1, slot, attempt: 0 }));
    let random = Variation::random(Dialect::default());
    let random = (0..6).map(|slot| random.birth(BirthKey { seed: 2, slot, attempt: 0 }));
    let genomes = presets.chain(random).chain(ModelKind::ALL.into_iter().map(model)).chain(bumped);
    let programs = genomes.map(|genome| express(&genome)).filter(|program| !program.is_painted());
    let files: Vec<String> = programs
        .map(|program| {
            export_material(&program, Format::Mitsuba, Within::default()).unwrap().into_text()
        })
        .collect();
    assert!(files.len() > 20);

    let mut python = Command::new("python3")
        .args(["-c", COMPILE])
        .stdin(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("python3 starts");
    python.stdin.take().unwrap().write_all(files.join("\0").as_bytes()).unwrap();
    let output = python.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
