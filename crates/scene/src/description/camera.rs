//! Camera of a scene, in three forms distinguished by their fields.

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

const FOV_Y_DEG: f64 = 30.0;
const ORBIT_DEG: [f64; 2] = [30.0, 20.0];

/// Camera. Pictures are square with y up.
#[derive(Debug, Clone, PartialEq)]
pub enum Camera {
    /// Position on a sphere about the centre of the mesh, looking at the centre.
    Orbit {
        /// Azimuth (0 is +z, 90 is +x) and elevation above the horizontal plane, degrees.
        orbit_deg: [f64; 2],
        /// Distance from the centre; `None` frames the bounding sphere at scale 1 with a small
        /// margin.
        distance: Option<f64>,
        /// Vertical field of view, degrees.
        fov_y_deg: f64,
    },
    /// Position and target.
    LookAt {
        /// Position of the eye.
        eye: [f64; 3],
        /// Point in the middle of the picture.
        target: [f64; 3],
        /// Up direction of the picture, of any length.
        up: [f64; 3],
        /// Vertical field of view, degrees.
        fov_y_deg: f64,
    },
    /// Parallel rays along -z with the world's origin in the middle of the picture.
    Orthographic {
        /// Half the height of the view, in world units.
        orthographic: f64,
    },
}

impl Default for Camera {
    fn default() -> Self {
        Self::Orbit { orbit_deg: ORBIT_DEG, distance: None, fov_y_deg: FOV_Y_DEG }
    }
}

/// Fields of all three forms, for reading.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields, rename = "Camera", expecting = "a camera object")]
struct Fields {
    orbit_deg: Option<[f64; 2]>,
    distance: Option<f64>,
    eye: Option<[f64; 3]>,
    target: Option<[f64; 3]>,
    up: Option<[f64; 3]>,
    fov_y_deg: Option<f64>,
    orthographic: Option<f64>,
}

impl TryFrom<Fields> for Camera {
    type Error = String;

    fn try_from(fields: Fields) -> Result<Self, String> {
        let given = [
            ("orbit_deg", fields.orbit_deg.is_some(), 0),
            ("distance", fields.distance.is_some(), 0),
            ("eye", fields.eye.is_some(), 1),
            ("target", fields.target.is_some(), 1),
            ("up", fields.up.is_some(), 1),
            ("orthographic", fields.orthographic.is_some(), 2),
        ];
        let mut forms = given.into_iter().filter(|field| field.1);
        let first = forms.next();
        if let Some(first) = first
            && let Some(other) = forms.find(|field| field.2 != first.2)
        {
            return Err(format!(
                "a camera has either orbit_deg and distance, or eye, target and up, or orthographic, \
                 not both {} and {}",
                first.0, other.0
            ));
        }
        let fov_y_deg = fields.fov_y_deg.unwrap_or(FOV_Y_DEG);
        match first.map_or(0, |field| field.2) {
            0 => Ok(Self::Orbit {
                orbit_deg: fields.orbit_deg.unwrap_or(ORBIT_DEG),
                distance: fields.distance,
                fov_y_deg,
            }),
            1 => Ok(Self::LookAt {
                eye: fields.eye.ok_or("a camera with target or up needs eye")?,
                target: fields.target.unwrap_or([0.0; 3]),
                up: fields.up.unwrap_or([0.0, 1.0, 0.0]),
                fov_y_deg,
            }),
            _ if fields.fov_y_deg.is_some() => {
                Err("an orthographic camera has no fov_y_deg".to_owned())
            }
            _ => Ok(Self::Orthographic {
                orthographic: fields.orthographic.expect("this form was chosen by the field"),
            }),
        }
    }
}

/// Camera in formats without field names.
#[derive(Serialize, Deserialize)]
enum Tagged {
    Orbit([f64; 2], Option<f64>, f64),
    LookAt([f64; 3], [f64; 3], [f64; 3], f64),
    Orthographic(f64),
}

/// Camera in JSON: the fields of its form.
#[derive(Serialize)]
#[serde(untagged)]
enum Untagged {
    Orbit { orbit_deg: [f64; 2], distance: Option<f64>, fov_y_deg: f64 },
    LookAt { eye: [f64; 3], target: [f64; 3], up: [f64; 3], fov_y_deg: f64 },
    Orthographic { orthographic: f64 },
}

impl Serialize for Camera {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let named = serializer.is_human_readable();
        match *self {
            Self::Orbit { orbit_deg, distance, fov_y_deg } if named => {
                Untagged::Orbit { orbit_deg, distance, fov_y_deg }.serialize(serializer)
            }
            Self::LookAt { eye, target, up, fov_y_deg } if named => {
                Untagged::LookAt { eye, target, up, fov_y_deg }.serialize(serializer)
            }
            Self::Orthographic { orthographic } if named => {
                Untagged::Orthographic { orthographic }.serialize(serializer)
            }
            Self::Orbit { orbit_deg, distance, fov_y_deg } => {
                Tagged::Orbit(orbit_deg, distance, fov_y_deg).serialize(serializer)
            }
            Self::LookAt { eye, target, up, fov_y_deg } => {
                Tagged::LookAt(eye, target, up, fov_y_deg).serialize(serializer)
            }
            Self::Orthographic { orthographic } => {
                Tagged::Orthographic(orthographic).serialize(serializer)
            }
        }
    }
}

impl<'de> Deserialize<'de> for Camera {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        if deserializer.is_human_readable() {
            return Self::try_from(Fields::deserialize(deserializer)?).map_err(D::Error::custom);
        }
        Ok(match Tagged::deserialize(deserializer)? {
            Tagged::Orbit(orbit_deg, distance, fov_y_deg) => {
                Self::Orbit { orbit_deg, distance, fov_y_deg }
            }
            Tagged::LookAt(eye, target, up, fov_y_deg) => {
                Self::LookAt { eye, target, up, fov_y_deg }
            }
            Tagged::Orthographic(orthographic) => Self::Orthographic { orthographic },
        })
    }
}
