//! Models of reflectance on sample sets: f64 arithmetic on all cores, rounded to f32 at the end.

use brood_brdf::{Block, Brdf, Model};
use brood_scene::SampleSet;
use rayon::prelude::*;

use crate::Level;
use crate::canonical::LANES;

/// Samples that one task takes.
const TOGETHER: usize = 1024;

/// The reflectance of a model on each sample.
///
/// # Shapes
/// `3 * set.len()` long: red, green, blue, in each the samples in order, as an evaluator has it for one program. `out` is
/// made so long.
///
/// # Domain
/// A set with directions, which one of picked pixels has not. What is beyond f32 becomes its largest number.
///
/// # Panics
/// Where the set has no directions.
pub fn model_reflectance(brdf: &dyn Brdf, set: &SampleSet, out: &mut Vec<f32>) {
    out.clear();
    out.resize(3 * set.len(), 0.0);
    let (red, rest) = out.split_at_mut(set.len());
    let (green, blue) = rest.split_at_mut(set.len());
    let parts = red.par_chunks_mut(TOGETHER).zip(green.par_chunks_mut(TOGETHER));
    parts.zip(blue.par_chunks_mut(TOGETHER)).enumerate().for_each(
        |(part, ((red, green), blue))| {
            for k in 0..red.len() {
                let f = brdf.f(&set.pair(part * TOGETHER + k).0).to_array().map(nearest);
                [red[k], green[k], blue[k]] = f;
            }
        },
    );
}

/// The largest difference of what blocks of samples give for a model from its f64 reference, before either is rounded to
/// f32: relative, of values below 1e-60 relative to that.
///
/// # Domain
/// A set with directions.
///
/// # Panics
/// Where the set has no directions.
#[must_use]
pub fn model_error(model: &Model, set: &SampleSet, level: Level) -> f64 {
    const LEAST: f64 = 1e-60;
    let (prepared, mut block) = (model.prepare(), Block::<LANES>::new());
    let mut worst: f64 = 0.0;
    for pairs in set.pairs(0..set.len()).chunks(LANES) {
        block.fill(level, pairs);
        let f = prepared.f_block(level, &block);
        for (lane, pair) in pairs.iter().enumerate() {
            for (f, exact) in f.iter().zip(prepared.f(pair).to_array()) {
                let off = (f[lane] - exact).abs() / exact.abs().max(LEAST);
                worst = if off <= worst { worst } else { off };
            }
        }
    }
    worst
}

#[expect(clippy::cast_possible_truncation, reason = "rounded to the nearest f32")]
fn nearest(value: f64) -> f32 {
    (value as f32).clamp(f32::MIN, f32::MAX)
}

#[cfg(test)]
mod tests {
    use brood_brdf::{DirectionPair, Model, ModelKind};
    use glam::DVec3;

    use super::*;

    #[test]
    fn samples_are_in_their_order_channel_by_channel() {
        let model = Model::new(ModelKind::Phong).with("diffuse", &[0.1, 0.2, 0.3]).unwrap();
        let brdf = model.brdf();
        let pairs: Vec<DirectionPair> = (0..3000)
            .map(|k| {
                let z = (f64::from(k) + 0.5) / 3000.0;
                DirectionPair::new(DVec3::Z, DVec3::new((1.0 - z * z).sqrt(), 0.0, z)).unwrap()
            })
            .collect();
        let mut out = vec![7.0; 5];
        model_reflectance(&*brdf, &SampleSet::from_pairs(&pairs, &[]), &mut out);
        assert_eq!(out.len(), 9000);
        for (k, pair) in pairs.iter().enumerate() {
            let f = [out[k], out[3000 + k], out[6000 + k]];
            assert_eq!(f, brdf.f(pair).to_array().map(nearest), "{k}");
        }
    }
}
