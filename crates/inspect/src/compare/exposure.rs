//! Exposures for a comparison, measured on small pictures over the light orbit.

use brood_eval::Gain;
use brood_light::LightAssets;
use brood_mesh::Mesh;
use brood_program::Program;
use brood_scene::{EV_MAX, Exposure, Film, PixelArea, Raster, SampleSet, Sampling, Scene};

use super::Specimen;

/// Positions of the light on its orbit.
const PLACES: u32 = 8;
/// Side of the pictures in pixels.
const PX: u32 = 64;

/// Small sample sets of a scene, one with its lights as they are, the others with the lights at
/// equal steps along the light orbit.
#[derive(Debug)]
pub struct LightOrbit {
    /// With the lights as they are.
    own: SampleSet,
    /// With the lights at [`PLACES`] positions on the orbit.
    places: Vec<SampleSet>,
}

impl LightOrbit {
    /// Traces the sample sets.
    #[must_use]
    pub fn trace(mesh: &Mesh, scene: &Scene, assets: &LightAssets) -> Self {
        let raster =
            Raster { size_px: PX.into(), sampling: Sampling::Fixed(1), area: PixelArea::whole(PX) };
        let set = |scene: &Scene| SampleSet::render_with_assets(mesh, scene, assets, raster);
        let degrees = |place| 360.0 * f64::from(place) / f64::from(PLACES);
        let places = (0..PLACES).map(|place| set(&scene.with_light_deg(degrees(place)))).collect();
        Self { own: set(scene), places }
    }

    /// Returns the automatic exposure of a program over the whole orbit, in EV.
    #[must_use]
    pub fn common_ev(&self, program: &Program) -> f64 {
        Gain::common(program, &self.places).ev
    }

    /// Returns the exposure of a material by the film, with the lights as they are, clamped to the
    /// range of a scene, in EV.
    #[must_use]
    pub fn ev(&self, of: &Specimen<'_>, film: Film) -> f64 {
        // Beyond this range a picture is black or clipped anyway.
        ev(of, &self.own, film).clamp(-EV_MAX, EV_MAX)
    }

    /// Returns the smallest and largest automatic exposure of a material over the orbit, in EV.
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
