//! Surface points of pictures, for painted materials.

use brood_light::LightAssets;

use super::paint::{Painted, PaintedLights};
use super::render::pixel_sampler;
use super::sampling::Raster;
use super::set::SampleSet;
use crate::description::Scene;
use crate::stage::Stage;

impl SampleSet {
    /// Samples the surface points of a picture with their lights, for painted materials: one sample
    /// per point, lit or not, whose irradiance is the share of the pixel that it represents.
    ///
    /// # Domain
    /// At most [`brood_brdf::Input::LIGHTS`] lights.
    ///
    /// # Panics
    /// As [`SampleSet::render_area`], and if there are more lights.
    #[must_use]
    pub fn render_points<'a>(
        stage: impl Into<Stage<'a>>,
        scene: &Scene,
        assets: &LightAssets,
        raster: Raster,
    ) -> Self {
        Self::painted_points((&stage.into(), scene, assets), raster, false)
    }

    /// As [`SampleSet::render_points`], and keeps where each sample is on the surface, for
    /// [`SampleSet::mirrored_ways`] and [`SampleSet::ways_out`].
    ///
    /// # Panics
    /// As [`SampleSet::render_points`].
    #[must_use]
    pub fn render_clear_points<'a>(
        stage: impl Into<Stage<'a>>,
        scene: &Scene,
        assets: &LightAssets,
        raster: Raster,
    ) -> Self {
        Self::painted_points((&stage.into(), scene, assets), raster, true)
    }

    fn painted_points(
        (stage, scene, assets): (&Stage<'_>, &Scene, &LightAssets),
        raster: Raster,
        keeps_seen: bool,
    ) -> Self {
        let mut sampler = pixel_sampler(stage, scene, assets, raster.size_px);
        let spacing = 1.0 / f64::from(raster.sampling.min_rays()).sqrt();
        let lights = PaintedLights::new(&sampler.surface.lights);
        sampler.painted = Some(Painted { lights, spacing, keeps_seen });
        Self::render_with(&sampler, raster).0
    }
}
