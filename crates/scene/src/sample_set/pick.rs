//! A few pixels of a set as a set of their own.

use brood_brdf::InputMask;

use super::point::Gathered;
use super::values::Values;
use super::{ImageLayout, PixelArea, PixelRun, SampleCounts, SampleSet};

pub(super) fn pick(set: &SampleSet, pixels: &[u32], inputs: InputMask) -> SampleSet {
    let layout = set.image().expect("the set has an image");
    assert!(pixels.is_sorted_by(|a, b| a < b), "pixels ascend");
    let width = u32::try_from(pixels.len()).expect("an image has fewer than 2^32 pixels");
    let mut gathered = Gathered::default();
    let mut runs: Vec<PixelRun> = Vec::new();
    let mut samples: Vec<usize> = Vec::new();
    let mut spans = layout.spans().peekable();
    for (number, pixel) in (0..width).zip(pixels) {
        while spans.next_if(|span| span.pixel < *pixel).is_some() {}
        let Some(span) = spans.next_if(|span| span.pixel == *pixel) else { continue };
        let range = span.start as usize..span.end as usize;
        let run = PixelRun {
            pixel: number,
            pixels: 1,
            start: gathered.count(),
            samples: span.end - span.start,
            centre: span.centre_end - span.start,
            counted: span.counted - span.start,
        };
        if !runs.last_mut().is_some_and(|last| last.extend(&run)) {
            runs.push(run);
        }
        gathered.extend_from(&set.pairs, &set.uvs, &set.irradiance, range.clone());
        samples.extend(range);
    }
    let image = ImageLayout {
        width,
        height: 1,
        area: PixelArea { x: 0, y: 0, width, height: 1 },
        runs,
        coverage: pixels.iter().map(|pixel| layout.coverage[*pixel as usize]).collect(),
        ..layout.clone()
    };
    let lit = u64::from(gathered.count());
    let counts = SampleCounts { rays: 0, covered: lit, lit };
    let picked =
        SampleSet::new(gathered.pairs, gathered.uvs, gathered.irradiance, Some(image), counts);
    for input in inputs.iter() {
        let all = set.input(input);
        let values = Values::compute(samples.len(), |index| all[samples[index]]);
        picked.inputs[input.index()].get_or_init(|| values);
    }
    picked
}
