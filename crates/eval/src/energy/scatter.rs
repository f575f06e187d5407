//! Scattered places of the search: no two share a coordinate, so they meet ridges of the albedo
//! that are narrower than the spacing of the grid.

use brood_program::Program;
use glam::DVec2;
use rayon::prelude::*;

use super::limit::Incidence;
use super::subject::{ProgramRule, Samples, Subject, largest};

/// Number of places evaluated at once.
const TOGETHER: usize = 64;

/// Scattered places and their samples.
#[derive(Debug)]
pub(super) struct Scatter {
    /// In parts, for several threads.
    parts: Vec<(Vec<Incidence>, Samples)>,
}

impl Scatter {
    /// Scatters `count` places, equally many between each two of the ascending tilts. All are at
    /// azimuth 0 if `azimuth` is false.
    pub(super) fn new(count: usize, tilts: &[f64], azimuth: bool, rule: &ProgramRule) -> Self {
        let place = |index: usize| {
            let [tilt, turn, u, v] = coordinates(index);
            let at = tilt * (tilts.len() - 1) as f64;
            let (ring, share) = (at as usize, at.fract());
            let tilt = tilts[ring] + share * (tilts[ring + 1] - tilts[ring]);
            let turn = if azimuth { 0.5 * turn } else { 0.0 };
            Incidence { tilt, turn, uv: DVec2::new(u, v) }
        };
        let places: Vec<Incidence> = (0..count).map(place).collect();
        let part = |places: &[Incidence]| (places.to_vec(), rule.samples(places));
        Self { parts: places.chunks(TOGETHER).map(part).collect() }
    }

    /// Number of samples of all places.
    pub(super) fn samples(&self) -> usize {
        self.parts.iter().map(|(_, samples)| samples.len()).sum()
    }

    /// Returns each place with the largest albedo there of the program without its layers.
    pub(super) fn albedos(
        &self,
        subject: &Subject<'_>,
        squares: &Program,
    ) -> Vec<(Incidence, f64)> {
        let of_part = |(places, samples): &(Vec<Incidence>, Samples)| -> Vec<(Incidence, f64)> {
            let albedos = samples.albedos(squares).into_iter();
            let largest = albedos.map(|albedo| largest(subject.stage(albedo)));
            places.iter().copied().zip(largest).collect()
        };
        self.parts.par_iter().map(of_part).collect::<Vec<_>>().concat()
    }
}

/// Returns the fractional parts of multiples of the powers of 1 / x, x^5 = x + 1: a sequence in
/// [0, 1)^4 whose values are all different along each axis.
///
/// # Source
/// Roberts 2018, *The Unreasonable Effectiveness of Quasirandom Sequences*.
fn coordinates(index: usize) -> [f64; 4] {
    const ROOT: f64 = 1.167_303_978_261_418_7;
    let mut share = 1.0;
    [0, 1, 2, 3].map(|_| {
        share /= ROOT;
        (0.5 + index as f64 * share).fract()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_different_and_even_along_each_axis() {
        for axis in 0..4 {
            let mut values: Vec<f64> = (0..2048).map(|index| coordinates(index)[axis]).collect();
            values.sort_by(f64::total_cmp);
            let widest = values.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
            assert!(widest < 3.0 / 2048.0, "{axis}: {widest}");
            assert!(values.windows(2).all(|pair| pair[1] > pair[0]), "{axis}");
        }
    }
}
