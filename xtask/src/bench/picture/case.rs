//! What is rendered by both programs: a material on an object in the light of one lamp.
//!
//! Owns objects, cameras and lights. Scenes are brood's; the peer's script puts them into the peer's words.

use std::path::PathBuf;

use serde_json::{Value, json};

use super::material;

/// Samples a pixel of all pictures that are held against each other anew.
const SAMPLES: u32 = 256;

/// One picture of either program.
pub struct Case {
    /// What is seen.
    pub object: &'static str,
    /// What it is lit by.
    pub light: &'static str,
    /// What the material is called.
    pub material_name: String,
    /// brood's material.
    pub material: Material,
    /// The peer's plugin and its properties.
    pub bsdf: Value,
    /// brood's scene.
    pub scene: Value,
    /// Which form of the mesh; none is a sphere.
    pub mesh: Option<&'static str>,
    /// Side of the picture.
    pub size_px: u32,
    /// Samples a pixel of brood's picture.
    pub samples: u32,
    /// Samples a pixel of the peer's pictures.
    pub peer_samples: u32,
    /// How the peer chooses them.
    pub peer_sampler: &'static str,
    /// A picture that the peer made earlier: it is what brood is held against, and pictures made anew only tell the noise.
    pub recorded: Option<PathBuf>,
}

/// What brood renders with.
pub enum Material {
    /// The name of a model, and its parameters.
    Model(&'static str),
    /// A file of what was measured.
    Measured(PathBuf),
}

impl Case {
    /// In words.
    pub fn name(&self) -> String {
        let when = if self.recorded.is_some() { ", recorded" } else { "" };
        format!("{}, {} light, {}{when}", self.object, self.light, self.material_name)
    }

    /// The same for files.
    pub fn file_name(&self) -> String {
        self.name().replace(", ", "-").replace(' ', "-").to_lowercase()
    }
}

/// An object and how it is seen.
struct Object {
    name: &'static str,
    mesh: Option<&'static str>,
    size_px: u32,
    camera: fn() -> Value,
    /// One light each.
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
    // Flat: what normals tell of is what is there.
    Object {
        name: "spot in facets",
        mesh: Some("facets"),
        size_px: 192,
        camera: spot_camera,
        lights: spot_lights,
    },
    // Round: nearly so.
    Object {
        name: "spot refined",
        mesh: Some("refined"),
        size_px: 192,
        camera: spot_camera,
        lights: spot_lights,
    },
    // Round normals on large triangles.
    Object {
        name: "spot",
        mesh: Some("smooth"),
        size_px: 192,
        camera: spot_camera,
        lights: spot_lights,
    },
];

/// Every material on every object in every light.
pub fn fresh(with_meshes: bool) -> Vec<Case> {
    let mut cases = Vec::new();
    for object in OBJECTS.iter().filter(|object| with_meshes || object.mesh.is_none()) {
        for (light, lamp) in (object.lights)() {
            let scene = scene((object.camera)(), lamp);
            cases.extend(material::all().into_iter().map(|pair| Case {
                object: object.name,
                light,
                material_name: pair.name.to_owned(),
                material: Material::Model(pair.model),
                bsdf: pair.bsdf,
                scene: scene.clone(),
                mesh: object.mesh,
                size_px: object.size_px,
                samples: SAMPLES,
                peer_samples: SAMPLES,
                peer_sampler: "independent",
                recorded: None,
            }));
        }
    }
    cases
}

/// With shadows, which the peer always has, and with normals taken as the peer takes them.
pub fn scene(camera: Value, light: Value) -> Value {
    json!({"camera": camera, "lights": [light], "shadows": true, "normals": "plain"})
}

/// All of a unit sphere and a little more.
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

/// From before and above, at the face.
pub fn spot_camera() -> Value {
    json!({
        "eye": [-2.04846, 1.24647, -3.22406],
        "target": [0.0, 0.108_429_998_159_408_57, 0.190_050_005_912_780_76],
        "fov_y_deg": 40.0,
    })
}

/// Above the camera: the head's shadow falls on the body.
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
    fn cases_have_names_of_their_own() {
        let cases = fresh(true);
        let names: BTreeSet<String> = cases.iter().map(super::Case::file_name).collect();
        assert_eq!(names.len(), cases.len());
        for object in ["sphere", "spot-in-facets", "spot-refined", "spot"] {
            let name = format!("{object}-point-light-ward-anisotropic");
            assert!(names.contains(&name), "{name}: {names:?}");
        }
    }

    #[test]
    fn only_the_sphere_is_left_when_there_are_no_meshes() {
        assert!(fresh(false).iter().all(|case| case.object == "sphere"));
        assert!(!fresh(false).is_empty());
    }
}
