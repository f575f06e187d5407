//! Lit spheres: radiance of a material in the environments of a scene, for all normals, from which
//! the page draws any mesh live.
//!
//! Radiance depends on the normal n and on the direction o to the eye, which varies little within a
//! picture. Each sphere has one direction v to the eye: that of a corner of the picture, of the
//! middle of a side, or of the middle. A surface point with the mirror direction r reads the sphere
//! at the normal between v and r. Mirror directions are exact; the errors in n and n . o cancel to
//! first order in the bilinear mean of the four spheres around the point.

use brood_light::{LightAssets, LightSampler};
use brood_mesh::{Mesh, UnitFrame};
use glam::{DVec2, DVec3};

use super::light::PrefilteredLight;
use super::point::LitPoint;
use crate::description::Scene;
use crate::sample_set::View;

/// Number of rows of lit spheres, and of spheres in a row, from the lower left of the picture.
pub const SPHERES_ACROSS: u32 = 3;
/// Angle between the normals of neighbouring texels in the middle of a sphere, times the number of
/// texels along a side.
const SPREAD: f64 = std::f64::consts::SQRT_2;

impl PrefilteredLight {
    /// Returns the environments of a scene on its lit spheres, and a point for each texel.
    ///
    /// A sphere is a square of `side` x `side` texels; the spheres are in one image, the first row
    /// at the bottom. A texel at a, b in -1..=1 has in the frame of its sphere (x to the right in
    /// the picture, z towards the eye) the normal along (p, q, 1 - |p| - |q|) with p = (a + b) / 2
    /// and q = (a - b) / 2.
    ///
    /// # Domain
    /// `side` at least 2; `mesh` is any mesh, of which only the frame is used.
    ///
    /// # Source
    /// Cigolle et al. 2014, *A Survey of Efficient Representations for Independent Unit Vectors*:
    /// the octahedral map of a hemisphere.
    #[must_use]
    pub fn on_spheres(scene: &Scene, mesh: &Mesh, assets: &LightAssets, side: u32) -> Self {
        let frame = UnitFrame::new(mesh, scene.scale, scene.rotation_deg);
        let lights = LightSampler::all(&scene.lights, scene.light_deg, assets, &frame);
        let view = View::new(&scene.camera, &frame, side.into());
        let spread = SPREAD / f64::from(side - 1);
        let at = |texel: u32| 2.0 * f64::from(texel) / f64::from(side - 1) - 1.0;
        let mut points = Vec::new();
        let across = SPHERES_ACROSS * side;
        for row in 0..across {
            for column in 0..across {
                let place = [column / side, row / side].map(|k| f64::from(k) - 1.0);
                let eye = -view.ray(DVec2::from(place)).direction;
                let x = (view.right() - eye * view.right().dot(eye)).normalize();
                let (a, b) = (at(column % side), at(row % side));
                let (p, q) = (0.5 * (a + b), 0.5 * (a - b));
                let local = DVec3::new(p, q, 1.0 - p.abs() - q.abs()).normalize();
                let n = x * local.x + eye.cross(x) * local.y + eye * local.z;
                points.push(LitPoint::new((row * across + column, 1.0), (n, eye), spread));
            }
        }
        Self::new(points, lights.iter().filter_map(LightSampler::prefiltered).collect())
    }
}

#[cfg(test)]
mod tests {
    use brood_mesh::BuiltinMesh;

    use super::*;

    #[test]
    fn spheres_have_all_normals_on_the_side_of_the_eye() {
        const SIDE: u32 = 5;
        let lights = r#"{"lights": [{"kind": "environment", "image": "studio"}]}"#;
        let scene: Scene = serde_json::from_str(lights).unwrap();
        let mesh = Mesh::builtin(BuiltinMesh::Sphere);
        let light = PrefilteredLight::on_spheres(&scene, &mesh, &LightAssets::default(), SIDE);
        let across = SPHERES_ACROSS * SIDE;
        let points = light.points();
        assert_eq!(points.len(), (across * across) as usize);
        let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let at = |column: u32, row: u32| &points[(row * across + column) as usize];
        let middle = at(across / 2, across / 2);
        assert!((vector(middle.n) - vector(middle.eye)).length() < 1e-6, "it faces the eye");
        for (index, point) in points.iter().enumerate() {
            assert_eq!(point.pixel as usize, index);
            let (n, eye) = (vector(point.n), vector(point.eye));
            assert!((n.length() - 1.0).abs() < 1e-6 && (eye.length() - 1.0).abs() < 1e-6);
            assert!(n.dot(eye) > -1e-6, "{n} {eye}");
        }
        // The edges of a sphere are its silhouette.
        for k in 0..SIDE {
            for edge in [at(k, 0), at(0, k), at(SIDE - 1, k), at(k, SIDE - 1)] {
                assert!(vector(edge.n).dot(vector(edge.eye)).abs() < 1e-6);
            }
        }
        // From the eye in the picture's upper right, the surface is seen from there.
        let upper_right = vector(at(across - 1, across - 1).eye);
        let apart = upper_right.dot(vector(middle.eye)).acos().to_degrees();
        let expected = (15f64.to_radians().tan() * std::f64::consts::SQRT_2).atan().to_degrees();
        assert!((apart - expected).abs() < 1e-3, "{apart} {expected}");
    }
}
