//! Environment light on a surface point as few samples of mean radiance, for materials that vary
//! over the surface or with its tangents. Such materials are evaluated at every point, so fewer
//! directions are affordable than in the tables of [`super::LobeNodes`].

use std::f64::consts::PI;
use std::sync::LazyLock;

use brood_brdf::{DirectionPair, Level, SimdKernel};
use brood_light::PrefilteredEnvironment;
use glam::DVec3;

use super::facing::Facing;
use super::light::{EyeFrame, Place, add_light};
use super::nodes::{NODES, Nodes, RingBelow, half_vector};

/// Shape of the lobes of materials, which decides the number of directions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LobeShape {
    /// Isotropic.
    Round,
    /// Any: lobes may be streaks, which need more directions around the normal.
    Any,
}

/// Ring of nodes.
struct Ring {
    /// Distance of its half vectors from the normal, as a chord.
    chord: f64,
    /// Distance of the border to the next ring.
    border: f64,
    /// Number of nodes for round lobes and for any lobes, at equal angles around the normal.
    counts: [usize; 2],
}

const fn ring(chord: f64, border: f64, round: usize, any: usize) -> Ring {
    Ring { chord, border, counts: [round, any] }
}

/// Rings of nodes. Chords grow by factors up to 0.25, and borders are where the areas of rings are
/// those of the trapezoidal rule in the logarithm of the chord, which converges exponentially for
/// smooth lobes. Inner rings need few nodes, because light hardly changes over them.
const RINGS: [Ring; 17] = [
    ring(0.0, 0.0054, 1, 1),
    ring(0.008, 0.0109, 1, 2),
    ring(0.016, 0.0188, 1, 4),
    ring(0.0226, 0.0266, 2, 8),
    ring(0.032, 0.0376, 4, 8),
    ring(0.045, 0.0531, 6, 12),
    ring(0.064, 0.0752, 8, 16),
    ring(0.09, 0.1062, 8, 24),
    ring(0.128, 0.1503, 8, 24),
    ring(0.18, 0.2102, 12, 24),
    ring(0.25, 0.2967, 12, 24),
    ring(0.36, 0.4204, 12, 24),
    ring(0.5, 0.5708, 12, 24),
    ring(0.66, 0.7411, 12, 24),
    ring(0.84, 0.945, 12, 24),
    ring(1.05, 1.15, 8, 12),
    ring(1.25, std::f64::consts::SQRT_2, 8, 12),
];
const CHORDS: [f32; RINGS.len()] = {
    let mut chords = [0.0; RINGS.len()];
    let mut ring = 0;
    while ring < RINGS.len() {
        chords[ring] = RINGS[ring].chord as f32;
        ring += 1;
    }
    chords
};
const RING_BELOW: RingBelow = RingBelow::new(&CHORDS);
/// Width of means of radiance, divided by the spacing of nodes. Lobes blur the light too, so wider
/// means would blur it twice.
const SPACING: f64 = 0.7;
/// Number of tabulated angles to the eye, at equal distances of the cosine.
const ROWS: usize = 33;

impl LobeShape {
    const ALL: [Self; 2] = [Self::Round, Self::Any];

    /// Largest number of samples of the environments at a surface point.
    #[must_use]
    pub const fn samples(self) -> usize {
        let (mut count, mut ring) = (0, 0);
        while ring < RINGS.len() {
            count += RINGS[ring].counts[self as usize];
            ring += 1;
        }
        count
    }

    fn nodes(self) -> &'static DirectNodes {
        static NODES: LazyLock<[DirectNodes; 2]> =
            LazyLock::new(|| LobeShape::ALL.map(DirectNodes::new));
        &NODES[self as usize]
    }
}
const _: () = assert!(LobeShape::Any.samples() <= NODES);

/// Nodes at which materials are evaluated directly.
struct DirectNodes {
    /// x, y and z of the half vectors.
    half: [Vec<f32>; 3],
    /// Solid angle of half vectors around each node.
    areas: Vec<f32>,
    /// First node of each ring, number of its nodes, and turn of the first as a share of a full
    /// turn.
    rings: [(usize, usize, f32); RINGS.len()],
}

impl DirectNodes {
    fn new(shape: LobeShape) -> Self {
        let mut nodes =
            Self { half: Default::default(), areas: Vec::new(), rings: [(0, 0, 0.0); RINGS.len()] };
        let mut inner = 0.0;
        for (ring, of_ring) in RINGS.iter().zip(&mut nodes.rings) {
            let count = ring.counts[shape as usize];
            // Few nodes are placed symmetrically beside the plane of the eye.
            let turn = match count {
                1 | 2 => 0.25,
                4 => 0.125,
                _ => 0.0,
            };
            *of_ring = (nodes.areas.len(), count, turn as f32);
            for k in 0..count {
                let half = half_vector(ring.chord, 2.0 * PI * (k as f64 / count as f64 + turn));
                for (into, value) in nodes.half.iter_mut().zip(half.as_vec3().to_array()) {
                    into.push(value);
                }
                let area = PI * (ring.border * ring.border - inner * inner) / count as f64;
                nodes.areas.push(area as f32);
            }
            inner = ring.border;
        }
        nodes
    }

    /// Solid angle of incident directions around each node, for sine and cosine of the angle to the
    /// eye.
    #[inline(always)]
    fn solid_angle(&self, [sin, cos]: [f32; 2], node: usize) -> f32 {
        let along = sin * self.half[0][node] + cos * self.half[2][node];
        4.0 * along.max(0.0) * self.areas[node]
    }

    /// Returns the two nodes of a ring around a turn, and the share of the second.
    #[inline(always)]
    fn along(&self, ring: usize, turn: f32) -> ([usize; 2], f32) {
        let (first, count, start) = self.rings[ring];
        let turn = turn - start;
        let at = if turn < 0.0 { turn + 1.0 } else { turn } * count as f32;
        // A turn of 1 may be rounded up to the end of the ring.
        let node = (at as usize).min(count - 1);
        let next = if node + 1 == count { 0 } else { node + 1 };
        ([first + node, first + next], at - node as f32)
    }
}

impl Nodes for DirectNodes {
    fn half_parts(&self) -> [&[f32]; 3] {
        [&self.half[0], &self.half[1], &self.half[2]]
    }

    #[inline(always)]
    fn around(&self, chord: f32, turn: f32) -> ([usize; 4], [f32; 4]) {
        let ring = RING_BELOW.of(&CHORDS, chord);
        let (own, next) = (CHORDS[ring], CHORDS[ring + 1]);
        let outwards = ((chord - own) / (next - own)).clamp(0.0, 1.0);
        let ([a, b], inner) = self.along(ring, turn);
        let ([c, d], outer) = self.along(ring + 1, turn);
        let shares = [
            (1.0 - outwards) * (1.0 - inner),
            (1.0 - outwards) * inner,
            outwards * (1.0 - outer),
            outwards * outer,
        ];
        ([a, b, c, d], shares)
    }
}

/// Environments of a scene, as samples of mean radiance.
pub(crate) struct DirectLight {
    level: Level,
    nodes: &'static DirectNodes,
    environments: Vec<Environment>,
}

struct Environment {
    light: PrefilteredEnvironment,
    /// Level of each node, by the cosine of the angle to the eye.
    levels: Vec<Vec<u8>>,
}

impl DirectLight {
    pub(crate) fn new(environments: Vec<PrefilteredEnvironment>, shape: LobeShape) -> Self {
        let nodes = shape.nodes();
        let levels = |light: &PrefilteredEnvironment| {
            let row = |row: usize| {
                let cos = row as f32 / (ROWS - 1) as f32;
                let eye = [(1.0 - cos * cos).max(0.0).sqrt(), cos];
                let level = |node: usize| {
                    light.node_level(f64::from(nodes.solid_angle(eye, node)).sqrt() * SPACING)
                };
                (0..nodes.areas.len()).map(level).collect()
            };
            (0..ROWS).map(row).collect()
        };
        let environment = |light| Environment { levels: levels(&light), light };
        let environments = environments.into_iter().map(environment).collect();
        Self { level: Level::best(), nodes, environments }
    }

    /// Returns the directions of each node, seen from an angle with this cosine; `None` below the
    /// horizon. Nodes that are each other's mirror image, which isotropic materials do not
    /// distinguish, have the same bits.
    pub(crate) fn pairs(shape: LobeShape, cos_o: f64) -> Vec<Option<DirectionPair>> {
        let nodes = shape.nodes();
        let wo = DVec3::new((1.0 - cos_o * cos_o).sqrt(), 0.0, cos_o);
        let pair = |node: usize| {
            let half = [0, 1, 2].map(|axis| f64::from(nodes.half[axis][node]));
            let half = DVec3::new(half[0], half[1].abs(), half[2]).normalize();
            let wi = (2.0 * wo.dot(half) * half - wo).normalize();
            (wi.z > 0.0).then(|| DirectionPair::new(wi, wo).expect("both are unit vectors"))
        };
        (0..nodes.areas.len()).map(pair).collect()
    }

    /// Returns the samples at a surface point.
    pub(crate) fn at(&self, facing: &Facing) -> DirectSamples {
        self.level.run(At { light: self, facing })
    }
}

/// Kernel that samples the light at a surface point.
struct At<'a> {
    light: &'a DirectLight,
    facing: &'a Facing,
}

impl SimdKernel for At<'_> {
    type Output = DirectSamples;

    #[inline(always)]
    fn run(self) -> DirectSamples {
        let Self { light: DirectLight { nodes, environments, .. }, facing } = self;
        let nodes: &DirectNodes = nodes;
        let count = nodes.areas.len();
        let frame = EyeFrame::new(facing.frame.n(), facing.eye);
        let [sin, cos] = frame.eye;
        let (mut cosines, mut weights) = ([0.0; NODES], [0.0; NODES]);
        for k in 0..count {
            let along = sin * nodes.half[0][k] + cos * nodes.half[2][k];
            cosines[k] = (2.0 * along * nodes.half[2][k] - cos).max(0.0);
            weights[k] = nodes.solid_angle(frame.eye, k) * cosines[k];
        }
        let mut means = [[0.0; NODES]; 3];
        let row = (cos * (ROWS - 1) as f32 + 0.5) as usize;
        let at = Place { frame, weights: &weights[..count], spread: 0.0 };
        for Environment { light, levels } in environments {
            add_light(nodes, (light, &levels[row]), &at, &mut means);
        }
        let EyeFrame { x, y, n, .. } = at.frame;
        let (mut samples, mut places) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for k in 0..count {
            let irradiance = [0, 1, 2].map(|c| f64::from(means[c][k] * weights[k]));
            if cosines[k] > 0.0 && irradiance != [0.0; 3] {
                let h = [nodes.half[0][k], nodes.half[1][k], nodes.half[2][k]].map(f64::from);
                let double = 2.0 * (f64::from(sin) * h[0] + f64::from(cos) * h[2]);
                let along = double * h[0] - f64::from(sin);
                let up = double * h[2] - f64::from(cos);
                let towards = x * along + y * (double * h[1]) + n * up;
                samples.push((towards.normalize(), irradiance));
                places.push(k);
            }
        }
        DirectSamples { n: facing.frame.n(), samples, nodes: places }
    }
}

/// Samples of environments around a surface point.
#[derive(Debug, Clone)]
pub(crate) struct DirectSamples {
    n: DVec3,
    samples: Vec<(DVec3, [f64; 3])>,
    /// Node of each sample.
    nodes: Vec<usize>,
}

/// Distance of normals up to which points of a pixel share samples.
const NEAR: f64 = 0.01;

impl DirectSamples {
    /// True if the samples also serve another point of the pixel.
    pub(crate) fn is_near(&self, facing: &Facing) -> bool {
        (self.n - facing.frame.n()).length() <= NEAR
    }

    /// Iterates over directions in the unit frame, and irradiance times cosine.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &(DVec3, [f64; 3])> {
        self.samples.iter()
    }

    /// Nodes of the samples, in the order of [`DirectSamples::iter`].
    pub(crate) fn nodes(&self) -> &[usize] {
        &self.nodes
    }
}

#[cfg(test)]
mod tests {
    use brood_light::{Light, LightAssets, LightSampler};
    use brood_mesh::{BuiltinMesh, LocalFrame, Mesh, UnitFrame};
    use glam::DVec2;

    use super::*;

    fn light(environment: &str, shape: LobeShape) -> (DirectLight, PrefilteredEnvironment) {
        let json = format!(r#"{{"kind": "environment", "image": "{environment}"}}"#);
        let light: Light = serde_json::from_str(&json).unwrap();
        let frame = UnitFrame::new(&Mesh::builtin(BuiltinMesh::Sphere), 1.0, [0.0; 3]);
        let samplers = LightSampler::all(&[light], 0.0, &LightAssets::default(), &frame);
        let one = samplers[0].prefiltered().unwrap();
        (DirectLight::new(vec![one.clone()], shape), one)
    }

    #[test]
    fn samples_sum_to_the_irradiance() {
        for environment in ["studio", "low-sun", "overcast", "interior"] {
            for shape in LobeShape::ALL {
                let (light, expected) = light(environment, shape);
                for (n, eye) in [
                    (DVec3::Z, DVec3::Z),
                    (DVec3::new(0.36, 0.48, 0.8), DVec3::Z),
                    (DVec3::new(-0.8, 0.6, 0.0), DVec3::new(0.0, 0.6, 0.8)),
                ] {
                    let frame = LocalFrame::new(n, n.any_orthonormal_vector());
                    let facing = Facing { frame, eye, uv: DVec2::ZERO };
                    let samples = light.at(&facing);
                    assert!(samples.samples.len() <= shape.samples());
                    let mut sum = [0.0; 3];
                    for (towards, irradiance) in samples.iter() {
                        assert!((towards.length() - 1.0).abs() < 1e-9 && towards.dot(n) > -1e-6);
                        sum = [0, 1, 2].map(|c| sum[c] + irradiance[c]);
                    }
                    let map = expected.in_map(n).as_vec3().to_array();
                    for (sum, expected) in sum.iter().zip(expected.irradiance(map)) {
                        let ratio = sum / f64::from(expected);
                        assert!((ratio - 1.0).abs() < 0.01, "{environment} {n} {ratio}");
                    }
                }
            }
        }
    }

    #[test]
    fn rings_integrate_round_lobes() {
        let nodes = LobeShape::Round.nodes();
        for alpha in [0.02, 0.05, 0.1, 0.2, 0.5] {
            let density = |node: usize| {
                let cos = f64::from(nodes.half[2][node]);
                let tan_squared = 1.0 / (cos * cos) - 1.0;
                let t = alpha * alpha + tan_squared;
                alpha * alpha / (PI * cos.powi(4) * t * t) * cos
            };
            let all = 0..nodes.areas.len();
            let sum: f64 = all.map(|node| density(node) * f64::from(nodes.areas[node])).sum();
            assert!((sum - 1.0).abs() < 0.02, "GGX of {alpha}: {sum}");
        }
    }
}
