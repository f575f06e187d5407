//! Least squares of a model's parameters and the scenes' unknowns problem.

use std::sync::Arc;

use brood_brdf::{PreparedModel, TableDetail};
use brood_target::KnownView;
use rayon::prelude::*;

use super::shot::{Photograph, Shot};
use super::unknown::Unknowns;
use crate::analytic::{EQUAL, INDEPENDENT, ROW, Space, Workspace};
use crate::levenberg_marquardt::{NormalEquations, Problem, Rules, Solution};
use crate::solve::inverse_diagonal;

const RULES: Rules = Rules {
    diagonal_floor: 1e-9,
    decrease: 0.2,
    increase: 4.0,
    max_damping: 1e6,
    enough: 1e-18,
    converged: (2, 1e-3),
    stops_when_singular: false,
};
/// Number of times that the weights of residuals and of the prior are set, and of steps with each.
const ROUNDS: usize = 3;
const STEPS: usize = 5;
/// Residual above which the loss is linear (dust, interreflections, pixels off by one), in the
/// first steps and in the score.
const LARGE: f64 = 0.1;
/// Later steps use this multiple of the median residual, at least the second number.
const LARGE_MEDIANS: f64 = 2.0;
const LARGE_LEAST: f64 = 2e-3;
/// Least ln(1 + radiance / irradiance) of pixels that the median is taken of.
const LIT: f64 = 1e-3;
/// Number of pictures of each photograph that are kept: the first, the best and the last.
const KEPT: usize = 3;
/// Largest step and value of an unknown, in standard deviations.
const LONGEST: f64 = 2.0;
const FARTHEST: f64 = 4.0;

/// Photographs and their unknowns.
pub(super) struct Joint<'a> {
    views: &'a [KnownView],
    photographs: &'a [Photograph],
    unknowns: &'a Unknowns,
    /// Mean square below which fits are equally good.
    equal: f64,
    /// Number of residuals of all photographs.
    total: f64,
    /// Pictures at the first values of the unknowns.
    first: Shots,
    /// Pictures after a step of each unknown from there; `None` of photographs that it leaves as
    /// they are.
    steps: Vec<Vec<Option<Shot>>>,
}

/// A model fitted with the unknowns.
pub(super) struct Fit {
    space: Space,
    /// Parameters of the model, then unknowns.
    point: Vec<f64>,
    /// Standard deviations of the unknowns, in those stated.
    pub(super) deviations: Vec<f64>,
    /// -2 ln of the probability, up to a constant; the least is best.
    pub(super) score: f64,
}

impl Fit {
    pub(super) fn unknowns(&self) -> &[f64] {
        &self.point[self.space.len()..]
    }

    /// Model and its parameters.
    pub(super) fn start(&self) -> (Space, Vec<f64>) {
        (self.space.clone(), self.point[..self.space.len()].to_vec())
    }
}

/// Pictures of all photographs for values of the unknowns.
type Shots = (Vec<f64>, Arc<Vec<Shot>>);

/// The least-squares problem of one model.
struct JointProblem<'a> {
    joint: &'a Joint<'a>,
    space: &'a Space,
    workspace: Workspace,
    /// The pictures rendered last.
    shots: Vec<Shots>,
    /// Weights of the residuals.
    weights: Vec<f64>,
    /// Weight of the priors: what one squared standard deviation adds to the mean square.
    prior: f64,
}

impl<'a> Joint<'a> {
    /// Prepares fits that start from these values of the unknowns.
    pub(super) fn new(
        views: &'a [KnownView],
        photographs: &'a [Photograph],
        unknowns: &'a Unknowns,
        z: &[f64],
    ) -> Self {
        let wanted = photographs.iter().flat_map(Photograph::wanted);
        let (sum, count) =
            wanted.fold((0.0, 0.0), |(sum, count), wanted| (sum + wanted * wanted, count + 1.0));
        let total = f64::max(count, 1.0);
        let (first, equal) = ((z.to_vec(), Arc::default()), EQUAL * EQUAL * sum / total);
        let mut own = Self { views, photographs, unknowns, equal, total, first, steps: Vec::new() };
        own.first.1 = Arc::new(own.render(z));
        let after = |unknown: usize| {
            let mut moved = z.to_vec();
            moved[unknown] += unknowns.step(unknown);
            let changes = |photograph: &&Photograph| {
                unknowns.moves(unknown) && unknowns.changes(unknown, photograph.view)
            };
            let shot = |photograph: &Photograph| {
                changes(&photograph).then(|| own.shot(photograph, &moved))
            };
            photographs.par_iter().map(shot).collect()
        };
        own.steps = (0..unknowns.len()).into_par_iter().map(after).collect();
        own
    }

    /// Fits a model from these parameters and the first values of the unknowns.
    pub(super) fn fit(&self, space: Space, mut x: Vec<f64>) -> Fit {
        x.extend_from_slice(&self.first.0);
        let mut problem = JointProblem {
            joint: self,
            space: &space,
            workspace: Workspace::new(),
            shots: vec![self.first.clone()],
            weights: Vec::new(),
            prior: 0.0,
        };
        let mut solution = Solution::new(x);
        problem.weigh(&solution.point, LARGE);
        for _ in 0..ROUNDS {
            solution.start(&mut problem);
            solution.minimise(&mut problem, &RULES, STEPS);
            let large = problem.large(&solution.point);
            // The prior's last weights are those of the error that remains, so that exact pictures
            // give exact scenes.
            let loss = problem.weigh(&solution.point, large);
            problem.prior = loss / INDEPENDENT;
        }
        let loss = problem.weigh(&solution.point, LARGE);
        let equations = problem.normal_equations(&mut solution);
        let scale = INDEPENDENT / ((loss + self.equal) * self.total);
        let hessian: Vec<f64> = equations.matrix.iter().map(|value| scale * value).collect();
        let count = solution.point.len();
        let variances = inverse_diagonal(hessian, count).unwrap_or_else(|| vec![1.0; count]);
        let (x, z) = solution.point.split_at(space.len());
        let squares: f64 = z.iter().map(|z| z * z).sum();
        let score = INDEPENDENT * libm::log(loss + self.equal) + space.prior.distance(x) + squares;
        let deviations = variances[space.len()..].iter().map(|value| value.sqrt().min(1.0));
        let deviations = deviations.collect();
        Fit { deviations, point: solution.point, score, space }
    }

    /// Pictures for values of the unknowns.
    fn render(&self, z: &[f64]) -> Vec<Shot> {
        let photographs = self.photographs.par_iter();
        photographs.map(|photograph| self.shot(photograph, z)).collect()
    }

    fn shot(&self, photograph: &Photograph, z: &[f64]) -> Shot {
        let view = &self.views[photograph.view];
        photograph.shot(view, &self.unknowns.scene(view, photograph.view, z))
    }
}

impl JointProblem<'_> {
    /// Residuals of the photographs without weights.
    fn unweighted(&mut self, point: &[f64]) -> Vec<f64> {
        self.weights.clear();
        self.prior = 0.0;
        let mut residuals = self.residuals(point);
        residuals.truncate(self.joint.total as usize);
        residuals
    }

    /// Residual above which the loss is linear, from the residuals at a point.
    fn large(&mut self, point: &[f64]) -> f64 {
        let wanted = self.joint.photographs.iter().flat_map(Photograph::wanted);
        let residuals = self.unweighted(point).into_iter().zip(wanted);
        let lit = residuals.filter(|(_, wanted)| *wanted > LIT);
        let mut sizes: Vec<f64> = lit.map(|(off, _)| off.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let median = sizes.get(sizes.len() / 2).copied().unwrap_or(0.0);
        (LARGE_MEDIANS * median).clamp(LARGE_LEAST, LARGE)
    }

    /// Sets the weights from the residuals at a point; returns the mean loss there.
    fn weigh(&mut self, point: &[f64], large: f64) -> f64 {
        let samples = self.unweighted(point);
        let weight = |off: &f64| if off.abs() > large { (large / off.abs()).sqrt() } else { 1.0 };
        self.weights = samples.iter().map(weight).collect();
        let loss = |off: &f64| {
            let size = off.abs();
            if size > large { large * (2.0 * size - large) } else { size * size }
        };
        let loss = samples.iter().map(loss).sum::<f64>() / self.joint.total;
        self.prior = (loss + self.joint.equal) / INDEPENDENT;
        loss
    }

    /// Pictures for values of the unknowns, from the last ones if possible.
    fn shots(&mut self, z: &[f64]) -> Arc<Vec<Shot>> {
        if let Some((_, shots)) = self.shots.iter().find(|(own, _)| own == z) {
            return shots.clone();
        }
        let shots = Arc::new(self.joint.render(z));
        // The first pictures are kept.
        if self.shots.len() == KEPT {
            self.shots.remove(1);
        }
        self.shots.push((z.to_vec(), shots.clone()));
        shots
    }

    /// Weighted residuals of the photographs, then those of the priors, then zeros up to a whole
    /// number of blocks.
    fn residuals(&mut self, point: &[f64]) -> Vec<f64> {
        let (x, z) = point.split_at(self.space.len());
        let shots = self.shots(z);
        let mut all = Vec::with_capacity(self.rows());
        let models = self.workspace.prepared(self.space, x, TableDetail::Coarse);
        for (photograph, shot) in self.joint.photographs.iter().zip(shots.iter()) {
            let balance = self.joint.unknowns.balance(photograph.view, z);
            all.extend(photograph.residuals(
                shot,
                |block| self.workspace.f(&models, block),
                balance,
            ));
        }
        for (off, weight) in all.iter_mut().zip(&self.weights) {
            *off *= weight;
        }
        let scale = (self.prior * self.joint.total).sqrt();
        all.extend(self.space.prior.deviations(x).iter().map(|off| scale * off));
        all.extend(z.iter().map(|off| scale * off));
        all.resize(self.rows(), 0.0);
        all
    }

    /// Number of residuals: a whole number of blocks.
    fn rows(&self) -> usize {
        let priors = self.space.len() + self.joint.unknowns.len();
        (self.joint.total as usize + priors).next_multiple_of(ROW)
    }

    /// Derivatives of the residuals by an unknown: those of the model here in the scenes of the
    /// first values, which change little.
    fn by_unknown(&self, models: &[PreparedModel], base: &[f64], unknown: usize) -> Vec<f64> {
        let Joint { photographs, unknowns, .. } = self.joint;
        let (z, first) = &self.joint.first;
        let step = unknowns.step(unknown);
        let mut moved = z.clone();
        moved[unknown] += step;
        let mut column = vec![0.0; self.rows()];
        let mut start = 0;
        for (index, photograph) in photographs.iter().enumerate() {
            let rows = start..start + 3 * photograph.pixels.len();
            start = rows.end;
            if !unknowns.changes(unknown, photograph.view) {
                continue;
            }
            let balance = unknowns.balance(photograph.view, &moved);
            let shot = self.joint.steps[unknown][index].as_ref().unwrap_or(&first[index]);
            let f = |block: &_| self.workspace.f(models, block);
            for (row, residual) in rows.zip(photograph.residuals(shot, f, balance)) {
                column[row] = (residual * self.weights[row] - base[row]) / step;
            }
        }
        let row = self.joint.total as usize + self.space.len() + unknown;
        column[row] = (self.prior * self.joint.total).sqrt();
        column
    }
}

impl Problem for JointProblem<'_> {
    type Point = Vec<f64>;

    fn error(&mut self, point: &Vec<f64>) -> f64 {
        self.residuals(point).iter().map(|off| off * off).sum::<f64>() / self.joint.total
    }

    fn normal_equations(&mut self, at: &mut Solution<Vec<f64>>) -> NormalEquations {
        let point = &at.point;
        let base = self.residuals(point);
        let mut columns = Vec::with_capacity(point.len() * base.len());
        let mut here = point.clone();
        for k in 0..self.space.len() {
            let step = self.space.difference(k, point[k]);
            here[k] = point[k] + step;
            let after = self.residuals(&here);
            columns.extend(after.iter().zip(&base).map(|(after, base)| (after - base) / step));
            here[k] = point[k];
        }
        let x = &point[..self.space.len()];
        let first = [x, &self.joint.first.0].concat();
        let at_first = self.residuals(&first);
        let models = self.workspace.prepared(self.space, x, TableDetail::Coarse);
        let own = &*self;
        let unknowns: Vec<Vec<f64>> = (0..self.joint.unknowns.len())
            .into_par_iter()
            .map(|unknown| own.by_unknown(&models, &at_first, unknown))
            .collect();
        columns.extend(unknowns.into_iter().flatten());
        self.workspace.products(&columns, &base, point.len())
    }

    fn longest_step(&self, index: usize) -> f64 {
        self.space.coordinates.get(index).map_or(LONGEST, |coordinate| coordinate.longest)
    }

    fn moved(&self, point: &Vec<f64>, change: &[f64]) -> Option<Vec<f64>> {
        let mut next: Vec<f64> = point.iter().zip(change).map(|(x, change)| x - change).collect();
        let (x, z) = next.split_at_mut(self.space.len());
        self.space.clamp(x);
        z.iter_mut().for_each(|z| *z = z.clamp(-FARTHEST, FARTHEST));
        change.iter().any(|change| change.abs() > 0.0).then_some(next)
    }
}
