//! Pixels in highlights. Within such a pixel theta_h, the angle between half vector and normal,
//! changes by a large share of itself, so f may too.

use brood_brdf::DirectionPair;
use brood_scene::{PixelSpan, SampleSet};

use super::pixel::{around, spans};

/// Number of points of such a pixel, along a side.
pub(super) const PARTS: u32 = 8;
/// Largest angle between half vector and normal, as a multiple of its change to a neighbour. Beyond
/// it, f = theta_h^-4 is within 3 % at the centre of a pixel of its mean over the pixel.
const REACH: f64 = 6.0;

/// Returns true for each pixel of a picture in a highlight of a light that reaches its centre. If
/// there are more than `most`, those nearest to a highlight count.
///
/// # Panics
/// If the set is not that of a picture.
#[must_use]
pub fn highlights(set: &SampleSet, most: usize) -> Vec<bool> {
    let layout = set.image().expect("the set has a picture layout");
    let (size, spans) = ((layout.width as usize, layout.height as usize), spans(layout));
    // theta_h of each light at the centre of each pixel.
    let thetas = |span: &Option<PixelSpan>| -> Vec<f64> {
        let at = span.map_or(0..0, |span| span.start..span.centre_end);
        at.map(|at| theta_h(&set.pair(at as usize).0)).collect()
    };
    let thetas: Vec<Vec<f64>> = spans.iter().map(thetas).collect();
    let distance = |pixel: usize| {
        let own = &thetas[pixel];
        let near = || around(pixel, size, 1).map(|other| &thetas[other]);
        let of = |light: usize| {
            let comparable = near().filter(|other| other.len() == own.len());
            let change = comparable.map(|other| (other[light] - own[light]).abs());
            own[light] / change.fold(f64::MIN_POSITIVE, f64::max)
        };
        (0..own.len()).map(of).fold(f64::INFINITY, f64::min)
    };
    let all = (0..spans.len()).map(|pixel| (distance(pixel), pixel));
    let mut found: Vec<(f64, usize)> = all.filter(|(distance, _)| *distance < REACH).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    found.truncate(most);
    let mut is_highlight = vec![false; spans.len()];
    found.into_iter().for_each(|(_, pixel)| is_highlight[pixel] = true);
    is_highlight
}

/// Angle between half vector and normal in radians, precise near 0.
fn theta_h(pair: &DirectionPair) -> f64 {
    let half = pair.wi() + pair.wo();
    libm::atan2(libm::hypot(half.x, half.y), half.z)
}
