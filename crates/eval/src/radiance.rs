//! Shading: radiance of a picture from reflectance, summed over the samples and lights of each
//! pixel.

use std::ops::Range;
use std::sync::Arc;

use brood_brdf::Brdf;
use brood_scene::{ImageLayout, PixelArea, PixelRun, SampleSet};

use crate::model_reflectance;

/// Linear radiance and coverage of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct RadianceImage {
    width: u32,
    height: u32,
    /// Radiance times coverage.
    premultiplied: Vec<[f32; 3]>,
    coverage: Arc<[f32]>,
    /// Values that automatic exposure measures.
    centres: Vec<f32>,
}

impl RadianceImage {
    /// Returns the width in pixels.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the height in pixels.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Returns radiance times coverage, row by row from the top.
    #[must_use]
    pub fn premultiplied(&self) -> &[[f32; 3]] {
        &self.premultiplied
    }

    /// Returns the share of each pixel that the object covers.
    #[must_use]
    pub fn coverage(&self) -> &[f32] {
        &self.coverage
    }

    /// Joins bands of a picture, from the top.
    ///
    /// # Panics
    /// If their widths differ.
    #[must_use]
    pub fn of_bands(bands: &[Self]) -> Self {
        let width = bands.first().map_or(0, |band| band.width);
        assert!(bands.iter().all(|band| band.width == width), "bands are as wide as the picture");
        Self {
            width,
            height: bands.iter().map(|band| band.height).sum(),
            premultiplied: bands.iter().flat_map(|band| &band.premultiplied).copied().collect(),
            coverage: bands.iter().flat_map(|band| &*band.coverage).copied().collect(),
            centres: bands.iter().flat_map(|band| &band.centres).copied().collect(),
        }
    }

    /// Replaces the radiance times coverage of a pixel.
    ///
    /// # Panics
    /// If there is no such pixel.
    pub fn put(&mut self, pixel: usize, premultiplied: [f32; 3]) {
        self.premultiplied[pixel] = premultiplied;
    }

    /// Adds radiance times coverage to every pixel. Automatic exposure then measures the means of
    /// pixels that are covered to one half or more.
    ///
    /// # Panics
    /// If `more` has another number of pixels.
    pub fn add(&mut self, more: &[[f32; 3]]) {
        assert_eq!(more.len(), self.premultiplied.len(), "one radiance for each pixel");
        for (sum, more) in self.premultiplied.iter_mut().zip(more) {
            *sum = [sum[0] + more[0], sum[1] + more[1], sum[2] + more[2]];
        }
        let covered = self.premultiplied.iter().zip(&*self.coverage).filter(|(_, c)| **c >= 0.5);
        self.centres = covered.map(|(sum, c)| largest(*sum) / c).collect();
    }

    /// Makes the objects of some pixels cover all of them.
    ///
    /// # Panics
    /// If there is no such pixel.
    pub(crate) fn close(&mut self, pixels: &[usize]) {
        let mut coverage = self.coverage.to_vec();
        for pixel in pixels.iter().copied().filter(|pixel| self.coverage[*pixel] > 0.0) {
            self.premultiplied[pixel] = self.premultiplied[pixel].map(|c| c / coverage[pixel]);
            coverage[pixel] = 1.0;
        }
        self.coverage = coverage.into();
    }

    /// Adds another object of the same scene, which covers another part of each pixel. Automatic
    /// exposure still measures this one. Where rounding makes them cover more than a pixel, the
    /// mean is kept.
    ///
    /// # Panics
    /// If the other picture has another size.
    pub fn put_beside(&mut self, other: &Self) {
        assert_eq!(self.coverage.len(), other.coverage.len(), "pictures of one size");
        let both = self.coverage.iter().zip(&*other.coverage).map(|(own, other)| own + other);
        let both: Vec<f32> = both.collect();
        let pixels = self.premultiplied.iter_mut().zip(&other.premultiplied);
        for ((sum, more), all) in pixels.zip(&both) {
            let share = 1.0 / all.max(1.0);
            *sum = [0, 1, 2].map(|c| (sum[c] + more[c]) * share);
        }
        self.coverage = both.into_iter().map(|all| all.min(1.0)).collect();
    }

    /// Returns a part of the picture; `area` counts from the upper left corner of this picture.
    /// Automatic exposure still measures the whole picture.
    ///
    /// # Panics
    /// If the area is not within the picture.
    #[must_use]
    pub fn crop(&self, area: PixelArea) -> Self {
        let pixels = || {
            let rows = area.y..area.y + area.height;
            rows.flat_map(|y| (area.x..area.x + area.width).map(move |x| (x, y)))
                .map(|(x, y)| y as usize * self.width as usize + x as usize)
        };
        Self {
            width: area.width,
            height: area.height,
            premultiplied: pixels().map(|pixel| self.premultiplied[pixel]).collect(),
            coverage: pixels().map(|pixel| self.coverage[pixel]).collect(),
            centres: self.centres.clone(),
        }
    }

    pub(crate) fn centres(&self) -> &[f32] {
        &self.centres
    }
}

/// Shades a picture: L = sum over samples and lights of f E cos_i, weighted by the layout of the
/// set.
///
/// # Shapes
/// `f` is the part of one program in the output of an evaluator: red, green, blue, each `set.len()`
/// long.
///
/// # Panics
/// If the set is not that of a picture, or `f` has another length.
#[must_use]
pub fn shade(set: &SampleSet, f: &[f32]) -> RadianceImage {
    let light = ReflectedLight::new(set, f);
    let layout = light.layout;
    let mut premultiplied = vec![[0.0; 3]; layout.coverage.len()];
    shade_each(set, f, |pixel, radiance| premultiplied[pixel] = radiance);
    let (width, height) = (layout.width, layout.height);
    let coverage = layout.coverage.clone();
    RadianceImage { width, height, premultiplied, coverage, centres: light.centres() }
}

/// Shades a picture of a BRDF, see [`model_reflectance`] and [`shade`].
///
/// # Panics
/// If the set is not that of a picture, or has no directions.
#[must_use]
pub fn shade_brdf(set: &SampleSet, brdf: &dyn Brdf) -> RadianceImage {
    let mut f = Vec::new();
    model_reflectance(brdf, set, &mut f);
    shade(set, &f)
}

/// Shades without building a picture: calls `put` with each pixel that has samples and its radiance
/// times coverage.
///
/// # Panics
/// As [`shade`].
pub fn shade_each(set: &SampleSet, f: &[f32], mut put: impl FnMut(usize, [f32; 3])) {
    let light = ReflectedLight::new(set, f);
    for run in &light.layout.runs {
        let first = run.pixel as usize;
        light.each_pixel(run, |k, radiance| put(first + k, radiance));
    }
}

/// Reflectance of a program and irradiance of each sample, with the layout of the picture.
pub(crate) struct ReflectedLight<'a> {
    pub(crate) layout: &'a ImageLayout,
    f: [&'a [f32]; 3],
    /// Irradiance of each sample times cos_i, see [`SampleSet::irradiance`].
    irradiance: [&'a [f32]; 3],
}

impl<'a> ReflectedLight<'a> {
    /// As [`shade`].
    pub(crate) fn new(set: &'a SampleSet, f: &'a [f32]) -> Self {
        let layout = set.image().expect("the samples are those of a picture");
        let samples = set.len();
        assert_eq!(f.len(), 3 * samples, "one reflectance for each channel and sample");
        let (red, rest) = f.split_at(samples);
        let (green, blue) = rest.split_at(samples);
        Self { layout, f: [red, green, blue], irradiance: set.irradiance() }
    }

    /// Returns reflectance and irradiance of a range of samples in one channel.
    #[inline(always)]
    pub(crate) fn channel(&self, channel: usize, samples: Range<usize>) -> (&[f32], &[f32]) {
        (&self.f[channel][samples.clone()], &self.irradiance[channel][samples])
    }

    /// Calls `put` with each pixel of a run, counted from its first, and its radiance times
    /// coverage.
    #[inline(always)]
    pub(crate) fn each_pixel(&self, run: &PixelRun, mut put: impl FnMut(usize, [f32; 3])) {
        let scale = self.layout.scale;
        let (start, pixels) = (run.start as usize, run.pixels as usize);
        if run.samples == 1 && run.radiance_start == 0 {
            // The usual case. Slices of one length remove the bounds checks from the loop.
            let [red, green, blue] = self.f.map(|f| &f[start..start + pixels]);
            let [to_red, to_green, to_blue] = self.irradiance.map(|e| &e[start..start + pixels]);
            for k in 0..pixels {
                let sum = [red[k] * to_red[k], green[k] * to_green[k], blue[k] * to_blue[k]];
                put(k, sum.map(|sum| sum * scale));
            }
            return;
        }
        for (k, span) in run.spans().enumerate() {
            let sum = self.sum(span.radiance_start as usize, span.end as usize);
            put(k, sum.map(|sum| sum * scale));
        }
    }

    /// Returns the sum of f E cos_i over a range of samples.
    #[inline(always)]
    fn sum(&self, start: usize, end: usize) -> [f32; 3] {
        let mut sum = [0.0; 3];
        for (channel, sum) in sum.iter_mut().enumerate() {
            let pairs =
                self.f[channel][start..end].iter().zip(&self.irradiance[channel][start..end]);
            *sum = pairs.fold(0.0, |sum, (f, e)| sum + f * e);
        }
        sum
    }

    /// Returns the largest channel of each pixel whose centre is covered and lit: the values that
    /// automatic exposure measures.
    pub(crate) fn centres(&self) -> Vec<f32> {
        let mut centres = Vec::with_capacity(self.layout.coverage.len());
        for run in self.layout.runs.iter().filter(|run| run.centre > 0) {
            let (start, pixels) = (run.start as usize, run.pixels as usize);
            if run.samples == 1 {
                let [red, green, blue] = self.f.map(|f| &f[start..start + pixels]);
                let [to_red, to_green, to_blue] =
                    self.irradiance.map(|e| &e[start..start + pixels]);
                centres.extend((0..pixels).map(|k| {
                    largest([red[k] * to_red[k], green[k] * to_green[k], blue[k] * to_blue[k]])
                }));
                continue;
            }
            centres.extend(
                run.spans()
                    .map(|span| largest(self.sum(span.start as usize, span.centre_end as usize))),
            );
        }
        centres
    }
}

/// Returns the largest channel; no channel is NaN.
#[inline(always)]
fn largest([red, green, blue]: [f32; 3]) -> f32 {
    let more = if red > green { red } else { green };
    if more > blue { more } else { blue }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;
    use std::sync::Arc;

    use brood_brdf::{Brdf, DirectionPair, Model, ModelKind};
    use brood_light::{EnvironmentMap, LightAssets};
    use brood_mesh::{BuiltinMesh, Mesh};
    use brood_scene::{Raster, Sampling, Scene};
    use glam::DVec3;

    use super::*;

    /// Returns the share of a uniform sky's light that is reflected towards the eye: the mean of pi
    /// f over cosine-weighted directions.
    fn albedo(brdf: &dyn Brdf, wo: DVec3) -> f64 {
        let steps = 96;
        let mut sum = 0.0;
        for k in 0..steps * steps {
            let at = |k: u32| (f64::from(k) + 0.5) / f64::from(steps);
            let (across, (sin, cos)) = (at(k % steps), (2.0 * PI * at(k / steps)).sin_cos());
            let level = across.sqrt();
            let wi = DVec3::new(level * cos, level * sin, (1.0 - across).sqrt());
            sum += PI * brdf.f(&DirectionPair::new(wi, wo).unwrap()).x;
        }
        sum / f64::from(steps * steps)
    }

    #[test]
    fn uniform_light_shows_the_directional_albedo() {
        let model = Model::new(ModelKind::CookTorrance).with("diffuse", &[0.4, 0.2, 0.1]).unwrap();
        let brdf = model.with("roughness", &[0.5]).unwrap().brdf();
        let mut assets = LightAssets::default();
        let map = EnvironmentMap::new(8, 4, vec![[1.0; 3]; 32]).unwrap();
        assets.insert_environment("even", Arc::new(map));
        for (light, bound) in [(r#""ambient""#, 0.02), (r#""environment", "image": "even""#, 0.05)]
        {
            let json = format!(r#"{{"lights": [{{"kind": {light}, "samples": 1024}}]}}"#);
            let scene: Scene = serde_json::from_str(&json).unwrap();
            let (size_px, sampling) = (12, Sampling::Fixed(1));
            let raster =
                Raster { size_px: size_px.into(), sampling, area: PixelArea::whole(size_px) };
            let mesh = Mesh::builtin(BuiltinMesh::Sphere);
            let set = SampleSet::render_with_assets(&mesh, &scene, &assets, raster);
            let image = shade_brdf(&set, &*brdf);
            let mut seen = 0;
            for span in set.image().unwrap().spans() {
                let wo = set.pair(span.start as usize).0.wo();
                if wo.z < 0.3 {
                    continue;
                }
                seen += 1;
                let found = f64::from(image.premultiplied()[span.pixel as usize][0]);
                let expected = albedo(&*brdf, wo);
                assert!((found / expected - 1.0).abs() < bound, "{light} {found} {expected}");
            }
            assert!(seen > 50, "{seen}");
        }
    }
}
