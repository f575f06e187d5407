//! Pictures of a known scene as targets: from pixels to pairs of directions with a reflectance each, and how far a picture of what
//! was found is from them.
//!
//! Owns which pixels say something of the material, and why the others do not. Refuses to know files and who renders.

mod pixel;
mod refusal;

use brood_eval::{LinearPicture, RadianceImage};
use brood_scene::{
    Exposure, Light, LightAssets, Mesh, PixelArea, PixelSpan, Raster, SampleSet, Sampling, Scene,
    Tone,
};

use super::Samples;
use pixel::Look;
pub use pixel::{PixelCounts, PixelFate};
pub use refusal::ImageTargetError;

/// Sides of a picture at least.
const SIDE: u32 = 8;
/// Pixels that are used at least.
const FEWEST: usize = 100;
/// Both cosines are at least this.
const LEAST_COSINE: f64 = 0.01;
/// Light within a pixel that differs by more than this share from that at its centre: a shadow's edge.
const UNEVEN: f64 = 0.02;

/// A picture with all that is known of how it was made.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// What is shown.
    pub mesh: &'a Mesh,
    /// How it is seen and lit.
    pub scene: &'a Scene,
    /// What the lights refer to.
    pub assets: &'a LightAssets,
    /// How its pixels were sampled.
    pub sampling: Sampling,
    /// The picture.
    pub picture: &'a LinearPicture,
    /// Pixels that are looked at are white in it.
    pub mask: Option<&'a LinearPicture>,
    /// Whether brightness is not known: pictures with automatic exposure are so anyway.
    pub is_gain_unknown: bool,
}

/// A picture whose pixels have been told apart.
#[derive(Debug)]
pub struct ImageView {
    set: SampleSet,
    /// Linear radiance of each pixel, or as much of it as is known.
    wanted: Vec<[f64; 3]>,
    /// Pixels that pictures are compared in: neither masked nor clipped.
    compared: Vec<bool>,
    fates: Vec<PixelFate>,
    is_gain_unknown: bool,
    counts: PixelCounts,
}

/// How far a picture is from that of a view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageError {
    /// Root mean square difference of linear radiance over all pixels that are neither masked nor clipped.
    pub rmse: f64,
    /// The same over the pixels that were used.
    pub rmse_used: f64,
    /// What the found picture was multiplied by: 1 unless brightness is not known.
    pub gain: f64,
}

impl ImageView {
    /// Tells the pixels of a picture apart; also what the material reflects at those that say something of it.
    ///
    /// A pixel is used where the mesh covers it wholly, one light reaches its centre, and light is even within it; f is its
    /// radiance over the irradiance there. Where such a pixel is clipped, f is not below that ([`Samples::least`]).
    pub fn new(view: &View<'_>) -> Result<(Self, Samples), ImageTargetError> {
        let side = check(view)?;
        let exposure = film(view)?;
        let raster =
            Raster { size_px: side, sampling: view.sampling, area: PixelArea::whole(side) };
        let set = SampleSet::render_lit(view.mesh, view.scene, view.assets, raster);
        if set.counts().covered == 0 {
            return Err(ImageTargetError::Nothing);
        }
        if set.is_empty() {
            return Err(ImageTargetError::Unlit);
        }
        let radiance = |pixel: &[f32; 3]| pixel.map(|value| exposure.radiance(f64::from(value)));
        let wanted: Vec<[f64; 3]> = view.picture.pixels.iter().map(radiance).collect();
        let in_mask = |pixel: usize| view.mask.is_none_or(|mask| is_white(mask.pixels[pixel]));
        let compared = (0..wanted.len()).map(|k| in_mask(k) && !view.picture.clipped[k]).collect();
        let is_gain_unknown = exposure.is_unknown || view.is_gain_unknown;
        let counts = PixelCounts { pixels: wanted.len() as u64, ..PixelCounts::default() };
        let mut own = Self { set, wanted, compared, fates: Vec::new(), is_gain_unknown, counts };
        let samples = own.tell_apart(in_mask, &view.picture.clipped);
        Ok((own, samples))
    }

    fn tell_apart(&mut self, in_mask: impl Fn(usize) -> bool, clipped: &[bool]) -> Samples {
        let layout = self.set.image().expect("the set is one of a picture").clone();
        let mut spans: Vec<Option<PixelSpan>> = vec![None; self.wanted.len()];
        for span in layout.spans() {
            spans[span.pixel as usize] = Some(span);
        }
        let side = layout.width as usize;
        let (mut pairs, mut values, mut least) = (Vec::new(), Vec::new(), Vec::new());
        let mut counts = self.counts;
        for (pixel, span) in spans.into_iter().enumerate() {
            let coverage = layout.coverage[pixel];
            // What blurs over the border of a pixel shows its neighbours.
            let near_edge = || neighbours(pixel, side).any(|other| layout.coverage[other] < 1.0);
            let look = match span {
                _ if !in_mask(pixel) => Look::Nothing(PixelFate::Masked),
                _ if coverage == 0.0 => Look::Nothing(PixelFate::Background),
                _ if coverage < 1.0 || near_edge() => Look::Nothing(PixelFate::Edge),
                Some(span) if clipped[pixel] => match self.lit(span) {
                    Look::Sample(pair, value) => Look::Least(pair, value),
                    Look::Least(..) | Look::Nothing(_) => Look::Nothing(PixelFate::Clipped),
                },
                None if clipped[pixel] => Look::Nothing(PixelFate::Clipped),
                None => Look::Nothing(PixelFate::Unlit),
                Some(span) => self.lit(span),
            };
            let fate = match look {
                Look::Nothing(fate) => fate,
                Look::Sample(pair, value) => {
                    pairs.push(pair);
                    values.push(value);
                    PixelFate::Used
                }
                Look::Least(pair, value) => {
                    least.push((pair, value));
                    PixelFate::Clipped
                }
            };
            counts.add(fate);
            self.fates.push(fate);
        }
        self.counts = counts;
        Samples::new(pairs, values).with_least(least)
    }

    /// What a pixel is that is covered and in some light.
    fn lit(&self, span: PixelSpan) -> Look {
        match span.centre_end - span.start {
            0 => return Look::Nothing(PixelFate::Unlit),
            1 => {}
            _ => return Look::Nothing(PixelFate::SeveralLights),
        }
        let (pair, _) = self.set.pair(span.start as usize);
        if pair.cos_i().min(pair.cos_o()) < LEAST_COSINE {
            return Look::Nothing(PixelFate::Grazing);
        }
        let mut f = self.wanted[span.pixel as usize];
        for (f, irradiance) in f.iter_mut().zip(self.set.irradiance()) {
            let counted = &irradiance[span.counted as usize..span.end as usize];
            let mean = counted.iter().map(|e| f64::from(*e)).sum::<f64>() * self.scale();
            let centre = f64::from(irradiance[span.start as usize]);
            if centre <= 0.0 {
                return Look::Nothing(PixelFate::Unlit);
            }
            if (mean - centre).abs() > UNEVEN * centre {
                return Look::Nothing(PixelFate::HalfLit);
            }
            *f = f.max(0.0) / mean;
        }
        Look::Sample(pair, f)
    }

    fn scale(&self) -> f64 {
        f64::from(self.set.image().expect("the set is one of a picture").scale)
    }

    /// What became of its pixels.
    #[must_use]
    pub fn counts(&self) -> PixelCounts {
        self.counts
    }

    /// Its samples, all pixels of them: what a material has to be evaluated on for a picture.
    #[must_use]
    pub fn set(&self) -> &SampleSet {
        &self.set
    }

    /// Whether brightness is not known.
    #[must_use]
    pub fn is_gain_unknown(&self) -> bool {
        self.is_gain_unknown
    }

    /// The picture as linear radiance, row by row; as bright as it is shown where that is not known.
    #[must_use]
    pub fn wanted(&self) -> &[[f64; 3]] {
        &self.wanted
    }

    /// What became of each pixel.
    #[must_use]
    pub fn fates(&self) -> &[PixelFate] {
        &self.fates
    }

    /// How far a picture of the same scene is from this one.
    ///
    /// # Panics
    /// Where it is of another size.
    #[must_use]
    pub fn compare(&self, found: &RadianceImage) -> ImageError {
        assert_eq!(found.premultiplied().len(), self.wanted.len(), "pictures of one size");
        let pixel = |k: usize| (self.wanted[k], found.premultiplied()[k].map(f64::from));
        let compared: Vec<usize> = (0..self.wanted.len()).filter(|k| self.compared[*k]).collect();
        let gain = if self.is_gain_unknown {
            let products = |of: fn(&f64, &f64) -> f64| -> f64 {
                let of = |k: &usize| {
                    let (wanted, found) = pixel(*k);
                    wanted.iter().zip(&found).map(|(a, b)| of(a, b)).sum::<f64>()
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
                let (wanted, found) = pixel(k);
                sum += (0..3).map(|c| (wanted[c] - gain * found[c]).powi(2)).sum::<f64>();
                count += 3;
            }
            (sum / count.max(1) as f64).sqrt()
        };
        let of = |(k, fate): (usize, &PixelFate)| (*fate == PixelFate::Used).then_some(k);
        let mut used = self.fates.iter().enumerate().filter_map(of);
        ImageError { rmse: root(&mut compared.iter().copied()), rmse_used: root(&mut used), gain }
    }
}

/// The eight pixels around one, as far as the picture goes.
fn neighbours(pixel: usize, side: usize) -> impl Iterator<Item = usize> {
    let (row, column) = (pixel / side, pixel % side);
    let around = move |at: usize| at.saturating_sub(1)..(at + 2).min(side);
    around(row).flat_map(move |row| around(column).map(move |column| row * side + column))
}

fn is_white(pixel: [f32; 3]) -> bool {
    pixel.iter().all(|value| *value > 0.2)
}

/// What can be seen without rays; the side of the picture.
fn check(view: &View<'_>) -> Result<u32, ImageTargetError> {
    let LinearPicture { width, height, pixels, .. } = view.picture;
    let side = *width;
    if width != height {
        return Err(ImageTargetError::NotSquare(*width, *height));
    }
    if side < SIDE {
        return Err(ImageTargetError::Small(side));
    }
    if let Some(mask) = view.mask {
        let (mask_width, mask_height) = (mask.width, mask.height);
        if (mask_width, mask_height) != (side, side) {
            return Err(ImageTargetError::MaskSize { mask_width, mask_height, side });
        }
        if !mask.pixels.iter().any(|pixel| is_white(*pixel)) {
            return Err(ImageTargetError::MaskEmpty);
        }
    }
    if let Some(at) = pixels.iter().position(|pixel| pixel.iter().any(|value| !value.is_finite())) {
        let at = u32::try_from(at).expect("pictures have fewer pixels");
        return Err(ImageTargetError::NotFinite(at % side, at / side));
    }
    let is_soft = |light: &&Light| {
        !matches!(light, Light::Point(_) | Light::Directional(_) | Light::Spot(_) | Light::Ies(_))
    };
    match view.scene.lights.iter().find(is_soft) {
        Some(light) => Err(ImageTargetError::Light(light.kind())),
        None => Ok(side),
    }
}

/// What is shown as the brightest of 256 steps is at least this.
const ALMOST_ONE: f64 = 0.9956;

/// The way back from what a picture shows to radiance.
struct Shown {
    factor: f64,
    tone: Tone,
    is_unknown: bool,
}

impl Shown {
    fn radiance(&self, value: f64) -> f64 {
        let exposed = match self.tone {
            Tone::None | Tone::Filmic => value,
            // x / (1 + x), of which 1 is that of infinity: what is shown as 1 is not less than this.
            Tone::Reinhard => value.min(ALMOST_ONE) / (1.0 - value.min(ALMOST_ONE)),
        };
        exposed / self.factor
    }
}

fn film(view: &View<'_>) -> Result<Shown, ImageTargetError> {
    let linear = Shown { factor: 1.0, tone: Tone::None, is_unknown: false };
    if view.picture.is_linear {
        return Ok(linear);
    }
    let film = view.scene.film;
    if film.tone == Tone::Filmic {
        return Err(ImageTargetError::Tone(film.tone.name()));
    }
    Ok(match film.exposure {
        Exposure::Auto => Shown { tone: film.tone, is_unknown: true, ..linear },
        Exposure::Ev(ev) => Shown { factor: libm::exp2(ev), tone: film.tone, ..linear },
    })
}

/// Samples of several pictures together; refused where there are too few.
pub fn pooled<'a>(
    views: impl IntoIterator<Item = (&'a ImageView, &'a Samples)>,
) -> Result<(Samples, PixelCounts), ImageTargetError> {
    let mut counts = PixelCounts::default();
    let (mut pairs, mut values, mut least) = (Vec::new(), Vec::new(), Vec::new());
    for (view, samples) in views {
        counts = counts.and(view.counts());
        pairs.extend_from_slice(samples.pairs());
        values.extend_from_slice(samples.values());
        least.extend_from_slice(samples.least());
    }
    if pairs.len() < FEWEST {
        return Err(ImageTargetError::Few(counts));
    }
    Ok((Samples::new(pairs, values).with_least(least), counts))
}

#[cfg(test)]
#[path = "image_tests.rs"]
mod tests;
