//! Directional albedos of a program: that of its steps by evaluating samples, that of its layers by
//! a quadrature made for lobes.
//!
//! The output stage is affine, so the albedos of g^2 and of the layers are measured separately and
//! added before the output stage.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use brood_genome::Output;
use brood_program::{Operand, Program};
use brood_scene::SampleSet;
use glam::DVec3;
use rayon::prelude::*;

use super::hemisphere::{Quadrature, direction_pair};
use super::limit::Incidence;
use super::lobe::LobeRule;
use crate::layer::Layers;
use crate::{CanonicalEvaluator, Evaluator};

/// A program prepared for measuring albedos.
pub(super) enum Subject<'a> {
    /// A program without layers.
    Plain(&'a Program),
    /// A program with layers.
    Layered {
        /// The program without layers and output stage; `None` if its results are 0.
        squares: Option<Program>,
        layers: Layers,
        output: &'a Output,
        /// Quadratures by order, created at first use.
        rules: Mutex<BTreeMap<usize, Arc<LobeRule>>>,
    },
}

impl<'a> Subject<'a> {
    pub(super) fn new(program: &'a Program) -> Self {
        let Some(layers) = Layers::of(program) else { return Self::Plain(program) };
        // A genome of models alone has no steps, and its results are the constant 0.
        let is_constant = |result: &Operand| matches!(result, Operand::Constant(_));
        let is_empty = program.steps().is_empty()
            && program.results().iter().all(is_constant)
            && program.constants().iter().all(|constant| constant.canonical == 0.0);
        let squares = (!is_empty).then(|| program.bare());
        Self::Layered { squares, layers, output: program.output(), rules: Mutex::default() }
    }

    /// Number of reflectances per albedo.
    pub(super) fn samples(&self, rule: &Quadrature) -> usize {
        let directions = rule.directions().len();
        match self {
            Self::Plain(_) => directions,
            Self::Layered { squares, .. } => {
                let of_program = if squares.is_some() { directions } else { 0 };
                of_program + self.lobe_rule(rule.order()).len()
            }
        }
    }

    /// Returns the largest albedo of the channels at each place.
    pub(super) fn albedos_at(&self, places: &[Incidence], rule: &Quadrature) -> Vec<f64> {
        self.channels_at(places, rule).into_iter().map(largest).collect()
    }

    /// Does the same as [`Subject::albedos_at`], given the samples of the places.
    pub(super) fn albedos(
        &self,
        places: &[Incidence],
        set: &SampleSet,
        rule: &Quadrature,
    ) -> Vec<f64> {
        self.channels(places, set, rule).into_iter().map(largest).collect()
    }

    /// Returns the albedo of each channel at each place.
    pub(super) fn channels_at(&self, places: &[Incidence], rule: &Quadrature) -> Vec<[f64; 3]> {
        let set = match self {
            // Layers are not measured by samples.
            Self::Layered { squares: None, .. } => SampleSet::from_pairs(&[], &[]),
            Self::Plain(_) | Self::Layered { .. } => samples(places, rule),
        };
        self.channels(places, &set, rule)
    }

    /// Does the same as [`Subject::channels_at`], given the samples of the places.
    fn channels(&self, places: &[Incidence], set: &SampleSet, rule: &Quadrature) -> Vec<[f64; 3]> {
        let (squares, layers, output) = match self {
            Self::Plain(program) => return integrals(program, set, rule),
            Self::Layered { squares, layers, output, .. } => (squares, layers, output),
        };
        let of_squares = match squares {
            Some(squares) => integrals(squares, set, rule),
            None => vec![[0.0; 3]; places.len()],
        };
        let lobes = self.lobe_rule(rule.order());
        let of_layers: Vec<DVec3> =
            places.par_iter().map(|place| lobes.albedo(layers, place.direction())).collect();
        let both = of_squares.into_iter().zip(of_layers);
        both.map(|(squares, layers)| stage(output, DVec3::from(squares) + layers)).collect()
    }

    /// Returns the quadrature of the layers of that order.
    fn lobe_rule(&self, order: usize) -> Arc<LobeRule> {
        let Self::Layered { rules, .. } = self else { return Arc::new(LobeRule::new(1)) };
        let mut rules = rules.lock().unwrap_or_else(PoisonError::into_inner);
        rules.entry(order).or_insert_with(|| Arc::new(LobeRule::new(order))).clone()
    }
}

fn largest(albedo: [f64; 3]) -> f64 {
    albedo.into_iter().fold(0.0, f64::max)
}

/// Returns the samples of every direction of the rule for every place.
pub(super) fn samples(places: &[Incidence], rule: &Quadrature) -> SampleSet {
    let mut pairs = Vec::with_capacity(places.len() * rule.directions().len());
    let mut uvs = Vec::with_capacity(pairs.capacity());
    for place in places {
        let wi = place.direction();
        pairs.extend(rule.directions().iter().map(|wo| direction_pair(wi, *wo)));
        uvs.resize(pairs.len(), place.uv);
    }
    SampleSet::from_pairs(&pairs, &uvs)
}

/// Returns the albedo of each channel at each place of such samples.
fn integrals(program: &Program, set: &SampleSet, rule: &Quadrature) -> Vec<[f64; 3]> {
    let mut f = Vec::new();
    CanonicalEvaluator::default()
        .eval(&[program], set, &mut f)
        .expect("the CPU runs every program");
    let count = rule.directions().len();
    let albedo = |place: usize| {
        [0, 1, 2].map(|channel| {
            let start = channel * set.len() + place * count;
            rule.integrate(f[start..start + count].iter().map(|f| f64::from(*f)))
        })
    };
    (0..set.len() / count).map(albedo).collect()
}

/// Applies the output stage to albedos: a constant added to f adds pi times that to the albedo.
fn stage(output: &Output, albedo: DVec3) -> [f64; 3] {
    [0, 1, 2].map(|channel| {
        let mixed = DVec3::from(output.matrix()[channel].map(f64::from)).dot(albedo);
        let offset = std::f64::consts::PI * f64::from(output.offset()[channel]);
        f64::from(output.scale()[channel]) * mixed + offset
    })
}
