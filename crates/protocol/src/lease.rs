//! Work for workers: binary (postcard behind a version), because a brood's programs and pictures as JSON text would
//! cost milliseconds.

use brood_scene::{PixelArea, Sampling, Scene};
use serde::{Deserialize, Serialize, de::DeserializeOwned};

use crate::{Backend, BackendReport, JobId, LeaseId, PictureFormat, PictureKey, Work};

/// Content type of lease requests, grants and results.
pub const CONTENT_TYPE: &str = "application/vnd.brood.lease";
/// Opens every message; the digit is the version.
const MAGIC: &[u8; 8] = b"brood/4\n";

/// Bytes that are not a message of this version.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum WireError {
    /// Another version, or no message at all.
    #[error("the message does not begin with the version brood/4")]
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
    /// Scalar operations of the genome as written, which the program no longer shows: for [`Work`].
    pub operations_written: u32,
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
    pub sampling: Sampling,
    /// The part that is wanted; all of it if absent.
    pub area: Option<PixelArea>,
    /// The file wanted.
    pub format: PictureFormat,
    /// The evaluator wanted.
    pub backend: Backend,
}

impl Frame {
    /// A frame of a whole picture of a scene.
    #[must_use]
    pub fn new(
        scene: &Scene,
        mesh: MeshSource,
        size_px: u32,
        sampling: impl Into<Sampling>,
        (format, backend): (PictureFormat, Backend),
    ) -> Self {
        let scene_json = serde_json::to_string(scene).expect("a scene is finite numbers and words");
        let sampling = sampling.into();
        Self { scene_json, mesh, size_px, sampling, area: None, format, backend }
    }

    /// The same with another part of the picture.
    #[must_use]
    pub fn with_area(self, area: Option<PixelArea>) -> Self {
        // All of it is the picture itself, under its own key.
        let area = area.filter(|area| *area != PixelArea::whole(self.size_px));
        Self { area, ..self }
    }

    /// Rays that its picture takes at least.
    #[must_use]
    pub fn rays(&self) -> u64 {
        let area = self.area.unwrap_or(PixelArea::whole(self.size_px));
        area.pixels() * u64::from(self.sampling.least())
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
        let shape = (self.size_px, self.sampling, self.area);
        let parts = (scene, self.mesh, shape, self.format, class);
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
    /// The pictures, all of them, and what they took.
    Pictures(Vec<RenderedPicture>, Work),
    /// It cannot be done, and trying again would not help.
    Failed(String),
}

/// A picture as a worker made it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RenderedPicture {
    /// Its key.
    pub key: PictureKey,
    /// The encoded file.
    #[serde(with = "octets")]
    pub bytes: Vec<u8>,
    /// The exposure that was used, in EV; 0 for linear files.
    pub exposure_ev: f64,
    /// Samples shaded for it.
    pub samples: u64,
    /// Scalar operations executed for it.
    pub operations: u64,
}

/// Files as one run of bytes: serde's own form of a vector goes through them one by one, which takes milliseconds for the
/// pictures of a brood. What is on the wire is the same.
pub(crate) mod octets {
    use std::fmt;

    use serde::de::{Error, Visitor};
    use serde::{Deserializer, Serializer};

    pub fn serialize<S: Serializer>(bytes: &[u8], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(bytes)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<u8>, D::Error> {
        struct Octets;

        impl Visitor<'_> for Octets {
            type Value = Vec<u8>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("bytes")
            }

            fn visit_bytes<E: Error>(self, bytes: &[u8]) -> Result<Vec<u8>, E> {
                Ok(bytes.to_vec())
            }

            fn visit_byte_buf<E: Error>(self, bytes: Vec<u8>) -> Result<Vec<u8>, E> {
                Ok(bytes)
            }
        }

        deserializer.deserialize_byte_buf(Octets)
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn results(bytes: Vec<u8>) -> LeaseResults {
        let ticket = LeaseTicket { lease: LeaseId::fresh(), epoch: 3 };
        let key = PictureKey([7; 32]);
        let picture = RenderedPicture { key, bytes, exposure_ev: 0.5, samples: 9, operations: 99 };
        let work = Work { pictures: 1, samples_lit: 9, ..Work::default() };
        LeaseResults { ticket, outcome: Outcome::Pictures(vec![picture.clone(), picture], work) }
    }

    #[test]
    fn results_come_back_as_they_were_sent() {
        for bytes in [Vec::new(), (0..=255).cycle().take(70_000).collect()] {
            let sent = results(bytes);
            assert_eq!(decode::<LeaseResults>(&encode(&sent)).unwrap(), sent);
        }
    }

    #[test]
    fn message_is_refused_when_of_another_version_or_cut_off() {
        let whole = encode(&results(vec![1; 100]));
        let mut old = whole.clone();
        old[6] = b'1';
        assert_eq!(decode::<LeaseResults>(&old), Err(WireError::Version));
        for end in MAGIC.len()..whole.len() {
            let cut = decode::<LeaseResults>(&whole[..end]);
            assert!(matches!(cut, Err(WireError::Malformed(_))), "{end}: {cut:?}");
        }
        let longer = [whole.as_slice(), b"x"].concat();
        assert!(matches!(decode::<LeaseResults>(&longer), Err(WireError::Malformed(_))));
    }
}
