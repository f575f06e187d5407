//! The lights of a scene.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A light. In JSON an object with a `kind`.
#[derive(Debug, Clone, PartialEq)]
pub enum Light {
    /// Shines from a point in all directions; irradiance falls with the square of the distance.
    Point {
        /// Position in the world; `None` places it to the right of and above the default camera, four radii of the
        /// mesh's bounding sphere from its centre.
        position: Option<[f64; 3]>,
        /// Radiant intensity per channel; `None` is the one that gives irradiance pi at the centre of the mesh.
        intensity: Option<[f64; 3]>,
    },
}

impl Default for Light {
    fn default() -> Self {
        Self::Point { position: None, intensity: None }
    }
}

#[derive(Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Kind {
    #[default]
    Point,
}

/// The fields of a light in JSON; in formats without field names the same in this order.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "Light", expecting = "a light object")]
struct Fields {
    #[serde(default)]
    kind: Kind,
    #[serde(default)]
    position: Option<[f64; 3]>,
    #[serde(default)]
    intensity: Option<[f64; 3]>,
}

impl Serialize for Light {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match *self {
            Self::Point { position, intensity } => {
                Fields { kind: Kind::Point, position, intensity }.serialize(serializer)
            }
        }
    }
}

impl<'de> Deserialize<'de> for Light {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Fields { kind, position, intensity } = Fields::deserialize(deserializer)?;
        Ok(match kind {
            Kind::Point => Self::Point { position, intensity },
        })
    }
}
