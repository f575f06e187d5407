//! Stress test of meshes: invalid meshes read as OBJ and rendered. They have triangles without
//! area, texture coordinates that are missing, mirrored or singular, normals that oppose each
//! other, and extents near the ends of the range.

use std::f64::consts::{PI, TAU};
use std::fmt::Write;

use anyhow::Result;
use brood_brdf::Input;
use brood_eval::{CanonicalEvaluator, Evaluator};
use brood_genome::{BirthKey, Operator, Stream};
use brood_light::{Light, LightAssets};
use brood_mesh::{ObjLimits, parse_obj};
use brood_program::Program;
use brood_scene::{Camera, LookAtCamera, PixelArea, Raster, SampleSet, Sampling, Scene};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::Serialize;

use super::counts::counts;
use super::program::candidate;
use crate::output;

/// Rows of the ball that the faults are applied to.
const ROWS: usize = 14;
/// Columns of the ball.
const COLUMNS: usize = 20;
/// Side of the pictures in pixels.
const SIZE_PX: u32 = 32;
/// Side of the pictures of painted materials.
const POINTS_PX: u32 = 12;
/// Number of programs that run on each set.
const PROGRAMS: u64 = 4;
/// Largest deviation of a direction from unit length.
const UNIT_TOLERANCE: f64 = 1e-12;

counts! {
    /// Counts over all meshes.
    #[derive(Debug, Clone, Copy, Default, Serialize)]
    pub struct Meshes {
        pub meshes: u32,
        /// Meshes rejected by the reader with a reason; correct if no usable triangle is left.
        pub meshes_refused: u32,
        pub mesh_sets: u64,
        pub mesh_samples: u64,
        /// Samples with a non-finite direction, texture position, input, irradiance or reflectance.
        pub mesh_samples_not_finite: u64,
        /// Samples below the surface, not of unit length, or with negative irradiance.
        pub mesh_samples_out_of_bounds: u64,
    }
}

/// Faults of one mesh; several may be combined.
#[derive(Debug, Clone, Copy, Default)]
struct Faults {
    /// True if triangles without area are added.
    empty_triangles: bool,
    uv: Uv,
    /// True if normals are replaced by [`broken_normal`].
    opposing_normals: bool,
    /// Factor on all coordinates.
    size: f64,
    /// Offset added to all coordinates, in units of `size`.
    offset: f64,
}

/// Texture coordinates of a mesh.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
enum Uv {
    #[default]
    Missing,
    Ordinary,
    Mirrored,
    /// All at one point.
    Point,
    /// All on one line.
    Line,
    /// Near the end of the range of f32.
    Huge,
}

/// Renders `meshes` invalid meshes.
pub fn run(seed: u64, meshes: u32) -> Result<Meshes> {
    let bar = output::bar(meshes.into(), "broken meshes");
    let one = |index: u32| {
        let found = check_mesh(seed, index);
        bar.inc(1);
        found
    };
    let found =
        (0..meshes).into_par_iter().map(one).try_reduce(Meshes::default, |a, b| Ok(a.plus(b)));
    bar.finish_and_clear();
    found
}

/// Renders one mesh in several scenes and checks its samples.
fn check_mesh(seed: u64, index: u32) -> Result<Meshes> {
    let key = BirthKey { seed, slot: index, attempt: 0 };
    let mut stream = Stream::new(key, Operator::RandomConstants);
    let faults = Faults::draw(index, &mut stream);
    let mut found = Meshes { meshes: 1, ..Meshes::default() };
    let text = obj(&faults, &mut stream);
    let Ok(file) = parse_obj(text.as_bytes(), &ObjLimits::default()) else {
        return Ok(Meshes { meshes_refused: 1, ..found });
    };
    let programs: Vec<Program> =
        (0..PROGRAMS).map(|k| candidate(seed ^ u64::from(index) << 8 | k).program).collect();
    let at = faults.size * faults.offset;
    for sampling in [Sampling::Fixed(3), Sampling::Adaptive] {
        for scene in scenes(at, faults.size) {
            let set = SampleSet::render(&file.mesh, &scene, SIZE_PX, sampling);
            found.mesh_sets += 1;
            found.mesh_samples += set.len() as u64;
            found.check(&set, &programs)?;
        }
    }
    Ok(found)
}

/// Points of an invalid mesh for painted materials, with and without shadows; `None` if the mesh is
/// rejected or not visible.
pub fn points(seed: u64, index: u64) -> Option<SampleSet> {
    let index = index as u32;
    let mut stream =
        Stream::new(BirthKey { seed, slot: index, attempt: 0 }, Operator::RandomConstants);
    let faults = Faults::draw(index, &mut stream);
    let text = obj(&faults, &mut stream);
    let file = parse_obj(text.as_bytes(), &ObjLimits::default()).ok()?;
    let scenes = scenes(faults.size * faults.offset, faults.size);
    let mut scene = scenes[index as usize % scenes.len()].clone();
    scene.shadows = index.is_multiple_of(3);
    let area = PixelArea::whole(POINTS_PX);
    let raster = Raster { size_px: POINTS_PX.into(), sampling: Sampling::default(), area };
    let set = SampleSet::render_points(&file.mesh, &scene, &LightAssets::default(), raster);
    (!set.is_empty()).then_some(set)
}

impl Faults {
    /// Cycles through every combination of faults; sizes are random.
    fn draw(index: u32, stream: &mut Stream) -> Self {
        let uv = [Uv::Missing, Uv::Ordinary, Uv::Mirrored, Uv::Point, Uv::Line, Uv::Huge];
        Self {
            empty_triangles: index % 2 == 1,
            opposing_normals: index / 2 % 2 == 1,
            uv: uv[index as usize / 4 % uv.len()],
            size: [1.0, 1e-18, 1e18, 1.0][stream.below(4) as usize],
            offset: [0.0, 0.0, 1e3, -1e6][stream.below(4) as usize],
        }
    }
}

impl Meshes {
    /// Counts the invalid samples of a set.
    fn check(&mut self, set: &SampleSet, programs: &[Program]) -> Result<()> {
        let batch: Vec<&Program> = programs.iter().collect();
        let mut f = Vec::new();
        CanonicalEvaluator::default().eval(&batch, set, &mut f)?;
        let irradiance = set.irradiance();
        for sample in 0..set.len() {
            let (pair, uv) = set.pair(sample);
            let light = irradiance.map(|channel| channel[sample]);
            let inputs = Input::symmetric().all(|input| set.input(input)[sample].is_finite());
            let reflectance = f.iter().skip(sample).step_by(set.len()).all(|f| f.is_finite());
            let directions = [pair.wi(), pair.wo()];
            let finite = directions.iter().all(|w| w.is_finite()) && uv.is_finite();
            let is_finite = finite && inputs && reflectance && light.iter().all(|e| e.is_finite());
            self.mesh_samples_not_finite += u64::from(!is_finite);
            let unit = |w: &DVec3| (w.length() - 1.0).abs() <= UNIT_TOLERANCE;
            let above = pair.cos_i() > 0.0 && pair.cos_o() > 0.0;
            let in_bounds = above && directions.iter().all(unit) && light.iter().all(|e| *e >= 0.0);
            self.mesh_samples_out_of_bounds += u64::from(!in_bounds);
        }
        Ok(())
    }
}

/// The default view; lights at grazing positions, on the surface and inside; a close view; a scaled
/// view.
fn scenes(at: f64, size: f64) -> Vec<Scene> {
    let light =
        |x: f64, y: f64, z: f64| Light::point_at([at + size * x, at + size * y, at + size * z]);
    let close = Camera::LookAt(LookAtCamera {
        eye: [at + 1.2 * size, at, at],
        target: [at, at, at],
        up: [0.0, 1.0, 0.0],
        fov_y_deg: 90.0,
    });
    vec![
        Scene::default(),
        Scene { lights: vec![light(-3.0, 0.0, 0.0), light(0.0, -1.01, 0.0)], ..Scene::default() },
        Scene { lights: vec![light(0.0, 0.0, 1.0), light(0.0, 0.0, 0.0)], ..Scene::default() },
        Scene { camera: close, scale: 3.0, rotation_deg: [90.0, 45.0, 180.0], ..Scene::default() },
    ]
}

/// The ball with its faults, as OBJ.
fn obj(faults: &Faults, stream: &mut Stream) -> String {
    let mut text = String::new();
    let mut line = |arguments: std::fmt::Arguments<'_>| {
        writeln!(text, "{arguments}").expect("writing to a string cannot fail");
    };
    for row in 0..=ROWS {
        for column in 0..=COLUMNS {
            let (sin, cos) = libm::sincos(PI * row as f64 / ROWS as f64);
            let (sin_phi, cos_phi) = libm::sincos(TAU * column as f64 / COLUMNS as f64);
            let n = DVec3::new(sin * sin_phi, cos, sin * cos_phi);
            let p = (n + DVec3::splat(faults.offset)) * faults.size;
            line(format_args!("v {:e} {:e} {:e}", p.x, p.y, p.z));
            let DVec2 { x, y } = faults.uv_at(row, column);
            line(format_args!("vt {x:e} {y:e}"));
            let n = if faults.opposing_normals { broken_normal(n, stream) } else { n };
            line(format_args!("vn {:e} {:e} {:e}", n.x, n.y, n.z));
        }
    }
    for row in 0..ROWS {
        for column in 0..COLUMNS {
            let a = row * (COLUMNS + 1) + column + 1;
            let (b, c, d) = (a + 1, a + COLUMNS + 1, a + COLUMNS + 2);
            for corners in [[a, c, d], [a, d, b]] {
                line(format_args!("f {}", faults.face(corners)));
            }
            if faults.empty_triangles {
                // A repeated corner, and three corners on a line.
                line(format_args!("f {}", faults.face([a, a, d])));
                line(format_args!("f {}", faults.face([a, b, a])));
            }
        }
    }
    text
}

impl Faults {
    /// Texture coordinates of a vertex.
    fn uv_at(&self, row: usize, column: usize) -> DVec2 {
        let (u, v) = (column as f64 / COLUMNS as f64, 1.0 - row as f64 / ROWS as f64);
        match self.uv {
            Uv::Missing | Uv::Ordinary => DVec2::new(u, v),
            Uv::Mirrored => DVec2::new((2.0 * u - 1.0).abs(), v),
            Uv::Point => DVec2::splat(0.25),
            Uv::Line => DVec2::new(u, 3.0 * u),
            Uv::Huge => DVec2::new(u - 0.5, v - 0.5) * 6e38,
        }
    }

    /// Corners of a triangle as OBJ, without texture coordinates if they are missing.
    fn face(&self, corners: [usize; 3]) -> String {
        let corner = |k: usize| match self.uv {
            Uv::Missing => format!("{k}//{k}"),
            _ => format!("{k}/{k}/{k}"),
        };
        corners.map(corner).join(" ")
    }
}

/// Returns the normal unchanged, flipped, tangential or with (almost) no length.
fn broken_normal(n: DVec3, stream: &mut Stream) -> DVec3 {
    match stream.below(5) {
        0 => -n,
        1 => n.any_orthonormal_vector(),
        2 => DVec3::ZERO,
        3 => n * 1e-30,
        _ => n,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invalid_meshes_give_only_finite_samples() {
        let found = run(5, 24).unwrap();
        assert_eq!(found.meshes, 24);
        assert!(found.meshes_refused < 12 && found.mesh_samples > 10_000, "{found:?}");
        let bad = (found.mesh_samples_not_finite, found.mesh_samples_out_of_bounds);
        assert_eq!(bad, (0, 0), "{found:?}");
    }
}
