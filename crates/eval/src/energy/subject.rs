//! Directional albedos of a program: that of its steps by evaluating samples, that of its layers by
//! a quadrature made for highlights.
//!
//! The output stage is affine and its values are not negative, so the albedos of g^2 and of each
//! layer are measured separately and added before the output stage.

use brood_brdf::Level;
use brood_genome::Output;
use brood_program::{Operand, Program};
use brood_scene::SampleSet;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::hemisphere::{Quadrature, direction_pair};
use super::limit::Incidence;
use super::lobe::LobeRule;
use super::slope::{Nodes, SlopeRule, highlight_width};
use crate::lanes::pairwise_sum;
use crate::layer::Layers;
use crate::{CanonicalEvaluator, Evaluator};

/// Number of samples evaluated at once: small enough that their memory is reused from call to call.
const BATCH_SAMPLES: usize = 4096;

/// Quadrature over outgoing directions for programs.
#[derive(Debug)]
pub(super) enum ProgramRule {
    /// For programs whose inputs vary evenly over the hemisphere.
    Even(Quadrature),
    /// For programs that read how near the half vector is to the normal: they can have highlights.
    Highlight(LobeRule),
}

impl ProgramRule {
    /// Number of samples per place, at most.
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Even(rule) => rule.directions().len(),
            Self::Highlight(rule) => rule.len(),
        }
    }

    /// Returns the samples of every place.
    pub(super) fn samples(&self, places: &[Incidence]) -> Samples {
        let mut pairs = Vec::with_capacity(places.len() * self.len());
        let (mut uvs, mut weights) =
            (Vec::with_capacity(pairs.capacity()), Vec::with_capacity(pairs.capacity()));
        let mut ends = Vec::with_capacity(places.len());
        for place in places {
            let wi = place.direction();
            match self {
                Self::Even(rule) => {
                    for (wo, weight) in rule.weighted() {
                        pairs.push(direction_pair(wi, wo));
                        weights.push(weight);
                    }
                }
                Self::Highlight(rule) => {
                    for (pair, weight) in rule.nodes(wi) {
                        pairs.push(pair);
                        weights.push(weight);
                    }
                }
            }
            uvs.resize(pairs.len(), place.uv);
            ends.push(pairs.len());
        }
        Samples { set: SampleSet::from_pairs(&pairs, &uvs), weights, ends }
    }
}

/// Samples of several places, one place after the other.
#[derive(Debug)]
pub(super) struct Samples {
    set: SampleSet,
    /// The integral of f cos_o is the sum of f times weight over the samples of a place.
    weights: Vec<f64>,
    /// End of the samples of each place.
    ends: Vec<usize>,
}

impl Samples {
    /// Number of samples.
    pub(super) fn len(&self) -> usize {
        self.weights.len()
    }

    /// Returns the albedo of each channel at each place.
    pub(super) fn albedos(&self, program: &Program) -> Vec<Albedo> {
        let mut f = Vec::new();
        CanonicalEvaluator::default()
            .eval(&[program], &self.set, &mut f)
            .expect("the CPU runs every program");
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        let albedo = |(start, end): (usize, usize)| {
            DVec3::from([0, 1, 2].map(|channel| {
                let f = &f[channel * self.len()..][start..end];
                weighted_sum(f, &self.weights[start..end])
            }))
        };
        starts.zip(self.ends.iter().copied()).map(albedo).collect()
    }
}

/// Returns the sum of values times weights, in lanes: the same bits on every machine.
fn weighted_sum(values: &[f32], weights: &[f64]) -> f64 {
    let mut sums = [0.0; SUM_LANES];
    for (values, weights) in values.chunks(SUM_LANES).zip(weights.chunks(SUM_LANES)) {
        for ((sum, value), weight) in sums.iter_mut().zip(values).zip(weights) {
            *sum += f64::from(*value) * weight;
        }
    }
    pairwise_sum(sums)
}

/// Number of partial sums.
const SUM_LANES: usize = 8;

/// Quadrature of one measurement: of g^2, and of layers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fineness<'a> {
    /// Rule for g^2.
    pub(super) rule: &'a ProgramRule,
    /// Spacing of the nodes for layers; see [`SlopeRule`].
    pub(super) spacing: f64,
}

/// A program prepared for measuring albedos.
pub(super) struct Subject<'a> {
    /// The program without layers and output stage; `None` if its results are 0.
    squares: Option<Program>,
    layers: Option<Layers>,
    /// Width of the highlight of each layer.
    widths: Vec<DVec2>,
    output: &'a Output,
    level: Level,
}

/// Albedo of each channel, before the output stage.
type Albedo = DVec3;

impl<'a> Subject<'a> {
    pub(super) fn new(program: &'a Program) -> Self {
        // A genome of models alone has no steps, and its results are the constant 0.
        let is_constant = |result: &Operand| matches!(result, Operand::Constant(_));
        let is_empty = program.steps().is_empty()
            && program.results().iter().all(is_constant)
            && program.constants().iter().all(|constant| constant.canonical == 0.0);
        Self {
            squares: (!is_empty).then(|| program.bare()),
            layers: Layers::of(program),
            widths: program.layers().iter().map(highlight_width).collect(),
            output: program.output(),
            level: Level::best(),
        }
    }

    /// Returns the program without layers and output stage, or `None` if its results are 0.
    pub(super) fn squares(&self) -> Option<&Program> {
        self.squares.as_ref()
    }

    /// Returns the albedo of each channel at each place, and the number of reflectances.
    pub(super) fn albedos_at(
        &self,
        places: &[Incidence],
        fineness: Fineness<'_>,
    ) -> (Vec<[f64; 3]>, usize) {
        let (of_layers, nodes) = self.layers_at(places, fineness.spacing);
        let count = fineness.rule.len();
        let Some(squares) = &self.squares else {
            return (of_layers.into_iter().map(|layers| self.stage(layers)).collect(), nodes);
        };
        let batch = (BATCH_SAMPLES / count).max(1);
        let albedos = |places: &[Incidence]| fineness.rule.samples(places).albedos(squares);
        let of_squares: Vec<Albedo> = places.par_chunks(batch).flat_map_iter(albedos).collect();
        let both = of_squares.into_iter().zip(of_layers);
        let albedos = both.map(|(squares, layers)| self.stage(squares + layers)).collect();
        (albedos, nodes + places.len() * count)
    }

    /// Returns the sum of the albedos of all layers at each place, and the number of reflectances.
    pub(super) fn layers_at(&self, places: &[Incidence], spacing: f64) -> (Vec<Albedo>, usize) {
        let Some(layers) = &self.layers else { return (vec![DVec3::ZERO; places.len()], 0) };
        let at = |nodes: &mut Nodes, place: &Incidence| {
            let (wi, mut count) = (place.direction(), 0);
            let mut sum = DVec3::ZERO;
            for (layer, width) in self.widths.iter().enumerate() {
                SlopeRule::new(*width, spacing).fill(wi, nodes);
                sum += layers.weighted_sum(layer, &nodes.pairs, &nodes.weights, self.level);
                count += nodes.pairs.len();
            }
            (sum, count)
        };
        let found: Vec<(Albedo, usize)> = places.par_iter().map_init(Nodes::default, at).collect();
        let count = found.iter().map(|(_, count)| count).sum();
        (found.into_iter().map(|(sum, _)| sum).collect(), count)
    }

    /// Applies the output stage to albedos: a constant added to f adds pi times that to the albedo.
    pub(super) fn stage(&self, albedo: Albedo) -> [f64; 3] {
        let output = self.output;
        [0, 1, 2].map(|channel| {
            let mixed = DVec3::from(output.matrix()[channel].map(f64::from)).dot(albedo);
            let offset = std::f64::consts::PI * f64::from(output.offset()[channel]);
            f64::from(output.scale()[channel]) * mixed + offset
        })
    }
}

pub(super) fn largest(albedo: [f64; 3]) -> f64 {
    albedo.into_iter().fold(0.0, f64::max)
}
