//! Corrections of a scene: other directions and distances of lights and camera.

use brood_light::{Light, LightAssets, LightMove, LightSampler};
use brood_mesh::angle::rotated_deg;
use brood_mesh::{Mesh, UnitFrame};
use glam::DVec3;

use crate::description::{Camera, LookAtCamera, Scene};
use crate::sample_set::{PictureSize, looking_at};

/// Correction of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Correction {
    /// Movement of each light.
    pub lights: Vec<LightMove>,
    /// Movement of the camera.
    pub camera: CameraMove,
}

/// Movement of a camera. The default changes nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraMove {
    /// Turn about the centre of the mesh, with the whole camera: to the right and upwards, in
    /// degrees.
    pub turn_deg: [f64; 2],
    /// Turn about the eye: to the right, upwards, and clockwise, in degrees.
    pub aim_deg: [f64; 3],
    /// Factor of the distance from the centre of the mesh.
    pub distance: f64,
    /// Factor of the field of view.
    pub fov: f64,
}

impl Default for CameraMove {
    fn default() -> Self {
        Self { turn_deg: [0.0; 2], aim_deg: [0.0; 3], distance: 1.0, fov: 1.0 }
    }
}

impl Scene {
    /// True if the camera can be corrected: it has an eye.
    #[must_use]
    pub fn has_eye(&self) -> bool {
        !matches!(self.camera, Camera::Orthographic(_))
    }

    /// Returns the scene with moved lights and a moved camera. A camera that moves gets the form
    /// with `eye`, `target` and `up`; parallel rays do not move.
    ///
    /// # Panics
    /// If there are not as many movements as lights.
    #[must_use]
    pub fn corrected(&self, mesh: &Mesh, size_px: impl Into<PictureSize>, by: &Correction) -> Self {
        assert_eq!(by.lights.len(), self.lights.len(), "every light has a movement");
        let frame = UnitFrame::new(mesh, self.scale, self.rotation_deg);
        let lights = self.lights.iter().zip(&by.lights);
        let lights = lights.map(|(light, by)| light.moved(&frame, *by)).collect();
        let camera = match looking_at(&self.camera, &frame, size_px.into()) {
            Some(camera) if by.camera != CameraMove::default() => {
                Camera::LookAt(moved(&camera, &frame, by.camera))
            }
            _ => self.camera.clone(),
        };
        Self { lights, camera, ..self.clone() }
    }
}

impl Scene {
    /// Returns the direction of the first light without size as seen from the centre of the mesh,
    /// with the eye in front: to the right and upwards from the direction to the eye, in degrees.
    #[must_use]
    pub fn lamp_from_eye_deg(&self, mesh: &Mesh, assets: &LightAssets) -> Option<[f64; 2]> {
        let at = self.lights.iter().position(Light::is_movable)?;
        let frame = UnitFrame::new(mesh, self.scale, self.rotation_deg);
        let lamp = &LightSampler::all(&self.lights, self.light_deg, assets, &frame)[at];
        let towards = lamp.central(frame.pivot(), None)?.towards?;
        let back = -frame.direction(DVec3::from(self.camera.direction()));
        let right = frame.direction(DVec3::Y).cross(back).try_normalize()?;
        let up = back.cross(right);
        let [x, y, z] = [right, up, back].map(|axis| axis.dot(towards));
        Some([libm::atan2(x, z), libm::asin(y.clamp(-1.0, 1.0))].map(f64::to_degrees))
    }
}

fn moved(camera: &LookAtCamera, frame: &UnitFrame, by: CameraMove) -> LookAtCamera {
    let eye = frame.relative(camera.eye);
    let away = eye - frame.relative(camera.target);
    let back = away.normalize();
    let right = DVec3::from(camera.up).normalize().cross(back).normalize();
    let up = back.cross(right);
    // About the centre: the eye moves to the right and upwards.
    let turned = |v: DVec3| rotated_deg(rotated_deg(v, right, -by.turn_deg[1]), up, by.turn_deg[0]);
    let (eye, axes) = (turned(eye) * by.distance, [right, up, back].map(turned));
    // About the eye.
    let [aim_right, aim_up, roll] = by.aim_deg;
    let aimed = |v: DVec3| {
        let v = rotated_deg(rotated_deg(v, axes[0], aim_up), axes[1], -aim_right);
        rotated_deg(v, axes[2], -roll)
    };
    let [_, up, back] = axes.map(aimed);
    LookAtCamera {
        eye: frame.world(eye),
        target: frame.world(eye - back * away.length()),
        up: up.to_array(),
        fov_y_deg: camera.fov_y_deg * by.fov,
    }
}

#[cfg(test)]
mod tests {
    use brood_mesh::BuiltinMesh;

    use super::*;
    use crate::SampleSet;

    fn scene(json: &str) -> Scene {
        serde_json::from_str(json).unwrap()
    }

    fn none(scene: &Scene) -> Correction {
        let light = LightMove { turn_deg: [0.0; 2], distance: 1.0 };
        Correction { lights: vec![light; scene.lights.len()], camera: CameraMove::default() }
    }

    /// Mean column and row of the covered part of a picture, in pixels, and its area.
    fn covered(mesh: &Mesh, scene: &Scene) -> [f64; 3] {
        let set = SampleSet::render(mesh, scene, 64, 1);
        let image = set.image().unwrap();
        let mut sums = [0.0; 3];
        for (at, share) in image.coverage.iter().enumerate() {
            let share = f64::from(*share);
            sums[0] += share * (at % 64) as f64;
            sums[1] += share * (at / 64) as f64;
            sums[2] += share;
        }
        [sums[0] / sums[2], sums[1] / sums[2], sums[2]]
    }

    #[test]
    fn correction_by_nothing_keeps_the_picture() {
        let mesh = Mesh::builtin(BuiltinMesh::Knob);
        for json in [
            r#"{"camera": {"orbit_deg": [200, 35]}, "rotation_deg": [10, 20, 30]}"#,
            r#"{"camera": {"eye": [1, 2, 6], "target": [0, 0.3, 0]}, "scale": 0.8}"#,
        ] {
            let scene = scene(json);
            let slightly = CameraMove { fov: 1.0 + 1e-12, ..CameraMove::default() };
            let by = Correction { camera: slightly, ..none(&scene) };
            let corrected = scene.corrected(&mesh, 64, &by);
            assert!(matches!(corrected.camera, Camera::LookAt(_)));
            assert_eq!(covered(&mesh, &scene), covered(&mesh, &corrected), "{json}");
            assert_eq!(scene.corrected(&mesh, 64, &none(&scene)).camera, scene.camera);
        }
    }

    #[test]
    fn lamp_is_seen_from_the_eye() {
        // Centred at the origin.
        let mesh = Mesh::builtin(BuiltinMesh::Sphere);
        let seen = |position: [f64; 3]| {
            let scene = scene(&format!(
                r#"{{"camera": {{"orbit_deg": [90, 0]}}, "rotation_deg": [10, 20, 30],
                    "lights": [{{"kind": "point", "position": {position:?}}}]}}"#
            ));
            scene.lamp_from_eye_deg(&mesh, &LightAssets::default()).unwrap()
        };
        // The eye is at +x, so -z is to the right.
        for (position, wanted) in [
            ([4.0, 0.0, 0.0], [0.0, 0.0]),
            ([0.0, 0.0, -4.0], [90.0, 0.0]),
            ([4.0, 4.0, 0.0], [0.0, 45.0]),
        ] {
            let found = seen(position);
            let off = (0..2).map(|k| (found[k] - wanted[k]).abs()).fold(0.0, f64::max);
            assert!(off < 1e-9, "{position:?} {found:?}");
        }
    }

    #[test]
    fn camera_moves_as_described() {
        let mesh = Mesh::builtin(BuiltinMesh::Sphere);
        let scene = scene(r#"{"camera": {"eye": [0, 0, 6], "fov_y_deg": 30}}"#);
        let seen = |camera: CameraMove| {
            covered(&mesh, &scene.corrected(&mesh, 64, &Correction { camera, ..none(&scene) }))
        };
        let before = seen(CameraMove::default());
        let still = CameraMove::default();
        // Aimed to the right and upwards, the sphere moves to the left and down.
        let right = seen(CameraMove { aim_deg: [2.0, 0.0, 0.0], ..still });
        assert!(right[0] < before[0] - 3.0 && (right[1] - before[1]).abs() < 0.1, "{right:?}");
        let up = seen(CameraMove { aim_deg: [0.0, 2.0, 0.0], ..still });
        assert!(up[1] > before[1] + 3.0 && (up[0] - before[0]).abs() < 0.1, "{up:?}");
        // Farther, or with a wider view, it is smaller.
        assert!(seen(CameraMove { distance: 1.1, ..still })[2] < 0.9 * before[2]);
        assert!(seen(CameraMove { fov: 1.1, ..still })[2] < 0.9 * before[2]);
        // About the centre, it stays in place.
        let turned = seen(CameraMove { turn_deg: [5.0, 3.0], ..still });
        assert!((turned[0] - before[0]).abs() < 0.1 && (turned[2] / before[2] - 1.0).abs() < 0.01);
        let by = CameraMove { turn_deg: [90.0, 0.0], ..still };
        let corrected = scene.corrected(&mesh, 64, &Correction { camera: by, ..none(&scene) });
        let Camera::LookAt(LookAtCamera { eye, .. }) = corrected.camera else { panic!() };
        assert!((DVec3::from(eye) - DVec3::new(6.0, 0.0, 0.0)).length() < 1e-9, "{eye:?}");
    }
}
