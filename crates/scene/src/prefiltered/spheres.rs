//! Lit spheres: radiance of a material in the environments of a scene, for all normals, from which
//! the page draws any mesh live.
//!
//! Radiance depends on the normal n and on the direction o to the eye, which varies little within a
//! picture. Each sphere has one direction v to the eye: that of a corner of the picture, of the
//! middle of a side, or of the middle. A surface point with the mirror direction r reads the sphere
//! at the normal between v and r. Mirror directions are exact; the errors in n and n . o cancel to
//! first order in the bilinear mean of the four spheres around the point.

use brood_light::{LightAssets, LightSampler};
use brood_mesh::angle::rotation_y_deg;
use brood_mesh::{Mesh, UnitFrame};
use glam::{DVec2, DVec3};

use super::light::PrefilteredLight;
use super::point::LitPoint;
use crate::PictureSize;
use crate::description::Scene;
use crate::sample_set::View;

/// Number of rows of lit spheres, from the lower edge of the picture.
const ROWS: u32 = 3;

/// Layout of lit spheres in an image, the first row at the bottom.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SphereLayout {
    /// Texels along the side of a sphere, at least 2.
    pub texels: u32,
    /// Number of turns of the environments. With one the directions to the eye are those of
    /// corners, middles of the sides and middle of the picture, as three spheres in each of three
    /// rows. With more there is one sphere in each of three rows for each turn, those of the middle
    /// column: turned environments also stand for directions at other azimuths.
    pub turns: u32,
}

impl SphereLayout {
    /// Returns the layout in an image of this size; `None` if there is none.
    #[must_use]
    pub fn of_size(PictureSize { width, height }: PictureSize) -> Option<Self> {
        let layout = match width == height {
            true => Self { texels: width / ROWS, turns: 1 },
            false => Self { texels: width, turns: height / (ROWS * width).max(1) },
        };
        (layout.texels >= 2 && layout.size_px() == PictureSize { width, height }).then_some(layout)
    }

    /// Returns the number of spheres in a row.
    #[must_use]
    pub fn across(self) -> u32 {
        if self.turns == 1 { ROWS } else { 1 }
    }

    /// Returns the size of the image.
    #[must_use]
    pub fn size_px(self) -> PictureSize {
        let height = ROWS * self.texels * self.turns;
        PictureSize { width: self.across() * self.texels, height }
    }
}
/// Angle between the normals of neighbouring texels in the middle of a sphere, times the number of
/// texels along a side.
const SPREAD: f64 = std::f64::consts::SQRT_2;

impl PrefilteredLight {
    /// Returns the environments of a scene on its lit spheres, and a point for each texel.
    ///
    /// A texel at a, b in -1..=1 has in the frame of its sphere (x to the right in the picture, z
    /// towards the eye) the normal along (p, q, 1 - |p| - |q|) with p = (a + b) / 2 and
    /// q = (a - b) / 2. With n turns the spheres follow under the environments turned by 1 / n of a
    /// circle about the vertical axis, by 2 / n, and so on.
    ///
    /// # Domain
    /// `scene` is one of [`Scene::for_spheres`]; `mesh` is any mesh, of which only the frame is
    /// used.
    ///
    /// # Source
    /// Cigolle et al. 2014, *A Survey of Efficient Representations for Independent Unit Vectors*:
    /// the octahedral map of a hemisphere.
    #[must_use]
    pub fn on_spheres(
        scene: &Scene,
        mesh: &Mesh,
        assets: &LightAssets,
        layout: SphereLayout,
    ) -> Self {
        let SphereLayout { texels: side, turns } = layout;
        let frame = UnitFrame::new(mesh, scene.scale, scene.rotation_deg);
        let lights = LightSampler::all(&scene.lights, scene.light_deg, assets, &frame);
        let view = View::new(&scene.camera, &frame, side.into());
        let spread = SPREAD / f64::from(side - 1);
        let at = |texel: u32| 2.0 * f64::from(texel) / f64::from(side - 1) - 1.0;
        let mut points = Vec::new();
        let PictureSize { width, height } = layout.size_px();
        let first = 1.0 - f64::from(layout.across() / 2);
        for row in 0..height {
            // As the environments see the point after their turn.
            let turned = 360.0 * f64::from(row / (ROWS * side)) / f64::from(turns);
            let back = rotation_y_deg(-turned);
            for column in 0..width {
                let place = [first + f64::from(column / side), f64::from(row / side % ROWS)];
                let place = DVec2::from(place) - 1.0;
                let eye = -view.ray(place).direction;
                let x = (view.right() - eye * view.right().dot(eye)).normalize();
                let (a, b) = (at(column % side), at(row % side));
                let (p, q) = (0.5 * (a + b), 0.5 * (a - b));
                let local = DVec3::new(p, q, 1.0 - p.abs() - q.abs()).normalize();
                let n = x * local.x + eye.cross(x) * local.y + eye * local.z;
                let seen = (back * n, back * eye);
                points.push(LitPoint::new((row * width + column, 1.0), seen, spread));
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
        let layout = SphereLayout { texels: SIDE, turns: 1 };
        let light = PrefilteredLight::on_spheres(&scene, &mesh, &LightAssets::default(), layout);
        let across = layout.size_px().width;
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

    #[test]
    fn turned_spheres_see_the_environments_turned() {
        const SIDE: u32 = 4;
        let mesh = Mesh::builtin(BuiltinMesh::Sphere);
        let read = |rotation_deg: f64| -> Scene {
            let json = format!(
                r#"{{"lights": [{{"kind": "environment", "image": "studio",
                    "rotation_deg": {rotation_deg}}}]}}"#
            );
            serde_json::from_str(&json).unwrap()
        };
        let points = |scene: &Scene, turns: u32| {
            let layout = SphereLayout { texels: SIDE, turns };
            let scene = scene.for_spheres(turns);
            PrefilteredLight::on_spheres(&scene, &mesh, &LightAssets::default(), layout)
        };
        let turned = points(&read(77.0), 4);
        let points_of_turn = (3 * SIDE * SIDE) as usize;
        assert_eq!(turned.points().len(), 4 * points_of_turn);
        let mut nodes = [[0.0; super::super::NODES]; 3];
        let mut radiance = |light: &PrefilteredLight, point: usize| {
            light.radiance(&light.points()[point], &mut nodes);
            nodes.map(|channel| channel.iter().sum::<f32>())
        };
        for turn in 0..4 {
            let resting = points(&read(90.0 * turn as f64), 1);
            for row in 0..3 * SIDE {
                for column in 0..SIDE {
                    // The middle column of the three.
                    let own = (row * 3 * SIDE + SIDE + column) as usize;
                    let other = turn * points_of_turn + (row * SIDE + column) as usize;
                    let [a, b] = [radiance(&resting, own), radiance(&turned, other)];
                    for (a, b) in a.into_iter().zip(b) {
                        assert!((a - b).abs() <= 1e-3 * a.max(b), "{turn} {row} {column}: {a} {b}");
                    }
                }
            }
        }
    }

    #[test]
    fn layout_follows_from_the_size_of_the_image() {
        for (texels, turns) in [(2, 1), (48, 1), (32, 2), (32, 18)] {
            let layout = SphereLayout { texels, turns };
            assert_eq!(SphereLayout::of_size(layout.size_px()), Some(layout));
        }
        for (width, height) in [(0, 0), (3, 3), (7, 7), (32, 33), (32, 96), (32, 100)] {
            assert_eq!(SphereLayout::of_size(PictureSize { width, height }), None);
        }
    }
}
