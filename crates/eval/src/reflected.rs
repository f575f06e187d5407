//! Levels of the picture of a BRDF, as inputs of the painted material that paints it.

use brood_brdf::Input;
use brood_light::units::luminance;
use brood_program::Program;
use brood_scene::{Exposure, SampleSet};

use crate::film::Gain;
use crate::radiance::{RadianceImage, shade};
use crate::rounding::round_to_f32;
use crate::{EvalError, Evaluator};

/// Levels of the whole picture of a BRDF: L / (1 + L) of its exposed radiance L.
#[derive(Debug, Clone)]
pub struct ReflectedLevels {
    width: usize,
    height: usize,
    /// Levels of luminance, red, green and blue; `None` where the object does not cover the pixel.
    levels: Vec<Option<[f32; 4]>>,
}

impl ReflectedLevels {
    /// Returns the levels of a whole picture at an exposure. The tone curve has no effect.
    #[must_use]
    pub fn new(image: &RadianceImage, gain: Gain) -> Self {
        let factor = f64::from(gain.factor);
        let pixels = image.premultiplied().iter().zip(image.coverage());
        let levels = pixels.map(|(radiance, coverage)| {
            let exposed = |channel: &f32| factor * f64::from(*channel) / f64::from(*coverage);
            (*coverage > 0.0).then(|| {
                let channels = [0, 1, 2].map(|channel| exposed(&radiance[channel]));
                let [red, green, blue] = channels;
                [luminance(channels), red, green, blue].map(level)
            })
        });
        let (width, height) = (image.width() as usize, image.height() as usize);
        Self { width, height, levels: levels.collect() }
    }

    /// Evaluates a BRDF on the samples of a whole picture, at automatic exposure.
    ///
    /// # Errors
    /// As [`Evaluator::eval`].
    pub(crate) fn of_samples(
        evaluator: &dyn Evaluator,
        brdf: &Program,
        set: &SampleSet,
    ) -> Result<Self, EvalError> {
        let mut f = Vec::new();
        evaluator.eval(&[brdf], set, &mut f)?;
        let image = shade(set, &f);
        Ok(Self::new(&image, Gain::of_image(Exposure::Auto, &image)))
    }

    /// Returns a copy of points in which each has the levels of its pixel as inputs.
    ///
    /// # Panics
    /// If the points are not those of a picture of this size, or of a part of one.
    #[must_use]
    pub fn on(&self, points: &SampleSet) -> SampleSet {
        let layout = points.image().expect("the points are those of a picture");
        let size = (layout.size_px.width as usize, layout.size_px.height as usize);
        assert_eq!(size, (self.width, self.height), "a picture of the same size");
        let mut columns = [(); 5].map(|()| vec![0.0; points.len()]);
        for span in layout.spans() {
            let (x, y) = (span.pixel % layout.width, span.pixel / layout.width);
            let (x, y) = ((layout.area.x + x) as usize, (layout.area.y + y) as usize);
            let [level, red, green, blue] = self.at(x, y);
            let step = self.step(x, y);
            for (column, value) in columns.iter_mut().zip([level, red, green, blue, step]) {
                column[span.start as usize..span.end as usize].fill(value);
            }
        }
        let inputs = Input::REFLECTED.into_iter().chain([Input::ReflectedStep]);
        points.with_columns(inputs.zip(columns))
    }

    /// Levels of a pixel. Where only points cover it, at the silhouette, the mean of the covered
    /// pixels around it; 0 without any.
    fn at(&self, x: usize, y: usize) -> [f32; 4] {
        if let Some(own) = self.levels[y * self.width + x] {
            return own;
        }
        let near = |at: usize, side: usize| at.saturating_sub(1)..(at + 2).min(side);
        let around = near(y, self.height)
            .flat_map(|y| near(x, self.width).map(move |x| y * self.width + x))
            .filter_map(|pixel| self.levels[pixel]);
        let (sum, count) = around.fold(([0.0; 4], 0.0), |(sum, count), levels| {
            ([0, 1, 2, 3].map(|k| sum[k] + levels[k]), count + 1.0)
        });
        sum.map(|sum| if count > 0.0 { sum / count } else { 0.0 })
    }

    /// Length of the gradient of the level of luminance over a pixel, from the differences to the
    /// pixels to the right and below, or else to the left and above; 0 where these are not covered.
    fn step(&self, x: usize, y: usize) -> f32 {
        let level = |x: usize, y: usize| {
            let is_inside = x < self.width && y < self.height;
            is_inside.then(|| self.levels[y * self.width + x]).flatten().map(|levels| levels[0])
        };
        let Some(own) = level(x, y) else { return 0.0 };
        // Coordinates left of or above the picture wrap to large ones.
        let [across, down] = [
            level(x + 1, y).or_else(|| level(x.wrapping_sub(1), y)),
            level(x, y + 1).or_else(|| level(x, y.wrapping_sub(1))),
        ]
        .map(|other| other.map_or(0.0, |other| other - own));
        (across * across + down * down).sqrt().min(1.0)
    }
}

/// L / (1 + L); 1 for infinite radiance.
fn level(radiance: f64) -> f32 {
    let radiance = radiance.max(0.0);
    if radiance.is_finite() { round_to_f32(radiance / (1.0 + radiance)) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use brood_light::LightAssets;
    use brood_mesh::{BuiltinMesh, Mesh};
    use brood_scene::{PixelArea, Raster, Sampling, Scene};

    use super::*;
    use crate::CanonicalEvaluator;

    const SIDE: u32 = 32;

    fn reflected(text: &str) -> (ReflectedLevels, RadianceImage, Gain) {
        let mesh = Mesh::builtin(BuiltinMesh::Sphere);
        let set = SampleSet::render(&mesh, &Scene::default(), SIDE, Sampling::Fixed(1));
        let program = Program::lower(&format!("brood 1\n{text}").parse().unwrap());
        let mut f = Vec::new();
        CanonicalEvaluator::default().eval(&[&program], &set, &mut f).unwrap();
        let image = shade(&set, &f);
        let gain = Gain::of_image(Exposure::Ev(0.5), &image);
        (ReflectedLevels::new(&image, gain), image, gain)
    }

    fn points(area: PixelArea) -> SampleSet {
        let raster = Raster { size_px: SIDE.into(), sampling: Sampling::Fixed(1), area };
        let mesh = Mesh::builtin(BuiltinMesh::Sphere);
        SampleSet::render_points(&mesh, &Scene::default(), &LightAssets::default(), raster)
    }

    #[test]
    fn inputs_are_levels_of_the_exposed_radiance() {
        let (reflected, image, gain) = reflected(".model lambert\nalbedo 0.9 0.5 0.2\n");
        let set = reflected.on(&points(PixelArea::whole(SIDE)));
        let mut brightest = 0.0f32;
        for span in set.image().unwrap().spans() {
            let radiance = image.premultiplied()[span.pixel as usize].map(|c| c * gain.factor);
            let [red, green, blue] = radiance;
            let luminance = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
            for (input, own) in Input::REFLECTED.into_iter().zip([luminance, red, green, blue]) {
                let value = set.input(input)[span.start as usize];
                assert!((value - own / (1.0 + own)).abs() < 1e-6, "{input:?} {value} {own}");
                brightest = brightest.max(value);
            }
        }
        assert!(brightest > 0.2, "{brightest}");
    }

    #[test]
    fn step_is_the_difference_to_neighbours() {
        let (reflected, ..) = reflected(".model lambert\n");
        let set = reflected.on(&points(PixelArea::whole(SIDE)));
        let (levels, steps) = (set.input(Input::ReflectedLevel), set.input(Input::ReflectedStep));
        let mut samples = vec![None; (SIDE * SIDE) as usize];
        for span in set.image().unwrap().spans() {
            samples[span.pixel as usize] = Some(span.start as usize);
        }
        let at = |x: u32, y: u32| samples[(y * SIDE + x) as usize].unwrap();
        let (here, right, below) = (at(20, 12), at(21, 12), at(20, 13));
        let expected = (levels[right] - levels[here]).hypot(levels[below] - levels[here]);
        assert!((steps[here] - expected).abs() < 1e-6 && expected > 1e-3, "{expected}");
        // At the right and lower end of the picture, neighbours on the other side count.
        assert!(steps.iter().filter(|step| **step > 0.0).count() > steps.len() / 3);
        assert!(steps.iter().all(|step| *step < 0.5));
    }

    #[test]
    fn parts_have_the_values_of_the_whole() {
        let (reflected, ..) = reflected(".model conductor\nroughness 0.3\n");
        let whole = reflected.on(&points(PixelArea::whole(SIDE)));
        let area = PixelArea { x: 9, y: 4, width: 13, height: 20 };
        let part = reflected.on(&points(area));
        for input in Input::REFLECTED.into_iter().chain([Input::ReflectedStep]) {
            let mut expected = Vec::new();
            for span in whole.image().unwrap().spans() {
                let (x, y) = (span.pixel % SIDE, span.pixel / SIDE);
                let is_inside = (area.x..area.x + area.width).contains(&x)
                    && (area.y..area.y + area.height).contains(&y);
                if is_inside {
                    expected.push(whole.input(input)[span.start as usize]);
                }
            }
            assert_eq!(part.input(input), expected, "{input:?}");
        }
    }

    #[test]
    fn points_beside_the_picture_have_the_mean_of_their_neighbours() {
        let (mut reflected, ..) = reflected(".model lambert\n");
        let middle = (SIDE * SIDE / 2 + SIDE / 2) as usize;
        let near = [reflected.levels[middle - 1].unwrap(), reflected.levels[middle + 1].unwrap()];
        for row in [middle - SIDE as usize, middle, middle + SIDE as usize] {
            reflected.levels[row - 1..row + 2].fill(None);
        }
        let (x, y) = (SIDE as usize / 2, SIDE as usize / 2);
        assert_eq!((reflected.at(x, y), reflected.step(x, y)), ([0.0; 4], 0.0));
        (reflected.levels[middle - 1], reflected.levels[middle + 1]) =
            (Some(near[0]), Some(near[1]));
        let mean = [0, 1, 2, 3].map(|k| (near[0][k] + near[1][k]) / 2.0);
        assert_eq!(reflected.at(x, y), mean);
    }

    #[test]
    fn levels_stay_in_their_range() {
        let cases = [(0.0, 0.0), (-1.0, 0.0), (1.0, 0.5), (3.0, 0.75), (f64::INFINITY, 1.0)];
        for (radiance, expected) in cases {
            assert_eq!(level(radiance), expected);
        }
    }
}
