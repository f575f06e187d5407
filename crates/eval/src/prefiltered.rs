//! Shading by prefiltered light: radiance of a picture from tables of materials.

use brood_brdf::{Input, Level, SimdKernel};
use brood_program::Program;
use brood_scene::{
    LitPoint, LobeNodes, LobeTable, NODES, NODES_TOGETHER, PrefilteredLight, SampleSet,
};
use rayon::prelude::*;

use crate::energy::is_anisotropic;
use crate::lanes::pairwise_sum;

/// Points of which the light is gathered at once.
const POINTS_TOGETHER: usize = 256;
/// Largest mean radiance; brighter ones are limited, so that no picture overflows.
const RADIANCE_MAX: f32 = 1e27;
/// Largest code of a radiance.
const CODE_MAX: f32 = 65535.0;

/// Tabulates programs for [`shade_prefiltered`], in their order.
///
/// # Domain
/// Isotropic homogeneous programs; see [`is_prefilterable`].
///
/// # Errors
/// Those of `eval`, which evaluates the programs as [`crate::Evaluator::eval`] does.
pub fn lobe_tables<E>(
    programs: &[&Program],
    eval: impl FnOnce(&[&Program], &SampleSet, &mut Vec<f32>) -> Result<(), E>,
) -> Result<Vec<LobeTable>, E> {
    let nodes = LobeNodes::get();
    let mut f = Vec::new();
    eval(programs, nodes.set(), &mut f)?;
    Ok(f.par_chunks(3 * nodes.set().len()).map(|f| nodes.table(f)).collect())
}

/// Returns the radiance of each pixel times coverage under prefiltered light, for each table.
///
/// # Shapes
/// Per table `pixels` values, of which those without light are 0. `gathered` is the gathered light
/// or `None`, which costs time and changes no bit.
///
/// # Error
/// Bit-identical for any number of threads and every instruction set.
///
/// # Panics
/// If a point is not within the picture.
#[must_use]
pub fn shade_prefiltered(
    tables: &[&LobeTable],
    light: &PrefilteredLight,
    gathered: Option<&GatheredLight>,
    pixels: usize,
) -> Vec<Vec<[f32; 3]>> {
    let level = Level::best();
    let mut radiance = vec![[0.0; 3]; light.points().len() * tables.len()];
    light
        .points()
        .par_chunks(POINTS_TOGETHER)
        .zip(radiance.par_chunks_mut(POINTS_TOGETHER * tables.len()))
        .enumerate()
        .for_each(|(index, (points, out))| {
            let made;
            let incident = match gathered {
                Some(gathered) => &gathered.parts[index],
                None => {
                    made = level.run(Gathering { light, points });
                    &made
                }
            };
            level.run(Shading { tables, incident, points, out });
        });
    let picture = |table: usize| {
        let mut picture = vec![[0.0f32; 3]; pixels];
        for (point, radiance) in light.points().iter().zip(radiance.chunks(tables.len())) {
            let pixel = &mut picture[point.pixel as usize];
            for (sum, channel) in pixel.iter_mut().zip(radiance[table]) {
                *sum += point.weight * channel;
            }
        }
        for between in light.between() {
            let pixel = &mut picture[between.pixel as usize];
            for (point, weight) in between.points.iter().zip(between.weights) {
                let radiance = radiance[*point as usize * tables.len() + table];
                for (sum, channel) in pixel.iter_mut().zip(radiance) {
                    *sum += weight * channel;
                }
            }
        }
        picture
    };
    (0..tables.len()).into_par_iter().map(picture).collect()
}

/// Mean radiances around the nodes of all points of a picture, kept for further materials.
///
/// Radiances are stored as 16-bit codes of the root of their share of the largest of a point. The
/// relative error is at most 1.5e-4 at a hundredth of the largest.
#[derive(Debug)]
pub struct GatheredLight {
    parts: Vec<Part>,
}

/// Light of some points.
#[derive(Debug)]
struct Part {
    /// Per point the end of its codes: red, green and blue of as many nodes each.
    ends: Vec<u32>,
    /// Per point and channel the factor of the squares of codes.
    scales: Vec<[f32; 3]>,
    codes: Vec<u16>,
}

impl GatheredLight {
    /// Gathers the light.
    #[must_use]
    pub fn new(light: &PrefilteredLight) -> Self {
        let level = Level::best();
        let parts = light.points().par_chunks(POINTS_TOGETHER);
        Self { parts: parts.map(|points| level.run(Gathering { light, points })).collect() }
    }

    /// Returns the size in memory of the gathered light of a picture in bytes, at most.
    #[must_use]
    pub fn bytes_for(light: &PrefilteredLight) -> usize {
        let per_point = size_of::<u32>() + size_of::<[f32; 3]>() + 3 * NODES * size_of::<u16>();
        light.points().len() * per_point
    }
}

/// Gathering of the light of some points: the kernel.
struct Gathering<'a> {
    light: &'a PrefilteredLight,
    points: &'a [LitPoint],
}

impl SimdKernel for Gathering<'_> {
    type Output = Part;

    #[inline(always)]
    fn run(self) -> Part {
        let mut incident = [[0.0; NODES]; 3];
        let mut codes = vec![0; 3 * NODES * self.points.len()];
        let (mut ends, mut scales) = (Vec::new(), Vec::new());
        let mut end = 0;
        for point in self.points {
            let count = self.light.radiance(point, &mut incident);
            let mut factors = [0.0; 3];
            for c in 0..3 {
                let values = &mut incident[c][..count];
                let mut largest = 0.0f32;
                for value in values.iter_mut() {
                    // NaN, possible for extreme maps, becomes 0.
                    *value = if *value > 0.0 { value.min(RADIANCE_MAX) } else { 0.0 };
                    largest = if *value > largest { *value } else { largest };
                }
                let inverse = if largest > 0.0 { 1.0 / largest } else { 0.0 };
                let into = &mut codes[end..][..count];
                for k in 0..count {
                    into[k] = ((values[k] * inverse).sqrt() * CODE_MAX + 0.5) as u16;
                }
                factors[c] = largest / (CODE_MAX * CODE_MAX);
                end += count;
            }
            ends.push(u32::try_from(end).expect("a part has few points"));
            scales.push(factors);
        }
        codes.truncate(end);
        codes.shrink_to_fit();
        Part { ends, scales, codes }
    }
}

/// Shading of some points: the kernel.
struct Shading<'a> {
    tables: &'a [&'a LobeTable],
    incident: &'a Part,
    points: &'a [LitPoint],
    /// Per point one radiance for each table.
    out: &'a mut [[f32; 3]],
}

impl SimdKernel for Shading<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let mut incident = [[0.0; NODES]; 3];
        let Part { ends, scales, codes } = self.incident;
        let mut start = 0;
        let lit = self.points.iter().zip(ends).zip(scales);
        for (((point, end), scales), out) in lit.zip(self.out.chunks_mut(self.tables.len())) {
            let codes = &codes[start..*end as usize];
            start = *end as usize;
            let count = (codes.len() / 3).min(NODES);
            for c in 0..3 {
                let codes = &codes[c * count..][..count];
                let incident = &mut incident[c][..count];
                for k in 0..count {
                    let root = f32::from(codes[k]);
                    incident[k] = root * root * scales[c];
                }
            }
            let (row, share) = point.row();
            for (table, out) in self.tables.iter().zip(out) {
                for c in 0..3 {
                    let incident = &incident[c][..count];
                    let below = sum(&table.channel(row, c)[..count], incident);
                    let above = sum(&table.channel(row + 1, c)[..count], incident);
                    out[c] = below + (above - below) * share;
                }
            }
        }
    }
}

/// Returns the sum of products in lanes: enough of them that the compiler keeps the loop over lanes
/// and vectorises it. The number of values is a multiple of [`NODES_TOGETHER`].
#[inline(always)]
fn sum(a: &[f32], b: &[f32]) -> f32 {
    let (a, b) = (a.as_chunks::<NODES_TOGETHER>().0, b.as_chunks::<NODES_TOGETHER>().0);
    let mut sums = [0.0f32; NODES_TOGETHER];
    for (a, b) in a.iter().zip(b) {
        // At optimisation level 3 the compiler keeps sums that change in place on the stack, which
        // takes twice the time. Sums by value stay in registers.
        let mut next = [0.0f32; NODES_TOGETHER];
        for lane in 0..NODES_TOGETHER {
            next[lane] = sums[lane] + a[lane] * b[lane];
        }
        sums = next;
    }
    pairwise_sum(sums)
}

/// True if a program is isotropic and homogeneous, so that prefiltered light can shade it.
#[must_use]
pub fn is_prefilterable(program: &Program) -> bool {
    let inputs = program.inputs();
    !program.is_painted()
        && !is_anisotropic(program)
        && !inputs.contains(Input::U)
        && !inputs.contains(Input::V)
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;
    use std::sync::Arc;

    use brood_genome::Genome;
    use brood_light::{EnvironmentMap, LightAssets};
    use brood_mesh::{BuiltinMesh, Mesh};
    use brood_scene::{PixelArea, Raster, Sampling, Scene};

    use super::*;
    use crate::{CanonicalEvaluator, Evaluator, shade};

    const SIZE_PX: u32 = 32;

    fn scene(environment: &str, samples: u32) -> Scene {
        let light = format!(
            r#"{{"kind": "environment", "image": "{environment}", "rotation_deg": 20, "samples": {samples}}}"#
        );
        serde_json::from_str(&format!(r#"{{"lights": [{light}]}}"#)).unwrap()
    }

    fn program(model: &str) -> Program {
        let genome: Genome = format!("brood 1\n.model {model}\n").parse().unwrap();
        Program::lower(&genome)
    }

    fn light(scene: &Scene) -> PrefilteredLight {
        light_with(scene, &LightAssets::default())
    }

    fn light_with(scene: &Scene, assets: &LightAssets) -> PrefilteredLight {
        let raster = Raster {
            size_px: SIZE_PX.into(),
            sampling: Sampling::Adaptive,
            area: PixelArea::whole(SIZE_PX),
        };
        let mesh = Mesh::builtin(BuiltinMesh::Sphere);
        SampleSet::render_prefiltered(&mesh, scene, assets, raster).1
    }

    fn evaluated(
        programs: &[&Program],
        set: &SampleSet,
        f: &mut Vec<f32>,
    ) -> Result<(), Infallible> {
        CanonicalEvaluator::default().eval(programs, set, f).expect("the CPU runs every program");
        Ok(())
    }

    fn tables(programs: &[&Program]) -> Vec<LobeTable> {
        lobe_tables(programs, evaluated).unwrap_or_else(|error| match error {})
    }

    #[test]
    fn radiance_is_close_to_that_of_many_samples() {
        let pixels = (SIZE_PX * SIZE_PX) as usize;
        for (model, environment, bound) in [
            ("lambert\nalbedo 0.8 0.5 0.2", "studio", 0.02),
            ("lambert\nalbedo 0.8 0.5 0.2", "low-sun", 0.02),
            ("conductor\nroughness 0.3", "interior", 0.05),
            ("conductor\nroughness 0.3", "overcast", 0.03),
        ] {
            let program = program(model);
            let found = light(&scene(environment, 1));
            let tables = tables(&[&program]);
            let image = &shade_prefiltered(&[&tables[0]], &found, None, pixels)[0];
            let raster = Raster {
                size_px: SIZE_PX.into(),
                sampling: Sampling::Fixed(1),
                area: PixelArea::whole(SIZE_PX),
            };
            let mesh = Mesh::builtin(BuiltinMesh::Sphere);
            let many = scene(environment, 1024);
            let set = SampleSet::render_with_assets(&mesh, &many, &LightAssets::default(), raster);
            let mut f = Vec::new();
            let Ok(()) = evaluated(&[&program], &set, &mut f);
            let expected = shade(&set, &f);
            let (mut squares, mut sum, mut count) = (0.0, 0.0, 0.0);
            for (index, expected) in expected.premultiplied().iter().enumerate() {
                // Pixels at the silhouette have other directions to the eye in their centre.
                let (x, y) = (index as u32 % SIZE_PX, index as u32 / SIZE_PX);
                let from_centre = |at: u32| (f64::from(at) + 0.5) / f64::from(SIZE_PX) * 2.0 - 1.0;
                if from_centre(x).hypot(from_centre(y)) < 0.75 {
                    for c in 0..3 {
                        squares += f64::from(image[index][c] - expected[c]).powi(2);
                        sum += f64::from(expected[c]);
                        count += 1.0;
                    }
                }
            }
            let error = f64::sqrt(squares * count) / sum;
            assert!(error < bound, "{model} in {environment}: {error}");
        }
    }

    #[test]
    fn extreme_maps_give_finite_pictures() {
        let program = program("conductor\nroughness 0.05");
        let tables = tables(&[&program]);
        let pixels = (SIZE_PX * SIZE_PX) as usize;
        let mut bright = vec![[0.0; 3]; 2048];
        bright[700] = [f32::MAX; 3];
        for (width, height, map) in [
            (1, 1, vec![[1.0; 3]]),
            (1, 1, vec![[0.0; 3]]),
            (4, 2, vec![[f32::MAX; 3]; 8]),
            (5, 3, vec![[f32::from_bits(1); 3]; 15]),
            (64, 32, bright),
        ] {
            let map = EnvironmentMap::new(width, height, map).unwrap();
            let mut assets = LightAssets::default();
            assets.insert_environment("own", Arc::new(map));
            let found = light_with(&scene("own", 1), &assets);
            let picture = &shade_prefiltered(&[&tables[0]], &found, None, pixels)[0];
            assert!(picture.as_flattened().iter().all(|c| c.is_finite() && *c >= 0.0));
        }
    }

    #[test]
    fn kept_light_and_other_materials_change_no_bit() {
        let programs = ["conductor\nroughness 0.2", "lambert\nalbedo 0.5 0.5 0.5"].map(program);
        let programs: Vec<&Program> = programs.iter().collect();
        let light = light(&scene("low-sun", 1));
        let tables = tables(&programs);
        let pixels = (SIZE_PX * SIZE_PX) as usize;
        let kept = GatheredLight::new(&light);
        let both = shade_prefiltered(&[&tables[0], &tables[1]], &light, Some(&kept), pixels);
        let alone = shade_prefiltered(&[&tables[1]], &light, None, pixels);
        assert_eq!(both[1], alone[0]);
        assert!(both[0].iter().any(|pixel| pixel[0] > 0.0));
    }

    #[test]
    fn all_instruction_sets_compute_the_same_bits() {
        let program = program("conductor\nroughness 0.1");
        let light = light(&scene("studio", 1));
        let tables = tables(&[&program]);
        let points = &light.points()[..200];
        let shaded = |level: Level| {
            let incident = level.run(Gathering { light: &light, points });
            let mut out = vec![[0.0; 3]; points.len()];
            level.run(Shading {
                tables: &[&tables[0]],
                incident: &incident,
                points,
                out: &mut out,
            });
            (incident.codes, out)
        };
        let levels = Level::available();
        let baseline = shaded(levels[0]);
        for level in &levels[1..] {
            assert_eq!(shaded(*level), baseline, "{}", level.name());
        }
    }
}
