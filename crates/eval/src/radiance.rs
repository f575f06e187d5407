//! From reflectance to radiance: the sum over the samples and lights of each pixel.

use brood_scene::SampleSet;

/// Linear radiance of a picture, and how much of each pixel the object covers.
#[derive(Debug, Clone, PartialEq)]
pub struct RadianceImage {
    width: u32,
    height: u32,
    /// Radiance times coverage.
    premultiplied: Vec<[f32; 3]>,
    coverage: Vec<f32>,
    /// For each lit, covered pixel the largest channel of its first sample: what automatic exposure looks at.
    first_samples: Vec<f32>,
}

impl RadianceImage {
    /// Width in pixels.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Radiance times coverage, row by row from the top.
    #[must_use]
    pub fn premultiplied(&self) -> &[[f32; 3]] {
        &self.premultiplied
    }

    /// Share of each pixel that the object covers.
    #[must_use]
    pub fn coverage(&self) -> &[f32] {
        &self.coverage
    }

    pub(crate) fn first_samples(&self) -> &[f32] {
        &self.first_samples
    }
}

/// Reflected light of a picture: L = sum over samples and lights of f E cos_i, divided by the samples of a pixel.
///
/// # Shapes
/// `f` is one program's part of an evaluator's output: red, green, blue, each `set.len()` long.
///
/// # Panics
/// Where the set is not one of a picture, or `f` is not of its length.
#[must_use]
pub fn shade(set: &SampleSet, f: &[f32]) -> RadianceImage {
    let layout = set.image().expect("the samples are those of a picture");
    let samples = set.len();
    assert_eq!(f.len(), 3 * samples, "one reflectance for each channel and sample");
    let irradiance = set.irradiance();
    let pixels = layout.covered.len();
    let mut premultiplied = vec![[0.0; 3]; pixels];
    let mut first_samples = Vec::with_capacity(layout.spans.len());
    let inverse = 1.0 / f32_count(layout.samples_per_pixel);
    let (red, rest) = f.split_at(samples);
    let (green, blue) = rest.split_at(samples);
    for span in &layout.spans {
        let mut sum = [0.0; 3];
        for sample in span.start as usize..span.end as usize {
            if sample == span.first_end as usize {
                first_samples.push(largest(sum));
            }
            sum[0] += red[sample] * irradiance[0][sample];
            sum[1] += green[sample] * irradiance[1][sample];
            sum[2] += blue[sample] * irradiance[2][sample];
        }
        if span.first_end == span.end {
            first_samples.push(largest(sum));
        }
        premultiplied[span.pixel as usize] = sum.map(|radiance| radiance * inverse);
    }
    let coverage = layout.covered.iter().map(|count| f32::from(*count) * inverse).collect();
    let (width, height) = (layout.width, layout.height);
    RadianceImage { width, height, premultiplied, coverage, first_samples }
}

fn largest([red, green, blue]: [f32; 3]) -> f32 {
    red.max(green).max(blue)
}

fn f32_count(count: u32) -> f32 {
    f32::from(u16::try_from(count).expect("at most 65535 samples in a pixel"))
}
