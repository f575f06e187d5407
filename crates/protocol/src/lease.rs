//! Work for workers: binary (postcard behind a version), because a brood's programs and pictures as JSON text would
//! cost milliseconds.

use brood_scene::Scene;
use serde::{Deserialize, Serialize, de::DeserializeOwned};

use crate::{Backend, BackendReport, JobId, LeaseId, PictureFormat, PictureKey};

/// Content type of lease requests, grants and results.
pub const CONTENT_TYPE: &str = "application/vnd.brood.lease";
/// Opens every message; the digit is the version.
const MAGIC: &[u8; 8] = b"brood/1\n";

/// Bytes that are not a message of this version.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum WireError {
    /// Another version, or no message at all.
    #[error("the message does not begin with the version brood/1")]
    Version,
    /// Broken off or malformed.
    #[error("the message is malformed: {0}")]
    Malformed(String),
}

/// Asks for a job.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LeaseRequest {
    /// Who asks; for logs and `/v1/system`.
    pub worker: String,
    /// What it renders with.
    pub report: WorkerReport,
    /// How long the server may hold the request back when there is nothing to do.
    pub wait_ms: u32,
}

/// What a worker tells about itself.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct WorkerReport {
    /// Its evaluator.
    pub backend: BackendReport,
    /// Whether it can render with a bit-exact GPU.
    pub gpu: bool,
}

/// Proof of a lease: results with another epoch are refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct LeaseTicket {
    /// The lease.
    pub lease: LeaseId,
    /// Counted up each time the job is leased.
    pub epoch: u64,
}

/// A job in a worker's hands.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LeaseGrant {
    /// The lease.
    pub ticket: LeaseTicket,
    /// The job.
    pub job: JobId,
    /// The lease lapses unless renewed within this time.
    pub ttl_ms: u32,
    /// What to do.
    pub work: RenderJob,
}

/// Pictures of many programs in one frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RenderJob {
    /// What is common to the pictures.
    pub frame: Frame,
    /// The pictures.
    pub items: Vec<RenderItem>,
}

/// One picture to be made.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct RenderItem {
    /// Its key.
    pub key: PictureKey,
    /// The program's packed words.
    pub words: Vec<u32>,
}

/// Where a worker gets the mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum MeshSource {
    /// The scene's `mesh` names a built-in one.
    Builtin,
    /// By content hash, at `GET /v1/leases/meshes/{hash}`.
    Uploaded([u8; 32]),
}

/// Everything a picture depends on besides the program.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// The scene as JSON: its forms are self-describing, which postcard is not.
    scene_json: String,
    /// The mesh.
    pub mesh: MeshSource,
    /// Side in pixels.
    pub size_px: u32,
    /// Samples per pixel.
    pub samples_per_pixel: u32,
    /// The file wanted.
    pub format: PictureFormat,
    /// The evaluator wanted.
    pub backend: Backend,
}

impl Frame {
    /// A frame of a scene.
    #[must_use]
    pub fn new(
        scene: &Scene,
        mesh: MeshSource,
        size_px: u32,
        samples_per_pixel: u32,
        (format, backend): (PictureFormat, Backend),
    ) -> Self {
        let scene_json = serde_json::to_string(scene).expect("a scene is finite numbers and words");
        Self { scene_json, mesh, size_px, samples_per_pixel, format, backend }
    }

    /// The scene.
    pub fn scene(&self) -> Result<Scene, WireError> {
        serde_json::from_str(&self.scene_json).map_err(|e| WireError::Malformed(e.to_string()))
    }

    /// Hash of what decides the pixels; uploaded meshes count by content, evaluators by their exactness class.
    #[must_use]
    pub fn identity(&self) -> blake3::Hash {
        let class = self.backend.exactness_class();
        let mut scene = self.scene_json.clone();
        if let (MeshSource::Uploaded(_), Ok(mut parsed)) = (self.mesh, self.scene()) {
            // Two uploads of one file are one mesh: the id in the scene does not matter, the content does.
            parsed.mesh = brood_scene::MeshRef::Uploaded(String::new());
            scene = serde_json::to_string(&parsed).expect("a scene is finite numbers and words");
        }
        let parts = (scene, self.mesh, self.size_px, self.samples_per_pixel, self.format, class);
        blake3::hash(&postcard::to_stdvec(&parts).expect("plain data serialises"))
    }
}

/// Hands a job back.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LeaseResults {
    /// The lease.
    pub ticket: LeaseTicket,
    /// What came of it.
    pub outcome: Outcome,
}

/// What came of a job.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Outcome {
    /// The pictures, all of them.
    Pictures(Vec<RenderedPicture>),
    /// It cannot be done, and trying again would not help.
    Failed(String),
}

/// A picture as a worker made it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RenderedPicture {
    /// Its key.
    pub key: PictureKey,
    /// The encoded file.
    pub bytes: Vec<u8>,
    /// The exposure that was used, in EV; 0 for linear files.
    pub exposure_ev: f64,
    /// Samples shaded for it.
    pub samples: u64,
    /// Scalar operations executed for it.
    pub operations: u64,
}

/// A message as bytes.
#[must_use]
pub fn encode<T: Serialize>(message: &T) -> Vec<u8> {
    postcard::to_extend(message, MAGIC.to_vec()).expect("plain data serialises")
}

/// The message in bytes.
pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, WireError> {
    let body = bytes.strip_prefix(MAGIC).ok_or(WireError::Version)?;
    match postcard::take_from_bytes(body) {
        Ok((message, [])) => Ok(message),
        Ok((_, rest)) => Err(WireError::Malformed(format!("{} bytes too many", rest.len()))),
        Err(error) => Err(WireError::Malformed(error.to_string())),
    }
}
