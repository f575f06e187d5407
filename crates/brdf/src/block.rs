//! Blocks of direction pairs (structure of arrays) and loops over their lanes.
//!
//! A lane is one pair of a [`Block`]. The block holds the half vectors and their cosines, computed
//! once for all models that evaluate it. A [`Loop`] is written once for any number of lanes; a
//! [`Machine`] chooses the instructions that it is compiled to. This crate has only the plain
//! machine; the ones with SIMD instructions are in `crates/eval/src/level.rs`. Independent of
//! models.

use std::marker::PhantomData;

use glam::DVec3;

use crate::{DirectionPair, Elementary};

/// Least cosine at which a direction counts as above the surface. Keeps all divisors of the models
/// within f64.
pub const HORIZON: f64 = 1e-100;

/// A loop over lanes. No lane depends on another.
pub trait Loop {
    /// The results of all lanes.
    type Values;

    /// Runs the loop with these elementary functions. Implementations must be
    /// `#[inline(always)]`, so that they are compiled with the instructions of the machine that
    /// calls them.
    fn run<F: Elementary>(self) -> Self::Values;
}

/// Runs loops with a set of CPU instructions.
pub trait Machine: Copy {
    /// Runs a loop.
    fn run<L: Loop>(self, work: L) -> L::Values;
}

/// Machine without extra CPU instructions, with elementary functions of choice.
#[derive(Debug, Clone, Copy)]
pub struct Plain<F>(PhantomData<F>);

impl<F> Plain<F> {
    /// Creates the machine.
    #[must_use]
    pub fn new() -> Self {
        Self(PhantomData)
    }
}

impl<F> Default for Plain<F> {
    fn default() -> Self {
        Self::new()
    }
}

impl<F: Elementary + Copy> Machine for Plain<F> {
    #[inline]
    fn run<L: Loop>(self, work: L) -> L::Values {
        work.run::<F>()
    }
}

/// Pairs of directions as a structure of arrays, with their half vectors.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub struct Block<const N: usize> {
    wi: [[f64; N]; 3],
    wo: [[f64; N]; 3],
    h: [[f64; N]; 3],
    cos_d: [f64; N],
    /// 1 where both directions are above the surface, 0 elsewhere.
    lit: [f64; N],
}

/// Quantities that models read of a pair whose directions are both above the surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Half {
    pub(crate) wi: DVec3,
    pub(crate) wo: DVec3,
    /// The half vector h = (wi + wo) / |wi + wo|.
    pub(crate) h: DVec3,
    /// h . wi = h . wo.
    pub(crate) cos_d: f64,
}

impl<const N: usize> Block<N> {
    /// Returns a block to be filled: both directions of each lane are the normal.
    #[must_use]
    pub fn new() -> Self {
        let normal = [[0.0; N], [0.0; N], [1.0; N]];
        Self { wi: normal, wo: normal, h: normal, cos_d: [1.0; N], lit: [0.0; N] }
    }

    /// Fills the block with the first `N` of these pairs. Lanes beyond the last pair reflect
    /// nothing.
    pub fn fill<M: Machine>(&mut self, machine: M, pairs: &[DirectionPair]) {
        machine.run(Fill { block: self, pairs });
    }

    #[inline(always)]
    pub(crate) fn half(&self, k: usize) -> Half {
        let vector = |rows: &[[f64; N]; 3]| DVec3::new(rows[0][k], rows[1][k], rows[2][k]);
        Half {
            wi: vector(&self.wi),
            wo: vector(&self.wo),
            h: vector(&self.h),
            cos_d: self.cos_d[k],
        }
    }

    /// Returns `value` if the lane is lit, otherwise 0.
    #[inline(always)]
    pub(crate) fn where_lit(&self, k: usize, value: f64) -> f64 {
        if self.lit[k] > 0.0 { value } else { 0.0 }
    }
}

impl<const N: usize> Default for Block<N> {
    fn default() -> Self {
        Self::new()
    }
}

struct Fill<'a, const N: usize> {
    block: &'a mut Block<N>,
    pairs: &'a [DirectionPair],
}

impl<const N: usize> Loop for Fill<'_, N> {
    type Values = ();

    #[inline(always)]
    fn run<F: Elementary>(self) {
        let Self { block, pairs } = self;
        let normal = DVec3::Z;
        for k in 0..N {
            let (i, o) = pairs.get(k).map_or((normal, -normal), |pair| (pair.wi(), pair.wo()));
            [block.wi[0][k], block.wi[1][k], block.wi[2][k]] = i.to_array();
            [block.wo[0][k], block.wo[1][k], block.wo[2][k]] = o.to_array();
        }
        for k in 0..N {
            let Half { wi, wo, .. } = block.half(k);
            // Unlit lanes are computed as the normal is; `where_lit` drops the result.
            let is_lit = (wi.z >= HORIZON) & (wo.z >= HORIZON);
            let place = |value: f64, otherwise: f64| if is_lit { value } else { otherwise };
            let vector = |w: DVec3| DVec3::new(place(w.x, 0.0), place(w.y, 0.0), place(w.z, 1.0));
            let half = Half::of(vector(wi), vector(wo));
            [block.wi[0][k], block.wi[1][k], block.wi[2][k]] = half.wi.to_array();
            [block.wo[0][k], block.wo[1][k], block.wo[2][k]] = half.wo.to_array();
            [block.h[0][k], block.h[1][k], block.h[2][k]] = half.h.to_array();
            block.cos_d[k] = half.cos_d;
            block.lit[k] = place(1.0, 0.0);
        }
    }
}

impl Half {
    /// Sums and products of the components commute, so the swapped pair gives the same bits in
    /// all but `wi` and `wo`. |wi + wo| / 2 is sqrt((1 + wi . wo) / 2) without the cancellation
    /// of nearly opposite directions.
    #[inline(always)]
    pub(crate) fn of(wi: DVec3, wo: DVec3) -> Self {
        let sum = wi + wo;
        let length = (sum.x * sum.x + sum.y * sum.y + sum.z * sum.z).sqrt();
        Self { wi, wo, h: sum / length, cos_d: smaller(0.5 * length, 1.0) }
    }

    #[inline(always)]
    pub(crate) fn cos_i(&self) -> f64 {
        self.wi.z
    }

    #[inline(always)]
    pub(crate) fn cos_o(&self) -> f64 {
        self.wo.z
    }

    /// wi . wo
    #[inline(always)]
    pub(crate) fn cos_io(&self) -> f64 {
        self.wi.x * self.wo.x + self.wi.y * self.wo.y + self.wi.z * self.wo.z
    }

    /// The larger of `cos_i` and `cos_o`.
    #[inline(always)]
    pub(crate) fn cos_max(&self) -> f64 {
        larger(self.wi.z, self.wo.z)
    }

    /// sin^2 of the angle between h and the normal.
    #[inline(always)]
    pub(crate) fn sin2(&self) -> f64 {
        self.h.x * self.h.x + self.h.y * self.h.y
    }
}

/// Maximum in one instruction (`f64::max` also checks for NaN). Returns `b` if either is NaN.
#[inline(always)]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Minimum; otherwise as [`larger`].
#[inline(always)]
pub(crate) fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Clamps to [0, 1]. Returns 1 for NaN.
#[inline(always)]
pub(crate) fn unit(x: f64) -> f64 {
    smaller(larger(x, 0.0), 1.0)
}
