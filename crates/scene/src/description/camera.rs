//! Camera of a scene, in three forms distinguished by their fields.

use std::borrow::Cow;

use brood_mesh::angle::orbit_direction;
use glam::DVec3;
use serde::{Deserialize, Deserializer, Serialize};
use utoipa::openapi::{OneOfBuilder, RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};

const FOV_Y_DEG: f64 = 30.0;
const ORBIT_DEG: [f64; 2] = [30.0, 20.0];
const TARGET: [f64; 3] = [0.0; 3];
const UP: [f64; 3] = [0.0, 1.0, 0.0];

/// Where the scene is seen from; the fields tell the form. y is up, pixels are square.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged, try_from = "Fields")]
pub enum Camera {
    /// Position on a sphere about the centre of the mesh.
    Orbit(OrbitCamera),
    /// Position and target.
    LookAt(LookAtCamera),
    /// Parallel rays.
    Orthographic(OrthographicCamera),
}

/// Position on a sphere about the centre of the mesh, looking at the centre.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct OrbitCamera {
    /// Azimuth (0 is +z, 90 is +x) and elevation above the horizontal plane, degrees.
    #[schema(value_type = Option<[f64; 2]>, default = json!(ORBIT_DEG))]
    pub orbit_deg: [f64; 2],
    /// Distance from the centre. Default: frames the bounding sphere at scale 1, and other objects
    /// of the scene, with a small margin, within the shorter side of the picture.
    pub distance: Option<f64>,
    /// Vertical field of view, degrees. The horizontal one follows from the picture's size.
    #[schema(value_type = Option<f64>, default = json!(FOV_Y_DEG))]
    pub fov_y_deg: f64,
}

/// Position and target.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LookAtCamera {
    /// Position of the eye.
    pub eye: [f64; 3],
    /// Point in the middle of the picture.
    #[schema(value_type = Option<[f64; 3]>, default = json!(TARGET))]
    pub target: [f64; 3],
    /// Up direction of the picture, of any length.
    #[schema(value_type = Option<[f64; 3]>, default = json!(UP))]
    pub up: [f64; 3],
    /// Vertical field of view, degrees. The horizontal one follows from the picture's size.
    #[schema(value_type = Option<f64>, default = json!(FOV_Y_DEG))]
    pub fov_y_deg: f64,
}

/// Parallel rays along -z with the world's origin in the middle of the picture.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct OrthographicCamera {
    /// Half the height of the picture, in world units.
    pub orthographic: f64,
}

impl Camera {
    /// Unit vector along the view, in the middle of the picture.
    #[must_use]
    pub fn direction(&self) -> [f64; 3] {
        let along = match self {
            Self::Orbit(OrbitCamera { orbit_deg: [azimuth, elevation], .. }) => {
                -orbit_direction(*azimuth, *elevation)
            }
            Self::LookAt(LookAtCamera { eye, target, .. }) => {
                (DVec3::from(*target) - DVec3::from(*eye)).normalize()
            }
            Self::Orthographic(_) => DVec3::NEG_Z,
        };
        along.to_array()
    }
}

impl PartialSchema for Camera {
    fn schema() -> RefOr<Schema> {
        let items = OneOfBuilder::new()
            .description(Some("Where the scene is seen from; the fields tell the form."))
            .item(OrbitCamera::schema())
            .item(LookAtCamera::schema())
            .item(OrthographicCamera::schema());
        RefOr::T(Schema::OneOf(items.build()))
    }
}

impl ToSchema for Camera {
    fn name() -> Cow<'static, str> {
        Cow::Borrowed("Camera")
    }
}

impl Default for Camera {
    fn default() -> Self {
        Self::Orbit(OrbitCamera { orbit_deg: ORBIT_DEG, distance: None, fov_y_deg: FOV_Y_DEG })
    }
}

/// Fields of all three forms, for reading.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields, rename = "Camera", expecting = "a camera object")]
struct Fields {
    orbit_deg: Option<[f64; 2]>,
    distance: Option<f64>,
    #[serde(default, deserialize_with = "present")]
    eye: Option<[f64; 3]>,
    target: Option<[f64; 3]>,
    up: Option<[f64; 3]>,
    fov_y_deg: Option<f64>,
    #[serde(default, deserialize_with = "present")]
    orthographic: Option<f64>,
}

/// Reads a field that is not null: these two choose the form.
fn present<'de, D: Deserializer<'de>, T: Deserialize<'de>>(from: D) -> Result<Option<T>, D::Error> {
    T::deserialize(from).map(Some)
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
            0 => Ok(Self::Orbit(OrbitCamera {
                orbit_deg: fields.orbit_deg.unwrap_or(ORBIT_DEG),
                distance: fields.distance,
                fov_y_deg,
            })),
            1 => Ok(Self::LookAt(LookAtCamera {
                eye: fields.eye.ok_or("a camera with target or up needs eye")?,
                target: fields.target.unwrap_or(TARGET),
                up: fields.up.unwrap_or(UP),
                fov_y_deg,
            })),
            _ if fields.fov_y_deg.is_some() => {
                Err("an orthographic camera has no fov_y_deg".to_owned())
            }
            _ => Ok(Self::Orthographic(OrthographicCamera {
                orthographic: fields.orthographic.expect("this form was chosen by the field"),
            })),
        }
    }
}
