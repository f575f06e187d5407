//! Outliers: pixels that differ from their neighbours by more than noise and a smooth material do,
//! as dust, scratches and hot pixels do.

use brood_brdf::DirectionPair;
use rayon::prelude::*;

/// Offsets of neighbours to the right and downwards. Those to the other side are neighbours too:
/// both together predict the pixel between them.
const OFFSETS: [(isize, isize); 12] = [
    (1, 1),
    (2, 0),
    (2, 2),
    (3, 1),
    (1, 3),
    (3, 3),
    (0, 2),
    (-1, 1),
    (-2, 2),
    (-3, 1),
    (-1, 3),
    (-3, 3),
];
/// Least number of predictions that a pixel is judged by.
const FEWEST: usize = 6;
/// Largest distance between half vectors and largest difference of the cosines of light and half
/// vector, up to which a pixel is a neighbour; others are beyond a crease.
const ALIKE: (f64, f64) = (0.3, 0.15);
/// Deviation from the median of the predictions that makes an outlier, as a multiple of their
/// median deviation: 5.7 standard deviations of normal noise.
const FAR: f64 = 12.0;
/// Least deviation of ln f that makes an outlier.
const HARMFUL: f64 = 0.1;
/// Share of the median f that is added before the logarithm, because noise is large against dark
/// pixels.
const DARK: f64 = 0.05;

/// A pixel with its pair of directions and f.
pub(super) type Seen = (usize, DirectionPair, [f64; 3]);

/// Returns true for each outlier.
///
/// # Shapes
/// `seen` holds pixels of a picture of `pixels` pixels and that width, in ascending order; one
/// result each.
pub(super) fn outliers(seen: &[Seen], width: usize, pixels: usize) -> Vec<bool> {
    let mut places = vec![None; pixels];
    for (place, (pixel, ..)) in seen.iter().enumerate() {
        places[*pixel] = Some(place);
    }
    let dark = [0, 1, 2].map(|channel| {
        let mut all: Vec<f64> = seen.iter().map(|(.., f)| f[channel]).collect();
        if all.is_empty() { 0.0 } else { DARK * median(&mut all) }
    });
    let log = |(_, pair, f): &Seen| {
        let half = (pair.wi() + pair.wo()).normalize();
        let logs = [0, 1, 2].map(|k| libm::log((f[k] + dark[k]).max(f64::MIN_POSITIVE)));
        (half, half.dot(pair.wi()), logs)
    };
    let logs: Vec<_> = seen.par_iter().map(log).collect();
    let is_outlier = |place: usize| {
        let (half, cosine, own) = &logs[place];
        let neighbour = |right: isize, down: isize| {
            let other = places[moved(seen[place].0, (right, down), width, pixels)?]?;
            let (half_of, cosine_of, logs) = &logs[other];
            let is_alike =
                half.distance(*half_of) < ALIKE.0 && (cosine - cosine_of).abs() < ALIKE.1;
            is_alike.then_some(logs)
        };
        let both =
            |(right, down): &(isize, isize)| neighbour(*right, *down).zip(neighbour(-right, -down));
        let both: Vec<_> = OFFSETS.iter().filter_map(both).collect();
        both.len() >= FEWEST
            && (0..3).any(|channel| {
                let predicted = both.iter().map(|(a, b)| 0.5 * (a[channel] + b[channel]));
                let mut predicted: Vec<f64> = predicted.collect();
                let middle = median(&mut predicted);
                predicted.iter_mut().for_each(|log| *log = (*log - middle).abs());
                let least = (FAR * median(&mut predicted)).max(HARMFUL);
                (own[channel] - middle).abs() > least
            })
    };
    (0..seen.len()).into_par_iter().map(is_outlier).collect()
}

/// Index of a pixel that many columns to the right and rows down; `None` beyond the picture.
fn moved(
    pixel: usize,
    (right, down): (isize, isize),
    width: usize,
    pixels: usize,
) -> Option<usize> {
    let x = (pixel % width).checked_add_signed(right).filter(|x| *x < width)?;
    let y = (pixel / width).checked_add_signed(down)?;
    Some(y * width + x).filter(|pixel| *pixel < pixels)
}

/// Median, the upper of two. Reorders the values, of which there must be one.
fn median(values: &mut [f64]) -> f64 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
