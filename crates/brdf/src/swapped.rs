//! A material with the roles of light and eye exchanged.

use glam::DVec3;

use crate::{Brdf, Claims, DirectionPair};

/// Reflects from `wo` to `wi` what the other reflects from `wi` to `wo`, as renderers see a measured material that follow light from the
/// eye and give its direction where the measurement has that of the light. The same material where it is reciprocal.
pub struct Swapped<'a>(pub &'a dyn Brdf);

impl Brdf for Swapped<'_> {
    fn f(&self, pair: &DirectionPair) -> DVec3 {
        self.0.f(&pair.swapped())
    }

    fn claims(&self) -> Claims {
        // What it sends back at most is another integral.
        let Claims { reciprocal, conserving } = self.0.claims();
        Claims { reciprocal, conserving: conserving && reciprocal }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Model, ModelKind};

    #[test]
    fn values_are_those_of_the_swapped_pair() {
        let phong = Model::new(ModelKind::Phong).brdf();
        let at = |x: f64| DVec3::new(x, 0.2, 0.7).normalize();
        let pair = DirectionPair::new(at(-0.6), at(0.3)).unwrap();
        assert_ne!(phong.f(&pair), phong.f(&pair.swapped()));
        let swapped = Swapped(&*phong);
        assert_eq!(swapped.f(&pair), phong.f(&pair.swapped()));
        assert!(!swapped.claims().reciprocal);
    }
}
