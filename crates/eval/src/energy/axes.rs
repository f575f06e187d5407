//! Coordinates of a place that can change the result of a program.

use brood_brdf::Input;
use brood_program::Program;
use glam::DVec2;

use super::limit::{Incidence, tilt_of};

/// Inputs that change when the surface turns about its normal; a program without them is isotropic.
const AZIMUTHAL: [Input; 4] = [Input::SmoothP5, Input::SmoothP6, Input::PaperP5, Input::PaperP6];
/// Inputs that vary fast near the mirror direction.
const HIGHLIGHT: [Input; 4] =
    [Input::LogTanHalf, Input::NormalDotHalf, Input::CosineDifference, Input::MirrorAsymmetry];
/// Cosine of the flattest incident direction, if a layer reflects without bound at the horizon.
pub const UNBOUNDED_COS: f64 = 1e-4;

/// True if anything that the program reads changes when the surface turns about its normal;
/// otherwise the program is isotropic.
#[must_use]
pub fn is_anisotropic(program: &Program) -> bool {
    let inputs = program.inputs();
    AZIMUTHAL.into_iter().any(|input| inputs.contains(input))
        || program.layers().iter().any(|model| *model != model.isotropic())
}

/// Coordinates of a place that can change the result of a program.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axes {
    pub(super) azimuth: bool,
    pub(super) u: bool,
    pub(super) v: bool,
    /// True if there is a program beside the layers.
    pub(super) program: bool,
    /// True if an input varies fast near the mirror direction.
    pub(super) highlight: bool,
    /// Largest tilt.
    pub(super) tilt_max: f64,
}

impl Axes {
    pub(super) fn of(program: &Program) -> Self {
        let inputs = program.inputs();
        let reads = |input| inputs.contains(input);
        let is_unbounded = program.layers().iter().any(|model| !model.is_bounded_at_horizon());
        Self {
            azimuth: is_anisotropic(program),
            u: reads(Input::U),
            v: reads(Input::V),
            program: !program.steps().is_empty(),
            highlight: HIGHLIGHT.into_iter().any(reads),
            tilt_max: if is_unbounded { tilt_of(UNBOUNDED_COS) } else { 2.0 },
        }
    }

    /// Returns the place within the domain.
    pub(super) fn clamped(&self, place: Incidence) -> Incidence {
        Incidence {
            tilt: place.tilt.clamp(0.0, self.tilt_max),
            uv: place.uv.clamp(DVec2::ZERO, DVec2::ONE),
            ..place
        }
    }

    /// Returns the places one step away along each axis, both ways.
    pub(super) fn neighbours(&self, place: &Incidence, step: &Incidence) -> Vec<[Incidence; 2]> {
        let mut all = Vec::new();
        let mut add = |along: Incidence| {
            all.push([-1.0, 1.0].map(|sign| {
                self.clamped(Incidence {
                    tilt: place.tilt + sign * along.tilt,
                    turn: place.turn + sign * along.turn,
                    uv: place.uv + sign * along.uv,
                })
            }));
        };
        let still = Incidence { tilt: 0.0, turn: 0.0, uv: DVec2::ZERO };
        // Near the normal, steps are in proportion to the tilt.
        let share = if place.tilt > 0.0 { (16.0 * place.tilt).min(1.0) } else { 1.0 };
        add(Incidence { tilt: share * step.tilt, ..still });
        if self.azimuth {
            add(Incidence { turn: step.turn, ..still });
        }
        if self.u {
            add(Incidence { uv: DVec2::X * step.uv.x, ..still });
        }
        if self.v {
            add(Incidence { uv: DVec2::Y * step.uv.y, ..still });
        }
        all
    }
}
