//! Reflectance of analytic models and measured BRDFs on sample sets: f64 arithmetic on all cores,
//! rounded to f32 at the end.

use brood_brdf::{Block, Brdf, Level, Model};
use brood_scene::SampleSet;
use rayon::prelude::*;

use crate::lanes::LANES;
use crate::rounding::round_to_f32;

/// Number of samples per task.
const TASK_SAMPLES: usize = 1024;

/// Computes the reflectance of a BRDF on each sample.
///
/// # Shapes
/// `out` is resized to `3 * set.len()`: red, green, blue, in each the samples in order, as an
/// evaluator returns them for one program.
///
/// # Domain
/// The set needs directions; a set of picked pixels may have none. Values beyond f32 become its
/// largest number.
///
/// # Panics
/// If the set has no directions.
pub fn model_reflectance(brdf: &dyn Brdf, set: &SampleSet, out: &mut Vec<f32>) {
    out.clear();
    out.resize(3 * set.len(), 0.0);
    let (red, rest) = out.split_at_mut(set.len());
    let (green, blue) = rest.split_at_mut(set.len());
    let parts = red.par_chunks_mut(TASK_SAMPLES).zip(green.par_chunks_mut(TASK_SAMPLES));
    parts.zip(blue.par_chunks_mut(TASK_SAMPLES)).enumerate().for_each(
        |(part, ((red, green), blue))| {
            for k in 0..red.len() {
                let f =
                    brdf.f(&set.pair(part * TASK_SAMPLES + k).0).to_array().map(round_to_finite);
                [red[k], green[k], blue[k]] = f;
            }
        },
    );
}

/// Returns the largest relative difference between a model evaluated in blocks and its f64
/// reference, both before rounding to f32. Values below 1e-60 are compared relative to 1e-60.
///
/// # Domain
/// The set needs directions.
///
/// # Panics
/// If the set has no directions.
#[must_use]
pub fn model_error(model: &Model, set: &SampleSet, level: Level) -> f64 {
    const SMALLEST: f64 = 1e-60;
    let (prepared, mut block) = (model.prepare(), Block::<LANES>::new());
    let mut worst: f64 = 0.0;
    for pairs in set.pairs(0..set.len()).chunks(LANES) {
        block.fill(level, pairs);
        let f = prepared.f_block(level, &block);
        for (lane, pair) in pairs.iter().enumerate() {
            for (f, exact) in f.iter().zip(prepared.f(pair).to_array()) {
                let error = (f[lane] - exact).abs() / exact.abs().max(SMALLEST);
                worst = if error <= worst { worst } else { error };
            }
        }
    }
    worst
}

/// Returns the nearest finite f32.
fn round_to_finite(value: f64) -> f32 {
    round_to_f32(value).clamp(f32::MIN, f32::MAX)
}

#[cfg(test)]
mod tests {
    use brood_brdf::{DirectionPair, Model, ModelKind};
    use glam::DVec3;

    use super::*;

    #[test]
    fn reflectance_is_in_sample_order_channel_by_channel() {
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
            assert_eq!(f, brdf.f(pair).to_array().map(round_to_finite), "{k}");
        }
    }
}
