//! Approximate energy limit of programs: the exact one takes a tenth of a second.

use brood_brdf::DirectionPair;
use brood_eval::{CanonicalEvaluator, Evaluator, LobeRule, direction_at};
use brood_program::Program;
use brood_scene::SampleSet;

use crate::lobes::ANGLES;

/// Order of the quadrature ([`LobeRule`]): within 3 % for programs without kinks.
const ORDER: usize = 16;
/// Incident light comes from every second of [`ANGLES`] and from one azimuth. More directions cost
/// time, and albedos seldom depend on the azimuth.
const STEP: usize = 2;

/// Nodes of the quadratures of directional albedos.
pub(crate) struct Albedos {
    set: SampleSet,
    /// Quadrature weight of each sample.
    weights: Vec<f64>,
    /// End of the samples of each incident direction.
    ends: Vec<usize>,
}

impl Albedos {
    pub(crate) fn new() -> Self {
        let rule = LobeRule::new(ORDER);
        let mut pairs: Vec<DirectionPair> = Vec::new();
        let (mut weights, mut ends) = (Vec::new(), Vec::new());
        for angle in ANGLES.into_iter().step_by(STEP) {
            let (sin, cos) = libm::sincos(angle.to_radians());
            for (pair, weight) in rule.nodes(direction_at(sin, cos, 0.0)) {
                pairs.push(pair);
                weights.push(weight);
            }
            ends.push(pairs.len());
        }
        Self { set: SampleSet::from_pairs(&pairs, &[]), weights, ends }
    }

    /// Divisor of the energy limit of each program: its largest albedo, or 1 if that is less.
    ///
    /// # Shapes
    /// One for each program, in their order.
    pub(crate) fn divisors(&self, programs: &[&Program]) -> Vec<f64> {
        let mut f = Vec::new();
        CanonicalEvaluator::default()
            .eval(programs, &self.set, &mut f)
            .expect("the canonical evaluator runs every program");
        let channels = f.chunks(self.weights.len()).map(|f| self.largest(f)).collect::<Vec<f64>>();
        channels.chunks(3).map(|albedos| albedos.iter().copied().fold(1.0, f64::max)).collect()
    }

    /// Largest albedo of a channel.
    fn largest(&self, f: &[f32]) -> f64 {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        let albedo = |(start, end): (usize, &usize)| {
            let nodes = f[start..*end].iter().zip(&self.weights[start..*end]);
            nodes.map(|(f, weight)| f64::from(*f) * weight).sum::<f64>()
        };
        starts.zip(&self.ends).map(albedo).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use brood_eval::energy_limit;
    use brood_genome::BirthKey;

    use super::*;
    use crate::gp::breed::random;

    #[test]
    fn divisors_are_near_the_exact_ones() {
        let program = |seed| {
            let key = BirthKey { seed, slot: 0, attempt: 0 };
            Program::lower(&random(brood_target::Strategy::DIALECT, key))
        };
        let programs: Vec<Program> = (0..40).map(program).collect();
        let found = Albedos::new().divisors(&programs.iter().collect::<Vec<_>>());
        let exact: Vec<f64> =
            programs.iter().map(|program| energy_limit(program).divisor).collect();
        // Random programs have albedos of any size. The exact limit also allows for peaks that it
        // may have missed.
        let usual: Vec<(f64, f64)> =
            found.into_iter().zip(exact).filter(|(_, exact)| *exact < 20.0).collect();
        assert!(usual.len() > 8, "{usual:?}");
        assert!(usual.iter().all(|(a, b)| (a / b - 1.0).abs() < 0.15), "{usual:?}");
    }
}
