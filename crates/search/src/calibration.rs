//! Calibration of photographs: corrects lights, camera and brightness together with a material.
//!
//! A photograph's scene is known only roughly. Its unknowns (directions and distances of lights,
//! pose and field of view of the camera, brightness) have the standard deviations of
//! [`Refine`](brood_scene::Refine). They are fitted with the parameters of analytic models to all
//! pixels, the outline included, by the Levenberg-Marquardt method. docs/maths/fit.md explains the
//! design.
//!
//! `unknown` has the unknowns and the scenes that they give, `shot` the pictures of these scenes,
//! `joint` the least-squares problem. This file has the order of the fits.

mod joint;
mod shot;
mod unknown;

use brood_target::{KnownView, MeasuredTarget, Pictures, PicturesError, Samples, ViewError};

use crate::analytic::{Analytic, Space, default_kinds};
use joint::{Fit, Joint};
use shot::Photograph;
use unknown::Unknowns;

pub use unknown::Corrected;

/// Seed of the models' starts.
const SEED: u64 = 1;
/// Generations of the first search for models.
const GENERATIONS: u32 = 2;
/// Number of models that are fitted with the unknowns in the first round and in later ones, besides
/// the best of the round before.
const TRIED: [usize; 2] = [3, 1];
/// Largest number of rounds. The next one follows if an unknown has moved by more than `STILL` of
/// its standard deviation.
const ROUNDS: usize = 2;
const STILL: f64 = 0.05;

/// Pictures in corrected scenes.
#[derive(Debug)]
pub struct Calibrated {
    /// The pictures.
    pub pictures: Pictures,
    /// Samples of the fitted ones.
    pub target: MeasuredTarget,
    /// Corrections; empty if every scene is exact.
    pub corrections: Vec<Corrected>,
}

/// Corrects the scenes of pictures within their uncertainties. Held-out pictures are not fitted;
/// cameras and lights that they share with fitted ones are corrected with these.
///
/// Deterministic: depends on the pictures alone, not on the number of threads.
///
/// # Errors
/// Returns [`PicturesError`] if the pictures are no target in the corrected scenes.
pub fn calibrate(pictures: Pictures, target: MeasuredTarget) -> Result<Calibrated, PicturesError> {
    let unknowns = Unknowns::of(&pictures.views);
    if unknowns.is_empty() {
        return Ok(Calibrated { pictures, target, corrections: Vec::new() });
    }
    let photographs = Photograph::all(&pictures.views);
    let mut best: Option<Fit> = None;
    let mut samples = target.fitted;
    for round in 0..ROUNDS {
        let z = best.as_ref().map_or_else(|| unknowns.stated(), |best| best.unknowns().to_vec());
        let joint = Joint::new(&pictures.views, &photographs, &unknowns, &z);
        let mut starts: Vec<(Space, Vec<f64>)> = best.iter().map(Fit::start).collect();
        starts.extend(models(&samples, round));
        let fits = starts.into_iter().map(|(space, x)| joint.fit(space, x));
        // No model has a finite error on the samples: the scenes stay as they are.
        let Some(found) = fits.min_by(|a, b| a.score.total_cmp(&b.score)) else { break };
        let moved = z.iter().zip(found.unknowns()).map(|(a, b)| (a - b).abs());
        let is_still = moved.fold(0.0, f64::max) < STILL;
        best = Some(found);
        if is_still || round + 1 == ROUNDS {
            break;
        }
        let z = best.as_ref().expect("a fit has just been kept").unknowns();
        samples = gathered(&pictures.views, &unknowns, z)?.1.fitted;
    }
    let Some(best) = best else {
        let z = unknowns.stated();
        let (pictures, target) = gathered(&pictures.views, &unknowns, &z)?;
        return Ok(Calibrated { pictures, target, corrections: Vec::new() });
    };
    let corrections = unknowns.corrected(best.unknowns(), &best.deviations);
    let (pictures, target) = gathered(&pictures.views, &unknowns, best.unknowns())?;
    Ok(Calibrated { pictures, target, corrections })
}

/// The most probable models of samples, with their parameters.
fn models(samples: &Samples, round: usize) -> Vec<(Space, Vec<f64>)> {
    let mut search = Analytic::new(samples, default_kinds(), &[], SEED);
    for _ in 0..if round == 0 { GENERATIONS } else { 1 } {
        search.step();
    }
    search.best_points(TRIED[round.min(1)])
}

/// The pictures in scenes with these unknowns, and their samples.
fn gathered(
    views: &[KnownView],
    unknowns: &Unknowns,
    z: &[f64],
) -> Result<(Pictures, MeasuredTarget), PicturesError> {
    let corrected = |(index, view): (usize, &KnownView)| -> Result<_, ViewError> {
        view.in_scene(unknowns.scene(view, index, z), unknowns.balance(index, z))
    };
    Pictures::gather(views.iter().enumerate().map(corrected))
}

#[cfg(test)]
#[path = "calibration_tests.rs"]
mod tests;
