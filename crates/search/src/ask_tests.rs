//! Tests that asked genomes approach the target, and that a resume changes nothing.

use super::*;
use brood_brdf::{Model, ModelKind};
use brood_eval::{CanonicalEvaluator, Evaluator};
use brood_scene::SampleSet;
use brood_target::{Samples, Strategy, draw_pairs, metric};

fn options() -> AskOptions {
    AskOptions { dialect: Strategy::DIALECT, start: Vec::new(), seed: 3, count: 24, kept: 16 }
}

/// E_log on samples of a Lambertian material.
fn measured(genomes: &[Genome]) -> Vec<f64> {
    let pairs = draw_pairs(64, 1);
    let samples = Samples::of(&*Model::new(ModelKind::Lambert).brdf(), pairs.clone());
    let set = SampleSet::from_pairs(&pairs, &[]);
    let error = |genome: &Genome| {
        let mut out = Vec::new();
        let evaluator = CanonicalEvaluator::default();
        evaluator.eval(&[&Program::lower(genome)], &set, &mut out).unwrap();
        let weighted = |at: usize, of: [f64; 3]| of.map(|f| f * pairs[at].cos_i());
        let found = |at: usize| [0, 1, 2].map(|c| f64::from(out[c * pairs.len() + at]));
        let found: Vec<[f64; 3]> = (0..pairs.len()).map(|at| weighted(at, found(at))).collect();
        let expected = samples.values().iter().enumerate();
        let expected: Vec<[f64; 3]> = expected.map(|(at, f)| weighted(at, *f)).collect();
        metric::e_log(&expected, &found)
    };
    genomes.iter().map(error).collect()
}

#[test]
fn ask_tell_reduces_the_error() {
    let mut search = AskTell::new(options());
    let mut first = None;
    for _ in 0..12 {
        let progress = search.tell(&measured(search.ask())).unwrap();
        first.get_or_insert(progress.held);
    }
    let last = search.progress();
    assert!(last.held < 0.5 * first.unwrap(), "{first:?} {last:?}");
    assert_eq!((last.generation, last.evaluations), (12, 12 * 24));
    assert_eq!(search.best().unwrap().error, search.front().last().unwrap().error);
    let probe = search.probe();
    assert!(probe.members == 16 && probe.median >= last.held, "{probe:?}");
}

#[test]
fn resume_changes_nothing() {
    let mut whole = AskTell::new(options());
    let mut broken = AskTell::new(options());
    for _ in 0..5 {
        broken = AskTell::resume(options(), &broken.checkpoint()).unwrap();
        assert_eq!(broken.ask(), whole.ask());
        let errors = measured(whole.ask());
        assert_eq!(broken.tell(&errors), whole.tell(&errors));
    }
    assert_eq!(broken.checkpoint(), whole.checkpoint());
    assert!(matches!(AskTell::resume(options(), &[]), Err(SearchError::Damaged)));
    assert!(matches!(AskTell::resume(options(), &[1, 1]), Err(SearchError::Version)));
    assert!(matches!(AskTell::resume(options(), &[9, 1]), Err(SearchError::Later)));
}

#[test]
fn tell_rejects_bad_errors_and_keeps_the_generation() {
    let mut search = AskTell::new(options());
    let asked = search.ask().to_vec();
    assert_eq!(search.tell(&[1.0]), Err(TellError::Count { expected: 24, actual: 1 }));
    let mut errors = vec![1.0; 24];
    errors[3] = f64::NAN;
    assert_eq!(search.tell(&errors), Err(TellError::NotANumber(3)));
    assert_eq!(search.ask(), asked);
    // All genomes are discarded: it draws new ones.
    search.tell(&[f64::INFINITY; 24]).unwrap();
    assert!(search.best().is_none() && search.ask() != asked);
}

#[test]
fn ask_begins_with_the_given_genomes() {
    let mut first = AskTell::new(options());
    first.tell(&measured(first.ask())).unwrap();
    let start = vec![first.best().unwrap().genome.clone()];
    let search = AskTell::new(AskOptions { start: start.clone(), ..options() });
    assert_eq!(search.ask()[0], start[0]);
    assert_ne!(search.ask()[1], start[0]);
}

#[test]
fn program_is_kept_once_when_its_error_varies() {
    let twin = AskTell::new(options()).ask()[0].clone();
    let start = vec![twin.clone(), twin.clone()];
    let mut search = AskTell::new(AskOptions { start, kept: 24, ..options() });
    let mut errors = vec![0.2; 24];
    (errors[0], errors[1]) = (0.3, 0.1);
    search.tell(&errors).unwrap();
    let hash = hash_of(&twin);
    let kept: Vec<f64> =
        search.kept.iter().filter(|it| it.hash == hash).map(|it| it.error).collect();
    assert_eq!(kept, [0.1]);
}
