//! BRDFs that tables are made of: f in batches, its symmetry, and words about it.

use brood_brdf::{Brdf, DirectionPair};
use brood_eval::{energy_limit, is_anisotropic};
use brood_program::Program;
use glam::{DVec2, DVec3};

use crate::model::Layers;
use crate::module::reads_texture;
use crate::reflectance::{even_pairs, reflectance, spread};

/// Largest magnitude of a measured value in tables; far below the end of f32.
const LARGEST: f64 = 1e30;
/// Texture positions over which f is averaged.
const POSITIONS: usize = 16;
/// Pairs at which the symmetry of a measured BRDF is tested, and angles by which they are turned.
const SYMMETRY_PAIRS: usize = 64;
const TURNS: [f64; 3] = [0.7, 1.9, 4.4];
/// Largest change of f cos_i by a turn that keeps f, relative to its mean.
const SYMMETRY_ERROR: f64 = 1e-3;
/// Pairs that are evaluated at once.
const BATCH: usize = 4096;

/// Texture positions over which tables average f of a textured program.
#[must_use]
pub fn mean_positions() -> [DVec2; POSITIONS] {
    std::array::from_fn(spread)
}

/// Turns about the normal that keep f.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Symmetry {
    /// Any turn.
    Isotropic,
    /// Half a turn.
    Half,
    /// None.
    None,
}

/// A BRDF that a table is made of.
pub(crate) struct Source<'a> {
    kind: Kind<'a>,
    symmetry: Symmetry,
    is_reciprocal: bool,
}

enum Kind<'a> {
    /// A program without bumps, and texture positions over which f is averaged.
    Program(&'a Program, Vec<DVec2>),
    Measured(&'a dyn Brdf),
}

impl<'a> Source<'a> {
    /// Takes a program without bumps. Programs and models are unchanged by half a turn.
    pub(crate) fn of_program(program: &'a Program) -> Self {
        let positions =
            if reads_texture(program) { mean_positions().to_vec() } else { vec![DVec2::ZERO] };
        let symmetry = if is_anisotropic(program) { Symmetry::Half } else { Symmetry::Isotropic };
        let is_reciprocal = Layers::of(program.layers()).are_reciprocal();
        Self { kind: Kind::Program(program, positions), symmetry, is_reciprocal }
    }

    /// Takes a measured BRDF. Its symmetry is that of its values.
    pub(crate) fn of_measured(brdf: &'a dyn Brdf) -> Self {
        let is_kept = |angle: f64| {
            let (mut change, mut sum) = (0.0, 0.0);
            for pair in even_pairs(SYMMETRY_PAIRS) {
                let (f, other) = (brdf.f(&pair), brdf.f(&turned(&pair, angle)));
                change += (f - other).abs().element_sum() * pair.cos_i();
                sum += f.abs().element_sum() * pair.cos_i();
            }
            change <= SYMMETRY_ERROR * sum
        };
        let symmetry = match (TURNS.into_iter().all(is_kept), is_kept(std::f64::consts::PI)) {
            (true, _) => Symmetry::Isotropic,
            (false, true) => Symmetry::Half,
            (false, false) => Symmetry::None,
        };
        let is_reciprocal = brdf.claims().reciprocal;
        Self { kind: Kind::Measured(brdf), symmetry, is_reciprocal }
    }

    pub(crate) fn symmetry(&self) -> Symmetry {
        self.symmetry
    }

    /// True if f is the same for exchanged directions.
    pub(crate) fn is_reciprocal(&self) -> bool {
        self.is_reciprocal
    }

    /// f of each pair.
    pub(crate) fn f(&self, pairs: &[DirectionPair]) -> Vec<DVec3> {
        match &self.kind {
            // Numbers of tables have 32 bits.
            Kind::Measured(brdf) => {
                let f = |pair| brdf.f(pair).clamp(DVec3::splat(-LARGEST), DVec3::splat(LARGEST));
                pairs.iter().map(f).collect()
            }
            Kind::Program(program, positions) => pairs
                .chunks(BATCH)
                .flat_map(|pairs| mean_reflectance(program, pairs, positions))
                .collect(),
        }
    }

    /// Words about the BRDF, for people.
    pub(crate) fn words(&self) -> String {
        let Kind::Program(program, positions) = &self.kind else {
            return "measured material, without energy limit".to_owned();
        };
        let bound = energy_limit(program).bound();
        let energy = match bound > 1.0 + 1e-6 {
            true => format!("reflects up to {bound:.4} times the light: the energy limit is off"),
            false => format!("reflects at most {bound:.4} of the light"),
        };
        let texture = match positions.len() {
            1 => String::new(),
            count => format!(", mean of {count} texture positions"),
        };
        format!("program {}, {energy}{texture}", program.hash())
    }
}

fn mean_reflectance(program: &Program, pairs: &[DirectionPair], positions: &[DVec2]) -> Vec<DVec3> {
    let mut sums = vec![DVec3::ZERO; pairs.len()];
    for position in positions {
        let f = reflectance(program, pairs, &vec![*position; pairs.len()]);
        sums.iter_mut().zip(f).for_each(|(sum, f)| *sum += f);
    }
    sums.into_iter().map(|sum| sum / positions.len() as f64).collect()
}

/// The pair after a turn about the normal.
fn turned(pair: &DirectionPair, angle: f64) -> DirectionPair {
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    let turn = |w: DVec3| DVec3::new(cos * w.x - sin * w.y, sin * w.x + cos * w.y, w.z);
    DirectionPair::new(turn(pair.wi()), turn(pair.wo())).expect("the directions have length 1")
}
