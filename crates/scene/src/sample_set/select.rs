//! Copying selected samples of a set into a new set.

use super::SampleSet;
use super::layout::SampleCounts;

impl SampleSet {
    /// Copies the samples at `indices`, in this order, into a set without an image.
    ///
    /// # Panics
    /// If an index is out of range, or the set was picked without directions.
    #[must_use]
    pub fn select(&self, indices: &[u32]) -> Self {
        let pick = |values: &Vec<f32>| indices.iter().map(|k| values[*k as usize]).collect();
        let count = indices.len() as u64;
        Self::new(
            indices.iter().map(|k| self.pairs[*k as usize]).collect(),
            indices.iter().map(|k| self.uvs[*k as usize]).collect(),
            [0, 1, 2].map(|channel| pick(&self.irradiance[channel])),
            None,
            SampleCounts { covered: count, lit: count, ..SampleCounts::default() },
        )
    }
}

#[cfg(test)]
mod tests {
    use brood_brdf::{DirectionPair, Input};
    use glam::DVec3;

    use super::*;

    #[test]
    fn select_keeps_order_of_indices() {
        let direction = |k: u32| DVec3::new(f64::from(k), 1.0, 2.0).normalize();
        let pairs: Vec<_> =
            (0..9).map(|k| DirectionPair::new(direction(k), DVec3::Z).unwrap()).collect();
        let set = SampleSet::from_pairs(&pairs, &[]);
        let selected = set.select(&[7, 0, 3]);
        assert_eq!(selected.len(), 3);
        let p1 = set.input(Input::P1);
        assert_eq!(selected.input(Input::P1), [p1[7], p1[0], p1[3]]);
        assert!(set.select(&[]).is_empty());
    }
}
