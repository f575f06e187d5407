//! Pictures of known scenes as targets: converts pixels to pairs of directions with a reflectance
//! each, and compares pictures of results with the target.
//!
//! Owns the rules for which pixels are usable, and the reasons for the others. Does not depend on
//! files or on a renderer of results.

mod clip;
mod film;
mod highlight;
mod noise;
mod outlier;
mod pixel;
mod refusal;
mod soft;
mod view;

use brood_eval::RadianceImage;
use brood_light::LightAssets;
use brood_mesh::Mesh;
use brood_scene::{ImageLayout, PixelArea, PixelSpan, Raster, SampleSet, Sampling, Scene};

use crate::measured::FEWEST;
use crate::{LightMeans, LowerBound, PixelRadiance, Samples};
use clip::{Clip, Clipping};
use film::FilmInverse;
pub use highlight::highlights;
pub use pixel::{PixelCounts, PixelStatus};
use pixel::{PixelReading, around, spans};
pub use refusal::ImageTargetError;
use refusal::{check, is_white};
use soft::{MeanPixels, most_highlights, soft_light};
pub use view::View;

/// Least value of both cosines.
const LEAST_COSINE: f64 = 0.01;
/// Relative deviation of the mean light in a pixel from that at its centre, above which the pixel
/// is at a shadow's edge.
const UNEVEN: f64 = 0.02;

/// A picture whose pixels are classified.
#[derive(Debug)]
pub struct ImageView {
    set: SampleSet,
    /// Linear radiance of each pixel, up to a gain if that is unknown.
    target: Vec<[f64; 3]>,
    in_mask: Vec<bool>,
    clips: Vec<Clip>,
    /// Clipped pixels in ascending order.
    least: Vec<Least>,
    statuses: Vec<PixelStatus>,
    is_gain_unknown: bool,
    is_soft: bool,
    clipped_from: [Option<u8>; 3],
    counts: PixelCounts,
}

/// Radiance of a clipped pixel.
#[derive(Debug, Clone, Copy)]
struct Least {
    pixel: usize,
    /// Radiance of known channels, and the least radiance of the others.
    radiance: [f64; 3],
    is_known: [bool; 3],
}

/// Difference between a picture and that of a view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageError {
    /// Root mean square difference of linear radiance over all pixels that are neither masked nor
    /// clipped.
    pub rmse: f64,
    /// Root mean square difference over the pixels that are used, or lit by several lights.
    pub rmse_used: f64,
    /// Factor applied to the compared picture: 1 unless the brightness is unknown.
    pub gain: f64,
}

impl ImageView {
    /// Classifies the pixels of a picture; also returns the reflectance at the usable ones.
    ///
    /// A pixel is used if the mesh covers it wholly, one light reaches its centre, and the light is
    /// uniform within it. f is its radiance over the irradiance there. If such a pixel is clipped,
    /// its f is a lower bound ([`Samples::lower_bounds`]). A pixel that several lights, a light
    /// with an area or an environment reach shows a mean of f cos_i ([`Samples::means`]), and so
    /// does a pixel in a highlight, within which f may differ.
    ///
    /// # Errors
    /// Returns [`ImageTargetError`] if sizes do not match, a pixel is not finite, the scene's
    /// lights or tone curve cannot be inverted, nothing visible is lit, or a linear picture has a
    /// code to clip from.
    pub fn new(view: &View<'_>) -> Result<(Self, Samples), ImageTargetError> {
        let size_px = check(view)?;
        let exposure = FilmInverse::new(view.picture.is_linear, view.scene.film)?;
        let raster = Raster { size_px, sampling: view.sampling, area: PixelArea::whole(size_px) };
        let lit_scene = (view.scene, view.assets);
        let set = visible(view.mesh, lit_scene, raster)?;
        let radiance = |pixel: &[f32; 3]| pixel.map(|value| exposure.radiance(f64::from(value)));
        let target: Vec<[f64; 3]> = view.picture.pixels.iter().map(radiance).collect();
        let in_mask = |pixel: usize| view.mask.is_none_or(|mask| is_white(mask.pixels[pixel]));
        let lit = irradiance(&set, in_mask);
        let clipping = Clipping::of(view.clip_from, view.picture, &target, &lit)?;
        let in_mask = (0..target.len()).map(in_mask).collect();
        let is_gain_unknown = exposure.is_unknown || view.is_gain_unknown;
        let (clips, clipped_from) = (clipping.pixels, clipping.from);
        let (statuses, counts) = (Vec::new(), PixelCounts::default());
        let noise =
            noise::deviation(view.picture, |at| lit[at].is_some() && clips[at] == Clip::Free);
        let bounds = clips.iter().enumerate().filter(|(_, clip)| **clip == Clip::Bound);
        let lowered = |(pixel, _): (usize, &Clip)| {
            let value = view.picture.pixels[pixel];
            let is_known = [0, 1, 2].map(|c| noise::is_known(value[c], clipped_from[c], noise));
            let shown = [0, 1, 2]
                .map(|c| if is_known[c] { value[c] } else { noise::lowered(value[c], noise) });
            Least { pixel, radiance: radiance(&shown), is_known }
        };
        let least = bounds.map(lowered).collect();
        let mut own = Self {
            set,
            target,
            in_mask,
            clips,
            least,
            statuses,
            is_gain_unknown,
            is_soft: soft_light(view.scene).is_some(),
            clipped_from,
            counts,
        };
        let samples = own.classify(view.mesh, lit_scene);
        Ok((own, samples))
    }

    /// Classifies the pixels of the same picture in a corrected scene; clipped ones stay clipped.
    /// The radiance of red, green and blue is divided by `balance`.
    ///
    /// # Errors
    /// Returns [`ImageTargetError`] if the camera sees nothing, or nothing visible is lit.
    pub fn in_scene(
        &self,
        mesh: &Mesh,
        lit: (&Scene, &LightAssets),
        balance: [f64; 3],
    ) -> Result<(Self, Samples), ImageTargetError> {
        let layout = self.layout();
        let (size_px, sampling, area) = (layout.size_px, layout.sampling, layout.area);
        let set = visible(mesh, lit, Raster { size_px, sampling, area })?;
        let divided = |radiance: &[f64; 3]| [0, 1, 2].map(|c| radiance[c] / balance[c]);
        let least = self.least.iter().map(|one| Least { radiance: divided(&one.radiance), ..*one });
        let mut own = Self {
            set,
            target: self.target.iter().map(divided).collect(),
            in_mask: self.in_mask.clone(),
            clips: self.clips.clone(),
            least: least.collect(),
            statuses: Vec::new(),
            ..*self
        };
        let samples = own.classify(mesh, lit);
        Ok((own, samples))
    }

    fn layout(&self) -> &ImageLayout {
        self.set.image().expect("the set has a picture layout")
    }

    fn classify(&mut self, mesh: &Mesh, lit: (&Scene, &LightAssets)) -> Samples {
        let layout = self.layout().clone();
        let spans = spans(&layout);
        let size = (layout.width as usize, layout.height as usize);
        let (mut seen, mut least) = (Vec::new(), Vec::new());
        // Pixels that show means: over lights at the centre, and over points of highlights.
        let (mut several, mut within) = (MeanPixels::new(), MeanPixels::new());
        let is_highlight = match self.is_soft {
            true => vec![false; spans.len()],
            false => highlights(&self.set, most_highlights(lit.0)),
        };
        // A pixel of one ray shows only its centre.
        let is_mean = layout.sampling != Sampling::Fixed(1);
        let (in_mask, clips) = (&self.in_mask, &self.clips);
        for (pixel, span) in spans.into_iter().enumerate() {
            let coverage = layout.coverage[pixel];
            // Blur over the border of a pixel shows its neighbours.
            let near_edge = || around(pixel, size, 1).any(|other| layout.coverage[other] < 1.0);
            let reading = match span {
                _ if !in_mask[pixel] => PixelReading::Unusable(PixelStatus::Masked),
                _ if coverage == 0.0 => PixelReading::Unusable(PixelStatus::Background),
                _ if coverage < 1.0 || near_edge() => PixelReading::Unusable(PixelStatus::Edge),
                _ if clips[pixel] == Clip::Beside => PixelReading::Unusable(PixelStatus::Clipped),
                Some(span) if clips[pixel] == Clip::Bound => match self.lit(span) {
                    PixelReading::Sample(pair, value) => PixelReading::LowerBound(pair, value),
                    PixelReading::Several(_) => PixelReading::Several(PixelStatus::Clipped),
                    PixelReading::LowerBound(..) | PixelReading::Unusable(_) => {
                        PixelReading::Unusable(PixelStatus::Clipped)
                    }
                },
                None if clips[pixel] == Clip::Bound => PixelReading::Unusable(PixelStatus::Clipped),
                None => PixelReading::Unusable(PixelStatus::Unlit),
                Some(span) => self.lit(span),
            };
            let known = self.least(pixel).map(|least| (least.radiance, least.is_known));
            let (radiance, is_known) = known.unwrap_or((self.target[pixel], [true; 3]));
            let shown = |centre| (pixel, PixelRadiance { radiance, is_known, centre });
            let is_within = is_highlight[pixel] && is_mean;
            let status = match reading {
                PixelReading::Unusable(status) => status,
                PixelReading::Sample(pair, value) => {
                    if is_within {
                        within.push(shown(Some((pair, value))));
                    } else {
                        seen.push((pixel, pair, value));
                    }
                    PixelStatus::Used
                }
                PixelReading::LowerBound(pair, f) => {
                    if is_within {
                        within.push(shown(Some((pair, f))));
                    } else {
                        least.push(LowerBound { pair, f, is_known });
                    }
                    PixelStatus::Clipped
                }
                PixelReading::Several(status) => {
                    if is_within { &mut within } else { &mut several }.push(shown(None));
                    status
                }
            };
            self.statuses.push(status);
        }
        let mut means = LightMeans::default();
        for of in [(&several, soft::parts(lit.0)), (&within, highlight::PARTS)] {
            let (found, unlit) = soft::means(mesh, lit, layout.size_px, of);
            means.append(&found);
            unlit.into_iter().for_each(|pixel| self.statuses[pixel] = PixelStatus::Unlit);
        }
        // Highlights may be as small as dust is.
        let is_outlier = outlier::outliers(&seen, size.0, self.statuses.len());
        let (mut pairs, mut values) = (Vec::new(), Vec::new());
        for ((pixel, pair, value), is_outlier) in seen.into_iter().zip(is_outlier) {
            if is_outlier && !is_highlight[pixel] {
                self.statuses[pixel] = PixelStatus::Outlier;
            } else {
                pairs.push(pair);
                values.push(value);
            }
        }
        self.counts = PixelCounts::of(&self.statuses);
        Samples::new(pairs, values).with_lower_bounds(least).with_means(means)
    }

    /// Reads a pixel that is covered and lit.
    fn lit(&self, span: PixelSpan) -> PixelReading {
        let lights = span.centre_end - span.start;
        if lights == 0 {
            return PixelReading::Unusable(PixelStatus::Unlit);
        }
        let (pair, _) = self.set.pair(span.start as usize);
        let cos_i = if lights == 1 { pair.cos_i() } else { 1.0 };
        if cos_i.min(pair.cos_o()) < LEAST_COSINE {
            return PixelReading::Unusable(PixelStatus::Grazing);
        }
        let pixel = span.pixel as usize;
        let mut f = self.lower_bound(pixel).unwrap_or(self.target[pixel]);
        for (f, irradiance) in f.iter_mut().zip(self.set.irradiance()) {
            let counted = &irradiance[span.radiance_start as usize..span.end as usize];
            let mean = counted.iter().map(|e| f64::from(*e)).sum::<f64>() * self.scale();
            let at_centre = &irradiance[span.start as usize..span.centre_end as usize];
            let centre = at_centre.iter().map(|e| f64::from(*e)).sum::<f64>();
            if centre <= 0.0 {
                return PixelReading::Unusable(PixelStatus::Unlit);
            }
            if (mean - centre).abs() > UNEVEN * centre {
                return PixelReading::Unusable(PixelStatus::HalfLit);
            }
            *f = f.max(0.0) / mean;
        }
        match lights {
            1 if !self.is_soft => PixelReading::Sample(pair, f),
            _ => PixelReading::Several(PixelStatus::SeveralLights),
        }
    }

    fn scale(&self) -> f64 {
        f64::from(self.layout().scale)
    }

    /// Number of pixels by status.
    #[must_use]
    pub fn counts(&self) -> PixelCounts {
        self.counts
    }

    /// Code from which red, green and blue are clipped; `None` for a channel that is not. 255 is
    /// the value 1 in pictures of linear light.
    #[must_use]
    pub fn clipped_from(&self) -> [Option<u8>; 3] {
        self.clipped_from
    }

    /// Samples of all pixels, on which a material is evaluated to render this view. If the view
    /// [has soft light](ImageView::is_soft), they are of one light at the eye instead.
    #[must_use]
    pub fn set(&self) -> &SampleSet {
        &self.set
    }

    /// True if a light of the scene has an area or is an environment.
    #[must_use]
    pub fn is_soft(&self) -> bool {
        self.is_soft
    }

    /// True if the brightness is unknown.
    #[must_use]
    pub fn is_gain_unknown(&self) -> bool {
        self.is_gain_unknown
    }

    /// The picture as linear radiance, row by row; up to a gain if the brightness is unknown.
    #[must_use]
    pub fn target(&self) -> &[[f64; 3]] {
        &self.target
    }

    /// Status of each pixel.
    #[must_use]
    pub fn statuses(&self) -> &[PixelStatus] {
        &self.statuses
    }

    /// True for a pixel in which pictures are compared: neither masked nor clipped.
    #[must_use]
    pub fn is_compared(&self, pixel: usize) -> bool {
        self.in_mask[pixel] && self.clips[pixel] == Clip::Free
    }

    /// Least radiance of a clipped pixel, less than shown by what noise may have added; `None` for
    /// pixels that are masked or not clipped.
    #[must_use]
    pub fn lower_bound(&self, pixel: usize) -> Option<[f64; 3]> {
        self.least(pixel).map(|least| least.radiance)
    }

    fn least(&self, pixel: usize) -> Option<&Least> {
        let known = self.least.binary_search_by_key(&pixel, |least| least.pixel).ok();
        known.filter(|_| self.in_mask[pixel]).map(|at| &self.least[at])
    }

    /// Compares a picture of the same scene with this one.
    ///
    /// # Panics
    /// If it has another size.
    #[must_use]
    pub fn compare(&self, found: &RadianceImage) -> ImageError {
        let layout = self.layout();
        assert_eq!(
            (found.width(), found.height()),
            (layout.width, layout.height),
            "both pictures have the same size"
        );
        let pixel = |k: usize| (self.target[k], found.premultiplied()[k].map(f64::from));
        let compared: Vec<usize> =
            (0..self.target.len()).filter(|k| self.is_compared(*k)).collect();
        let gain = if self.is_gain_unknown {
            let products = |of: fn(&f64, &f64) -> f64| -> f64 {
                let of = |k: &usize| {
                    let (target, found) = pixel(*k);
                    target.iter().zip(&found).map(|(a, b)| of(a, b)).sum::<f64>()
                };
                compared.iter().map(of).sum()
            };
            let (both, own) = (products(|a, b| a * b), products(|_, b| b * b));
            if own > 0.0 { (both / own).max(0.0) } else { 1.0 }
        } else {
            1.0
        };
        let root = |pixels: &mut dyn Iterator<Item = usize>| {
            let (mut sum, mut count) = (0.0, 0u64);
            for k in pixels {
                let (target, found) = pixel(k);
                sum += (0..3).map(|c| (target[c] - gain * found[c]).powi(2)).sum::<f64>();
                count += 3;
            }
            (sum / count.max(1) as f64).sqrt()
        };
        let of = |(k, status): (usize, &PixelStatus)| status.is_usable().then_some(k);
        let mut used = self.statuses.iter().enumerate().filter_map(of);
        ImageError { rmse: root(&mut compared.iter().copied()), rmse_used: root(&mut used), gain }
    }
}

/// Samples a scene in which something is seen and lit.
fn visible(
    mesh: &Mesh,
    (scene, assets): (&Scene, &LightAssets),
    raster: Raster,
) -> Result<SampleSet, ImageTargetError> {
    let set = match soft_light(scene) {
        None => SampleSet::render_with_assets(mesh, scene, assets, raster),
        Some(_) => SampleSet::render_with_assets(mesh, &scene.lit_from_eye(), assets, raster),
    };
    if set.counts().covered == 0 {
        return Err(ImageTargetError::Nothing);
    }
    if set.is_empty() {
        return Err(ImageTargetError::Unlit);
    }
    Ok(set)
}

/// Irradiance at the centre of each pixel that is in the mask, wholly covered and lit.
fn irradiance(set: &SampleSet, in_mask: impl Fn(usize) -> bool) -> Vec<Option<[f32; 3]>> {
    let layout = set.image().expect("the set has a picture layout");
    let of = |(pixel, span): (usize, Option<PixelSpan>)| {
        let is_usable = in_mask(pixel) && layout.coverage[pixel] >= 1.0;
        let span = span.filter(|span| is_usable && span.centre_end > span.start)?;
        let at_centre = span.start as usize..span.centre_end as usize;
        Some(set.irradiance().map(|channel| channel[at_centre.clone()].iter().sum()))
    };
    spans(layout).into_iter().enumerate().map(of).collect()
}

/// Joins the samples of several pictures.
///
/// # Errors
/// Returns [`ImageTargetError::Few`] if there are fewer than 100 samples.
pub fn pooled<'a>(
    views: impl IntoIterator<Item = (&'a ImageView, &'a Samples)>,
) -> Result<(Samples, PixelCounts), ImageTargetError> {
    let mut counts = PixelCounts::default();
    let (mut pairs, mut values, mut least) = (Vec::new(), Vec::new(), Vec::new());
    let mut means = LightMeans::default();
    for (view, samples) in views {
        counts = counts.and(view.counts());
        pairs.extend_from_slice(samples.pairs());
        values.extend_from_slice(samples.values());
        least.extend_from_slice(samples.lower_bounds());
        means.append(samples.means());
    }
    let samples = Samples::new(pairs, values).with_lower_bounds(least).with_means(means);
    if samples.observations() < FEWEST {
        return Err(ImageTargetError::Few(counts));
    }
    Ok((samples, counts))
}

#[cfg(test)]
#[path = "image_tests.rs"]
mod tests;
