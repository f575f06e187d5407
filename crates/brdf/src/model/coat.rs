//! What a rough boundary lets through and what it sends back: tables over the cosine of the light, by quadrature over the normals
//! of the facets that are seen. One loop without a branch, which many lanes run through together.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::fresnel;
use super::microfacet::{Distribution, Facets};
use super::parameter::Values;
use crate::block::larger;
use crate::{Elementary, Loop, Machine};

/// Cosines that transmittance is tabled for, from 0 to 1.
pub(super) const TABLED: usize = 64;
/// Columns of the quadrature that are summed side by side.
const LANES: usize = 8;
/// Points of the quadrature over the facets' normals, along each of two axes; a multiple of the lanes.
const POINTS: usize = 5 * LANES;
/// The same where it need not be exact.
const COARSE_POINTS: usize = LANES;

/// What takes long to prepare of a coat: what passes it, and what it sends back from inside. The same for all colours of what lies
/// below.
#[derive(Debug, Clone, PartialEq)]
pub struct CoatTables {
    /// The share of the light at each tabled cosine that passes from outside.
    pub(super) passes: [f64; TABLED],
    /// Twice the cosine times the share that is sent back from inside: their sum, and the last.
    pub(super) back: (f64, f64),
}

/// How finely tables are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TableDetail {
    /// As models are defined.
    Full,
    /// In a twenty-fifth of the time, off by some thousandths: for derivatives, and to come near.
    Coarse,
}

impl CoatTables {
    pub(super) fn new(machine: impl Machine, values: Values<'_>, detail: TableDetail) -> Self {
        let alpha = values.scalar("roughness");
        let boundary = Boundary {
            distribution: Distribution::named(values.choice("distribution"), DVec2::splat(alpha)),
            alpha,
            eta: values.scalar("ior"),
        };
        let points = match detail {
            TableDetail::Full => POINTS,
            TableDetail::Coarse => COARSE_POINTS,
        };
        let shares = boundary.shares(machine, &Grid::new(&boundary, points), &cosines());
        let inside = |k: usize| 2.0 * cosine(k) * shares[k].back;
        Self {
            passes: std::array::from_fn(|k| shares[k].through),
            back: ((0..TABLED).map(inside).sum(), inside(TABLED - 1)),
        }
    }
}

/// The tabled cosines; the first is not quite at the horizon.
fn cosines() -> [f64; TABLED] {
    std::array::from_fn(cosine)
}

fn cosine(k: usize) -> f64 {
    (k as f64 / (TABLED - 1) as f64).max(1e-6)
}

/// A rough boundary to a medium of relative index `eta`.
#[derive(Debug, Clone, Copy)]
struct Boundary {
    distribution: Distribution,
    alpha: f64,
    eta: f64,
}

/// Of the light from one direction.
#[derive(Debug, Clone, Copy, Default)]
struct Shares {
    /// What comes through from outside.
    through: f64,
    /// What is sent back from inside.
    back: f64,
}

/// Points of the quadrature: facets' normals, drawn as they are distributed.
struct Grid {
    rows: Vec<Row>,
    /// Around half of the circle; the other half is the same mirrored.
    columns: Vec<Columns>,
}

/// Normals at one height.
struct Row {
    /// Distance of the normal from the axis, and height.
    r: f64,
    z: f64,
    /// Of each point, over the height.
    weight: f64,
}

struct Columns {
    cos: [f64; LANES],
    sin: [f64; LANES],
}

impl Grid {
    /// So many rows, and as many columns; a multiple of the lanes.
    fn new(boundary: &Boundary, points: usize) -> Self {
        let alpha2 = boundary.alpha * boundary.alpha;
        let row = |row: usize| {
            let left = 1.0 - (row as f64 + 0.5) / points as f64;
            // What a grazing view sees is far out in GGX's tail: by this substitution rows stand closer there.
            let rest = left * left * left;
            let density = 3.0 * left * left;
            let tan2 = match boundary.distribution {
                Distribution::Beckmann(_) => -alpha2 * libm::log(rest),
                _ => alpha2 * (1.0 - rest) / rest,
            };
            let z = 1.0 / (1.0 + tan2).sqrt();
            let r = (1.0 - z * z).max(0.0).sqrt();
            Row { r, z, weight: density / (z * (points * points) as f64) }
        };
        let turn = |column: usize| 0.5 * TAU * (column as f64 + 0.5) / points as f64;
        let columns = |first: usize| Columns {
            cos: std::array::from_fn(|k| libm::cos(turn(first + k))),
            sin: std::array::from_fn(|k| libm::sin(turn(first + k))),
        };
        Self {
            rows: (0..points).map(row).collect(),
            columns: (0..points).step_by(LANES).map(columns).collect(),
        }
    }
}

impl Boundary {
    /// Of light at each of the cosines.
    fn shares<const N: usize>(
        &self,
        machine: impl Machine,
        grid: &Grid,
        cosines: &[f64; N],
    ) -> [Shares; N] {
        match self.distribution {
            Distribution::Ggx(facets) => self.shares_of(machine, grid, (facets, cosines)),
            Distribution::Beckmann(facets) => self.shares_of(machine, grid, (facets, cosines)),
            Distribution::Gaussian(facets) => self.shares_of(machine, grid, (facets, cosines)),
            Distribution::Blinn(facets) => self.shares_of(machine, grid, (facets, cosines)),
        }
    }

    fn shares_of<const N: usize>(
        &self,
        machine: impl Machine,
        grid: &Grid,
        (facets, cosines): (impl Facets, &[f64; N]),
    ) -> [Shares; N] {
        machine.run(Integrals { eta: self.eta, facets, grid, cosines })
    }
}

/// The means over the grid, light being at each of the cosines.
struct Integrals<'a, S, const N: usize> {
    eta: f64,
    facets: S,
    grid: &'a Grid,
    cosines: &'a [f64; N],
}

impl<S: Facets, const N: usize> Loop for Integrals<'_, S, N> {
    type Values = [Shares; N];

    #[inline(always)]
    fn run<F: Elementary>(self) -> [Shares; N] {
        let (outside, inside) = (Side::new(self.eta), Side::new(1.0 / self.eta));
        let mut all = [Shares::default(); N];
        for (shares, cosine) in all.iter_mut().zip(self.cosines) {
            let wi = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, *cosine);
            // Of the facets that are seen from wi.
            let seen = 1.0 / self.facets.unmasked::<F>(wi);
            let (mut through, mut back) = ([0.0; LANES], [0.0; LANES]);
            for row in &self.grid.rows {
                let weight = row.weight * seen;
                for columns in &self.grid.columns {
                    for k in 0..LANES {
                        let m = DVec3::new(row.r * columns.cos[k], row.r * columns.sin[k], row.z);
                        let c = larger(wi.x * m.x + wi.z * m.z, 0.0);
                        let weight = weight * c;
                        through[k] += weight * outside.refracted::<F>(&self.facets, wi, m, c);
                        back[k] += weight * inside.reflected::<F>(&self.facets, wi, m, c);
                    }
                }
            }
            *shares = Shares { through: through.iter().sum(), back: back.iter().sum() };
        }
        all
    }
}

/// The boundary as it is met from one side.
struct Side {
    eta: f64,
    inverse: f64,
}

impl Side {
    #[inline(always)]
    fn new(eta: f64) -> Self {
        Self { eta, inverse: 1.0 / eta }
    }

    /// What of the light from wi a facet lets through, as far as other facets do not hide it below.
    #[inline(always)]
    fn refracted<F: Elementary>(&self, facets: &impl Facets, wi: DVec3, m: DVec3, c: f64) -> f64 {
        let fresnel = fresnel::Quotient::of(self.eta, c);
        let along = c * self.inverse - fresnel.cos_t;
        let x = m.x * along - wi.x * self.inverse;
        let y = m.y * along;
        let z = wi.z * self.inverse - m.z * along;
        let below = DVec3::new(x, y, larger(z, f64::MIN_POSITIVE));
        let left = fresnel.denominator - fresnel.numerator;
        let share = left * z / (fresnel.denominator * facets.unmasked::<F>(below));
        if z > 0.0 && !fresnel.is_total { share } else { 0.0 }
    }

    /// What a facet sends back, as far as other facets do not hide it.
    #[inline(always)]
    fn reflected<F: Elementary>(&self, facets: &impl Facets, wi: DVec3, m: DVec3, c: f64) -> f64 {
        let fresnel = fresnel::Quotient::of(self.eta, c);
        let mirrored = m * (2.0 * c) - wi;
        let z = mirrored.z;
        let mirrored = DVec3::new(mirrored.x, mirrored.y, larger(z, f64::MIN_POSITIVE));
        let unmasked = facets.unmasked::<F>(mirrored);
        let partly = fresnel.numerator * z / (fresnel.denominator * unmasked);
        let share = if fresnel.is_total { z / unmasked } else { partly };
        if z > 0.0 { share } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Branchless, Libm, Plain};

    fn boundary(word: &str, alpha: f64) -> Boundary {
        let distribution = Distribution::named(word, DVec2::splat(alpha));
        Boundary { distribution, alpha, eta: 1.5 }
    }

    fn shares<const N: usize>(
        boundary: &Boundary,
        points: usize,
        cosines: &[f64; N],
    ) -> [Shares; N] {
        boundary.shares(Plain::<Branchless>::new(), &Grid::new(boundary, points), cosines)
    }

    /// As it is defined: the light's direction, the facets, the directions that it takes, one after the other.
    fn plainly(boundary: &Boundary, points: usize, cosine: f64) -> Shares {
        let Boundary { distribution, eta, .. } = *boundary;
        let grid = Grid::new(boundary, points);
        let wi = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
        let seen = |w: DVec3| distribution.masking::<Libm>(w) * w.z;
        let mut sum = Shares::default();
        for row in &grid.rows {
            for columns in &grid.columns {
                for (cos, sin) in columns.cos.iter().zip(columns.sin) {
                    let m = DVec3::new(row.r * cos, row.r * sin, row.z);
                    let c = wi.dot(m);
                    if c <= 0.0 {
                        continue;
                    }
                    let weight = row.weight * distribution.masking::<Libm>(wi) * c;
                    let cos_t = (1.0 - (1.0 - c * c) / (eta * eta)).max(0.0).sqrt();
                    let refracted = m * (c / eta - cos_t) - wi / eta;
                    if refracted.z < 0.0 {
                        let below = DVec3::new(refracted.x, refracted.y, -refracted.z);
                        sum.through += weight * (1.0 - fresnel::dielectric(eta, c)) * seen(below);
                    }
                    let mirrored = m * (2.0 * c) - wi;
                    if mirrored.z > 0.0 {
                        sum.back += weight * fresnel::dielectric(1.0 / eta, c) * seen(mirrored);
                    }
                }
            }
        }
        sum
    }

    #[test]
    fn lanes_sum_up_what_is_defined() {
        for word in ["ggx", "beckmann"] {
            for alpha in [0.02, 0.3, 1.0] {
                let boundary = boundary(word, alpha);
                for cosine in [1e-6, 0.1, 0.6, 1.0] {
                    let [lanes] = shares(&boundary, POINTS, &[cosine]);
                    let plain = plainly(&boundary, POINTS, cosine);
                    assert!((lanes.through - plain.through).abs() < 1e-12, "{word} {alpha}");
                    assert!((lanes.back - plain.back).abs() < 1e-12, "{word} {alpha} {cosine}");
                }
            }
        }
    }

    #[test]
    fn what_passes_is_that_of_many_more_normals() {
        for word in ["ggx", "beckmann"] {
            for alpha in [0.02, 0.1, 0.3, 0.8] {
                let boundary = boundary(word, alpha);
                let cosines = [1e-6, 0.05, 0.2, 0.5, 1.0];
                let few = shares(&boundary, POINTS, &cosines);
                let many = shares(&boundary, 1000, &cosines);
                for ((few, many), cosine) in few.iter().zip(many).zip(cosines) {
                    let off = (few.through - many.through).abs();
                    assert!(off < 1.5e-3, "{word} {alpha} {cosine}: {off}");
                }
            }
        }
    }

    #[test]
    fn what_comes_back_over_the_hemisphere_is_that_of_many_more_normals() {
        for alpha in [0.02, 0.1, 0.3, 0.8] {
            let boundary = boundary("ggx", alpha);
            let of = |points| {
                let shares = shares(&boundary, points, &cosines());
                shares.iter().zip(cosines()).map(|(s, cosine)| cosine * s.back).sum::<f64>() / 32.0
            };
            let off = (of(POINTS) - of(304)).abs();
            assert!(off < 1e-3, "{alpha}: {off}");
        }
    }
}
