//! Objects with their cameras and lights, and the ways in which they are photographed.

use serde_json::{Value, json};

/// Noise of the codes of 8 bits, as a share of the largest.
const NOISE: f64 = 2.0 / 255.0;
/// Share of the pixels with dust in [`Grade::Dusty`].
const DUST: f64 = 0.01;
/// Most parts of a path of light in [`Grade::Interreflected`]: up to five reflections.
const MAX_DEPTH: u32 = 6;
/// Errors of the stated scene in [`Grade::Misaligned`]: light and camera are turned about the
/// object by these angles in degrees, and the field of view is larger by this share.
const LIGHT_OFF_DEG: f64 = 2.0;
const CAMERA_OFF_DEG: f64 = 0.7;
const VIEW_OFF: f64 = 0.01;

/// Way in which pictures are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Grade {
    /// Linear, without noise, and the scene is as stated.
    Exact,
    /// Codes of 8 bits with noise.
    Codes,
    /// The same with dust and scratches.
    Dusty,
    /// Codes with noise, and light and camera differ from those stated.
    Misaligned,
    /// Linear and as stated, in an environment instead of under a point light.
    Environment,
    /// Linear and as stated, with light that parts of the object send to each other.
    Interreflected,
}

impl Grade {
    pub const ALL: [Self; 6] = [
        Self::Exact,
        Self::Codes,
        Self::Dusty,
        Self::Misaligned,
        Self::Environment,
        Self::Interreflected,
    ];

    /// File of the light, beside the pictures; `None` for a point light.
    pub fn light_file(self) -> Option<&'static str> {
        (self == Self::Environment).then_some("environment.hdr")
    }

    /// Name in tables and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Codes => "codes",
            Self::Dusty => "dusty",
            Self::Misaligned => "misaligned",
            Self::Environment => "environment",
            Self::Interreflected => "interreflected",
        }
    }
}

/// Object that has the material.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Object {
    Sphere,
    /// Mesh with smooth normals, finely subdivided.
    Spot,
    /// The same, of which no photograph is taken.
    Teapot,
}

/// Picture that a fit does not see.
#[derive(Debug, Clone)]
pub struct Test {
    /// Name of its files.
    pub name: String,
    pub object: Object,
    pub scene: Value,
    /// True if the object is another than that of the photographs.
    pub is_unseen_mesh: bool,
}

/// Lights of pictures, then those of tests: right, up and towards the camera from the object.
const LIGHTS: [[f64; 3]; 8] = [
    [-2.0, 3.0, 4.0],
    [3.5, 1.0, 2.5],
    [0.5, -2.0, 4.5],
    [-3.5, 0.5, 1.5],
    [1.0, 4.0, 1.0],
    [2.5, 2.0, 4.0],
    [-4.0, -1.5, 2.0],
    [0.3, 0.6, 5.0],
];
const TESTS: [[f64; 3]; 3] = [[2.8, 3.2, 2.2], [-1.0, 0.4, 4.8], [-4.2, 1.8, 0.6]];
/// Intensity of a light, in W/sr.
const INTENSITY: f64 = 80.0;
/// Rotation of the environment in the first picture, which is none for Mitsuba, and from one
/// picture to the next, in degrees.
const ROTATION_DEG: [f64; 2] = [180.0, 100.0];

impl Object {
    /// Those that are photographed.
    pub const ALL: [Self; 2] = [Self::Sphere, Self::Spot];

    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sphere => "sphere",
            Self::Spot => "spot",
            Self::Teapot => "teapot",
        }
    }

    /// File of the mesh; `None` for the built-in sphere.
    pub fn mesh(self) -> Option<&'static str> {
        match self {
            Self::Sphere => None,
            Self::Spot => Some("refined.obj"),
            Self::Teapot => Some("other.obj"),
        }
    }

    /// Camera: eye, target and vertical field of view in degrees.
    fn camera(self) -> ([f64; 3], [f64; 3], f64) {
        match self {
            Self::Sphere => ([0.0, 0.6, 4.96], [0.0; 3], 26.0),
            Self::Spot => (
                [-2.05, 1.25, -3.22],
                [0.0, 0.108_429_998_159_408_57, 0.190_050_005_912_780_76],
                30.0,
            ),
            Self::Teapot => ([1.6, 1.5, 4.2], [0.0; 3], 26.0),
        }
    }

    /// Scene with a light of these coordinates, light and camera turned by angles in degrees, and
    /// with the field of view enlarged by a share.
    fn scene(self, light: [f64; 3], (light_deg, camera_deg, view): (f64, f64, f64)) -> Value {
        let (eye, target, fov) = self.camera();
        let back = unit(subtract(eye, target));
        let right = unit(cross([0.0, 1.0, 0.0], back));
        let up = cross(back, right);
        let along = |k: usize| light[0] * right[k] + light[1] * up[k] + light[2] * back[k];
        let lamp = turned([along(0), along(1), along(2)], light_deg);
        let position = [0, 1, 2].map(|k| target[k] + lamp[k]);
        let seen = turned(subtract(eye, target), camera_deg);
        let eye = [0, 1, 2].map(|k| target[k] + seen[k]);
        json!({
            "camera": {"eye": eye, "target": target, "fov_y_deg": fov * (1.0 + view)},
            "lights": [{"kind": "point", "position": position, "intensity": INTENSITY}],
            "shadows": true, "normals": "plain",
        })
    }

    /// Picture of a number as it is taken, and as the target states it.
    pub fn picture(self, number: usize, grade: Grade) -> Value {
        let light = LIGHTS[number];
        let right = (0.0, 0.0, 0.0);
        let taken = match grade {
            Grade::Exact
            | Grade::Codes
            | Grade::Dusty
            | Grade::Environment
            | Grade::Interreflected => right,
            Grade::Misaligned => (LIGHT_OFF_DEG, CAMERA_OFF_DEG, VIEW_OFF),
        };
        let has_noise = !matches!(grade, Grade::Exact | Grade::Environment | Grade::Interreflected);
        let (mut stated, mut taken) = (self.scene(light, right), self.scene(light, taken));
        if let Some(file) = grade.light_file() {
            let rotation_deg = ROTATION_DEG[0] + ROTATION_DEG[1] * number as f64;
            let light = json!({"kind": "environment", "image": file, "rotation_deg": rotation_deg});
            (stated["lights"], taken["lights"]) = (json!([light]), json!([light]));
        }
        json!({
            "stated": stated, "taken": taken,
            "noise": has_noise.then_some(NOISE), "seed": number,
            "dust": (grade == Grade::Dusty).then_some(DUST),
            "max_depth": if grade == Grade::Interreflected { MAX_DEPTH } else { 2 },
            "refine": (grade == Grade::Misaligned).then(refine),
        })
    }

    /// Errors of a corrected scene in degrees: of the light's direction as the camera sees it, and
    /// of the camera's direction from the object. `None` for the camera before a sphere, which
    /// looks the same from everywhere.
    pub fn scene_error(self, corrected: &Value, number: usize) -> Option<(f64, Option<f64>)> {
        let (_, centre, _) = self.camera();
        let taken = self.picture(number, Grade::Misaligned)["taken"].clone();
        let relative = |value: &Value| Some(subtract(vector(value)?, centre));
        let seen = |scene: &Value| {
            let camera = &scene["camera"];
            let (eye, target) = (relative(&camera["eye"])?, relative(&camera["target"])?);
            let up = vector(&camera["up"]).unwrap_or([0.0, 1.0, 0.0]);
            let back = unit(subtract(eye, target));
            let right = unit(cross(up, back));
            let lamp = relative(&scene["lights"][0]["position"])?;
            Some((eye, [right, cross(back, right), back].map(|axis| dot(axis, lamp))))
        };
        let ((found_eye, found), (eye, lamp)) = (seen(corrected)?, seen(&taken)?);
        Some((angle_deg(found, lamp), self.mesh().map(|_| angle_deg(found_eye, eye))))
    }

    /// The object in lights that no picture shows, and another object if there are meshes.
    pub fn tests(self, has_meshes: bool) -> Vec<Test> {
        let test = |name: String, object: Self, light| Test {
            name,
            object,
            scene: object.scene(light, (0.0, 0.0, 0.0)),
            is_unseen_mesh: object != self,
        };
        let lights = TESTS.iter().enumerate();
        let mut tests: Vec<Test> =
            lights.map(|(k, light)| test(format!("test-{}", k + 1), self, *light)).collect();
        if has_meshes {
            tests.push(test("mesh".to_owned(), Self::Teapot, TESTS[0]));
        }
        tests
    }
}

/// Uncertainties that targets state in [`Grade::Misaligned`].
fn refine() -> Value {
    json!({"light_deg": LIGHT_OFF_DEG, "camera_deg": 1.0, "fov": VIEW_OFF})
}

fn vector(value: &Value) -> Option<[f64; 3]> {
    Some([value[0].as_f64()?, value[1].as_f64()?, value[2].as_f64()?])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn angle_deg(a: [f64; 3], b: [f64; 3]) -> f64 {
    dot(unit(a), unit(b)).clamp(-1.0, 1.0).acos().to_degrees()
}

/// Turns about the vertical axis, by an angle in degrees.
fn turned(v: [f64; 3], angle_deg: f64) -> [f64; 3] {
    let (sin, cos) = angle_deg.to_radians().sin_cos();
    [cos * v[0] + sin * v[2], v[1], cos * v[2] - sin * v[0]]
}

fn subtract(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3])
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.map(|x| x / length)
}
