//! Albedos on the grid of the search, and their peaks.

/// Albedos on the grid.
pub(super) struct Lattice<'a> {
    /// Numbers of places along u, v, tilt and azimuth; the last axis is cyclic.
    pub(super) sides: [usize; 4],
    /// Number of tilts that are searched.
    pub(super) rings: usize,
    pub(super) albedos: &'a [f64],
}

impl Lattice<'_> {
    /// Returns the indices of the best peaks, best first.
    pub(super) fn peaks(&self, count: usize) -> Vec<usize> {
        let mut found: Vec<(usize, f64)> =
            (0..self.albedos.len()).filter_map(|index| Some((index, self.peak(index)?))).collect();
        // A stable sort keeps the first of equal places first.
        found.sort_by(|a, b| b.1.total_cmp(&a.1));
        found.into_iter().take(count).map(|(index, _)| index).collect()
    }

    /// Adds the places with the largest albedos until there are `count`.
    pub(super) fn add_largest(&self, starts: &mut Vec<usize>, count: usize) {
        let searched = |index: &usize| index / self.sides[3] % self.sides[2] < self.rings;
        let mut all: Vec<usize> = (0..self.albedos.len()).filter(searched).collect();
        all.sort_by(|a, b| self.albedos[*b].total_cmp(&self.albedos[*a]));
        for index in all.into_iter().take(count) {
            if starts.len() < count && self.albedos[index] > 0.0 && !starts.contains(&index) {
                starts.push(index);
            }
        }
    }

    /// Returns the albedo that parabolas of its logarithm reach near a place, or `None` if a
    /// neighbour has a larger albedo.
    fn peak(&self, index: usize) -> Option<f64> {
        let middle = self.albedos[index];
        let ring = index / self.sides[3] % self.sides[2];
        if ring >= self.rings || middle <= 0.0 {
            return None;
        }
        let mut rise = 0.0;
        let mut stride = 1;
        for axis in (0..4).rev() {
            let side = self.sides[axis];
            let at = index / stride % side;
            let end = if axis == 2 { self.rings } else { side };
            let neighbour = |at: usize, to: usize| self.albedos[index + to * stride - at * stride];
            let below = (at > 0).then(|| neighbour(at, at - 1));
            let above = (at + 1 < end).then(|| neighbour(at, at + 1));
            let is_cyclic = axis == 3 && side > 2;
            let below = below.or_else(|| is_cyclic.then(|| neighbour(at, side - 1)));
            let above = above.or_else(|| is_cyclic.then(|| neighbour(at, 0)));
            if below.is_some_and(|below| below > middle)
                || above.is_some_and(|above| above > middle)
            {
                return None;
            }
            if let (Some(below), Some(above)) = (below, above) {
                rise += log_rise(below, middle, above);
            }
            stride *= side;
        }
        Some(libm::log(middle) + rise)
    }
}

/// Rise of the logarithm from the middle of three places to the top of the parabola through them.
fn log_rise(below: f64, middle: f64, above: f64) -> f64 {
    let log = |albedo: f64| libm::log((albedo / middle).max(f64::MIN_POSITIVE));
    let (below, above) = (log(below), log(above));
    let bend = -(below + above);
    if bend > 0.0 { (above - below) * (above - below) / (8.0 * bend) } else { 0.0 }
}
