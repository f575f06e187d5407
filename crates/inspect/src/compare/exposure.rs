//! Exposures for a comparison, measured on small pictures: one for all, and those of the whole light circle.

use brood_eval::Gain;
use brood_program::Program;
use brood_scene::{
    EV_MAX, Exposure, Film, LightAssets, Mesh, PixelArea, Raster, SampleSet, Sampling, Scene,
};

use super::Specimen;

/// Places of the light circle that exposures are measured at, and the side of the pictures.
const PLACES: u32 = 8;
const PX: u32 = 64;

/// What a small camera sees of a scene, with the light in its own place and all around its circle.
#[derive(Debug)]
pub struct LightCircle {
    own: SampleSet,
    places: Vec<SampleSet>,
}

impl LightCircle {
    /// Traces them.
    #[must_use]
    pub fn trace(mesh: &Mesh, scene: &Scene, assets: &LightAssets) -> Self {
        let raster =
            Raster { size_px: PX, sampling: Sampling::Fixed(1), area: PixelArea::whole(PX) };
        let set = |scene: &Scene| SampleSet::render_lit(mesh, scene, assets, raster);
        let degrees = |place| 360.0 * f64::from(place) / f64::from(PLACES);
        let places = (0..PLACES).map(|place| set(&scene.with_light_deg(degrees(place)))).collect();
        Self { own: set(scene), places }
    }

    /// The automatic exposure that a program has over the whole circle.
    #[must_use]
    pub fn common_ev(&self, program: &Program) -> f64 {
        Gain::common(program, &self.places).ev
    }

    /// The exposure of a film for a material where the light is, within what a scene may have.
    #[must_use]
    pub fn ev(&self, of: &Specimen<'_>, film: Film) -> f64 {
        // What lies beyond is black or burnt out either way.
        ev(of, &self.own, film).clamp(-EV_MAX, EV_MAX)
    }

    /// Least and largest automatic exposure of a material around the circle.
    #[must_use]
    pub(super) fn extremes_ev(&self, of: &Specimen<'_>) -> [f64; 2] {
        let film = Film { exposure: Exposure::Auto, ..Film::default() };
        let all = self.places.iter().map(|set| ev(of, set, film));
        all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], ev| [low.min(ev), high.max(ev)])
    }
}

fn ev(of: &Specimen<'_>, set: &SampleSet, film: Film) -> f64 {
    let mut f = Vec::new();
    of.shade(set, &mut f);
    Gain::new(film, set, &f).ev
}
