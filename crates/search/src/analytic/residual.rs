//! Residuals of models on samples, and their derivatives by the free parameters.

use std::sync::Arc;

use brood_brdf::{Block, CoatTables, Elementary, Loop, Machine, Model, PreparedModel, TableDetail};
use brood_eval::{Level, SimdKernel};
use brood_genome::Stream;

use super::albedo::{Albedos, Nodes, is_coarse_enough, residual};
use super::batch::{Batch, Lanes, Means};
use super::coordinate::Coordinate;
use super::prior::{Prior, PriorMaterials};
use super::{Form, LANES};
use crate::levenberg_marquardt::NormalEquations;

/// Number of residuals per block: three channels.
pub(crate) const ROW: usize = 3 * LANES;
/// Number of partial sums of a dot product, so that it is vectorised.
const SUMS: usize = 8;
/// Step of the finite differences, in coordinates; a share of the range if that is below 1.
const DIFFERENCE: f64 = 1e-6;
/// Number of cached tables of rough plastic. Normal equations of one model need four: coarse and
/// full ones at the point, and coarse ones after a step in refractive index and in roughness.
const KEPT: usize = 4;

/// The space that a fit of a form searches: one coordinate per free parameter.
#[derive(Debug, Clone)]
pub(crate) struct Space {
    pub(super) form: Form,
    pub(crate) coordinates: Vec<Coordinate>,
    pub(crate) prior: Arc<Prior>,
    /// Materials that made the prior.
    materials: Arc<PriorMaterials>,
}

/// Buffers and tables that are reused between evaluations.
pub(crate) struct Workspace {
    level: Level,
    /// Tables by detail and by all parameter values but the albedo, on which they do not depend.
    tables: Vec<(TableDetail, Vec<f64>, CoatTables)>,
    /// f of the pairs of means, with an unused fourth channel.
    f_of_pairs: Vec<[f64; 4]>,
    /// Residuals at a point.
    base: Vec<f64>,
    /// Residuals after a step in each coordinate, and then the Jacobian, column by column.
    columns: Vec<f64>,
}

impl Space {
    pub(super) fn new(form: Form, materials: &Arc<PriorMaterials>) -> Self {
        let coordinates = form.coordinates();
        let prior = Arc::new(Prior::of(&form, &coordinates, materials));
        Self { form, coordinates, prior, materials: materials.clone() }
    }

    /// The space of another form, with a prior by the same materials.
    pub(super) fn of_form(&self, form: Form) -> Self {
        Self::new(form, &self.materials)
    }

    pub(crate) fn len(&self) -> usize {
        self.coordinates.len()
    }

    pub(super) fn models(&self, x: &[f64]) -> Vec<Model> {
        self.form.models(&self.coordinates, x)
    }

    /// Draws a point from the prior.
    pub(super) fn drawn(&self, stream: &mut Stream) -> Vec<f64> {
        let mut x = self.prior.draw(stream);
        self.clamp(&mut x);
        x
    }

    /// Clamps x to the bounds.
    pub(crate) fn clamp(&self, x: &mut [f64]) {
        for (x, coordinate) in x.iter_mut().zip(&self.coordinates) {
            *x = x.clamp(coordinate.bounds.0, coordinate.bounds.1);
        }
    }

    /// Step of the finite difference of a coordinate at x, towards the inside of its bounds.
    pub(crate) fn difference(&self, k: usize, x: f64) -> f64 {
        let (low, high) = self.coordinates[k].bounds;
        let step = DIFFERENCE * (high - low).min(1.0);
        if x + step > high { -step } else { step }
    }
}

impl Workspace {
    pub(crate) fn new() -> Self {
        let (f_of_pairs, base, columns) = Default::default();
        Self { level: Level::best(), tables: Vec::new(), f_of_pairs, base, columns }
    }

    /// Prepares a model for evaluation, with cached tables if it is rough plastic, whose tables
    /// take milliseconds.
    fn prepare(&mut self, model: &Model, detail: TableDetail) -> PreparedModel {
        if model.kind() != brood_brdf::ModelKind::RoughPlastic {
            return model.prepare();
        }
        let key = model.parameters().filter(|(parameter, _)| parameter.name != "albedo");
        let key: Vec<f64> = key.flat_map(|(_, numbers)| numbers.iter().copied()).collect();
        let known = self.tables.iter().position(|(of, other, _)| *of == detail && *other == key);
        let known = known.unwrap_or_else(|| {
            if self.tables.len() == KEPT {
                self.tables.remove(0);
            }
            let tables = model.coat_tables(self.level, detail).expect("rough plastic has tables");
            self.tables.push((detail, key, tables));
            self.tables.len() - 1
        });
        model.prepare_with(&self.tables[known].2)
    }

    /// Sum of squared residuals at a point.
    pub(super) fn error(
        &mut self,
        space: &Space,
        x: &[f64],
        batch: &Batch,
        detail: TableDetail,
    ) -> f64 {
        self.error_divided(space, (x, 1.0), batch, detail)
    }

    /// Sum of squared residuals after the energy limit has divided f by `divisor`.
    pub(super) fn error_divided(
        &mut self,
        space: &Space,
        (x, divisor): (&[f64], f64),
        batch: &Batch,
        detail: TableDetail,
    ) -> f64 {
        let mut out = std::mem::take(&mut self.base);
        out.resize(batch.residuals(), 0.0);
        let sum = self.residuals(space, (x, divisor), (batch, detail), &mut out);
        self.base = out;
        sum
    }

    /// Mean squared residual as in [`Workspace::error_divided`], in which every residual counts
    /// fully.
    pub(super) fn mean_square(&mut self, space: &Space, x: (&[f64], f64), batch: &Batch) -> f64 {
        let batch = batch.clone().with_large(f64::INFINITY);
        self.error_divided(space, x, &batch, TableDetail::Full) / batch.total.max(1.0)
    }

    /// Writes the residuals of samples, then those of albedos and of the prior, to `out`; returns
    /// the sum of their squares.
    fn residuals(
        &mut self,
        space: &Space,
        (x, divisor): (&[f64], f64),
        (batch, detail): (&Batch, TableDetail),
        out: &mut [f64],
    ) -> f64 {
        let models = self.prepared(space, x, detail);
        let share = 1.0 / divisor;
        let mut sum = 0.0;
        let (of_lanes, rest) = out.split_at_mut(ROW * batch.lanes.len());
        for (lanes, out) in batch.lanes.iter().zip(of_lanes.chunks_exact_mut(ROW)) {
            let f = f(self.level, &models, &lanes.block);
            let compare = Compare { lanes, f: &f, share, large: batch.large, out };
            sum += Machine::run(self.level, compare);
        }
        let mut rest = rest;
        if let Some(means) = &batch.means {
            let (of_means, after) = rest.split_at_mut(ROW * means.lanes.len());
            sum += self.residuals_of_means(&models, (share, batch.large), means, of_means);
            rest = after;
        }
        rest.fill(0.0);
        let (out, of_prior) = rest.split_at_mut(batch.albedos.as_ref().map_or(0, |_| ROW));
        if let Some(weight) = batch.prior {
            let scale = (weight * batch.total).sqrt();
            for (out, deviation) in of_prior.iter_mut().zip(space.prior.deviations(x)) {
                *out = scale * deviation;
                sum += *out * *out;
            }
        }
        if let Some((albedos, level)) = &batch.albedos {
            let directions = albedos.coarse(space.form.is_anisotropic());
            let rows = out.chunks_exact_mut(3).zip(directions);
            for (out, nodes) in rows {
                let albedos = reflected(self.level, &models, nodes);
                for (out, albedo) in out.iter_mut().zip(albedos) {
                    *out = residual(share * albedo, *level, batch.total);
                    sum += *out * *out;
                }
            }
        }
        sum
    }

    /// Writes the residuals of means to `out`; returns the sum of their squares.
    fn residuals_of_means(
        &mut self,
        models: &[PreparedModel],
        (share, large): (f64, f64),
        means: &Means,
        out: &mut [f64],
    ) -> f64 {
        self.f_of_pairs.clear();
        for block in &means.blocks {
            let [red, green, blue] = f(self.level, models, block);
            let of_lane = |lane: usize| {
                [red[lane], green[lane], blue[lane], 0.0].map(|f| if f > 0.0 { f } else { 0.0 })
            };
            self.f_of_pairs.extend((0..LANES).map(of_lane));
        }
        let mut sum = 0.0;
        let parts = means.lanes.iter().zip(out.chunks_exact_mut(ROW));
        for (part, (lanes, out)) in parts.enumerate() {
            let first = part * LANES;
            let mut mean = [[0.0; LANES]; 3];
            for index in first..means.means.len().min(first + LANES) {
                let terms = means.means.terms(index);
                let [red, green, blue, _] = self.level.run(Sum { terms, f: &self.f_of_pairs });
                let lane = index - first;
                (mean[0][lane], mean[1][lane], mean[2][lane]) = (red, green, blue);
            }
            let compare = Compare { lanes, f: &mean, share, large, out };
            sum += Machine::run(self.level, compare);
        }
        sum
    }

    /// Largest albedo of any channel over the incident directions of the quadratures.
    pub(super) fn albedo(&mut self, space: &Space, x: &[f64], albedos: &Albedos) -> f64 {
        let models = self.prepared(space, x, TableDetail::Full);
        let most = |directions: &[Vec<Nodes>]| {
            directions
                .iter()
                .flat_map(|nodes| reflected(self.level, &models, nodes))
                .fold(0.0, |most, a| if a > most || a.is_nan() { a } else { most })
        };
        let is_anisotropic = space.form.is_anisotropic();
        let coarse = most(albedos.coarse(is_anisotropic));
        if is_coarse_enough(coarse) { coarse } else { most(albedos.fine(is_anisotropic)) }
    }

    /// Prepares the models of a point for evaluation.
    pub(crate) fn prepared(
        &mut self,
        space: &Space,
        x: &[f64],
        detail: TableDetail,
    ) -> Vec<PreparedModel> {
        space.models(x).iter().map(|model| self.prepare(model, detail)).collect()
    }

    /// f of prepared models together.
    pub(crate) fn f(&self, models: &[PreparedModel], block: &Block<LANES>) -> [[f64; LANES]; 3] {
        f(self.level, models, block)
    }

    /// Normal equations of `count` columns of derivatives, one after the other, and residuals. Both
    /// have a whole number of blocks of [`ROW`].
    pub(crate) fn products(&self, columns: &[f64], base: &[f64], count: usize) -> NormalEquations {
        self.level.run(Products { columns, base, count })
    }

    /// Normal equations at a point, by finite differences. Derivatives use coarse tables, residuals
    /// those of `detail`.
    pub(super) fn normal_equations(
        &mut self,
        space: &Space,
        x: &[f64],
        batch: &Batch,
        detail: TableDetail,
    ) -> NormalEquations {
        let (count, rows) = (space.len(), batch.residuals());
        let (mut base, mut columns) =
            (std::mem::take(&mut self.base), std::mem::take(&mut self.columns));
        base.resize(rows, 0.0);
        columns.resize(count * rows, 0.0);
        let mut here = x.to_vec();
        let coarse = (batch, TableDetail::Coarse);
        self.residuals(space, (x, 1.0), coarse, &mut base);
        for k in 0..count {
            here[k] = x[k] + space.difference(k, x[k]);
            let column = &mut columns[k * rows..][..rows];
            self.residuals(space, (&here, 1.0), coarse, column);
            self.level.run(Difference { column, base: &base, by: 1.0 / (here[k] - x[k]) });
            here[k] = x[k];
        }
        let exact =
            space.form.has(brood_brdf::ModelKind::RoughPlastic) && detail == TableDetail::Full;
        if exact {
            self.residuals(space, (x, 1.0), (batch, detail), &mut base);
        }
        let normal = self.level.run(Products { columns: &columns, base: &base, count });
        (self.base, self.columns) = (base, columns);
        normal
    }
}

/// f of all models together.
fn f(level: Level, models: &[PreparedModel], block: &Block<LANES>) -> [[f64; LANES]; 3] {
    let mut f = models[0].f_block(level, block);
    for model in &models[1..] {
        let more = model.f_block(level, block);
        Machine::run(level, Add { sum: &mut f, f: &more });
    }
    f
}

/// Albedo of each channel.
fn reflected(level: Level, models: &[PreparedModel], nodes: &[Nodes]) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for nodes in nodes {
        for (sum, f) in sums.iter_mut().zip(f(level, models, &nodes.block)) {
            let f = f.map(|f| if f > 0.0 { f } else { 0.0 });
            *sum += dot(&f, &nodes.weights);
        }
    }
    sums
}

/// Adds f of one more model. Negative values and NaN count as 0.
struct Add<'a> {
    sum: &'a mut [[f64; LANES]; 3],
    f: &'a [[f64; LANES]; 3],
}

impl Loop for Add<'_> {
    type Values = ();

    #[inline(always)]
    fn run<F: Elementary>(self) {
        for (sum, f) in self.sum.iter_mut().zip(self.f) {
            for (sum, f) in sum.iter_mut().zip(f) {
                let (own, more) =
                    (if *sum > 0.0 { *sum } else { 0.0 }, if *f > 0.0 { *f } else { 0.0 });
                *sum = own + more;
            }
        }
    }
}

/// Sum of shares times f.
struct Sum<'a> {
    terms: &'a [(u32, [f32; 3])],
    f: &'a [[f64; 4]],
}

impl SimdKernel for Sum<'_> {
    type Output = [f64; 4];

    #[inline(always)]
    fn run(self) -> [f64; 4] {
        let mut sum = [0.0; 4];
        for (at, [red, green, blue]) in self.terms {
            let f = &self.f[*at as usize];
            let share = [*red, *green, *blue, 0.0].map(f64::from);
            for channel in 0..4 {
                sum[channel] += share[channel] * f[channel];
            }
        }
        sum
    }
}

/// Writes the residuals ln(1 + share f cos_i) minus the target; returns the sum of their squares.
/// Negative f and NaN count as 0. A residual r becomes r sqrt(2 / (1 + sqrt(1 + (r / large)^2))),
/// whose square is about r^2 below `large` and 2 large |r| above.
///
/// # Source
/// Charbonnier et al., *Deterministic Edge-Preserving Regularization in Computed Imaging* (1997),
/// for this loss.
struct Compare<'a> {
    lanes: &'a Lanes,
    f: &'a [[f64; LANES]; 3],
    share: f64,
    large: f64,
    out: &'a mut [f64],
}

impl Loop for Compare<'_> {
    type Values = f64;

    #[inline(always)]
    fn run<F: Elementary>(self) -> f64 {
        let Self { lanes, f, share, large, out } = self;
        let mut sums = [0.0; SUMS];
        let by = 1.0 / large;
        let wanted = lanes.target.iter().zip(&lanes.above);
        for ((f, (target, above)), out) in f.iter().zip(wanted).zip(out.chunks_exact_mut(LANES)) {
            for k in 0..LANES {
                let f = if f[k] > 0.0 { share * f[k] } else { 0.0 };
                let off = F::ln(1.0 + f * lanes.weight[k]) - target[k];
                let off = if off > 0.0 { off * above[k] } else { off };
                let ratio = by * off;
                let off = off * (2.0 / (1.0 + (1.0 + ratio * ratio).sqrt())).sqrt();
                out[k] = lanes.counts[k] * off;
            }
            for part in out.chunks_exact(SUMS) {
                for (sum, value) in sums.iter_mut().zip(part) {
                    *sum += value * value;
                }
            }
        }
        sums.iter().sum()
    }
}

/// Turns a column of residuals after a step into derivatives.
struct Difference<'a> {
    column: &'a mut [f64],
    base: &'a [f64],
    by: f64,
}

impl SimdKernel for Difference<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (value, base) in self.column.iter_mut().zip(self.base) {
            *value = (*value - base) * self.by;
        }
    }
}

/// Products of the Jacobian's columns with each other and with the residuals.
struct Products<'a> {
    columns: &'a [f64],
    base: &'a [f64],
    count: usize,
}

impl SimdKernel for Products<'_> {
    type Output = NormalEquations;

    #[inline(always)]
    fn run(self) -> NormalEquations {
        let Self { columns, base, count } = self;
        let rows = base.len();
        let mut normal = NormalEquations::zero(count);
        for start in (0..rows).step_by(ROW) {
            let part = |k: usize| &columns[k * rows + start..][..ROW];
            for a in 0..count {
                for b in 0..=a {
                    normal.matrix[a * count + b] += dot(part(a), part(b));
                }
                normal.gradient[a] += dot(part(a), &base[start..][..ROW]);
            }
        }
        for a in 0..count {
            for b in 0..a {
                normal.matrix[b * count + a] = normal.matrix[a * count + b];
            }
        }
        normal
    }
}

#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; SUMS];
    for (a, b) in a.chunks_exact(SUMS).zip(b.chunks_exact(SUMS)) {
        for k in 0..SUMS {
            sums[k] += a[k] * b[k];
        }
    }
    sums.iter().sum()
}
