//! Copying selected samples of a set into a new set.

use super::layout::SampleCounts;
use super::set::SampleSet;

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
    use glam::{DVec2, DVec3};

    use super::*;

    #[test]
    fn select_keeps_order_of_indices() {
        let direction = |k: u32| DVec3::new(f64::from(k), 1.0, 2.0).normalize();
        let pairs: Vec<_> =
            (0..9).map(|k| DirectionPair::new(direction(k), DVec3::Z).unwrap()).collect();
        let uvs: Vec<_> = (0..9).map(|k| DVec2::new(f64::from(k), -f64::from(k))).collect();
        let mut set = SampleSet::from_pairs(&pairs, &uvs);
        set.irradiance = [1, 10, 100].map(|scale| (0..9).map(|k| (scale * k) as f32).collect());
        let selected = set.select(&[7, 0, 3]);
        assert_eq!(selected.len(), 3);
        for input in [Input::P1, Input::U, Input::V] {
            let values = set.input(input);
            assert_eq!(selected.input(input), [values[7], values[0], values[3]], "{input:?}");
        }
        assert_eq!(selected.irradiance(), [[7., 0., 3.], [70., 0., 30.], [700., 0., 300.]]);
        assert!(set.select(&[]).is_empty());
    }
}
