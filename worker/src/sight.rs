//! Sight of the rays that a clear body mirrors or lets through: other objects, the body itself and
//! what is behind all.

use std::sync::Arc;

use brood_eval::{Gain, RadianceImage, ReflectedLevels, is_anisotropic, shade};
use brood_program::Program;
use brood_protocol::{Backend, RenderStats};
use brood_scene::{
    Backdrop, Exposure, LeavingRay, LobeShape, PictureSize, SampleSet, Seen, WayOut,
    colors_towards, radiance_towards,
};

use crate::error::RenderError;
use crate::renderer::Renderer;
use crate::scene_view::{Raster, SceneView};
use crate::shot::Shot;

/// Number of rays that are sampled together. Environments make up to 300 samples of each.
const RAYS: usize = 4096;

/// Colour that a ray sees, in display values; `None` if it sees nothing.
pub(crate) type SeenColor = Option<[f32; 3]>;

/// Which rays of a body are followed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Followed {
    /// Mirrored eye rays.
    pub(crate) mirrored: bool,
    /// Ways through the body.
    pub(crate) ways: bool,
    /// Index of refraction of the body.
    pub(crate) index: f64,
}

/// Rays of the samples of a body with the colours that they see, without the body itself.
pub(crate) struct Sight {
    /// Ways of each sample; empty if none are followed.
    pub(crate) ways: Vec<[Option<WayOut>; 2]>,
    /// Lengths inside the body of the mirrored rays, one for each sample, which are the first rays;
    /// empty if none are followed.
    pub(crate) mirrored: Vec<f64>,
    /// Number of the ray of each way.
    pub(crate) numbers: Vec<[Option<usize>; 2]>,
    /// All rays that are followed.
    pub(crate) rays: Vec<LeavingRay>,
    /// Colours of all rays.
    pub(crate) colors: Vec<SeenColor>,
    /// Points of the body itself that rays see: a picture of one row, with a pixel for each ray.
    pub(crate) own: SampleSet,
}

impl Sight {
    fn bytes(&self) -> usize {
        size_of_val(self.ways.as_slice())
            + size_of_val(self.mirrored.as_slice())
            + size_of_val(self.numbers.as_slice())
            + size_of_val(self.rays.as_slice())
            + size_of_val(self.colors.as_slice())
            + self.own.bytes()
    }
}

impl Renderer {
    /// Returns what the rays of a body see in a shot, from the cache if possible. `points` are the
    /// clear points of the raster.
    pub(crate) fn sight(
        &self,
        shot: &Shot<'_>,
        (points, raster): (&SampleSet, Raster),
        followed: Followed,
    ) -> Result<Arc<Sight>, RenderError> {
        let Shot { view, frame, .. } = shot;
        let exposure = self.exposure_of_others(shot)?;
        let mut hasher = blake3::Hasher::new();
        hasher.update(view.points_key(raster).as_bytes()).update(b"sight");
        hasher.update(&[u8::from(followed.mirrored), u8::from(followed.ways)]);
        hasher.update(&followed.index.to_le_bytes());
        hasher.update(&exposure.ev.to_le_bytes()).update(&view.seen_behind());
        for object in &frame.objects {
            let words = object.words.iter().flat_map(|word| word.to_le_bytes());
            hasher.update(&words.collect::<Vec<u8>>()).update(b"material");
        }
        if let Some(subject) = shot.subject {
            hasher.update(subject.hash().as_bytes());
        }
        hasher.update(&[u8::from(frame.backend == Backend::Reference)]);
        let key = *hasher.finalize().as_bytes();
        self.caches.entry(key, || {
            let sight = self.followed(shot, points, (followed, exposure))?;
            let bytes = sight.bytes();
            Ok((sight, bytes))
        })
    }

    fn followed(
        &self,
        shot: &Shot<'_>,
        points: &SampleSet,
        (followed, exposure): (Followed, Gain),
    ) -> Result<Sight, RenderError> {
        let Shot { view, frame, .. } = shot;
        let (stage, index) = (&view.stage, followed.index);
        let mirrored =
            if followed.mirrored { points.mirrored_ways(stage, index) } else { Vec::new() };
        let mut rays: Vec<LeavingRay> = mirrored.iter().map(|way| way.leaving).collect();
        let mirrored = mirrored.iter().map(|way| way.length).collect();
        let ways = if followed.ways { points.ways_out(stage, index) } else { Vec::new() };
        let numbers = ways.iter().map(|pair| {
            pair.map(|way| {
                way.map(|way| {
                    rays.push(way.leaving);
                    rays.len() - 1
                })
            })
        });
        let numbers = numbers.collect();
        let rays_traced = rays.len() as u64;
        self.caches.counters.add(RenderStats { rays: rays_traced, ..RenderStats::default() });
        let colors = self.seen_around(shot, &rays, exposure)?;
        let own = of_rays((view, view.stage.part()), frame.size_px, &rays, Seen::Points);
        Ok(Sight { ways, mirrored, numbers, rays, colors, own })
    }

    /// Returns the colours that rays see without the part of the shot. Rays are in the unit frame
    /// of that part.
    fn seen_around(
        &self,
        shot: &Shot<'_>,
        rays: &[LeavingRay],
        exposure: Gain,
    ) -> Result<Vec<SeenColor>, RenderError> {
        let Shot { view, frame, .. } = shot;
        let mut colors = behind(view, (frame.size_px, rays), exposure);
        let part = view.stage.part();
        for other in (0..view.parts()).filter(|other| *other != part) {
            let program = match other.checked_sub(1) {
                Some(object) => Some(self.program(&frame.objects[object].words)?),
                None => shot.subject.map(|subject| Arc::new(subject.clone())),
            };
            // Without its material, the subject is not seen.
            let Some(program) = program else { continue };
            let seen = self.seen_along(shot, (other, &program), rays)?;
            for (color, seen) in colors.iter_mut().zip(seen) {
                *color = seen.or(*color);
            }
        }
        Ok(colors)
    }

    /// Returns the colours that rays see of a part of the scene with a material. The rays are in
    /// the unit frame of the part of the shot.
    pub(crate) fn seen_along(
        &self,
        shot: &Shot<'_>,
        (part, program): (usize, &Program),
        rays: &[LeavingRay],
    ) -> Result<Vec<SeenColor>, RenderError> {
        let (backend, exposure) = (shot.frame.backend, self.exposure_of_others(shot)?);
        let from = shot.view.stage.part();
        let other = shot.view.with_part(part);
        let view = if part == from { &shot.view } else { &other };
        let size_px = shot.frame.size_px;
        let lobes = view.scene().is_prefilterable().then(|| match is_anisotropic(program) {
            true => LobeShape::Any,
            false => LobeShape::Round,
        });
        let mut colors = Vec::with_capacity(rays.len());
        for rays in rays.chunks(RAYS) {
            let sampled = |seen| of_rays((view, from), size_px, rays, seen);
            let brdf = program.brdf();
            let light = brdf.map(|brdf| (sampled(Seen::Light(lobes)), brdf));
            let mut f = Vec::new();
            if let Some((light, brdf)) = &light {
                self.evaluators.eval(backend, &[brdf], light, &mut f)?;
            }
            colors.extend(match (light, program.is_painted()) {
                (Some((light, _)), false) => seen_in(&shade(&light, &f), |radiance| {
                    exposure.codes(radiance).map(|code| f32::from(code) / 255.0)
                }),
                (Some((light, _)), true) => {
                    let reflected = ReflectedLevels::new(&shade(&light, &f), exposure);
                    let points = reflected.on(&sampled(Seen::Points));
                    self.seen_on(&points, program, backend)?
                }
                (None, _) => self.seen_on(&sampled(Seen::Points), program, backend)?,
            });
        }
        Ok(colors)
    }

    /// Returns the colours of a style on the points that rays see. A clear one is seen without its
    /// glass.
    pub(crate) fn seen_on(
        &self,
        points: &SampleSet,
        style: &Program,
        backend: Backend,
    ) -> Result<Vec<SeenColor>, RenderError> {
        let lighting = points.lighting().expect("the samples are points");
        let style = style.without_glass();
        let lowered = style.painted(lighting);
        let with_images = self.with_images(points, &style)?;
        let mut colors = Vec::new();
        let on = with_images.as_ref().unwrap_or(points);
        self.evaluators.eval(backend, &[&lowered], on, &mut colors)?;
        Ok(seen_in(&shade(points, &colors), |color| color))
    }

    /// Returns the gain in which objects beside a painted one are seen.
    fn exposure_of_others(&self, shot: &Shot<'_>) -> Result<Gain, RenderError> {
        let film = self.ground_exposure(shot)?;
        let ev = match film.exposure {
            Exposure::Ev(ev) => ev,
            Exposure::Auto => 0.0,
        };
        Ok(Gain::fixed(ev).with_tone(film.tone))
    }
}

/// Returns the colours of a picture with a pixel for each ray.
fn seen_in(image: &RadianceImage, color: impl Fn([f32; 3]) -> [f32; 3]) -> Vec<SeenColor> {
    let pixels = image.premultiplied().iter().zip(image.coverage());
    pixels.map(|(radiance, coverage)| (*coverage > 0.0).then(|| color(*radiance))).collect()
}

fn of_rays(
    (view, from): (&SceneView<'_>, usize),
    size_px: PictureSize,
    rays: &[LeavingRay],
    seen: Seen,
) -> SampleSet {
    let (scene, assets) = (view.scene(), view.assets);
    SampleSet::of_rays((&view.stage, from), (scene, assets), (size_px, rays), seen)
}

/// Returns the colours behind all objects: those of the backdrop, or of the environments without
/// one.
fn behind(
    view: &SceneView<'_>,
    (size_px, rays): (PictureSize, &[LeavingRay]),
    exposure: Gain,
) -> Vec<SeenColor> {
    let scene = view.scene();
    let blur_deg = match &scene.backdrop {
        Some(Backdrop::Color { color }) => return vec![Some(color.map(|c| c as f32)); rays.len()],
        Some(Backdrop::Image { image }) => {
            let Some(image) = view.assets.image(image) else { return vec![None; rays.len()] };
            let colors = colors_towards(image, (scene, &view.stage), (size_px, rays));
            let straight = |[r, g, b, opacity]: [f32; 4]| {
                (opacity >= 0.5).then(|| [r, g, b].map(|channel| channel / opacity))
            };
            return colors.into_iter().map(straight).collect();
        }
        Some(Backdrop::Environment { blur_deg }) => *blur_deg,
        None if scene.has_environment() => 0.0,
        None => return vec![None; rays.len()],
    };
    let towards: Vec<_> = rays.iter().map(|leaving| leaving.ray.direction).collect();
    let radiance = radiance_towards(blur_deg, (scene, &view.stage, view.assets), &towards);
    let color = |radiance| Some(exposure.codes(radiance).map(|code| f32::from(code) / 255.0));
    radiance.into_iter().map(color).collect()
}

#[cfg(test)]
#[path = "sight_tests.rs"]
mod tests;
