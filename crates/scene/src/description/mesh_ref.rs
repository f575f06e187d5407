//! Reference to the mesh of a scene: built-in by name, or uploaded by id.

use std::borrow::Cow;
use std::fmt;

use brood_light::FieldError;
use brood_light::field::require;
use brood_mesh::BuiltinMesh;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use utoipa::openapi::schema::{SchemaType, Type};
use utoipa::openapi::{ObjectBuilder, RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};

/// Longest mesh id, in bytes.
const ID_BYTES_MAX: usize = 128;
/// Largest scale of a mesh.
pub(super) const SCALE_MAX: f64 = 1000.0;

/// Mesh by name. In JSON a string: the name of a built-in mesh, otherwise the id of an uploaded
/// one.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum MeshRef {
    /// Built-in mesh.
    Builtin(BuiltinMesh),
    /// Id of an uploaded mesh.
    Uploaded(String),
}

impl MeshRef {
    pub(super) fn validate(&self, pointer: &str) -> Result<(), FieldError> {
        let Self::Uploaded(id) = self else { return Ok(()) };
        require(!id.is_empty(), pointer, "the id of the mesh is empty")?;
        require(id.len() <= ID_BYTES_MAX, pointer, "the id of the mesh is over 128 bytes")
    }
}

impl Default for MeshRef {
    fn default() -> Self {
        Self::Builtin(BuiltinMesh::Sphere)
    }
}

impl From<&str> for MeshRef {
    fn from(name: &str) -> Self {
        match BuiltinMesh::from_name(name) {
            Some(mesh) => Self::Builtin(mesh),
            None => Self::Uploaded(name.to_owned()),
        }
    }
}

impl fmt::Display for MeshRef {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Builtin(mesh) => mesh.name(),
            Self::Uploaded(id) => id,
        })
    }
}

impl Serialize for MeshRef {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for MeshRef {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(Self::from(String::deserialize(deserializer)?.as_str()))
    }
}

impl PartialSchema for MeshRef {
    fn schema() -> RefOr<Schema> {
        let text =
            "\"ball\", \"sphere\", \"torus\", \"cube\", \"knob\" or the id of an uploaded mesh";
        let object = ObjectBuilder::new()
            .schema_type(SchemaType::new(Type::String))
            .min_length(Some(1))
            .max_length(Some(ID_BYTES_MAX))
            .description(Some(text))
            .build();
        RefOr::T(Schema::Object(object))
    }
}

impl ToSchema for MeshRef {
    fn name() -> Cow<'static, str> {
        Cow::Borrowed("MeshRef")
    }
}
