//! Cases rendered by both programs: a material on an object under one light.
//!
//! Owns objects, cameras and lights. Scenes are in brood's format; the peer's script translates
//! them.

use std::path::PathBuf;

use serde_json::{Value, json};

use super::material;

/// Samples per pixel of the pictures rendered in this run.
const SAMPLES: u32 = 256;

/// One picture to render with either program.
pub struct Case {
    /// Name of the object.
    pub object: &'static str,
    /// Name of the light.
    pub light: &'static str,
    /// Name of the material.
    pub material_name: String,
    /// brood's material.
    pub material: Material,
    /// The peer's plugin and its properties.
    pub bsdf: Value,
    /// brood's scene.
    pub scene: Value,
    /// The peer's materials of the other objects, spheres, then that of the ground.
    pub others: Vec<Value>,
    /// Variant of the mesh; `None` for a sphere.
    pub mesh: Option<&'static str>,
    /// Side of the picture in pixels.
    pub size_px: u32,
    /// Samples per pixel of brood's picture.
    pub samples: u32,
    /// Samples per pixel of the peer's pictures.
    pub peer_samples: u32,
    /// Sampler of the peer.
    pub peer_sampler: &'static str,
    /// Earlier picture of the peer that brood is compared with; new pictures of the peer then only
    /// measure its noise.
    pub recorded: Option<PathBuf>,
}

/// Material of brood's picture.
pub enum Material {
    /// Name and parameters of a model.
    Model(&'static str),
    /// File of a measured material.
    Measured(PathBuf),
}

impl Case {
    /// Name for people.
    pub fn name(&self) -> String {
        let suffix = if self.recorded.is_some() { ", recorded" } else { "" };
        format!("{}, {} light, {}{suffix}", self.object, self.light, self.material_name)
    }

    /// Name for files.
    pub fn file_name(&self) -> String {
        self.name().replace(", ", "-").replace(' ', "-").to_lowercase()
    }
}

/// Object with its camera and lights.
struct Object {
    name: &'static str,
    mesh: Option<&'static str>,
    size_px: u32,
    camera: fn() -> Value,
    /// Two lights, used one at a time.
    lights: fn() -> [(&'static str, Value); 2],
}

const OBJECTS: [Object; 4] = [
    Object {
        name: "sphere",
        mesh: None,
        size_px: 128,
        camera: sphere_camera,
        lights: sphere_lights,
    },
    // Flat facets: normals equal those of the triangles.
    Object {
        name: "spot in facets",
        mesh: Some("facets"),
        size_px: 192,
        camera: spot_camera,
        lights: spot_lights,
    },
    // Smooth normals on a finely subdivided surface, so they nearly equal the true normals.
    Object {
        name: "spot refined",
        mesh: Some("refined"),
        size_px: 192,
        camera: spot_camera,
        lights: spot_lights,
    },
    // Smooth normals on large triangles.
    Object {
        name: "spot",
        mesh: Some("smooth"),
        size_px: 192,
        camera: spot_camera,
        lights: spot_lights,
    },
];

/// Every material on every object under every light.
pub fn fresh(with_meshes: bool) -> Vec<Case> {
    let mut cases = Vec::new();
    for object in OBJECTS.iter().filter(|object| with_meshes || object.mesh.is_none()) {
        for (light, light_json) in (object.lights)() {
            let scene = scene((object.camera)(), light_json);
            cases.extend(material::all().into_iter().map(|pair| Case {
                object: object.name,
                light,
                material_name: pair.name.to_owned(),
                material: Material::Model(pair.model),
                bsdf: pair.bsdf,
                scene: scene.clone(),
                others: Vec::new(),
                mesh: object.mesh,
                size_px: object.size_px,
                samples: SAMPLES,
                peer_samples: SAMPLES,
                peer_sampler: "independent",
                recorded: None,
            }));
        }
    }
    for (light, light_json) in others_lights() {
        cases.extend(
            [material::lambert(), material::gold()].map(|pair| among(light, &light_json, pair)),
        );
    }
    cases
}

/// Name of the file with the material of the second object.
pub const SECOND: &str = "second.brood";

/// Sphere of a material between two others, above the ground, all in each other's shadow. One of
/// the others has the material of [`SECOND`], the rest is grey.
fn among(light: &'static str, light_json: &Value, pair: material::Pair) -> Case {
    let camera = json!({"eye": [2.5, 2.2, 4.5], "target": [0.2, -0.3, 0.0], "fov_y_deg": 40.0});
    let mut scene = scene(camera, light_json.clone());
    scene["objects"] = json!([
        {"mesh": "sphere", "position": [1.3, -0.55, 0.9], "scale": 0.5},
        {"mesh": "sphere", "position": [-1.4, -0.35, -0.5], "scale": 0.7, "material": SECOND},
    ]);
    scene["ground"] = json!({"height": -1.05});
    let grey = json!({"type": "diffuse", "reflectance": [0.5, 0.5, 0.5]});
    Case {
        object: "three spheres",
        light,
        material_name: pair.name.to_owned(),
        material: Material::Model(pair.model),
        bsdf: pair.bsdf,
        scene,
        others: vec![grey.clone(), second().bsdf, grey],
        mesh: None,
        size_px: 192,
        samples: SAMPLES,
        peer_samples: SAMPLES,
        peer_sampler: "independent",
        recorded: None,
    }
}

/// Material of the second object.
pub fn second() -> material::Pair {
    material::rough_plastic()
}

fn others_lights() -> [(&'static str, Value); 2] {
    let near = json!({"kind": "point", "position": [3.0, 4.0, 2.5], "intensity": 90.0});
    [("directional", distant([-1.0, -1.6, -0.7])), ("point", near)]
}

/// Scene with shadows, which the peer always has, and with the peer's treatment of normals.
pub fn scene(camera: Value, light: Value) -> Value {
    json!({"camera": camera, "lights": [light], "shadows": true, "normals": "plain"})
}

/// Orthographic camera that shows a unit sphere with a margin.
pub fn sphere_camera() -> Value {
    json!({"orthographic": 1.05})
}

fn sphere_lights() -> [(&'static str, Value); 2] {
    let side = std::f64::consts::SQRT_2;
    let near = json!({
        "kind": "point", "position": [2.0, 2.0, 2.0 * side], "intensity": 16.0 * std::f64::consts::PI,
    });
    [("directional", distant([-1.0, -1.0, -side])), ("point", near)]
}

/// Light of irradiance pi along a direction.
pub fn distant(direction: [f64; 3]) -> Value {
    json!({"kind": "directional", "direction": direction, "irradiance_w_m2": std::f64::consts::PI})
}

/// Camera in front of and above the face.
pub fn spot_camera() -> Value {
    json!({
        "eye": [-2.04846, 1.24647, -3.22406],
        "target": [0.0, 0.108_429_998_159_408_57, 0.190_050_005_912_780_76],
        "fov_y_deg": 40.0,
    })
}

/// Light above the camera; the head's shadow falls on the body.
pub fn spot_lamp() -> Value {
    json!({"kind": "point", "position": [-2.58809, 3.99057, -2.39804], "intensity": 89.433})
}

fn spot_lights() -> [(&'static str, Value); 2] {
    [("directional", distant([2.58809, -3.88214, 2.58809])), ("point", spot_lamp())]
}

#[cfg(test)]
mod tests {
    use super::fresh;
    use std::collections::BTreeSet;

    #[test]
    fn case_file_names_are_unique() {
        let cases = fresh(true);
        let names: BTreeSet<String> = cases.iter().map(super::Case::file_name).collect();
        assert_eq!(names.len(), cases.len());
        for object in ["sphere", "spot-in-facets", "spot-refined", "spot"] {
            let name = format!("{object}-point-light-ward-anisotropic");
            assert!(names.contains(&name), "{name}: {names:?}");
        }
    }

    #[test]
    fn only_spheres_are_rendered_without_meshes() {
        assert!(fresh(false).iter().all(|case| case.mesh.is_none()));
        assert!(!fresh(false).is_empty());
    }
}
