//! Previews: small pictures by which broods are made diverse. A draw is a candidate for a child;
//! nearly black draws, flat painted ones and draws that look alike are replaced by other draws.
//!
//! This module owns the preview scene and the thresholds. The scene is the same for every lineage,
//! so that a brood is a function of its request alone. The module does not depend on how draws are
//! made.

use std::sync::OnceLock;

use brood_genome::oklab::Oklab;
use brood_light::LightAssets;
use brood_mesh::{BuiltinMesh, Mesh};
use brood_program::{BroodRequest, Child, DrawScorer, Program, settle_scored};
use brood_scene::{Exposure, PixelArea, Raster, SampleSet, Sampling, Scene, Stage};
use rayon::prelude::*;

use crate::reflected::ReflectedLevels;
use crate::{CanonicalEvaluator, Evaluator, Gain, develop_colors, develop_samples, texture_bumps};

/// Side of a preview; its lit samples fit into one block of the evaluators.
const SIZE_PX: u32 = 19;
/// Smallest mean difference, in codes of 255, of two previews that look different: FLIP between
/// larger pictures is then at least 0.05 for 19 of 20 pairs (`brood bench brood`).
const UNLIKE_CODES: f32 = 7.0;
/// A pixel with every channel below this code is dark.
const DARK_CODE: u8 = 20;
/// A preview with a smaller share of pixels that are not dark counts as black.
const BRIGHT_SHARE: f32 = 0.06;

/// A painted preview with a smaller range of lightness in Oklab, from the 5 % to the 95 % quantile,
/// does not show the shape. Larger pictures of the others have a range of 0.25 or more.
const SHAPE_RANGE: f32 = 0.3;
/// As [`UNLIKE_CODES`], for painted materials: 7 codes in larger pictures.
const UNLIKE_PAINTED_CODES: f32 = 8.5;

/// Returns the sphere of the preview scene.
fn sphere() -> &'static Mesh {
    static SPHERE: OnceLock<Mesh> = OnceLock::new();
    SPHERE.get().unwrap_or_else(|| {
        // Not inside `get_or_init`: making a mesh uses rayon, and a thread that waits for its part
        // may run another task that needs the same mesh, which would deadlock. Making it twice is
        // harmless.
        let mesh = Mesh::builtin(BuiltinMesh::Sphere);
        SPHERE.get_or_init(|| mesh)
    })
}

/// Returns the samples of the preview scene: a sphere under the default light, one ray per pixel.
fn samples() -> &'static SampleSet {
    static SAMPLES: OnceLock<SampleSet> = OnceLock::new();
    SAMPLES.get().unwrap_or_else(|| {
        // Not inside `get_or_init`, as above.
        let set = SampleSet::render(sphere(), &Scene::default(), SIZE_PX, Sampling::Fixed(1));
        SAMPLES.get_or_init(|| set)
    })
}

/// Returns the samples of the preview scene with the bumps of a program; `None` without.
fn bumped_samples(program: &Program) -> Option<SampleSet> {
    let bumps = texture_bumps(program)?;
    let stage = Stage::from(sphere()).with_bumps(Some(bumps));
    Some(SampleSet::render_with_assets(
        stage,
        &Scene::default(),
        &LightAssets::default(),
        Raster {
            size_px: SIZE_PX.into(),
            sampling: Sampling::Fixed(1),
            area: PixelArea::whole(SIZE_PX),
        },
    ))
}

/// Returns the points of the preview scene, for painted materials.
fn points() -> &'static SampleSet {
    static POINTS: OnceLock<SampleSet> = OnceLock::new();
    POINTS.get().unwrap_or_else(|| {
        // Not inside `get_or_init`, as above.
        let (sampling, area) = (Sampling::Fixed(1), PixelArea::whole(SIZE_PX));
        let raster = Raster { size_px: SIZE_PX.into(), sampling, area };
        let set =
            SampleSet::render_points(sphere(), &Scene::default(), &LightAssets::default(), raster);
        POINTS.get_or_init(|| set)
    })
}

/// A preview of a program: the colours of the pixels that the object covers, at automatic exposure.
#[derive(Debug, Clone, PartialEq)]
pub struct Preview {
    /// Red, green and blue of each covered pixel in sRGB codes.
    codes: Vec<[u8; 3]>,
    /// Share of these pixels that are not dark.
    bright_share: f32,
    /// Range of lightness by which a painted material shows the shape; `None` for a BRDF.
    shape_range: Option<f32>,
}

/// Scores draws by their previews.
#[derive(Debug, Clone, Copy, Default)]
pub struct PreviewScorer;

impl Preview {
    /// Renders the preview of a program.
    #[must_use]
    pub fn of(program: &Program) -> Self {
        const MEMORY: &str = "memory for a few hundred samples";
        let is_painted = program.is_painted();
        let evaluator = CanonicalEvaluator::default();
        let reflected = program.brdf().filter(|_| is_painted).map(|brdf| {
            let reflected =
                ReflectedLevels::of_samples(&evaluator, &brdf, samples()).expect(MEMORY);
            reflected.on(points())
        });
        let bumped = bumped_samples(program);
        let set = match reflected.as_ref().or(bumped.as_ref()) {
            Some(set) => set,
            None if is_painted => points(),
            None => samples(),
        };
        let mut f = Vec::new();
        evaluator.eval(&[program], set, &mut f).expect(MEMORY);
        let picture = match is_painted {
            true => develop_colors(set, &f),
            false => develop_samples(set, &f, Gain::new(Exposure::Auto, set, &f)),
        };
        let pixels = picture.rgba.as_chunks::<4>().0.iter();
        let codes: Vec<[u8; 3]> =
            pixels.filter(|[.., alpha]| *alpha > 0).map(|[r, g, b, _]| [*r, *g, *b]).collect();
        let bright = codes.iter().filter(|pixel| pixel.iter().any(|code| *code >= DARK_CODE));
        let bright_share = bright.count() as f32 / codes.len() as f32;
        let shape_range = is_painted.then(|| lightness_range(&codes));
        Self { codes, bright_share, shape_range }
    }

    /// True if the preview is nearly black.
    #[must_use]
    pub fn is_black(&self) -> bool {
        self.bright_share < BRIGHT_SHARE
    }

    /// Returns the mean difference in codes over pixels and channels.
    #[must_use]
    pub fn apart(&self, other: &Self) -> f32 {
        let pairs = self.codes.as_flattened().iter().zip(other.codes.as_flattened());
        let sum: u32 = pairs.map(|(a, b)| u32::from(a.abs_diff(*b))).sum();
        // Both previews have the same samples.
        sum as f32 / (3 * self.codes.len()) as f32
    }

    /// Returns the distance to the nearest of other previews, relative to `UNLIKE_CODES` and at
    /// most 1.
    pub(crate) fn newness<'a>(&self, others: impl Iterator<Item = &'a Self>) -> f32 {
        let nearest = others.map(|other| self.apart(other)).fold(f32::INFINITY, f32::min);
        let unlike = if self.shape_range.is_some() { UNLIKE_PAINTED_CODES } else { UNLIKE_CODES };
        (nearest / unlike).min(1.0)
    }
}

/// Range of lightness in Oklab from the 5 % to the 95 % quantile.
fn lightness_range(codes: &[[u8; 3]]) -> f32 {
    let lightness = codes.iter().map(|codes| Oklab::of_codes(*codes).lightness);
    let mut lightness: Vec<f64> = lightness.collect();
    lightness.sort_by(f64::total_cmp);
    let last = lightness.len() - 1;
    (lightness[last - last / 20] - lightness[last / 20]) as f32
}

impl DrawScorer for PreviewScorer {
    type Features = Preview;

    fn features(&self, program: &Program) -> Preview {
        Preview::of(program)
    }

    /// Returns the distance to the nearest preview that was taken, relative to `UNLIKE_CODES` and
    /// at most 1. Black and flat previews score below 0, darker and flatter ones lower.
    fn score(&self, look: &Preview, taken: &[Preview]) -> f32 {
        if look.is_black() {
            return look.bright_share - BRIGHT_SHARE;
        }
        if let Some(range) = look.shape_range.filter(|range| *range < SHAPE_RANGE) {
            return range - SHAPE_RANGE;
        }
        look.newness(taken.iter())
    }
}

/// Breeds the children of a request so that no child looks like another one or a parent, as far as
/// the redraws allow; a pure function of the request.
#[must_use]
pub fn diverse_brood(request: &BroodRequest<'_>) -> Vec<Child> {
    let first = |slot| {
        let draw = request.draw(slot);
        let look = Preview::of(draw.program());
        (draw, look)
    };
    settle_scored(request, (0..request.count).into_par_iter().map(first).collect(), &PreviewScorer)
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
    fn children_differ_visibly_from_their_parent_and_each_other() {
        let parent = parent();
        for (mutation, least) in [(0.1, 14), (0.3, 18), (0.8, 18)] {
            let variation = Variation::mutate(&parent, mutation);
            let request = BroodRequest { variation, count: 20, seed: 7, distinct: true };
            let brood = diverse_brood(&request);
            let mut looks = vec![Preview::of(&Program::lower(&parent))];
            looks.extend(brood.iter().map(|child| Preview::of(&child.program)));
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
    fn bumps_are_seen() {
        let clay = "brood 1\n.model lambert\n";
        let waves = "brood 1\n.model lambert\n.bump const C0 60 0 0.02 0\n\
                     .bump MUL R1, R0, C0\n.bump SIN R1, R1.x\n.bump MUL R0, R1, C0.z\n";
        let [clay, waves] = [clay, waves]
            .map(|text| Preview::of(&Program::lower(&text.parse::<Genome>().unwrap())));
        assert!(clay.apart(&waves) > UNLIKE_CODES);
        assert!(!waves.is_black());
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
    fn dark_material_with_visible_detail_is_not_black() {
        assert!(Preview::of(&program("SUB R0, R0, R0\n")).is_black());
        assert!(!Preview::of(&program("MOV R0, R0\n")).is_black());
        let scaled = program(".const C0 0.001 0 0 0\nMUL R0, R0, C0.x\n");
        assert!(!Preview::of(&scaled).is_black(), "automatic exposure makes it visible");
    }

    #[test]
    fn children_of_painted_materials_show_the_shape_and_differ() {
        let start = brood_genome::Start::Painted;
        let random = Variation::random(start.dialect()).with_start(start);
        for seed in 0..4 {
            let parent = random.birth(BirthKey { seed, slot: 0, attempt: 0 });
            let variation = Variation::mutate(&parent, 0.3).with_start(start);
            let request = BroodRequest { variation, count: 20, seed, distinct: true };
            let looks = diverse_brood(&request);
            let looks: Vec<Preview> =
                looks.iter().map(|child| Preview::of(&child.program)).collect();
            let is_useful = |at: &usize| {
                let others = looks.iter().enumerate().filter(|(other, _)| other != at);
                looks[*at].shape_range.is_some_and(|range| range >= SHAPE_RANGE)
                    && looks[*at].newness(others.map(|(_, other)| other)) >= 1.0
            };
            let useful = (0..looks.len()).filter(is_useful).count();
            assert!(useful >= 18, "{useful} of 20 with seed {seed} from\n{parent}");
        }
    }
}
