//! Transmittance and internal reflectance of a rough dielectric boundary: tables over the cosine of
//! the light, by quadrature over the facet normals that are visible from the light. The loop is
//! branch-free, so that it compiles to vector instructions.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::fresnel;
use super::microfacet::{Distribution, Facets};
use super::parameter::Values;
use crate::block::larger;
use crate::{Elementary, Loop, Machine, gauss_legendre};

/// Number of cosines on either side of the critical angle in the integral of internal reflectance.
const BACK_COSINES: usize = 24;
/// Number of cosines from 0 to 1 in the tables.
pub(super) const TABLE_SIZE: usize = 64;
/// Columns of the quadrature that are summed in parallel.
const LANES: usize = 8;
/// Quadrature points along each of the two axes; a multiple of the lanes.
const POINTS: usize = 5 * LANES;
/// Quadrature points for coarse tables.
const COARSE_POINTS: usize = LANES;

/// The slow part of preparing a coat: its transmittance and internal reflectance. Independent of
/// the colour of the base.
#[derive(Debug, Clone, PartialEq)]
pub struct CoatTables {
    /// Transmittance from outside at each tabulated cosine.
    pub(super) transmittance: [f64; TABLE_SIZE],
    /// Internal reflectance of diffuse light.
    pub(super) back: f64,
}

/// Accuracy of the tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TableDetail {
    /// The accuracy that defines the models.
    Full,
    /// 25 times faster, with an error of some thousandths: for derivatives and first
    /// approximations.
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
        let grid = Grid::new(&boundary, points);
        let shares = boundary.shares(machine, &grid, &cosines());
        let inside = |k: usize| 2.0 * cosine(k) * shares[k].reflected;
        let back = match values.choice("internal") {
            // The mean of the tabulated values, as there.
            "mitsuba" => (0..TABLE_SIZE).map(inside).sum::<f64>() / TABLE_SIZE as f64,
            _ => boundary.back(machine, &grid),
        };
        Self { transmittance: std::array::from_fn(|k| shares[k].transmitted), back }
    }
}

/// The tabulated cosines; the first is slightly above the horizon.
fn cosines() -> [f64; TABLE_SIZE] {
    std::array::from_fn(cosine)
}

fn cosine(k: usize) -> f64 {
    (k as f64 / (TABLE_SIZE - 1) as f64).max(1e-6)
}

/// Rough boundary to a medium of relative index `eta`.
#[derive(Debug, Clone, Copy)]
struct Boundary {
    distribution: Distribution,
    alpha: f64,
    eta: f64,
}

/// Shares of light at one cosine.
#[derive(Debug, Clone, Copy, Default)]
struct Shares {
    /// Share of light from outside that is transmitted.
    transmitted: f64,
    /// Share of light from inside that is reflected back.
    reflected: f64,
}

/// Quadrature points: facet normals. The inverse of the cumulative distribution of D (n . m) places
/// them; steep angles get more points than this distribution gives them.
struct Grid {
    rows: Vec<Row>,
    /// Azimuths from 0 to pi; the other half is symmetric.
    columns: Vec<Columns>,
}

/// Normals at one height.
struct Row {
    /// Distance of the normal from the axis, and its height.
    r: f64,
    z: f64,
    /// Weight of each point. Divided by `z`, so that sums over the points integrate with D, not
    /// D (n . m).
    weight: f64,
}

/// Azimuths of `LANES` normals of a row.
struct Columns {
    cos: [f64; LANES],
    sin: [f64; LANES],
}

impl Grid {
    /// `points` rows by `points` columns; `points` must be a multiple of the lanes.
    fn new(boundary: &Boundary, points: usize) -> Self {
        let alpha2 = boundary.alpha * boundary.alpha;
        let row = |row: usize| {
            let left = 1.0 - (row as f64 + 0.5) / points as f64;
            // Grazing views see the far tail of GGX; this substitution samples it more
            // densely.
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
    /// Integrates for light at each of the cosines.
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

    /// Internal reflectance of diffuse light: the integral over the cosine mu of 2 mu times the
    /// share reflected, split at the critical angle of a smooth boundary, where the share has a
    /// square root.
    ///
    /// # Error
    /// Below 1e-3 of 1 - R, which divides the diffuse part of f, against 2048 cosines with the same
    /// normals, at indices from 1.01 to 3 and roughness from 1e-4 to 1
    /// (`internal_reflectance_is_exact_at_every_index_and_roughness`).
    fn back(&self, machine: impl Machine, grid: &Grid) -> f64 {
        let critical = (1.0 - 1.0 / (self.eta * self.eta)).max(0.0).sqrt();
        let nodes = gauss_legendre(BACK_COSINES);
        // The integral from the critical cosine to an end, with nodes denser towards the former.
        let towards = |end: f64| {
            let along = end - critical;
            let cosines: [f64; BACK_COSINES] =
                std::array::from_fn(|k| (critical + along * nodes[k].0 * nodes[k].0).max(1e-6));
            let shares = self.shares(machine, grid, &cosines);
            let terms = nodes.iter().zip(cosines).zip(shares);
            let term = |(((t, weight), cosine), shares): ((&(f64, f64), f64), Shares)| {
                2.0 * cosine * shares.reflected * weight * 2.0 * t
            };
            along.abs() * terms.map(term).sum::<f64>()
        };
        towards(0.0) + towards(1.0)
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

/// Sums over the grid for light at each of the cosines.
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
            // Normalises to the facets that are visible from wi: their density is
            // D G1 (wi . m) / cos_i.
            let seen = 1.0 / self.facets.cos_over_g1::<F>(wi);
            let (mut transmitted, mut reflected) = ([0.0; LANES], [0.0; LANES]);
            for row in &self.grid.rows {
                let weight = row.weight * seen;
                for columns in &self.grid.columns {
                    for k in 0..LANES {
                        let m = DVec3::new(row.r * columns.cos[k], row.r * columns.sin[k], row.z);
                        let c = larger(wi.x * m.x + wi.z * m.z, 0.0);
                        let weight = weight * c;
                        transmitted[k] += weight * outside.refracted::<F>(&self.facets, wi, m, c);
                        reflected[k] += weight * inside.reflected::<F>(&self.facets, wi, m, c);
                    }
                }
            }
            *shares =
                Shares { transmitted: transmitted.iter().sum(), reflected: reflected.iter().sum() };
        }
        all
    }
}

/// The boundary as seen from one side. `m` is the normal of a facet and c = wi . m.
struct Side {
    /// Refractive index of the other side relative to this one.
    eta: f64,
    inverse: f64,
}

impl Side {
    #[inline(always)]
    fn new(eta: f64) -> Self {
        Self { eta, inverse: 1.0 / eta }
    }

    /// Share of the light from `wi` that a facet transmits and other facets do not mask below.
    #[inline(always)]
    fn refracted<F: Elementary>(&self, facets: &impl Facets, wi: DVec3, m: DVec3, c: f64) -> f64 {
        let fresnel = fresnel::ReflectanceFraction::of(self.eta, c);
        let along = c * self.inverse - fresnel.cos_t;
        let x = m.x * along - wi.x * self.inverse;
        let y = m.y * along;
        let z = wi.z * self.inverse - m.z * along;
        let below = DVec3::new(x, y, larger(z, f64::MIN_POSITIVE));
        let left = fresnel.denominator - fresnel.numerator;
        let share = left * z / (fresnel.denominator * facets.cos_over_g1::<F>(below));
        if z > 0.0 && !fresnel.is_total { share } else { 0.0 }
    }

    /// Share of the light from `wi` that a facet reflects and other facets do not mask.
    #[inline(always)]
    fn reflected<F: Elementary>(&self, facets: &impl Facets, wi: DVec3, m: DVec3, c: f64) -> f64 {
        let fresnel = fresnel::ReflectanceFraction::of(self.eta, c);
        let mirrored = m * (2.0 * c) - wi;
        let z = mirrored.z;
        let mirrored = DVec3::new(mirrored.x, mirrored.y, larger(z, f64::MIN_POSITIVE));
        let unmasked = facets.cos_over_g1::<F>(mirrored);
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

    /// Reference by the definition, point by point.
    fn reference_shares(boundary: &Boundary, points: usize, cosine: f64) -> Shares {
        let Boundary { distribution, eta, .. } = *boundary;
        let grid = Grid::new(boundary, points);
        let wi = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
        let seen = |w: DVec3| distribution.g1_over_cos::<Libm>(w) * w.z;
        let mut sum = Shares::default();
        for row in &grid.rows {
            for columns in &grid.columns {
                for (cos, sin) in columns.cos.iter().zip(columns.sin) {
                    let m = DVec3::new(row.r * cos, row.r * sin, row.z);
                    let c = wi.dot(m);
                    if c <= 0.0 {
                        continue;
                    }
                    let weight = row.weight * distribution.g1_over_cos::<Libm>(wi) * c;
                    let cos_t = (1.0 - (1.0 - c * c) / (eta * eta)).max(0.0).sqrt();
                    let refracted = m * (c / eta - cos_t) - wi / eta;
                    if refracted.z < 0.0 {
                        let below = DVec3::new(refracted.x, refracted.y, -refracted.z);
                        sum.transmitted +=
                            weight * (1.0 - fresnel::dielectric(eta, c)) * seen(below);
                    }
                    let mirrored = m * (2.0 * c) - wi;
                    if mirrored.z > 0.0 {
                        sum.reflected +=
                            weight * fresnel::dielectric(1.0 / eta, c) * seen(mirrored);
                    }
                }
            }
        }
        sum
    }

    #[test]
    fn lanes_match_the_reference_sums() {
        for word in ["ggx", "beckmann"] {
            for alpha in [0.02, 0.3, 1.0] {
                let boundary = boundary(word, alpha);
                for cosine in [1e-6, 0.1, 0.6, 1.0] {
                    let [lanes] = shares(&boundary, POINTS, &[cosine]);
                    let plain = reference_shares(&boundary, POINTS, cosine);
                    assert!(
                        (lanes.transmitted - plain.transmitted).abs() < 1e-12,
                        "{word} {alpha}"
                    );
                    assert!(
                        (lanes.reflected - plain.reflected).abs() < 1e-12,
                        "{word} {alpha} {cosine}"
                    );
                }
            }
        }
    }

    #[test]
    fn transmittance_converges_with_few_normals() {
        for word in ["ggx", "beckmann"] {
            for alpha in [0.02, 0.1, 0.3, 0.8] {
                let boundary = boundary(word, alpha);
                let cosines = [1e-6, 0.05, 0.2, 0.5, 1.0];
                let few = shares(&boundary, POINTS, &cosines);
                let many = shares(&boundary, 1000, &cosines);
                for ((few, many), cosine) in few.iter().zip(many).zip(cosines) {
                    let off = (few.transmitted - many.transmitted).abs();
                    assert!(off < 1.5e-3, "{word} {alpha} {cosine}: {off}");
                }
            }
        }
    }

    /// Internal reflectance of diffuse light by many cosines, denser above the critical angle, with
    /// the same normals.
    fn reference_back(boundary: &Boundary) -> f64 {
        const MANY: usize = 1024;
        let critical = (1.0 - 1.0 / (boundary.eta * boundary.eta)).sqrt();
        let midpoint = |k: usize| (k as f64 + 0.5) / MANY as f64;
        let below: [f64; MANY] = std::array::from_fn(|k| critical * midpoint(k));
        let above: [f64; MANY] =
            std::array::from_fn(|k| critical + (1.0 - critical) * midpoint(k) * midpoint(k));
        let weighted = |cosines: &[f64; MANY], weight: &dyn Fn(usize) -> f64| -> f64 {
            let shares = shares(boundary, POINTS, cosines);
            let terms = cosines.iter().zip(shares).enumerate();
            terms.map(|(k, (cosine, own))| 2.0 * cosine * own.reflected * weight(k)).sum::<f64>()
                / MANY as f64
        };
        weighted(&below, &|_| critical)
            + weighted(&above, &|k| 2.0 * midpoint(k) * (1.0 - critical))
    }

    #[test]
    fn internal_reflectance_is_exact_at_every_index_and_roughness() {
        for word in ["ggx", "beckmann"] {
            for alpha in [1e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1, 0.3, 1.0] {
                for eta in [1.01, 1.2, 1.5, 2.0, 3.0] {
                    let boundary = Boundary { eta, ..boundary(word, alpha) };
                    let grid = Grid::new(&boundary, POINTS);
                    let found = boundary.back(Plain::<Branchless>::new(), &grid);
                    let reference = reference_back(&boundary);
                    // The diffuse part of f is divided by 1 - R.
                    let off = (found - reference).abs() / (1.0 - reference);
                    assert!(off < 1e-3, "{word} {eta} {alpha}: {off}");
                }
            }
        }
    }

    #[test]
    fn internal_reflectance_converges_with_few_normals() {
        for alpha in [0.02, 0.1, 0.3, 0.8] {
            let boundary = boundary("ggx", alpha);
            let of = |points| {
                let shares = shares(&boundary, points, &cosines());
                shares.iter().zip(cosines()).map(|(s, cosine)| cosine * s.reflected).sum::<f64>()
                    / 32.0
            };
            let off = (of(POINTS) - of(304)).abs();
            assert!(off < 1e-3, "{alpha}: {off}");
        }
    }
}
