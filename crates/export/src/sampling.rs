//! Sampling of a BRDF in proportion to what it reflects: a table of densities over half vectors.
//!
//! For each inclination of the eye, and each azimuth if the BRDF is anisotropic, the table has a
//! density over the unit square: x = (2 theta_h / pi)^(1 / n), y = phi_h / (2 pi), where phi_h is
//! measured from the azimuth of the eye or from the tangent. The density of a light direction is
//! that of its place, divided by 4 n pi^2 x^(n - 1) sin(theta_h) (h . wo). n is 2, or 4 for narrow
//! highlights. Between places, inclinations and
//! azimuths it is linear. The rest of the samples are in proportion to the cosine, so that nothing
//! which reflects is missed.
//!
//! Sources: Dupuy and Jakob 2018, An adaptive parameterization for efficient material acquisition
//! and rendering, for tables over half vectors.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI, TAU};

use brood_brdf::DirectionPair;
use brood_eval::is_anisotropic;
use brood_program::Program;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::module::reads_texture;
use crate::reflectance::{direction, reflectance, spread};

/// Shares of the samples that the table may choose. 0.5 is for BRDFs whose light is in places that
/// no table shows, 0 for diffuse ones.
const TABLE_SHARES: [f64; 3] = [0.9, 0.5, 0.0];
/// Sizes of the tables of isotropic BRDFs: inclinations, azimuths, rows, columns.
const ISOTROPIC: [[usize; 4]; 3] = [[8, 1, 17, 17], [16, 1, 33, 33], [24, 1, 49, 65]];
/// Sizes of the tables of anisotropic BRDFs.
const ANISOTROPIC: [[usize; 4]; 3] = [[8, 9, 17, 17], [10, 13, 33, 25], [12, 17, 49, 33]];
/// n, and true if rows begin at the tangent; those of isotropic BRDFs first.
const COORDINATES: [(i32, bool); 4] = [(2, false), (4, false), (2, true), (4, true)];
/// Factor of the variance of a larger table up to which the smaller one is taken.
const WORSE_RATIO: f64 = 1.25;
/// Variance that a smaller table may have beyond that.
const WORSE_MARGIN: f64 = 0.02;
/// Places per cell of the table at which the BRDF is averaged, along each axis.
const ISOTROPIC_DETAIL: usize = 4;
const ANISOTROPIC_DETAIL: usize = 2;
/// Inclinations of the views at which the variance is measured, in degrees.
const VIEWS_DEG: [f64; 7] = [5.0, 20.0, 33.0, 45.0, 57.0, 68.0, 80.0];
/// Places of a view at which the variance is measured.
const VARIANCE_PLACES: usize = 10_000;
/// Largest inclination of the eye, in radians: at 90 degrees nothing is seen.
const STEEPEST: f64 = 1.56;
/// Samples that are evaluated at once.
const BATCH: usize = 4096;

/// Table of densities of half vectors.
#[derive(Debug, Clone)]
pub struct SamplingTable {
    /// Inclinations and azimuths of the eye, rows (y), columns (x).
    pub(crate) shape: [usize; 4],
    /// Share of the samples that the table chooses.
    pub(crate) share: f64,
    /// n: 2 or 4.
    pub(crate) power: i32,
    /// True if rows begin at the tangent, false if at the azimuth of the eye.
    pub(crate) is_fixed: bool,
    /// Angle of the azimuths of the eye, after which the BRDF repeats: pi or 2 pi.
    pub(crate) period: f64,
    /// Densities in the order of `shape`; the largest of each view is 1.
    pub(crate) values: Vec<half::f16>,
    /// Integral of each view over the unit square.
    integrals: Vec<f64>,
    /// Sum over the cells of each row of each view, of both of their nodes.
    row_sums: Vec<f64>,
    /// Variances, each relative to the square of the mean.
    pub(crate) variance: Variance,
}

/// Variance of the estimate of the reflected light by one sample in an even sky, mean over views.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Variance {
    /// With samples by the table and the cosine.
    pub(crate) table: f64,
    /// With samples by the cosine alone.
    pub(crate) cosine: f64,
}

impl SamplingTable {
    /// Makes the smallest table of a BRDF that is about as good as the largest one.
    ///
    /// # Panics
    /// If the program is not of a BRDF.
    #[must_use]
    pub fn of(program: &Program) -> Self {
        let is_anisotropic = is_anisotropic(program) || program.bumps().is_some();
        let coordinates = if is_anisotropic { &COORDINATES[..] } else { &COORDINATES[..2] };
        let sizes = if is_anisotropic { ANISOTROPIC } else { ISOTROPIC };
        let smallest =
            coordinates.iter().map(|coordinates| Self::sized(program, sizes[0], *coordinates));
        let mut best = smallest
            .min_by(|a, b| a.variance.table.total_cmp(&b.variance.table))
            .expect("there are coordinates");
        for size in &sizes[1..] {
            let finer = Self::sized(program, *size, (best.power, best.is_fixed));
            if best.variance.table <= finer.variance.table * WORSE_RATIO + WORSE_MARGIN {
                break;
            }
            best = finer;
        }
        best
    }

    /// Share of the samples that the table chooses; the others are chosen by the cosine.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.share
    }

    /// Variances of the estimate of the reflected light by one sample in an even sky, each relative
    /// to the square of the mean: with samples by the table and the cosine, and by the cosine
    /// alone.
    #[must_use]
    pub fn variances(&self) -> (f64, f64) {
        (self.variance.table, self.variance.cosine)
    }

    /// Density of the direction to the light that [`SamplingTable::sample`] draws for the direction
    /// to the eye.
    ///
    /// # Units
    /// 1/sr; 0 unless both directions are above the surface.
    #[must_use]
    pub fn pdf(&self, pair: &DirectionPair) -> f64 {
        let (light, eye) = (pair.wi(), pair.wo());
        if light.z <= 0.0 || eye.z <= 0.0 {
            return 0.0;
        }
        let half = (light + eye).normalize();
        // Not 0, where the density has no limit.
        let inclination = libm::atan2(half.truncate().length(), half.z).max(1e-6);
        let x = libm::pow(inclination / FRAC_PI_2, 1.0 / f64::from(self.power));
        let turn = (libm::atan2(half.y, half.x) - self.origin(eye)) / TAU;
        let place = DVec2::new(x, turn - turn.floor());
        let stretch = 4.0 * f64::from(self.power) * PI * PI * x.powi(self.power - 1);
        let area = stretch * libm::sin(inclination) * half.dot(eye).abs();
        let table = self.density(&self.slices(eye), place) / area;
        self.share * table + (1.0 - self.share) * light.z * FRAC_1_PI
    }

    /// Draws a direction to the light for a direction to the eye, from three numbers in [0, 1). It
    /// may be below the surface, where nothing is reflected.
    #[must_use]
    pub fn sample(&self, eye: DVec3, random: [f64; 3]) -> DVec3 {
        let [choice, first, second] = random;
        if choice >= self.share {
            let (radius, azimuth) = (first.sqrt(), TAU * second);
            let height = (1.0 - first).max(0.0).sqrt();
            return DVec3::new(radius * libm::cos(azimuth), radius * libm::sin(azimuth), height);
        }
        // What chose the table also chooses one of the views beside the eye.
        let place = self.draw(&self.slices(eye), [choice / self.share, first, second]);
        let inclination = place.x.powi(self.power) * FRAC_PI_2;
        let half = direction(inclination, TAU * place.y + self.origin(eye));
        (2.0 * half.dot(eye) * half - eye).normalize()
    }

    /// Draws a place of the unit square in proportion to the density.
    fn draw(&self, slices: &[(usize, f64)], [choice, across, along]: [f64; 3]) -> DVec2 {
        let [.., rows, columns] = self.shape;
        let shares: Vec<f64> =
            slices.iter().map(|(view, weight)| weight * self.integrals[*view]).collect();
        let (chosen, _) = draw_cell(shares.len(), choice, |slice| shares[slice]);
        let view = slices[chosen].0;
        let nodes = &self.values[view * rows * columns..][..rows * columns];
        let node = |row: usize, column: usize| f64::from(nodes[row * columns + column]);
        let sums = &self.row_sums[view * rows..][..rows];
        let (row, part) = draw_cell(rows - 1, across, |row| sums[row] + sums[row + 1]);
        let up = draw_linear(sums[row], sums[row + 1], part);
        let value = |column: usize| node(row, column) * (1.0 - up) + node(row + 1, column) * up;
        let (column, part) =
            draw_cell(columns - 1, along, |column| value(column) + value(column + 1));
        let right = draw_linear(value(column), value(column + 1), part);
        let at = |cell: usize, part: f64, nodes: usize| (cell as f64 + part) / (nodes - 1) as f64;
        DVec2::new(at(column, right, columns), at(row, up, rows))
    }

    /// Azimuth at which the rows begin for a direction to the eye.
    fn origin(&self, eye: DVec3) -> f64 {
        let azimuth = libm::atan2(eye.y, eye.x);
        match self.is_fixed {
            true => self.period * (azimuth / self.period).floor(),
            false => azimuth,
        }
    }

    fn sized(program: &Program, shape: [usize; 4], (power, is_fixed): (i32, bool)) -> Self {
        let period = if program.bumps().is_some() { TAU } else { PI };
        let variance = Variance { table: 0.0, cosine: 0.0 };
        let mut table = Self {
            shape,
            share: TABLE_SHARES[0],
            power,
            is_fixed,
            period,
            values: Vec::new(),
            integrals: Vec::new(),
            row_sums: Vec::new(),
            variance,
        };
        let slices: Vec<Vec<half::f16>> = (0..shape[0] * shape[1])
            .into_par_iter()
            .map(|view| table.slice(program, view))
            .collect();
        table.values = slices.concat();
        table.integrals = (0..slices.len()).map(|view| table.integral(view)).collect();
        table.row_sums = table.values.chunks_exact(shape[3]).map(row_sum).collect();
        table.measure(program);
        table
    }

    /// Direction to the eye of a view of the table.
    fn eye(&self, view: usize) -> DVec3 {
        let [inclinations, azimuths, ..] = self.shape;
        let inclination = ratio(view / azimuths, inclinations - 1) * FRAC_PI_2;
        let azimuth = ratio(view % azimuths, (azimuths - 1).max(1)) * self.period;
        direction(inclination.min(STEEPEST), azimuth)
    }

    /// Densities of a view.
    fn slice(&self, program: &Program, view: usize) -> Vec<half::f16> {
        let [.., rows, columns] = self.shape;
        let eye = self.eye(view);
        let detail = if self.shape[1] == 1 { ISOTROPIC_DETAIL } else { ANISOTROPIC_DETAIL };
        let mut places = Vec::with_capacity(rows * columns * detail * detail);
        for node in 0..rows * columns {
            for part in 0..detail * detail {
                let offset = |part: usize| (ratio(part, detail) + 0.5 / detail as f64) - 0.5;
                let x = (node % columns) as f64 + offset(part % detail);
                let y = (node / columns) as f64 + offset(part / detail);
                // Beyond the edges: mirrored in x, around in y.
                let x = x.abs() / (columns - 1) as f64;
                let y = y / (rows - 1) as f64;
                places.push(DVec2::new(x.min(1.0), y - y.floor()));
            }
        }
        let parts = self.reflected(program, eye, &places);
        let cells = parts.chunks_exact(detail * detail);
        let mut nodes: Vec<f64> = cells.map(|cell| cell.iter().sum::<f64>()).collect();
        // No area is left at x = 0.
        nodes.iter_mut().step_by(columns).for_each(|node| *node = 0.0);
        let largest = nodes.iter().copied().fold(0.0, f64::max);
        if largest <= 0.0 {
            nodes = places
                .iter()
                .step_by(detail * detail)
                .map(|place| self.light(eye, *place).map_or(0.0, |(_, area)| area))
                .collect();
        }
        let largest = nodes.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        nodes.iter().map(|node| half::f16::from_f64(node / largest)).collect()
    }

    /// Direction to the light of a place in a view, and its solid angle for the unit of area;
    /// `None` if it is below the surface.
    fn light(&self, eye: DVec3, place: DVec2) -> Option<(DVec3, f64)> {
        let inclination = place.x.powi(self.power) * FRAC_PI_2;
        let origin = if self.is_fixed { 0.0 } else { libm::atan2(eye.y, eye.x) };
        let half = direction(inclination, TAU * place.y + origin);
        let across = half.dot(eye);
        let light = 2.0 * across * half - eye;
        let stretch = 4.0 * f64::from(self.power) * PI * PI * place.x.powi(self.power - 1);
        let area = stretch * libm::sin(inclination) * across;
        (across > 0.0 && light.z > 1e-6).then(|| (light.normalize(), area))
    }

    /// Mean of f cos_i over the channels, times the solid angle for the unit of area, at places in
    /// a view. Each place has its own texture position.
    fn reflected(&self, program: &Program, eye: DVec3, places: &[DVec2]) -> Vec<f64> {
        let lights: Vec<Option<(DVec3, f64)>> =
            places.iter().map(|place| self.light(eye, *place)).collect();
        let lit: Vec<(usize, DVec3, f64)> = lights
            .iter()
            .enumerate()
            .filter_map(|(place, light)| light.map(|(light, area)| (place, light, area)))
            .collect();
        let mut found = vec![0.0; places.len()];
        let directions: Vec<DVec3> = lit.iter().map(|(_, light, _)| *light).collect();
        for ((place, light, area), f) in lit.iter().zip(mean_f(program, eye, &directions)) {
            found[*place] = f * light.z * area;
        }
        found
    }

    /// Density of a place in the unit square, for a direction to the eye.
    fn density(&self, slices: &[(usize, f64)], place: DVec2) -> f64 {
        let [.., rows, columns] = self.shape;
        let cell = |at: f64, nodes: usize| {
            let at = at.clamp(0.0, 1.0) * (nodes - 1) as f64;
            let low = (at.floor() as usize).min(nodes - 2);
            (low, at - low as f64)
        };
        let ((column, right), (row, up)) = (cell(place.x, columns), cell(place.y, rows));
        let of = |view: usize| {
            let node = |row: usize, column: usize| {
                f64::from(self.values[(view * rows + row) * columns + column])
            };
            let along =
                |row: usize| node(row, column) * (1.0 - right) + node(row, column + 1) * right;
            along(row) * (1.0 - up) + along(row + 1) * up
        };
        slices.iter().map(|(view, weight)| weight * of(*view)).sum()
    }

    /// Views of the table next to a direction to the eye, and their weights divided by their
    /// integrals.
    fn slices(&self, eye: DVec3) -> Vec<(usize, f64)> {
        let [inclinations, azimuths, ..] = self.shape;
        let at = libm::acos(eye.z.min(1.0)) / FRAC_PI_2 * (inclinations - 1) as f64;
        let turn = libm::atan2(eye.y, eye.x) / self.period;
        let around = (turn - turn.floor()) * (azimuths - 1) as f64;
        let ends = |at: f64, nodes: usize| {
            let low = (at.floor() as usize).min(nodes.saturating_sub(2));
            let share = at - low as f64;
            [(low, 1.0 - share), ((low + 1).min(nodes - 1), share)]
        };
        let mut slices = Vec::with_capacity(4);
        for (inclination, above) in ends(at, inclinations) {
            for (azimuth, beside) in ends(around, azimuths) {
                let view = inclination * azimuths + azimuth;
                slices.push((view, above * beside / self.integrals[view]));
            }
        }
        slices
    }

    /// Integral of a view over the unit square, by the trapezoidal rule, which is exact.
    fn integral(&self, view: usize) -> f64 {
        let [.., rows, columns] = self.shape;
        let end = |at: usize, nodes: usize| if at == 0 || at == nodes - 1 { 0.5 } else { 1.0 };
        let nodes = &self.values[view * rows * columns..(view + 1) * rows * columns];
        let weighted = nodes.iter().enumerate().map(|(node, value)| {
            f64::from(*value) * end(node % columns, columns) * end(node / columns, rows)
        });
        weighted.sum::<f64>() / ((rows - 1) * (columns - 1)) as f64
    }

    /// Measures the variances, and chooses the share with the smaller one.
    fn measure(&mut self, program: &Program) {
        let views: Vec<Option<[f64; TABLE_SHARES.len()]>> = (0..VIEWS_DEG.len())
            .into_par_iter()
            .map(|view| {
                let turn = 0.618_033_988_749_895 * (view + 1) as f64;
                let eye = direction(VIEWS_DEG[view].to_radians(), self.period * turn.fract());
                self.relative_variances(program, eye)
            })
            .collect();
        let lit: Vec<[f64; TABLE_SHARES.len()]> = views.into_iter().flatten().collect();
        let mean =
            |kind: usize| lit.iter().map(|view| view[kind]).sum::<f64>() / lit.len().max(1) as f64;
        let variances = [0, 1, 2].map(mean);
        let by_share = TABLE_SHARES.into_iter().zip(variances);
        let (share, table) = by_share.min_by(|a, b| a.1.total_cmp(&b.1)).expect("there are shares");
        self.share = share;
        self.variance = Variance { table, cosine: variances[2] };
    }

    /// Relative variances of one sample with each of the shares. `None` if nothing is reflected.
    fn relative_variances(
        &self,
        program: &Program,
        eye: DVec3,
    ) -> Option<[f64; TABLE_SHARES.len()]> {
        let slices = self.slices(eye);
        let places: Vec<DVec2> = (0..VARIANCE_PLACES).map(spread).collect();
        let reflected = self.reflected(program, eye, &places);
        let (mut mean, mut squares) = (0.0, TABLE_SHARES.map(|_| 0.0));
        for (place, value) in places.iter().zip(&reflected) {
            let Some((light, area)) = self.light(eye, *place) else { continue };
            let cosine = light.z * FRAC_1_PI * area;
            let table = self.density(&slices, *place);
            mean += value;
            for (square, share) in squares.iter_mut().zip(TABLE_SHARES) {
                *square += value * value / (share * table + (1.0 - share) * cosine);
            }
        }
        let count = places.len() as f64;
        let relative = |square: f64| (square * count / (mean * mean) - 1.0).max(0.0);
        (mean > 0.0).then(|| squares.map(relative))
    }
}

/// Sum over the cells of a row, of both of their nodes.
fn row_sum(nodes: &[half::f16]) -> f64 {
    nodes.windows(2).map(|pair| f64::from(pair[0]) + f64::from(pair[1])).sum()
}

/// Draws a cell in proportion to its weight, and returns the part of the cell that is left of the
/// random number.
fn draw_cell(cells: usize, random: f64, weight: impl Fn(usize) -> f64) -> (usize, f64) {
    let total: f64 = (0..cells).map(&weight).sum();
    let mut left = random * total;
    let mut last = (0, 0.0);
    for cell in 0..cells {
        let weight = weight(cell);
        if weight <= 0.0 {
            continue;
        }
        if left < weight {
            return (cell, (left / weight).clamp(0.0, 1.0));
        }
        left -= weight;
        // Rounding may leave more than there is.
        last = (cell, 1.0);
    }
    last
}

/// Draws a place in [0, 1] of a density that is linear from `low` to `high`.
fn draw_linear(low: f64, high: f64, random: f64) -> f64 {
    let sum = low + high;
    if sum <= 0.0 {
        return random;
    }
    // Root of low t + (high - low) t^2 / 2 = random (low + high) / 2, in the form without
    // cancellation.
    let root = (low * low + (high - low) * sum * random).max(0.0).sqrt();
    if low + root <= 0.0 { random } else { (sum * random / (low + root)).clamp(0.0, 1.0) }
}

/// Mean of f over the channels for directions to the light, each at another texture position.
fn mean_f(program: &Program, eye: DVec3, lights: &[DVec3]) -> Vec<f64> {
    let is_textured = reads_texture(program);
    let mut means = Vec::with_capacity(lights.len());
    for (batch, lights) in lights.chunks(BATCH).enumerate() {
        let uv = |k: usize| match is_textured {
            true => spread(batch * BATCH + k),
            false => DVec2::ZERO,
        };
        let pair =
            |light: &DVec3| DirectionPair::new(*light, eye).expect("the directions have length 1");
        let pairs: Vec<DirectionPair> = lights.iter().map(pair).collect();
        let uvs: Vec<DVec2> = (0..lights.len()).map(uv).collect();
        let f = reflectance(program, &pairs, &uvs);
        means.extend(f.into_iter().map(|f| f.element_sum() / 3.0));
    }
    means
}

fn ratio(a: usize, b: usize) -> f64 {
    a as f64 / b as f64
}

#[cfg(test)]
#[path = "sampling_tests.rs"]
mod tests;
