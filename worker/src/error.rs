//! Errors of rendering.

use brood_eval::EvalError;
use brood_light::FieldError;
use brood_program::WordsError;
use brood_protocol::WireError;
use brood_scene::{PictureSize, PixelArea};

/// Error of rendering.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// The frame's scene is malformed.
    #[error("cannot parse the scene: {0}")]
    Wire(#[from] WireError),
    /// The frame's scene has a value that is out of range.
    #[error("invalid scene: {0}")]
    Scene(#[from] FieldError),
    /// The frame's area is empty or exceeds the picture.
    #[error(
        "the area must be within the picture of {} x {} pixels, got {area}",
        size_px.width, size_px.height
    )]
    Area {
        /// Area of the frame.
        area: PixelArea,
        /// Size of the picture.
        size_px: PictureSize,
    },
    /// The packed words are not a valid program.
    #[error("cannot decode the program: {0}")]
    Words(#[from] WordsError),
    /// The evaluator failed.
    #[error("evaluation failed: {0}")]
    Eval(#[from] EvalError),
    /// The encoder failed.
    #[error("cannot encode the picture: {0}")]
    Encode(String),
    /// The content hash of a mesh differs from the requested one.
    #[error("the mesh does not have the requested content hash")]
    MeshContent,
    /// The frame lacks meshes or materials of its scene.
    #[error("the scene has {expected} objects beside the subject, the frame {given}")]
    Objects {
        /// Number of objects of the scene, the ground included.
        expected: usize,
        /// Number of objects of the frame.
        given: usize,
    },
    /// A painted material names a control image that the job does not have.
    #[error("there is no control image {0}; offline, give its file with --image")]
    Image(String),
    /// The subject needs the file of a target.
    #[error("the job has a subject without its target")]
    NoTarget,
    /// The target's file cannot be read.
    #[error("cannot read the target: {0}")]
    Target(String),
    /// The job was cancelled: its pictures are no longer wanted.
    #[error("the job was cancelled")]
    Cancelled,
    /// The subject does not exist.
    #[error("{0}")]
    Missing(String),
    /// Painted materials distinguish fewer lights.
    #[error("painted materials are rendered with at most {most} lights, got {given}")]
    Lights {
        /// Number of lights of the scene.
        given: usize,
        /// Largest number of lights.
        most: usize,
    },
    /// Pictures of automatic exposure cannot be compared.
    #[error("a difference needs a fixed exposure")]
    AutoDifference,
}
