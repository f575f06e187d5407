//! Inverse of the film of a scene, for pictures of display codes.

use brood_scene::{Exposure, Film, Tone};

use super::refusal::ImageTargetError;

/// Least value that is displayed as the largest of 256 codes.
const ALMOST_ONE: f64 = 0.9956;

/// Inverse of the film: from displayed values to radiance.
pub(super) struct FilmInverse {
    factor: f64,
    tone: Tone,
    /// True if the exposure is unknown.
    pub(super) is_unknown: bool,
}

impl FilmInverse {
    /// Inverts the film of a scene.
    ///
    /// # Errors
    /// Returns [`ImageTargetError::Tone`] if its tone curve cannot be inverted.
    pub(super) fn new(is_linear: bool, film: Film) -> Result<Self, ImageTargetError> {
        let linear = Self { factor: 1.0, tone: Tone::None, is_unknown: false };
        if is_linear {
            return Ok(linear);
        }
        if film.tone == Tone::Filmic {
            return Err(ImageTargetError::Tone(film.tone.name()));
        }
        Ok(match film.exposure {
            Exposure::Auto => Self { tone: film.tone, is_unknown: true, ..linear },
            Exposure::Ev(ev) => Self { factor: libm::exp2(ev), tone: film.tone, ..linear },
        })
    }

    pub(super) fn radiance(&self, value: f64) -> f64 {
        let exposed = match self.tone {
            Tone::None | Tone::Filmic => value,
            // Inverse of x / (1 + x), which maps 1 to infinity: a displayed 1 counts as the least
            // value that is displayed so.
            Tone::Reinhard => value.min(ALMOST_ONE) / (1.0 - value.min(ALMOST_ONE)),
        };
        exposed / self.factor
    }
}
