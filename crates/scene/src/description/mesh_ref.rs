//! Which mesh a scene shows: one of the built-in ones or an uploaded one by its id.

use std::fmt;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A mesh by name. In JSON a string: the name of a built-in mesh, or else the id of an uploaded one.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum MeshRef {
    /// A mesh made by code.
    Builtin(BuiltinMesh),
    /// The id of an uploaded mesh.
    Uploaded(String),
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

/// A mesh that is made by code.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum BuiltinMesh {
    /// The unit sphere.
    Sphere,
    /// A ring.
    Torus,
    /// A cube with rounded edges.
    Cube,
    /// A turned knob: concave and convex curvature, grazing angles, a bead and a flange.
    Knob,
}

impl BuiltinMesh {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Sphere, Self::Torus, Self::Cube, Self::Knob];

    /// The name in scenes.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Sphere => "sphere",
            Self::Torus => "torus",
            Self::Cube => "cube",
            Self::Knob => "knob",
        }
    }

    /// The mesh of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|mesh| mesh.name() == name)
    }
}
