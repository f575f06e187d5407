//! Bumps of programs: on the texture of a mesh, and at pairs of directions.

use std::sync::Arc;

use brood_brdf::DirectionPair;
use brood_program::{Bumps, Program};
use brood_scene::{TextureBumps, above_horizon};
use glam::{DVec2, DVec3};

#[derive(Debug)]
struct ProgramBumps(Bumps);

impl TextureBumps for ProgramBumps {
    fn slopes(&self, uv: DVec2) -> DVec2 {
        self.0.slopes(uv.x, uv.y).into()
    }
}

/// Returns the bumps of a program for a stage; `None` if it has none.
#[must_use]
pub fn texture_bumps(program: &Program) -> Option<Arc<dyn TextureBumps>> {
    let bumps = program.bumps()?;
    Some(Arc::new(ProgramBumps(bumps.clone())))
}

/// Directions at a surface of a program, measured from the normal that its bumps turn.
#[derive(Debug, Clone, Copy)]
pub struct TurnedPair {
    /// The turned directions.
    pub pair: DirectionPair,
    /// Factor from f of the turned pair to f about the mesh's own normal. It is the ratio of both
    /// cosines of wi. It is 0 if wi is below the turned surface.
    pub factor: f64,
}

impl TurnedPair {
    /// Turns a pair in the frame x along u, y along v, z the mesh's normal.
    ///
    /// # Domain
    /// Any pair and finite position. The factor grows without bound where wi grazes the mesh, but
    /// the factor times cos_i does not.
    #[must_use]
    pub fn new(program: &Program, pair: DirectionPair, uv: DVec2) -> Self {
        match program.bumps() {
            Some(bumps) => Self::at_slopes(pair, bumps.slopes(uv.x, uv.y)),
            None => Self { pair, factor: 1.0 },
        }
    }

    /// As [`TurnedPair::new`], where the height changes by these slopes along u and v. Saves
    /// computing them for many pairs at one place.
    #[must_use]
    pub fn at_slopes(pair: DirectionPair, [along_u, along_v]: [f64; 2]) -> Self {
        let n = DVec3::new(-along_u, -along_v, 1.0).normalize();
        // Not 0: n is not horizontal.
        let x = (DVec3::X - n * n.x).normalize();
        let y = n.cross(x);
        let local = |w: DVec3| DVec3::new(w.dot(x), w.dot(y), w.dot(n));
        let (wi, wo) = (local(pair.wi()), local(pair.wo()));
        if wi.z <= 0.0 || pair.cos_i() <= 0.0 {
            return Self { pair, factor: 0.0 };
        }
        let turned = DirectionPair::new(wi, above_horizon(wo));
        let factor = wi.z / pair.cos_i();
        turned.map_or(Self { pair, factor: 0.0 }, |pair| Self { pair, factor })
    }
}

#[cfg(test)]
mod tests {
    use brood_genome::{BirthKey, Dialect, DialectConstraints, Genome, Variation};
    use proptest::prelude::*;

    use super::*;

    fn direction(theta: f64, phi: f64) -> DVec3 {
        DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    }

    #[test]
    fn ramps_turn_directions_by_their_angle() {
        let text = "brood 1\n.model lambert\n.bump strength 0.5\n.bump MOV R0, R0\n";
        let program = Program::lower(&text.parse::<Genome>().unwrap());
        let angle = 0.5_f64.atan();
        // The normal turns towards -x, away from growing heights.
        for theta in [-0.9, -0.3, 0.0, 0.4, 1.0] {
            let pair = DirectionPair::new(direction(theta, 0.0), DVec3::Z).unwrap();
            let TurnedPair { pair: turned, factor } = TurnedPair::new(&program, pair, DVec2::ZERO);
            let expected = direction(theta + angle, 0.0);
            assert!((turned.wi() - expected).length() < 1e-12, "{theta}");
            assert!((factor - (theta + angle).cos() / theta.cos()).abs() < 1e-12);
            assert!((turned.wo() - direction(angle, 0.0)).length() < 1e-12);
        }
        let below = DirectionPair::new(direction(1.3, 0.0), DVec3::Z).unwrap();
        assert!(TurnedPair::new(&program, below, DVec2::ZERO).factor <= 0.0);
    }

    proptest! {
        #[test]
        fn turned_directions_keep_their_angle(
            seed: u64, theta in 0.0..1.55, phi in 0.0..6.3, other in 0.0..0.9,
        ) {
            let constraints = DialectConstraints { bumps: Some(true), ..Default::default() };
            let random = Variation::random(Dialect::default()).with_constraints(constraints);
            let genome = random.birth(BirthKey { seed, slot: 0, attempt: 0 });
            let program = Program::lower(&genome);
            let pair = DirectionPair::new(direction(theta, phi), direction(other, 1.0)).unwrap();
            let turned = TurnedPair::new(&program, pair, DVec2::new(0.3, 0.7));
            prop_assert!(turned.factor >= 0.0 && turned.factor.is_finite());
            prop_assert!(turned.factor * pair.cos_i() <= 1.0 + 1e-12);
            let clamped = turned.pair.cos_o() <= 1.1e-4;
            if turned.factor > 0.0 && !clamped {
                let cosine = |pair: &DirectionPair| pair.wi().dot(pair.wo());
                prop_assert!((cosine(&turned.pair) - cosine(&pair)).abs() < 1e-12);
            }
        }
    }
}
