//! Blocks of pairs of directions, lane by lane, and loops over them.
//!
//! What models read of a pair (the half vector and its angles) is computed here, once for all models that look at the block.
//! A [`Loop`] is the same for one lane and for many; with which instructions it runs is for a [`Machine`] to know, which
//! this crate does not: it has the plain one alone. It refuses to know models.

use std::marker::PhantomData;

use glam::DVec3;

use crate::{DirectionPair, Elementary};

/// Directions whose cosine is below this are not above the surface: so all that models divide by stays within f64.
pub const HORIZON: f64 = 1e-100;

/// A loop over lanes, each of which is computed by itself.
pub trait Loop {
    /// The values of all lanes.
    type Values;

    /// Runs it with these elementary functions. Implementations are inlined into the function that a machine makes of them.
    fn run<F: Elementary>(self) -> Self::Values;
}

/// What runs loops.
pub trait Machine: Copy {
    /// Runs a loop.
    fn run<L: Loop>(self, work: L) -> L::Values;
}

/// Runs loops as they are, with elementary functions of choice.
#[derive(Debug, Clone, Copy)]
pub struct Plain<F>(PhantomData<F>);

impl<F> Plain<F> {
    /// The machine.
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

/// What models read of a pair whose directions are both above the surface.
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
    /// A block to be filled: both directions of each lane are the normal.
    #[must_use]
    pub fn new() -> Self {
        let normal = [[0.0; N], [0.0; N], [1.0; N]];
        Self { wi: normal, wo: normal, h: normal, cos_d: [1.0; N], lit: [0.0; N] }
    }

    /// Takes the first `N` of these pairs. Lanes beyond the last one reflect nothing.
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

    /// The value where light is reflected, 0 elsewhere.
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
            // What is not lit is computed as the normal is, and thrown away.
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
    /// Sums and products of the components commute, so the pair and the swapped one have the same bits but for `wi` and `wo`
    /// themselves. |wi + wo| / 2 is sqrt((1 + wi . wo) / 2) without the cancellation of nearly opposite directions.
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

    /// The larger of the cosines of both directions.
    #[inline(always)]
    pub(crate) fn cos_most(&self) -> f64 {
        larger(self.wi.z, self.wo.z)
    }

    /// sin^2 of the angle between h and the normal.
    #[inline(always)]
    pub(crate) fn sin2(&self) -> f64 {
        self.h.x * self.h.x + self.h.y * self.h.y
    }
}

/// One instruction, where `f64::max` also looks for NaN. The second where one is NaN.
#[inline(always)]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// As [`larger`].
#[inline(always)]
pub(crate) fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Between 0 and 1; of NaN 1.
#[inline(always)]
pub(crate) fn unit(x: f64) -> f64 {
    smaller(larger(x, 0.0), 1.0)
}
