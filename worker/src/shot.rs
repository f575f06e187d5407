//! Batch of pictures of programs, and how each is shaded.

use brood_eval::{is_anisotropic, is_prefilterable};
use brood_program::Program;
use brood_protocol::{Frame, PictureFormat};
use brood_scene::{Exposure, Film, LobeShape, PixelArea};

use crate::scene_view::SceneView;

/// Number of f32 values evaluated at once. Larger requests are split: a brood of 256 at 2048 x 2048
/// would take 13 GB.
pub(crate) const BATCH_FLOATS: usize = 32 << 20;

/// View, frame and film of a batch of pictures.
pub(crate) struct Shot<'a> {
    pub(crate) view: SceneView<'a>,
    pub(crate) frame: &'a Frame,
    pub(crate) film: Film,
    /// Requested part of the picture.
    pub(crate) area: PixelArea,
    /// Material of the subject, if the shot shows another part that may see it.
    pub(crate) subject: Option<&'a Program>,
}

impl<'a> Shot<'a> {
    /// Returns the view in which light passes through the subject if its material is clear.
    pub(crate) fn view_for(&self, program: &Program) -> SceneView<'a> {
        let subject = if self.view.stage.part() == 0 { Some(program) } else { self.subject };
        match subject {
            Some(subject) => self.view.with_subject(subject),
            None => self.view.clone(),
        }
    }

    /// Part of the picture that is evaluated if all pixels are developed from one image. Automatic
    /// exposure measures the whole picture, from which the part is cut; so does the refinement of
    /// linear pictures.
    pub(crate) fn lit_area(&self) -> PixelArea {
        match (self.film.exposure, self.frame.format) {
            (Exposure::Ev(_), PictureFormat::Png) => self.area.with_border(self.frame.size_px),
            _ => PixelArea::whole(self.frame.size_px),
        }
    }
}

/// How pictures of a program are shaded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Method {
    /// Samples of all lights.
    Samples,
    /// Environments by tables of the material.
    Tables,
    /// Few samples of the mean radiance of environments.
    Direct(LobeShape),
    /// Points with all lights, for painted materials.
    Points,
    /// The same with what a BRDF reflects, for painted materials that paint one.
    Reflected,
}

impl Method {
    pub(crate) const ALL: [Self; 6] = [
        Self::Samples,
        Self::Tables,
        Self::Direct(LobeShape::Round),
        Self::Direct(LobeShape::Any),
        Self::Points,
        Self::Reflected,
    ];

    /// Returns the method of a program; `prefilters` is true if the picture may prefilter
    /// environments.
    pub(crate) fn of(program: &Program, prefilters: bool) -> Self {
        if program.is_by_brdf() {
            return Self::Reflected;
        }
        if program.is_painted() {
            return Self::Points;
        }
        match prefilters {
            false => Self::Samples,
            true if is_prefilterable(program) => Self::Tables,
            true if is_anisotropic(program) => Self::Direct(LobeShape::Any),
            true => Self::Direct(LobeShape::Round),
        }
    }
}
