//! Small pictures by which a brood is chosen: nearly black ones and look-alikes give way to other draws.
//!
//! Owns what is looked at, which is the same for every lineage, so that a brood is a function of its request alone, and
//! when two materials count as looking alike. Refuses to know how draws are made.

use std::sync::OnceLock;

use brood_program::{BroodRequest, Child, Judge, Program, settle_judged};
use brood_scene::{BuiltinMesh, Exposure, Mesh, SampleSet, Sampling, Scene};
use rayon::prelude::*;

use crate::{CanonicalEvaluator, Evaluator, Gain, develop_samples};

/// Side of a preview: its lit samples fit one block of the evaluators.
const SIZE_PX: u32 = 19;
/// Mean difference in codes of 255 from which two previews are unlike enough: FLIP between larger pictures is then 0.05 or
/// more for 19 of 20 (`brood bench brood`).
const UNLIKE_CODES: f32 = 7.0;
/// A pixel below this code in every channel is dark ...
const DARK_CODE: u8 = 20;
/// ... and with less than this share of the others a picture is as good as black.
const BRIGHT_SHARE: f32 = 0.06;

/// A sphere under the default light, one ray a pixel.
fn samples() -> &'static SampleSet {
    static SAMPLES: OnceLock<SampleSet> = OnceLock::new();
    SAMPLES.get().unwrap_or_else(|| {
        // Not inside `get_or_init`: a thread that waits for its share of the rendering may be given a task that asks for the
        // same set, and would wait for itself. Rendering twice does no harm.
        let mesh = Mesh::builtin(BuiltinMesh::Sphere);
        let set = SampleSet::render(&mesh, &Scene::default(), SIZE_PX, Sampling::Fixed(1));
        SAMPLES.get_or_init(|| set)
    })
}

/// What is seen of a program: its colours where the object is, developed at automatic exposure.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    codes: Vec<[u8; 3]>,
    bright_share: f32,
}

/// Looks at previews.
#[derive(Debug, Clone, Copy, Default)]
pub struct Previewer;

impl Look {
    /// Of a program.
    #[must_use]
    pub fn of(program: &Program) -> Self {
        let set = samples();
        let mut f = Vec::new();
        CanonicalEvaluator::default()
            .eval(&[program], set, &mut f)
            .expect("memory for a few hundred samples");
        let picture = develop_samples(set, &f, Gain::new(Exposure::Auto, set, &f));
        let pixels = picture.rgba.as_chunks::<4>().0.iter();
        let codes: Vec<[u8; 3]> =
            pixels.filter(|[.., alpha]| *alpha > 0).map(|[r, g, b, _]| [*r, *g, *b]).collect();
        let bright = codes.iter().filter(|pixel| pixel.iter().any(|code| *code >= DARK_CODE));
        let bright_share = bright.count() as f32 / codes.len() as f32;
        Self { codes, bright_share }
    }

    /// Whether nearly nothing is to be seen.
    #[must_use]
    pub fn is_black(&self) -> bool {
        self.bright_share < BRIGHT_SHARE
    }

    /// Mean difference in codes over pixels and channels.
    #[must_use]
    pub fn apart(&self, other: &Self) -> f32 {
        let pairs = self.codes.as_flattened().iter().zip(other.codes.as_flattened());
        let sum: u32 = pairs.map(|(a, b)| u32::from(a.abs_diff(*b))).sum();
        // Both are of the same samples.
        sum as f32 / (3 * self.codes.len()) as f32
    }
}

impl Judge for Previewer {
    type Look = Look;

    fn look(&self, program: &Program) -> Look {
        Look::of(program)
    }

    /// How far it is from the nearest look that was taken, 1 where that is far enough; black ones are worth less than nothing,
    /// the darker the less.
    fn worth(&self, look: &Look, taken: &[Look]) -> f32 {
        if look.is_black() {
            return look.bright_share - BRIGHT_SHARE;
        }
        let nearest = taken.iter().map(|other| look.apart(other)).fold(f32::INFINITY, f32::min);
        (nearest / UNLIKE_CODES).min(1.0)
    }
}

/// Breeds the children of a request so that no two of them, and none and its parents, look alike, as far as that many draws
/// give it; a pure function of the request.
#[must_use]
pub fn diverse_brood(request: &BroodRequest<'_>) -> Vec<Child> {
    let first = |slot| {
        let draw = request.draw(slot);
        let look = Look::of(draw.program());
        (draw, look)
    };
    settle_judged(request, (0..request.count).into_par_iter().map(first).collect(), &Previewer)
}

#[cfg(test)]
mod tests {
    use brood_genome::{BirthKey, Dialect, Genome, Variation};

    use super::*;

    fn parent() -> Genome {
        Variation::random(Dialect::default()).birth(BirthKey { seed: 2, slot: 0, attempt: 0 })
    }

    fn program(text: &str) -> Program {
        let head = "brood 1\n.dialect paper smooth registers 7\n";
        Program::lower(&format!("{head}{text}").parse::<Genome>().unwrap())
    }

    #[test]
    fn children_are_unlike_their_parent_and_each_other() {
        let parent = parent();
        for (mutation, least) in [(0.1, 14), (0.3, 18), (0.8, 18)] {
            let variation = Variation::mutate(&parent, mutation);
            let request = BroodRequest { variation, count: 20, seed: 7, distinct: true };
            let brood = diverse_brood(&request);
            let mut looks = vec![Look::of(&Program::lower(&parent))];
            looks.extend(brood.iter().map(|child| Look::of(&child.program)));
            let unlike = |one: usize| {
                let others = looks.iter().enumerate().filter(|(other, _)| *other != one);
                others.into_iter().all(|(_, other)| looks[one].apart(other) >= UNLIKE_CODES)
            };
            let count = (1..looks.len()).filter(|one| unlike(*one)).count();
            assert!(count >= least, "{count} at {mutation}");
            assert!(looks[1..].iter().all(|look| !look.is_black()));
        }
    }

    #[test]
    fn brood_is_the_same_on_any_number_of_threads_and_the_beginning_of_a_larger_one() {
        let parent = parent();
        let variation = Variation::mutate(&parent, 0.2);
        let request = BroodRequest { variation, count: 20, seed: 3, distinct: true };
        let hashes = |count| -> Vec<_> {
            let brood = diverse_brood(&BroodRequest { count, ..request });
            brood.into_iter().map(|child| (child.hash, child.attempts)).collect()
        };
        let whole = hashes(20);
        assert_eq!(hashes(6), whole[..6]);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(pool.install(|| hashes(20)), whole);
        let again = |(slot, (hash, attempts)): (usize, &(_, u32))| {
            let key = BirthKey { seed: 3, slot: slot as u32, attempt: attempts - 1 };
            assert_eq!(variation.birth(key).hash(), *hash, "attempts name the draw that was taken");
        };
        whole.iter().enumerate().for_each(again);
    }

    #[test]
    fn black_is_told_from_dark_materials_with_something_to_see() {
        assert!(Look::of(&program("SUB R0, R0, R0\n")).is_black());
        assert!(!Look::of(&program("MOV R0, R0\n")).is_black());
        let scaled = program(".const C0 0.001 0 0 0\nMUL R0, R0, C0.x\n");
        assert!(!Look::of(&scaled).is_black(), "exposure brings it up");
    }
}
