//! Lit spheres of materials, which the page draws environments from.

use brood_eval::{BACKDROP_TEXELS, is_prefilterable};
use brood_program::Program;
use brood_protocol::{Frame, RenderStats};
use brood_scene::{Backdrop, LobeTable, PixelArea, SphereLayout, backdrop_radiance};

use crate::encoded_picture::EncodedPicture;
use crate::error::RenderError;
use crate::renderer::Renderer;
use crate::scene_view::{LoadedMesh, SceneView};

impl Renderer {
    /// Computes the lit spheres of programs in the environments of a frame.
    pub(crate) fn lit_spheres(
        &self,
        frame: &Frame,
        mesh: &LoadedMesh,
        programs: &[&Program],
    ) -> Result<Vec<EncodedPicture>, RenderError> {
        let scene = frame.scene()?;
        scene.validate()?;
        if !scene.is_prefilterable() || !programs.iter().all(|program| is_prefilterable(program)) {
            let words = "lit spheres need an environment and isotropic homogeneous programs";
            return Err(RenderError::Missing(words.to_owned()));
        }
        let words = || RenderError::Missing("no lit spheres have this size".to_owned());
        let layout = SphereLayout::of_size(frame.size_px).ok_or_else(words)?;
        let assets = self.loaded_assets();
        let texels = frame.size_px.pixels() as usize;
        let made = self.caches.lit_spheres(&SceneView::new(&scene, mesh, &assets), layout);
        let tables = self.lobe_tables(frame.backend, programs)?;
        let tables: Vec<&LobeTable> = tables.iter().map(|table| &**table).collect();
        let radiance = self.caches.counters.timed(
            || made.shade(&tables, texels),
            |evaluation_us| RenderStats { evaluation_us, ..RenderStats::default() },
        );
        let of_program = radiance.iter().zip(programs);
        let backdrop = match scene.backdrop {
            Some(Backdrop::Environment { blur_deg }) => {
                let (side, parts) = (BACKDROP_TEXELS, (&scene, mesh.mesh(), assets.assets()));
                Some(backdrop_radiance(blur_deg, parts, side.into(), PixelArea::whole(side)))
            }
            Some(Backdrop::Color { .. } | Backdrop::Image { .. }) | None => None,
        };
        let encoded = of_program.map(|(own, program)| {
            EncodedPicture::spheres(layout, own, backdrop.as_deref(), program)
        });
        Ok(encoded.collect())
    }
}
