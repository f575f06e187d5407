//! Tests of the evaluator on the available adapter. Without one they report that they were skipped,
//! or fail if `BROOD_REQUIRE_GPU=1`.

use std::time::Duration;

use brood_eval::{CanonicalEvaluator, conformance};

use super::*;
use crate::OwnPipelinePolicy;

pub(crate) fn evaluator(options: &GpuOptions) -> Option<GpuEvaluator> {
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

/// Asserts that all bits are canonical if the adapter is exact.
fn check_bits(evaluator: &GpuEvaluator, programs: &[Program], set: &SampleSet) {
    let batch: Vec<&Program> = programs.iter().collect();
    let (mut got, mut expected) = (Vec::new(), Vec::new());
    evaluator.eval(&batch, set, &mut got).unwrap();
    CanonicalEvaluator::default().eval(&batch, set, &mut expected).unwrap();
    assert_eq!(got.len(), expected.len());
    if evaluator.is_exact() {
        let different = (0..got.len()).find(|k| got[*k].to_bits() != expected[*k].to_bits());
        let Some(at) = different else { return };
        panic!("value {at} of {}: {}, expected {}", got.len(), got[at], expected[at]);
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
fn gpu_evaluator_passes_the_conformance_suite_with_every_guard() {
    for guard in [Guard::Barrier, Guard::NoContraction] {
        let options = GpuOptions { contraction: Contraction::Only(guard), ..GpuOptions::default() };
        let evaluator = match GpuEvaluator::new(&options) {
            // Not every device supports marked code.
            Err(GpuError::Rejected(reason)) if guard == Guard::NoContraction => {
                eprintln!("skipped: {reason}");
                continue;
            }
            _ => evaluator(&options),
        };
        let Some(evaluator) = evaluator else { return };
        assert!(evaluator.adapter().detail.starts_with(guard.name()));
        conformance::check(&evaluator);
    }
}

#[test]
fn gpu_evaluator_passes_the_conformance_suite_with_every_layout() {
    for shape in InterpreterLayout::ALL {
        let options = GpuOptions { shape: Some(shape), ..GpuOptions::default() };
        let Some(evaluator) = evaluator(&options) else { return };
        assert_eq!(evaluator.adapter().shape, shape);
        conformance::check(&evaluator);
    }
}

#[test]
fn guards_are_probed_in_order_when_the_compiler_contracts() {
    let options = GpuOptions::default();
    let Some(plain) = evaluator(&options) else { return };
    let guards = &plain.adapter().guards;
    // The compiler of a hardware driver may contract plain code by itself.
    assert_eq!(guards.len(), if guards[0].exact { 1 } else { Guard::ALL.len() });
    assert!(!plain.adapter().is_software || guards[0].exact, "{guards:?}");

    let evaluator = GpuEvaluator::open(&options, &[Guard::Plain]).unwrap();
    let report = evaluator.adapter();
    // Barriers do not keep subnormal numbers where the driver flushes them.
    let others = report.guards[1..].iter().any(|guard| guard.exact);
    assert!(!report.guards[0].exact && others, "{report:?}");
    assert!(report.exact && report.guard != Guard::Plain, "{report:?}");
    assert!(report.detail.contains("plain code is not exact"), "{}", report.detail);
    check_bits(&evaluator, &conformance::programs(2), &largest_set());

    let evaluator = GpuEvaluator::open(&options, &[Guard::Plain, Guard::Barrier]).unwrap();
    let report = evaluator.adapter();
    assert!(!report.guards[0].exact && !report.guards[1].exact, "{report:?}");
    assert_eq!(report.exact, report.guard == Guard::NoContraction, "{report:?}");

    let evaluator = GpuEvaluator::open(&options, &Guard::ALL).unwrap();
    let report = evaluator.adapter();
    assert!(
        !report.exact && report.guard == Guard::Plain && report.guards.len() == 3,
        "{report:?}"
    );
}

#[test]
fn inputs_are_uploaded_once_when_batches_use_the_same_set() {
    let Some(evaluator) = evaluator(&GpuOptions::default()) else { return };
    let programs = conformance::programs(2);
    let batch: Vec<&Program> = programs.iter().collect();
    let set = largest_set();
    let mut out = Vec::new();
    let first = evaluator.eval_timed(&batch, &set, &mut out).unwrap();
    let expected = out.clone();
    let second = evaluator.eval_timed(&batch, &set, &mut out).unwrap();
    assert!(first.uploaded_bytes >= 4 * set.len() as u64, "{first:?}");
    assert_eq!(second.uploaded_bytes, 0);
    assert_eq!(out, expected);
    assert!(second.device_s > 0.0 && second.longest_s <= second.device_s);

    // Another set with the same number of samples is another set.
    let other = conformance::hard_samples(99, set.len());
    assert!(evaluator.eval_timed(&batch, &other, &mut out).unwrap().uploaded_bytes > 0);
    check_bits(&evaluator, &programs, &other);
    check_bits(&evaluator, &programs, &set);
}

#[test]
fn least_recently_used_inputs_are_evicted_when_the_bound_is_reached() {
    let options = GpuOptions { resident_bytes: 300_000, ..GpuOptions::default() };
    let Some(evaluator) = evaluator(&options) else { return };
    let programs = conformance::programs(1);
    let sets: Vec<SampleSet> = (0..6).map(|seed| conformance::hard_samples(seed, 1500)).collect();
    for set in sets.iter().chain(sets.iter().rev()) {
        check_bits(&evaluator, &programs, set);
        let bytes = evaluator.lock().as_ref().unwrap().residency.bytes();
        assert!(bytes <= 300_000, "{bytes}");
    }
}

#[test]
fn batch_is_divided_into_submissions_by_the_measured_throughput() {
    let options = GpuOptions { submission: Duration::from_millis(2), ..GpuOptions::default() };
    let Some(evaluator) = evaluator(&options) else { return };
    let programs = conformance::programs(8);
    let batch: Vec<&Program> = programs.iter().collect();
    let set = conformance::hard_samples(5, 20_000);
    let mut out = Vec::new();
    let mut timing = BatchTiming::default();
    for _ in 0..3 {
        timing = evaluator.eval_timed(&batch, &set, &mut out).unwrap();
    }
    eprintln!("{timing:?}");
    // Several times 20 ms of work on a CPU; a fast device may finish in one submission.
    assert!(timing.submissions >= 5 || !evaluator.adapter().is_software, "{timing:?}");
}

#[test]
fn pipeline_of_a_single_program_gives_the_same_bits() {
    let options = GpuOptions { own_pipelines: OwnPipelinePolicy::Always, ..GpuOptions::default() };
    let Some(evaluator) = evaluator(&options) else { return };
    let (large, small) = (largest_set(), conformance::hard_samples(1, 77));
    let mut own = 0;
    for program in conformance::programs(2) {
        let mut out = Vec::new();
        evaluator.eval(&[&program], &small, &mut out).unwrap();
        for set in [&small, &large] {
            let timing = evaluator.eval_timed(&[&program], set, &mut out).unwrap();
            own += u32::from(timing.own_pipeline);
            if evaluator.is_exact() {
                let difference = conformance::first_difference(&program, set, &out);
                assert_eq!(difference, None, "{program:#?}");
            }
        }
    }
    assert!(own >= 20 || !evaluator.is_exact(), "{own} evaluations ran in pipelines of their own");
}

#[test]
fn program_gets_its_own_pipeline_when_it_is_evaluated_repeatedly() {
    let Some(evaluator) = evaluator(&GpuOptions::default()) else { return };
    if !evaluator.is_exact() {
        return;
    }
    let program = conformance::wild_program(1);
    let set = largest_set();
    let mut out = Vec::new();
    let is_own =
        |out: &mut Vec<f32>| evaluator.eval_timed(&[&program], &set, out).unwrap().own_pipeline;
    assert!(!is_own(&mut out));
    let expected = out.clone();
    assert!((0..20_000).any(|_| is_own(&mut out)), "the program never got its own pipeline");
    assert_eq!(out, expected);
}

#[test]
fn gpu_evaluator_is_exact_when_the_adapter_is_software() {
    let Some(evaluator) = evaluator(&GpuOptions::default()) else { return };
    let report = evaluator.adapter();
    assert!(report.exact || !report.is_software, "{report:?}");
}

#[test]
fn lost_device_is_reopened_at_the_next_batch() {
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
fn large_batch_is_divided_when_buffers_and_submissions_are_small() {
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
fn batch_fails_when_a_submission_exceeds_the_timeout() {
    let options = GpuOptions { timeout: Duration::from_nanos(1), ..GpuOptions::default() };
    match GpuEvaluator::new(&options) {
        Err(GpuError::Timeout { .. } | GpuError::NoAdapter) => {}
        // A fast device may finish before the first poll.
        Ok(evaluator) => assert!(!evaluator.adapter().is_software),
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn no_adapter_is_found_when_none_has_the_name() {
    let options = GpuOptions { adapter: Some("no such adapter".into()), ..GpuOptions::default() };
    assert_eq!(GpuEvaluator::new(&options).unwrap_err(), GpuError::NoAdapter);
}

/// Runs itself again in a process without drivers, because drivers are found through the
/// environment.
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

/// Returns a program with `live` values in registers at once: that many sums of u and v with
/// themselves, then the sum of all.
fn wide_program(live: u32) -> Program {
    let genome: brood_genome::Genome =
        "brood 1\n.dialect paper smooth registers 7\nADD R0.xyz, R1.z, R1.w\n".parse().unwrap();
    let mut words = Program::lower(&genome).to_words();
    let (first, step) = (words.len() - 2, [words[words.len() - 2], words[words.len() - 1]]);
    words.truncate(first);
    for index in 0..live {
        // Every sum has different operands, so that none is the same as another.
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
