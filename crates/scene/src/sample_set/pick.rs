//! Copying selected pixels of sets into a new set.

use std::ops::Range;

use brood_brdf::InputMask;

use super::layout::{ImageLayout, PixelRun, SampleCounts};
use super::sampling::PixelArea;
use super::set::SampleSet;
use super::values::{Values, concatenate};

/// Contiguous samples of one part.
type Piece<'a> = (&'a SampleSet, Range<usize>);

impl SampleSet {
    /// Copies some pixels of each part into one set, as an image of one row, part after part.
    /// The set has only the inputs in `inputs`, and directions only if `directions` is true.
    /// [`SampleSet::input_range`] is taken over the whole parts.
    ///
    /// # Domain
    /// Parts of the same [`Sampling`](super::Sampling).
    ///
    /// # Panics
    /// If a part has no image, or its pixels are not ascending or not in the image.
    #[must_use]
    pub fn pick(parts: &[(&Self, &[u32])], inputs: InputMask, directions: bool) -> Self {
        let pixels = parts.iter().map(|(_, pixels)| pixels.len()).sum();
        let mut runs: Vec<PixelRun> = Vec::new();
        let mut pieces: Vec<Piece<'_>> = Vec::new();
        let mut coverage = Vec::with_capacity(pixels);
        let mut len = 0;
        for (set, pixels) in parts {
            assert!(pixels.is_sorted_by(|a, b| a < b), "picked pixels must be ascending");
            let layout = set.image().expect("a part of a pick must have an image");
            let mut runs_of_part = layout.runs.iter().peekable();
            for pixel in *pixels {
                let number = narrow(coverage.len());
                coverage.push(layout.coverage[*pixel as usize]);
                while runs_of_part.next_if(|run| run.pixel + run.pixels <= *pixel).is_some() {}
                let Some(run) = runs_of_part.peek().filter(|run| run.pixel <= *pixel) else {
                    continue;
                };
                let first = (run.start + (pixel - run.pixel) * run.samples) as usize;
                let samples = first..first + run.samples as usize;
                let own = PixelRun { pixel: number, pixels: 1, start: narrow(len), ..**run };
                if !runs.last_mut().is_some_and(|last| last.extend(&own)) {
                    runs.push(own);
                }
                len += samples.len();
                match pieces.last_mut() {
                    // Adjacent pixels are merged into one copy.
                    Some((last, range)) if range.end == samples.start && last.id() == set.id() => {
                        range.end = samples.end;
                    }
                    _ => pieces.push((*set, samples)),
                }
            }
        }
        let width = narrow(pixels);
        let template = parts.first().and_then(|(set, _)| set.image());
        let image = template.map(|template| ImageLayout {
            width,
            height: 1,
            size_px: template.size_px,
            area: PixelArea { x: 0, y: 0, width, height: 1 },
            sampling: template.sampling,
            scale: template.scale,
            runs,
            coverage: coverage.into(),
        });
        let irradiance = [0, 1, 2].map(|channel| {
            let mut all = vec![0.0; len];
            concatenate(
                &mut all,
                pieces.iter().map(|(set, range)| (&*set.irradiance[channel], range.clone())),
            );
            all
        });
        let counts =
            SampleCounts { covered: len as u64, lit: len as u64, ..SampleCounts::default() };
        let (mut pairs, mut uvs) = (Vec::new(), Vec::new());
        if directions {
            for (set, range) in &pieces {
                pairs.extend_from_slice(&set.pairs[range.clone()]);
                uvs.extend_from_slice(&set.uvs[range.clone()]);
            }
        }
        let mut picked = Self::new(pairs, uvs, irradiance, image, counts);
        picked.len = len;
        for input in inputs.iter() {
            let ranges = parts.iter().map(|(set, _)| set.input_range(input));
            let range = ranges.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap_or_default();
            let values = pieces.iter().map(|(set, range)| (set.input(input), range.clone()));
            let values = Values::concatenated(len, range, values);
            picked.inputs[input.index()].get_or_init(|| values);
        }
        picked
    }
}

fn narrow(count: usize) -> u32 {
    u32::try_from(count).expect("an image has fewer than 2^32 samples")
}
