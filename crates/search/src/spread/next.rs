//! The picture that would tell most about a material, among pictures with the light elsewhere.
//!
//! The drawn materials give the covariance between the pixels of a picture and f at all directions.
//! The variance of f after the picture is that of an ensemble Kalman filter, with the error of the
//! fit as noise of the pixels.
//!
//! # Source
//! Evensen, *The Ensemble Kalman Filter: Theoretical Formulation and Practical Implementation*
//! (2003).

use brood_eval::EvalError;
use brood_light::{Light, LightMove};
use brood_scene::{CameraMove, Correction, LightTerms, PictureSize, Scene};
use brood_target::{KnownView, LightMeans, PixelRadiance, Samples, ViewSetup};
use glam::DVec3;
use rayon::prelude::*;

use super::{Spread, deviation};
use crate::analytic::OPEN_INDEPENDENT;
use crate::solve;

/// Turns of the light to the right and upwards, in degrees.
const RIGHT_DEG: [f64; 12] =
    [0.0, 30.0, 60.0, 90.0, 120.0, 150.0, 180.0, -150.0, -120.0, -90.0, -60.0, -30.0];
const UP_DEG: [f64; 5] = [0.0, 30.0, 60.0, -30.0, -60.0];
/// Side of the grid of pixels that a picture is judged by.
const SIDE_PX: u32 = 24;

/// Least share by which a next picture lowers the error to be worth taking.
const WORTH: f64 = 0.1;
/// Number of other lights, and least angle between two of them in degrees.
const LIGHTS: usize = 3;
const APART_DEG: f64 = 60.0;
/// Least cosine of the angle to the eye: pixels at the outline do not count.
const LEAST_COSINE: f64 = 0.2;

/// A picture that would tell more about a material.
#[derive(Debug, Clone, PartialEq)]
pub struct NextPicture {
    /// Scene: that of a known picture with the light elsewhere.
    pub scene: Scene,
    /// Direction of the light as seen from the object with the eye in front: to the right and
    /// upwards from the eye, in degrees. `None` if the environment is turned instead.
    pub light_deg: Option<[f64; 2]>,
    /// Expected E_log over all directions before and after the picture.
    pub e_log: [f64; 2],
}

impl NextPicture {
    /// Returns the first of sorted pictures if it lowers the expected error by a tenth, so that it
    /// is worth taking.
    #[must_use]
    pub fn worth_taking(sorted: &[Self]) -> Option<&Self> {
        sorted.first().filter(|next| next.e_log[1] < (1.0 - WORTH) * next.e_log[0])
    }

    /// Scenes that show how much materials differ under other lights: that of the first of sorted
    /// pictures, and of the next ones whose light is at least 60 degrees from those before, three
    /// at most. Empty if there are no pictures.
    #[must_use]
    pub fn other_lights(sorted: &[Self]) -> Vec<&Scene> {
        let mut chosen: Vec<&Self> = Vec::new();
        for next in sorted {
            if chosen.len() < LIGHTS && chosen.iter().all(|other| next.is_far_from(other)) {
                chosen.push(next);
            }
        }
        chosen.into_iter().map(|next| &next.scene).collect()
    }

    fn is_far_from(&self, other: &Self) -> bool {
        let cosine = match (self.light_deg, other.light_deg) {
            (Some(one), Some(other)) => direction(one).dot(direction(other)),
            _ => libm::cos((self.scene.light_deg - other.scene.light_deg).to_radians()),
        };
        cosine <= libm::cos(APART_DEG.to_radians()) + 1e-9
    }
}

/// Direction of a lamp to the right and upwards from the eye, which looks from +z.
fn direction(light_deg: [f64; 2]) -> DVec3 {
    let [(sin_right, cos_right), (sin_up, cos_up)] =
        light_deg.map(|deg| libm::sincos(deg.to_radians()));
    DVec3::new(sin_right * cos_up, sin_up, cos_right * cos_up)
}

impl Spread {
    /// Returns pictures with the light elsewhere, sorted by the error expected after each, the
    /// least first. Empty if no light is a lamp without size or an environment that `light_deg`
    /// turns.
    ///
    /// # Errors
    /// Returns [`EvalError`] if a program cannot be evaluated.
    pub fn next_pictures(&self, view: &KnownView) -> Result<Vec<NextPicture>, EvalError> {
        let everywhere = self.everywhere()?;
        let before = deviation(&everywhere);
        let judge = |scene: Scene| -> Result<Option<NextPicture>, EvalError> {
            let Some(shown) = self.shown(view, &scene)? else { return Ok(None) };
            let after = remaining(&shown, &everywhere, self.error);
            let light_deg = scene.lamp_from_eye_deg(&view.setting.mesh, &view.setting.assets);
            Ok(Some(NextPicture { scene, light_deg, e_log: [before, after] }))
        };
        let judged = scenes(&view.setting).into_par_iter().map(judge);
        let judged: Vec<Option<NextPicture>> = judged.collect::<Result<_, _>>()?;
        let mut all: Vec<NextPicture> = judged.into_iter().flatten().collect();
        all.sort_by(|a, b| a.e_log[1].total_cmp(&b.e_log[1]));
        Ok(all)
    }

    /// ln(1 + f cos_i) or means of it that the pixels of a picture would show of every material;
    /// `None` if no pixel is lit.
    fn shown(&self, view: &KnownView, scene: &Scene) -> Result<Option<Vec<Vec<f64>>>, EvalError> {
        let size_px = PictureSize { width: SIDE_PX, height: SIDE_PX };
        let pixels: Vec<(u32, u32)> =
            (0..SIDE_PX * SIDE_PX).map(|at| (at % SIDE_PX, at / SIDE_PX)).collect();
        let (mesh, assets) = (&*view.setting.mesh, &view.setting.assets);
        let light = LightTerms::render(mesh, scene, assets, size_px, &pixels, 1);
        let nothing = PixelRadiance { radiance: [0.0; 3], is_known: [true; 3], centre: None };
        let (means, _) = LightMeans::of_pixels(&light, &vec![nothing; pixels.len()]);
        let is_clear = |mean: &usize| {
            let (first, _) = means.terms(*mean)[0];
            means.pairs()[first as usize].cos_o() > LEAST_COSINE
        };
        let means = means.select((0..means.len()).filter(is_clear));
        if means.is_empty() {
            return Ok(None);
        }
        let shown = self.each(|program| {
            let f = Samples::of_program(program, means.pairs().to_vec())?;
            let means = means.of(f.values());
            Ok(means.as_flattened().iter().map(|mean| libm::log1p(*mean)).collect())
        });
        shown.map(Some)
    }
}

/// The scene of a view with its light elsewhere. All lamps without size move together. In scenes
/// without such lamps, the environments turn that `light_deg` turns.
pub(super) fn scenes(setting: &ViewSetup) -> Vec<Scene> {
    let scene = &setting.scene;
    let corrected = |right: f64, up: f64| {
        let by = LightMove { turn_deg: [right, up], distance: 1.0 };
        let lights = vec![by; scene.lights.len()];
        let by = Correction { lights, camera: CameraMove::default() };
        // Only lights move, so the size of the picture does not matter.
        scene.corrected(&setting.mesh, SIDE_PX, &by)
    };
    if scene.lights.iter().any(Light::is_movable) {
        let places = UP_DEG.iter().flat_map(|up| RIGHT_DEG.map(|right| (right, *up)));
        return places.skip(1).map(|(right, up)| corrected(right, up)).collect();
    }
    let turns = |light: &Light| matches!(light, Light::Environment(own) if !own.fixed);
    if scene.lights.iter().any(turns) {
        let turned = |by: &f64| Scene { light_deg: scene.light_deg + by, ..scene.clone() };
        return RIGHT_DEG[1..].iter().map(turned).collect();
    }
    Vec::new()
}

/// Expected E_log over all directions after a picture.
///
/// # Shapes
/// One row per material in both.
fn remaining(shown: &[Vec<f64>], everywhere: &[Vec<f64>], error: f64) -> f64 {
    let count = shown.len();
    // A picture whose pixels are all lit counts as OPEN_INDEPENDENT independent observations.
    let pixels = f64::from(3 * SIDE_PX * SIDE_PX);
    let scale = OPEN_INDEPENDENT / (pixels * error * count as f64);
    let (shown, wanted) = (centred(shown), centred(everywhere));
    let mut matrix = vec![0.0; count * count];
    for a in 0..count {
        for b in 0..count {
            let product: f64 = shown[a].iter().zip(&shown[b]).map(|(a, b)| a * b).sum();
            matrix[a * count + b] = scale * product + if a == b { 1.0 } else { 0.0 };
        }
    }
    let Some(upper) = solve::factor(matrix, count) else { return deviation(everywhere) };
    let columns = wanted[0].len();
    let sum: f64 = (0..columns)
        .map(|column| {
            let own = wanted.iter().map(|row| row[column]).collect();
            solve::forward(&upper, own).iter().map(|value| value * value).sum::<f64>()
        })
        .sum();
    (sum / (count * columns) as f64).sqrt()
}

/// Rows less their mean.
fn centred(rows: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let number = rows.len() as f64;
    let means: Vec<f64> =
        (0..rows[0].len()).map(|at| rows.iter().map(|row| row[at]).sum::<f64>() / number).collect();
    rows.iter().map(|row| row.iter().zip(&means).map(|(x, mean)| x - mean).collect()).collect()
}
