//! Steering: words that fit together, and the parts of genomes that they keep.

use super::*;
use crate::{BirthKey, Dialect, ModelKind, Start, Variation};

fn key(slot: u32) -> BirthKey {
    BirthKey { seed: 11, slot, attempt: 0 }
}

fn drawn(start: Start, slot: u32) -> Genome {
    Variation::random(start.dialect()).with_start(start).birth(key(slot))
}

fn check(words: &[Steer], parents: &[&Genome]) -> Result<(), SteerError> {
    Steer::check(words, parents, DialectConstraints::default())
}

#[test]
fn words_are_refused_when_they_contradict_or_do_not_fit_the_parents() {
    use Steer::*;
    let wild = drawn(Start::Wild, 0);
    assert_eq!(check(&[], &[]), Ok(()));
    assert_eq!(check(&[Warmer, Rougher, MorePattern], &[&wild]), Ok(()));
    assert_eq!(check(&[KeepColour, OnlyGloss, Glossier], &[&wild]), Ok(()));
    assert_eq!(check(&[Warmer], &[]), Err(SteerError::NoParent));
    assert_eq!(check(&[Warmer, Warmer], &[&wild]), Err(SteerError::Twice(Warmer)));
    for (one, other) in CONTRADICTIONS {
        let error = SteerError::Contradiction(one, other);
        assert_eq!(check(&[one, other], &[&wild]), Err(error));
        assert_eq!(check(&[other, one], &[&wild]), Err(SteerError::Contradiction(other, one)));
    }
    let error = SteerError::Contradiction(Warmer, Cooler).to_string();
    assert_eq!(error, "`cooler` contradicts `warmer`: leave one of them out");
    let phong = Genome::of_models(vec![Model::new(ModelKind::Phong)]).unwrap();
    assert_eq!(check(&[LessPattern], &[&phong]), Err(SteerError::NoPattern(LessPattern)));
    for parent in [drawn(Start::Believable, 0), phong] {
        assert_eq!(check(&[KeepColour], &[&parent]), Ok(()));
    }
    let constraints = DialectConstraints { homogeneous: Some(true), isotropic: None, bumps: None };
    let error = Err(SteerError::NoPattern(MorePattern));
    assert_eq!(Steer::check(&[MorePattern], &[&wild], constraints), error);
    let lambert = Genome::of_models(vec![Model::new(ModelKind::Lambert)]).unwrap();
    assert_eq!(check(&[OnlyGloss], &[&lambert]), Err(SteerError::NoGloss));
    assert_eq!(check(&[KeepColour], &[&lambert]), Err(SteerError::OnlyColours));
}

#[test]
fn gloss_and_tints_are_scalars_of_models() {
    let scalars: Vec<&str> = ModelKind::ALL
        .iter()
        .flat_map(|kind| kind.parameters())
        .filter(|one| matches!(one.kind, ParameterKind::Scalar { .. }))
        .map(|one| one.name)
        .collect();
    for name in GLOSS.iter().map(|(name, _)| name).chain(&TINTS) {
        assert!(scalars.contains(name), "{name}");
    }
}

/// Values of the parameters that satisfy a condition, by layer.
fn values(genome: &Genome, is_wanted: fn(&Parameter) -> bool) -> Vec<Vec<f64>> {
    let of = |model: &Model| {
        let wanted = model.parameters().filter(|(parameter, _)| is_wanted(parameter));
        wanted.flat_map(|(_, values)| values.to_vec()).collect()
    };
    genome.layers().iter().map(of).collect()
}

#[test]
fn models_keep_their_colours_exactly() {
    let mut changed = 0;
    for slot in 0..60 {
        let (parent, mate) = (drawn(Start::Models, slot), drawn(Start::Models, slot + 1));
        for variation in
            [Variation::mutate(&parent, 0.8), Variation::crossover(&parent, &mate, 0.5, 0.8)]
        {
            let child = variation.with_steer(&[Steer::KeepColour]).birth(key(slot));
            assert_eq!(values(&child, is_colour), values(&parent, is_colour));
            assert_eq!(child.layers()[0].kind(), parent.layers()[0].kind());
            changed += u32::from(child != parent);
        }
    }
    assert!(changed > 80, "{changed}");
}

#[test]
fn models_change_only_their_gloss() {
    let mut changed = 0;
    for slot in 0..60 {
        let parent = drawn(Start::Models, slot);
        let mutate = Variation::mutate(&parent, 0.5).with_steer(&[Steer::OnlyGloss]);
        let child = mutate.birth(key(slot));
        let others = |parameter: &Parameter| !is_gloss(parameter);
        assert_eq!(values(&child, others), values(&parent, others));
        changed += u32::from(values(&child, is_gloss) != values(&parent, is_gloss));
        assert_eq!(child != parent, has_gloss(parent.layers()));
    }
    assert!(changed > 30, "{changed}");
}

#[test]
fn wild_children_of_a_seed_do_not_depend_on_the_steer() {
    let parent = Variation::random(Dialect::default()).birth(key(0));
    let plain = Variation::mutate(&parent, 0.3);
    let steered = plain.with_steer(&[Steer::KeepColour, Steer::Rougher]);
    assert_eq!(steered.birth(key(1)), plain.birth(key(1)));
}

#[test]
fn models_step_towards_the_words() {
    let parent = Genome::of_models(vec![Model::new(ModelKind::CookTorrance)]).unwrap();
    let parent = parent.layers()[0].clone().with("diffuse", &[0.4; 3]).unwrap();
    let parent = Genome::of_models(vec![parent]).unwrap();
    let mean = |words: &[Steer], of: fn(&Model) -> f64| {
        let child = |slot| Variation::mutate(&parent, 0.3).with_steer(words).birth(key(slot));
        (0..100).map(|slot| of(&child(slot).layers()[0])).sum::<f64>() / 100.0
    };
    let roughness = |model: &Model| model.get("roughness").map_or(0.2, |one| one[0]).ln();
    let warmth = |model: &Model| model.get("diffuse").map_or(0.0, |one| one[0] - one[2]);
    let (plain, warm) = (mean(&[], roughness), mean(&[], warmth));
    assert!(mean(&[Steer::Glossier], roughness) < plain - 0.7);
    assert!(mean(&[Steer::Rougher], roughness) > plain + 0.4);
    assert!(mean(&[Steer::Warmer], warmth) > warm + 0.1);
    assert!(mean(&[Steer::Cooler], warmth) < warm - 0.1);
    // What a word keeps is not moved by another one.
    let both = [Steer::KeepColour, Steer::Glossier];
    assert_eq!(mean(&both, warmth), 0.0);
    assert!(mean(&both, roughness) < plain - 0.7);
}

#[test]
fn redraws_take_larger_steps() {
    let step = |attempt| {
        let mut stream = Stream::new(key(0), crate::Operator::Toward);
        Toward::step(0.3, attempt, &mut stream)
    };
    assert!(step(0) > 0.1 && step(0) < 0.5);
    assert!(step(1) > step(0) && step(32) > 4.0 * step(0));
    assert_eq!(step(100), step(32));
}
