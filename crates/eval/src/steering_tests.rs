//! Steering: features of known materials, and broods that follow the words.

use brood_genome::{BirthKey, Genome, Model, ModelKind, Start, Variation};

use super::*;

fn model(kind: ModelKind, values: &[(&str, &[f64])]) -> Appearance {
    let model = values
        .iter()
        .fold(Model::new(kind), |model, (name, values)| model.with(name, values).unwrap());
    Appearance::of(&Program::lower(&Genome::of_models(vec![model]).unwrap()))
}

fn program(constraint: &str) -> Appearance {
    let text = format!("brood 1\n.dialect paper smooth registers 7{constraint}\nMOV R0, R1\n");
    Appearance::of(&Program::lower(&text.parse::<Genome>().unwrap()))
}

fn drawn(start: Start, slot: u32) -> Genome {
    let key = BirthKey { seed: 4, slot, attempt: 0 };
    Variation::random(start.dialect()).with_start(start).birth(key)
}

#[test]
fn colour_is_that_of_the_body() {
    let plastic = |diffuse: &[f64], exponent: f64| {
        let values: [(&str, &[f64]); 2] = [("diffuse", diffuse), ("exponent", &[exponent])];
        model(ModelKind::Phong, &values)
    };
    let [grey, red] = [[0.4; 3], [0.5, 0.1, 0.1]].map(|diffuse| plastic(&diffuse, 30.0));
    assert!(grey.colour.iter().all(|one| one.abs() < 0.5), "{grey:?}");
    assert!(red.colour[0] > 20.0 && red.colour[1] > 5.0, "{red:?}");
    // Brightness and highlights do not count.
    for other in [plastic(&[0.25, 0.05, 0.05], 30.0), plastic(&[0.5, 0.1, 0.1], 300.0)] {
        assert!(other.follows(Steer::KeepColour, &red) > 0.7, "{other:?} {red:?}");
    }
    let blue = plastic(&[0.1, 0.1, 0.5], 30.0);
    assert_eq!(blue.follows(Steer::KeepColour, &red), 0.0);
    assert_eq!((red.follows(Steer::Warmer, &blue), blue.follows(Steer::Cooler, &red)), (1.0, 1.0));
    assert_eq!((blue.follows(Steer::Warmer, &red), red.follows(Steer::Warmer, &red)), (0.0, 0.5));
}

#[test]
fn gloss_grows_as_highlights_narrow() {
    let conductor =
        |roughness: f64| model(ModelKind::Conductor, &[("roughness", &[roughness])]).gloss;
    let all = [0.8, 0.5, 0.3, 0.2].map(conductor);
    assert!(all.is_sorted(), "{all:?}");
    let lambert = model(ModelKind::Lambert, &[]);
    assert!(lambert.gloss < 0.6 && lambert.gloss < all[1], "{lambert:?} {all:?}");
}

#[test]
fn pattern_is_what_changes_over_the_texture() {
    let plain = program(" homogeneous");
    assert_eq!(plain.pattern, 0.0);
    assert_eq!(model(ModelKind::Lambert, &[]).pattern, 0.0);
    let strong = program("");
    assert!((0.3..1.0).contains(&strong.pattern), "{strong:?}");
    assert_eq!(strong.follows(Steer::MorePattern, &plain), 1.0);
    assert_eq!(plain.follows(Steer::LessPattern, &strong), 1.0);
}

#[test]
fn steered_broods_follow_more_often_than_others() {
    for (start, slots) in
        [(Start::Wild, [2, 9]), (Start::Models, [1, 2]), (Start::Believable, [1, 2])]
    {
        for word in [Steer::KeepColour, Steer::Warmer, Steer::Glossier, Steer::Rougher] {
            let words = [word];
            let (mut steered, mut plain) = (0, 0);
            for parent in slots.map(|slot| drawn(start, slot)) {
                let own = Appearance::of(&Program::lower(&parent));
                let variation = Variation::mutate(&parent, 0.3).with_start(start);
                let variation = variation.with_steer(&words);
                let request = BroodRequest { variation, count: 20, seed: 5, distinct: true };
                let follow = |brood: &[Child]| {
                    let follows =
                        |child: &&Child| Appearance::of(&child.program).follows(word, &own) >= 1.0;
                    brood.iter().filter(follows).count()
                };
                steered += follow(&steered_brood(&request, &words, true));
                let unsteered = BroodRequest { variation: variation.with_steer(&[]), ..request };
                plain += follow(&crate::diverse_brood(&unsteered));
            }
            assert!(
                steered >= 15 && steered > 2 * plain.min(10),
                "{start:?} {word:?}: {steered} against {plain}"
            );
        }
    }
}

#[test]
fn steered_brood_is_the_same_on_any_number_of_threads_and_the_beginning_of_a_larger_one() {
    let parent = drawn(Start::Wild, 2);
    let words = [Steer::Warmer, Steer::Rougher];
    let variation = Variation::mutate(&parent, 0.3).with_steer(&words);
    let request = BroodRequest { variation, count: 20, seed: 3, distinct: true };
    let hashes = |count, is_diverse| -> Vec<_> {
        let brood = steered_brood(&BroodRequest { count, ..request }, &words, is_diverse);
        brood.into_iter().map(|child| (child.hash, child.attempts)).collect()
    };
    let whole = hashes(20, true);
    assert_eq!(hashes(6, true), whole[..6]);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(pool.install(|| hashes(20, true)), whole);
    assert_ne!(hashes(20, false), whole);
}

/// Mean differences in codes between previews of parents and children, by amount.
fn differences(start: Start, amounts: &[f32]) -> Vec<f32> {
    let parents: Vec<Genome> = (0..).map(|slot| drawn(start, slot)).take(60).collect();
    let mean = |amount: &f32| {
        let apart = parents.iter().zip(0..).map(|(parent, slot)| {
            let key = BirthKey { seed: 8, slot, attempt: 0 };
            let child = Variation::mutate(parent, *amount).with_start(start).birth(key);
            let [a, b] = [parent, &child].map(|genome| Preview::of(&Program::lower(genome)));
            a.apart(&b)
        });
        apart.sum::<f32>() / 60.0
    };
    amounts.iter().map(mean).collect()
}

#[test]
fn difference_from_the_parent_grows_alike_for_every_kind_of_genome() {
    for start in Start::ALL {
        let all = differences(start, &[0.0, 0.02, 0.1, 0.3, 0.6, 1.0]);
        assert!(all[0] == 0.0 && all.is_sorted(), "{start:?} {all:?}");
        assert!((0.3..5.0).contains(&all[1]), "{start:?} {all:?}");
        assert!((2.0..15.0).contains(&all[2]), "{start:?} {all:?}");
        assert!((30.0..120.0).contains(&all[5]), "{start:?} {all:?}");
    }
}
