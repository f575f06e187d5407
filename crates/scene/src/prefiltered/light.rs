//! Environment light on the surface points of a picture, at the nodes of each.

use brood_light::{PrefilteredEnvironment, SPOTS_MAX};
use glam::DVec3;
use rayon::prelude::*;

use super::between::{MirroredLight, PixelBetween, WIDTHS, crop, surroundings, thin};
use super::nodes::{COS_MIN, LobeNodes, NODES, Nodes};
use super::point::LitPoint;
use crate::{PixelArea, Raster};

/// Environments of a scene and the points of a picture that they light. Points of a pixel are
/// consecutive, pixels ascend.
#[derive(Debug)]
pub struct PrefilteredLight {
    points: Vec<LitPoint>,
    between: Vec<PixelBetween>,
    environments: Vec<Environment>,
}

#[derive(Debug)]
struct Environment {
    light: PrefilteredEnvironment,
    /// Level of each node, row by row.
    levels: Vec<[u8; NODES]>,
}

/// Spacing of tents as wide as a pixel's reflections, divided by the spread of its normals: the
/// reflections spread twice as far, and the variance of an even spread is half that of tents.
const SPACING_PER_SPREAD: f64 = std::f64::consts::SQRT_2;
/// Bounds of the factor of wide nodes.
const LEAST_SCALE: f32 = 0.25;
const LARGEST_SCALE: f32 = 4.0;
/// Length of the tangential part of the direction to the eye below which the eye is on the normal.
const LEAST_TANGENTIAL: f64 = 1e-6;
/// Integral of cos_i over a tent below which a node is left out: it is below the horizon.
const LEAST_WEIGHT: f32 = 1e-7;

impl PrefilteredLight {
    pub(crate) fn new(points: Vec<LitPoint>, lights: Vec<PrefilteredEnvironment>) -> Self {
        let nodes = LobeNodes::get();
        let environment = |light: PrefilteredEnvironment| {
            let of_row = |row: usize| nodes.spacings(row).map(|spacing| light.node_level(spacing));
            let levels = (0..LobeNodes::ROWS).map(of_row).collect();
            Environment { light, levels }
        };
        let environments = lights.into_iter().map(environment).collect();
        Self { points, between: Vec::new(), environments }
    }

    /// Returns the light of a picture; pixels of smooth parts are between points. `points` returns
    /// those of an area, which may be larger than that of the picture.
    pub(crate) fn of_picture(
        raster: Raster,
        lights: Vec<PrefilteredEnvironment>,
        points: impl FnOnce(PixelArea) -> Vec<LitPoint>,
    ) -> Self {
        let mut light = Self::new(Vec::new(), lights);
        let around = surroundings(raster.area, raster.size_px);
        let points = points(around);
        let mirrored: Vec<MirroredLight> =
            points.par_iter().map(|point| light.mirrored(point)).collect();
        let thinned = thin(points, &mirrored, around.width as usize);
        (light.points, light.between) = crop(thinned, around, raster.area);
        light
    }

    /// Returns the points.
    #[must_use]
    pub fn points(&self) -> &[LitPoint] {
        &self.points
    }

    /// Returns the pixels whose radiance is a mean of those of points.
    #[must_use]
    pub fn between(&self) -> &[PixelBetween] {
        &self.between
    }

    /// Returns its size in memory in bytes, environments included.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let environments = self
            .environments
            .iter()
            .map(|one| one.light.bytes() + size_of_val(one.levels.as_slice()));
        size_of_val(self.points.as_slice())
            + size_of_val(self.between.as_slice())
            + environments.sum::<usize>()
    }

    /// Returns the points alone, whose light has been gathered: environments may be large.
    #[must_use]
    pub fn without_environments(self) -> Self {
        Self { environments: Vec::new(), ..self }
    }

    /// Writes the mean radiance around the nodes of a point, and returns the number of nodes
    /// written, a multiple of [`super::NODES_TOGETHER`]; the others are below the horizon.
    ///
    /// # Units
    /// W/(m2 sr); the sum over all environments.
    #[inline(always)]
    pub fn radiance(&self, point: &LitPoint, out: &mut [[f32; NODES]; 3]) -> usize {
        let nodes = LobeNodes::get();
        let (row, distance) = point.row();
        let count = nodes.count(row);
        clear(out, count);
        let unit = |v: [f32; 3]| DVec3::from(v.map(f64::from)).normalize();
        let at = Place {
            frame: EyeFrame::new(unit(point.n), unit(point.eye)),
            weights: &nodes.weights(row, distance)[..count],
            spread: point.spread,
        };
        let row = row + usize::from(distance > 0.5);
        for Environment { light, levels } in &self.environments {
            add_light(nodes, (light, &levels[row]), &at, out);
        }
        count
    }
}

impl PrefilteredLight {
    /// Returns the light of a point from its mirror direction.
    fn mirrored(&self, point: &LitPoint) -> MirroredLight {
        let unit = |v: [f32; 3]| DVec3::from(v.map(f64::from)).normalize();
        let frame = EyeFrame::new(unit(point.n), unit(point.eye));
        let mut mirrored = MirroredLight { radiance: [[0.0; 3]; WIDTHS.len()], diffuse: 0.0 };
        for Environment { light, .. } in &self.environments {
            let axes = frame.axes(light);
            let half: [&[f32]; 3] = [&[0.0], &[0.0], &[1.0]];
            let (mut u, mut v) = ([0.0], [0.0]);
            directions(axes, frame.eye, half, (&mut u, &mut v));
            let (us, vs) = ([u[0]; WIDTHS.len()], [v[0]; WIDTHS.len()]);
            let levels = WIDTHS.map(|width| light.level_with_spots(width));
            let finest = light.level(SPACING_PER_SPREAD * f64::from(point.spread));
            light.radiance((&us, &vs), &levels, finest, |width, mean| {
                for (sum, mean) in mirrored.radiance[width].iter_mut().zip(mean) {
                    *sum += mean;
                }
            });
            let [red, green, blue] = light.irradiance(axes[2]);
            mirrored.diffuse += (red + green + blue) / (3.0 * std::f32::consts::PI);
        }
        mirrored
    }
}

/// Surface point of which the light is gathered.
pub(super) struct Place<'a> {
    pub(super) frame: EyeFrame,
    /// Integral of cos_i over the tent of each node.
    pub(super) weights: &'a [f32],
    /// Angle between the normals at opposite edges of the pixel, in radians.
    pub(super) spread: f32,
}

/// Local frame with the eye in the plane of x and z.
pub(super) struct EyeFrame {
    pub(super) x: DVec3,
    pub(super) y: DVec3,
    pub(super) n: DVec3,
    /// Sine and cosine of the angle to the eye.
    pub(super) eye: [f32; 2],
}

impl EyeFrame {
    /// Returns the frame of a unit normal and a unit vector to the eye.
    pub(super) fn new(n: DVec3, eye: DVec3) -> Self {
        let cos = n.dot(eye).clamp(COS_MIN, 1.0);
        let tangential = eye - n * n.dot(eye);
        // If the eye is on the normal, rounding alone makes the tangential part.
        let x = if tangential.length() > LEAST_TANGENTIAL {
            tangential.normalize()
        } else {
            n.any_orthonormal_vector()
        };
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        Self { x, y: n.cross(x), n, eye: [sin as f32, cos as f32] }
    }

    /// Returns the axes in a map.
    fn axes(&self, light: &PrefilteredEnvironment) -> [[f32; 3]; 3] {
        [self.x, self.y, self.n].map(|axis| light.in_map(axis).as_vec3().to_array())
    }
}

/// Adds the mean radiance around the nodes of a place. `levels`: one for each node, from
/// [`PrefilteredEnvironment::node_level`].
#[inline(always)]
pub(super) fn add_light(
    nodes: &impl Nodes,
    (light, levels): (&PrefilteredEnvironment, &[u8]),
    at: &Place<'_>,
    out: &mut [[f32; NODES]; 3],
) {
    let count = at.weights.len();
    let axes = at.frame.axes(light);
    let (mut us, mut vs) = ([0.0; NODES], [0.0; NODES]);
    let (us, vs) = (&mut us[..count], &mut vs[..count]);
    let half = nodes.half_parts();
    directions(axes, at.frame.eye, half, (us, vs));
    let finest = light.level(SPACING_PER_SPREAD * f64::from(at.spread));
    let mut means = [[0.0; NODES]; 3];
    light.radiance((us, vs), &levels[..count], finest, |node, mean| {
        means[0][node] = mean[0];
        means[1][node] = mean[1];
        means[2][node] = mean[2];
    });
    let mut of_spots = [[0.0; NODES]; 3];
    let spots = light.spots();
    let places = SpotPlaces::new(&spots.towards, (axes, at.frame.eye));
    let scale = light.scale();
    for k in 0..spots.classes.len().min(SPOTS_MAX) {
        let cos = places.cosines[k];
        if cos <= 0.0 {
            continue;
        }
        let irradiance = [0, 1, 2].map(|c| spots.irradiance[c][k] * scale[c]);
        let (around, shares) = nodes.around(places.chords[k], places.turns[k]);
        for corner in 0..4 {
            let node = around[corner];
            let weight = at.weights.get(node).copied().unwrap_or(0.0);
            // Nodes without a weight have no level.
            if weight > LEAST_WEIGHT
                && PrefilteredEnvironment::class(levels[node]) >= spots.classes[k]
            {
                let factor = cos * shares[corner] / weight;
                of_spots[0][node] += irradiance[0] * factor;
                of_spots[1][node] += irradiance[1] * factor;
                of_spots[2][node] += irradiance[2] * factor;
            }
        }
    }
    let irradiance = light.irradiance(axes[2]);
    for c in 0..3 {
        let (means, of_spots) = (&means[c][..count], &of_spots[c][..count]);
        let out = &mut out[c][..count];
        let (mut scaled, mut rest) = (0.0, 0.0);
        for k in 0..count {
            let is_wide = PrefilteredEnvironment::is_wide(levels[k]);
            scaled += if is_wide { at.weights[k] * means[k] } else { 0.0 };
            rest += at.weights[k] * if is_wide { of_spots[k] } else { of_spots[k] + means[k] };
        }
        // Means overlap only approximately as tents do. Those of wide nodes are scaled, so that
        // diffuse reflection is exact.
        let scale = (irradiance[c] - rest) / scaled.max(f32::MIN_POSITIVE);
        let scale = scale.clamp(LEAST_SCALE, LARGEST_SCALE);
        for k in 0..count {
            let factor = if PrefilteredEnvironment::is_wide(levels[k]) { scale } else { 1.0 };
            out[k] += of_spots[k] + means[k] * factor;
        }
    }
}

#[inline(always)]
fn clear(channels: &mut [[f32; NODES]; 3], count: usize) {
    for channel in channels {
        channel[..count].fill(0.0);
    }
}

/// Writes the points of the map's square for the incident directions of nodes. `axes`: the local
/// frame in the map, the eye in the plane of x and z; `eye`: sine and cosine of its angle.
#[inline(always)]
fn directions(
    axes: [[f32; 3]; 3],
    [sin, cos]: [f32; 2],
    half: [&[f32]; 3],
    (us, vs): (&mut [f32], &mut [f32]),
) {
    let [x, y, z] = axes;
    let count = us.len().min(vs.len()).min(half[0].len());
    let (us, vs) = (&mut us[..count], &mut vs[..count]);
    let (hx, hy, hz) = (&half[0][..count], &half[1][..count], &half[2][..count]);
    for k in 0..count {
        let h = [hx[k], hy[k], hz[k]];
        let double = 2.0 * (sin * h[0] + cos * h[2]);
        // Directions below the horizon belong to nodes of the row before or after.
        let wi = [double * h[0] - sin, double * h[1], (double * h[2] - cos).max(0.0)];
        let a = wi[0] * x[0] + wi[1] * y[0] + wi[2] * z[0];
        let b = wi[0] * x[1] + wi[1] * y[1] + wi[2] * z[1];
        let c = wi[0] * x[2] + wi[1] * y[2] + wi[2] * z[2];
        let length = (a * a + b * b + c * c).sqrt().max(1e-12);
        let [u, v] = PrefilteredEnvironment::square([a / length, b / length, c / length]);
        us[k] = u;
        vs[k] = v;
    }
}

/// Spots as seen from a place: their half vectors as chord and turn as in [`Nodes::around`], and
/// their cosines.
struct SpotPlaces {
    chords: [f32; SPOTS_MAX],
    turns: [f32; SPOTS_MAX],
    cosines: [f32; SPOTS_MAX],
}

impl SpotPlaces {
    /// `towards`: x, y and z of the directions of the spots; the others as in [`directions`].
    #[inline(always)]
    fn new(towards: &[Vec<f32>; 3], (axes, [sin, cos]): ([[f32; 3]; 3], [f32; 2])) -> Self {
        let mut places =
            Self { chords: [0.0; SPOTS_MAX], turns: [0.0; SPOTS_MAX], cosines: [0.0; SPOTS_MAX] };
        let [xs, ys, zs] = towards;
        let count = xs.len().min(SPOTS_MAX);
        let (xs, ys, zs) = (&xs[..count], &ys[..count], &zs[..count]);
        let [x, y, z] = axes;
        for k in 0..count {
            let (a, b, c) = (xs[k], ys[k], zs[k]);
            let cosine = z[0] * a + z[1] * b + z[2] * c;
            let along = x[0] * a + x[1] * b + x[2] * c + sin;
            let across = y[0] * a + y[1] * b + y[2] * c;
            let height = cosine + cos;
            let length = (along * along + across * across + height * height).sqrt().max(1e-6);
            places.chords[k] = (2.0 - 2.0 * height / length).max(0.0).sqrt();
            places.turns[k] = PrefilteredEnvironment::turns(along, across);
            places.cosines[k] = cosine;
        }
        places
    }
}

#[cfg(test)]
mod tests {
    use brood_light::{Light, LightAssets, LightSampler};
    use brood_mesh::{BuiltinMesh, Mesh, UnitFrame};

    use super::*;

    /// Light of the overcast sky at a point.
    fn overcast(n: DVec3, eye: DVec3) -> [[f32; NODES]; 3] {
        let light = r#"{"kind": "environment", "image": "overcast"}"#;
        let light: Light = serde_json::from_str(light).unwrap();
        let frame = UnitFrame::new(&Mesh::builtin(BuiltinMesh::Sphere), 1.0, [0.0; 3]);
        let samplers = LightSampler::all(&[light], 0.0, &LightAssets::default(), &frame);
        let point = LitPoint::new((0, 1.0), (n, eye), 0.0);
        let light = PrefilteredLight::new(vec![point], vec![samplers[0].prefiltered().unwrap()]);
        let mut out = [[0.0; NODES]; 3];
        light.radiance(&light.points()[0], &mut out);
        out
    }

    #[test]
    fn surface_that_faces_the_eye_has_the_light_of_one_that_almost_does() {
        for n in [DVec3::new(0.36, 0.48, 0.8), DVec3::Y, DVec3::new(-0.6, 0.0, 0.8)] {
            let facing = overcast(n, n);
            let almost = overcast(n, (n + n.any_orthonormal_vector() * 1e-3).normalize());
            // The frames differ by a turn about the normal: their sums are equal.
            let sum = |light: &[[f32; NODES]; 3]| light[1].iter().sum::<f32>();
            let (own, other) = (sum(&facing), sum(&almost));
            assert!((own / other - 1.0).abs() < 0.02, "{n} {own} {other}");
        }
    }
}
