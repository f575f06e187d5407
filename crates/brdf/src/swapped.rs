//! Adapter that exchanges the roles of light and eye of a BRDF.

use glam::DVec3;

use crate::{Brdf, Claims, DirectionPair};

/// BRDF with `wi` and `wo` exchanged. Renderers that trace paths from the eye pass the eye's
/// direction where a measurement has the light's, and so see a measured material this way. Equal to
/// the wrapped BRDF if that is reciprocal.
pub struct Swapped<'a>(pub &'a dyn Brdf);

impl Brdf for Swapped<'_> {
    fn f(&self, pair: &DirectionPair) -> DVec3 {
        self.0.f(&pair.swapped())
    }

    fn claims(&self) -> Claims {
        // Conserving energy for swapped directions is another integral, unless f is
        // reciprocal.
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
