//! The evaluator on whatever adapter there is; without one these tests say that they were skipped, or fail where
//! `BROOD_REQUIRE_GPU=1`.

use std::time::Duration;

use brood_eval::{CanonicalEvaluator, conformance};

use super::*;

fn evaluator(options: &GpuOptions) -> Option<GpuEvaluator> {
    match GpuEvaluator::new(options) {
        Ok(evaluator) => Some(evaluator),
        Err(error) => {
            let required = std::env::var_os("BROOD_REQUIRE_GPU").is_some_and(|v| v == "1");
            assert!(!required && error == GpuError::NoAdapter, "{error}");
            eprintln!("skipped: {error}");
            None
        }
    }
}

/// Where the adapter is exact, all bits are the canonical ones.
fn check_bits(evaluator: &GpuEvaluator, programs: &[Program], set: &SampleSet) {
    let batch: Vec<&Program> = programs.iter().collect();
    let (mut got, mut expected) = (Vec::new(), Vec::new());
    evaluator.eval(&batch, set, &mut got).unwrap();
    CanonicalEvaluator::default().eval(&batch, set, &mut expected).unwrap();
    assert_eq!(got.len(), expected.len());
    if evaluator.is_exact() {
        let different = (0..got.len()).find(|k| got[*k].to_bits() != expected[*k].to_bits());
        let Some(at) = different else { return };
        panic!("value {at} of {}: {} instead of {}", got.len(), got[at], expected[at]);
    }
}

fn largest_set() -> SampleSet {
    conformance::sample_sets().into_iter().max_by_key(SampleSet::len).unwrap()
}

#[test]
fn gpu_evaluator_passes_the_conformance_suite() {
    let Some(evaluator) = evaluator(&GpuOptions::default()) else { return };
    eprintln!("{:?}", evaluator.adapter());
    conformance::check(&evaluator);
}

#[test]
fn gpu_evaluator_passes_the_conformance_suite_when_it_has_barriers() {
    let options = GpuOptions { contraction: Contraction::Barrier, ..GpuOptions::default() };
    let Some(evaluator) = evaluator(&options) else { return };
    assert!(evaluator.adapter().detail.starts_with("code with barriers"));
    conformance::check(&evaluator);
}

#[test]
fn gpu_evaluator_is_exact_when_the_adapter_is_software() {
    let Some(evaluator) = evaluator(&GpuOptions::default()) else { return };
    let report = evaluator.adapter();
    assert!(report.exact || !report.is_software, "{report:?}");
}

#[test]
fn lost_device_is_opened_again_when_the_next_batch_comes() {
    let Some(evaluator) = evaluator(&GpuOptions::default()) else { return };
    let programs = conformance::programs(2);
    let set = largest_set();
    for _ in 0..3 {
        check_bits(&evaluator, &programs, &set);
        evaluator.lock().as_ref().unwrap().device.api.destroy();
    }
    check_bits(&evaluator, &programs, &set);
    assert!(!evaluator.lock().as_ref().unwrap().device.is_lost());
}

#[test]
fn large_batch_is_cut_when_buffers_and_submissions_are_small() {
    let options = GpuOptions {
        buffer_bytes: 40_000,
        submission: Duration::from_micros(200),
        ..GpuOptions::default()
    };
    let Some(evaluator) = evaluator(&options) else { return };
    // 5000 samples are several slabs of 256 to 1024 samples; a group holds few programs.
    check_bits(&evaluator, &conformance::programs(3), &largest_set());
}

#[test]
fn batch_is_refused_when_a_submission_takes_too_long() {
    let options = GpuOptions { timeout: Duration::from_nanos(1), ..GpuOptions::default() };
    match GpuEvaluator::new(&options) {
        Err(GpuError::Timeout { .. } | GpuError::NoAdapter) => {}
        // A fast device may be through before anyone asks.
        Ok(evaluator) => assert!(!evaluator.adapter().is_software),
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn no_adapter_is_found_when_none_has_the_name() {
    let options = GpuOptions { adapter: Some("no such adapter".into()), ..GpuOptions::default() };
    assert_eq!(GpuEvaluator::new(&options).unwrap_err(), GpuError::NoAdapter);
}

/// Runs itself once more in a process without drivers, because drivers are looked for in the environment.
#[cfg(target_os = "linux")]
#[test]
fn no_adapter_is_found_when_there_is_no_driver() {
    const MARK: &str = "BROOD_TEST_WITHOUT_DRIVERS";
    const NAME: &str = "evaluator::tests::no_adapter_is_found_when_there_is_no_driver";
    if std::env::var_os(MARK).is_some() {
        let error = GpuEvaluator::new(&GpuOptions::default()).unwrap_err();
        assert_eq!(error, GpuError::NoAdapter);
        return;
    }
    let output = std::process::Command::new(std::env::current_exe().unwrap())
        .args(["--exact", NAME])
        .env(MARK, "1")
        .env("VK_DRIVER_FILES", "/nonexistent")
        .env("VK_ICD_FILENAMES", "/nonexistent")
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && text.contains("1 passed"), "{text}");
}

/// A program with `live` values in registers at once: that many sums of u and v with themselves, then all added up.
fn wide_program(live: u32) -> Program {
    let genome: brood_genome::Genome =
        "brood 1\n.dialect paper smooth registers 7\nADD R0.xyz, R1.z, R1.w\n".parse().unwrap();
    let mut words = Program::lower(&genome).to_words();
    let (first, step) = (words.len() - 2, [words[words.len() - 2], words[words.len() - 1]]);
    words.truncate(first);
    for index in 0..live {
        // Every sum is of its own, so that none can be told apart by its place alone.
        let previous = if index == 0 { step[0] & 0x00ff_ffff } else { index - 1 };
        words.extend([step[0] & 0xff00_0000 | previous, step[1]]);
    }
    for index in 0..live - 1 {
        let sum = if index == 0 { live - 1 } else { live + index - 1 };
        words.extend([step[0] & 0xff00_0000 | sum, live - 2 - index]);
    }
    let steps = 2 * live - 1;
    words[2] = steps;
    words[3..6].fill(steps - 1);
    Program::from_words(&words).unwrap()
}

#[test]
fn program_is_unsupported_when_it_needs_more_registers_than_the_largest_file() {
    let Some(evaluator) = evaluator(&GpuOptions::default()) else { return };
    let set = largest_set();
    for live in [20, 100] {
        let program = wide_program(live);
        let registers = u32::from(brood_program::Tape::new(&program).registers());
        assert!((live - 1..=live).contains(&registers), "{live} {registers}");
        check_bits(&evaluator, &[program], &set);
    }
    let wide = wide_program(150);
    let error = evaluator.eval(&[&wide], &set, &mut Vec::new()).unwrap_err();
    assert!(matches!(error, EvalError::Unsupported(_)), "{error}");
    check_bits(&evaluator, &conformance::programs(1), &set);
}
