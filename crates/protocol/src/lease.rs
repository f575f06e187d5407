//! Lease protocol of render jobs.
//!
//! Messages are binary: a version, then postcard. As JSON text, the programs and pictures of a
//! brood would cost milliseconds.

use brood_program::Program;
use brood_scene::{Exposure, PictureSize, PixelArea, Sampling, Scene};
use serde::{Deserialize, Serialize, de::DeserializeOwned};

use crate::{
    Backend, BackendReport, JobId, LeaseId, PictureFormat, PictureKey, RenderStats, Subject,
};

/// Content type of all messages between server and workers.
pub const CONTENT_TYPE: &str = "application/vnd.brood.lease";
/// Prefix of every message; the digit is the protocol version, in base 36.
const MAGIC: &[u8; 8] = b"brood/d\n";

/// Header with the version of a worker, [`worker_version`].
pub const WORKER_HEADER: &str = "brood-worker";

/// Returns the version that server and worker must have in common to exchange jobs: that of the
/// messages, and that of the pictures.
#[must_use]
pub fn worker_version() -> String {
    format!("{}.{}", char::from(MAGIC[6]), crate::RENDERER_VERSION)
}

/// Error of [`decode`], [`decode_stored`] and [`Frame::scene`].
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum WireError {
    /// The prefix is missing or names another version.
    #[error("the message must begin with the protocol version brood/d")]
    Version,
    /// The message is truncated or malformed.
    #[error("the message is malformed: {0}")]
    Malformed(String),
}

brood_brdf::named_enum! {
    /// Queue of a render job. Workers serve both at once, the second at a low priority.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
    pub enum Queue {
        /// Pictures that a person waits for: short jobs.
        Interactive => "interactive",
        /// Long jobs, and pictures of large broods.
        Batch => "batch",
    }
}

/// Request for a render job.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LeaseRequest {
    /// Name of the worker, for logs and `/v1/system`.
    pub worker: String,
    /// Queue of the job.
    pub queue: Queue,
    /// Capabilities of the worker.
    pub report: WorkerReport,
    /// Longest time that the server may delay its answer if the queue is empty, in milliseconds.
    pub wait_ms: u32,
}

/// Capabilities of a worker.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct WorkerReport {
    /// Evaluator of the worker.
    pub backend: BackendReport,
    /// True if the worker can render with a bit-exact GPU.
    pub gpu: bool,
}

/// Proof of a lease. The server rejects results whose epoch is not the current one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct LeaseTicket {
    /// Id of the lease.
    pub lease: LeaseId,
    /// Number of leases of the job so far.
    pub epoch: u64,
}

/// Renewal of the lease of a render job.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LeaseRenewal {
    /// Ticket of the lease.
    pub ticket: LeaseTicket,
    /// Share of the job that is rendered, 0 to 1.
    pub progress: f32,
}

/// Render job that is leased to a worker.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LeaseGrant {
    /// Ticket of the lease.
    pub ticket: LeaseTicket,
    /// Id of the job.
    pub job: JobId,
    /// Time to live: the lease expires unless a heartbeat arrives within this time, in
    /// milliseconds.
    pub ttl_ms: u32,
    /// The job.
    pub work: RenderJob,
}

/// Render job: pictures of many subjects in one frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RenderJob {
    /// [`RENDERER_VERSION`](crate::RENDERER_VERSION) of the server; a worker of another version
    /// refuses the job.
    pub renderer_version: u32,
    /// Frame that the pictures share.
    pub frame: Frame,
    /// Pictures to render.
    pub items: Vec<RenderItem>,
}

impl RenderJob {
    /// Creates a job for the present renderer version.
    #[must_use]
    pub fn new(frame: Frame, items: Vec<RenderItem>) -> Self {
        Self { renderer_version: crate::RENDERER_VERSION, frame, items }
    }

    /// Returns the least number of camera rays of all pictures.
    #[must_use]
    pub fn rays(&self) -> u64 {
        self.frame.rays() * self.items.len() as u64
    }
}

/// Picture to render.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct RenderItem {
    /// Key of the picture.
    pub key: PictureKey,
    /// Subject of the picture.
    pub subject: Subject<PackedProgram>,
}

/// Program on its way to a worker.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct PackedProgram {
    /// Packed words of the program.
    pub words: Vec<u32>,
    /// Scalar operations of the genome as written, which cannot be counted from the lowered
    /// program. Input of [`RenderStats`].
    pub operations_written: u32,
}

/// Source of a scene's mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum MeshSource {
    /// Built-in mesh, named by the scene's `mesh`.
    Builtin,
    /// Uploaded mesh with this content hash, from `GET /v1/leases/meshes/{hash}`.
    Uploaded([u8; 32]),
    /// Mesh of a target's picture, in the file of the target, together with the files of its
    /// lights. Only for subjects with a target.
    Target,
}

/// Mesh and material of an object beside the subject, or of the ground.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct ObjectSource {
    /// Source of the mesh; built-in for the ground.
    pub mesh: MeshSource,
    /// Packed words of the material's program.
    pub words: Vec<u32>,
}

/// Everything that a picture depends on besides the subject.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// The scene as JSON: postcard is not self-describing, so it cannot decode the scene's untagged
    /// forms.
    scene_json: String,
    /// Source of the mesh.
    pub mesh: MeshSource,
    /// The scene's other objects in their order, then its ground.
    pub objects: Vec<ObjectSource>,
    /// Size of the whole picture.
    pub size_px: PictureSize,
    /// Samples per pixel.
    pub sampling: Sampling,
    /// Area to render; `None` for the whole picture.
    pub area: Option<PixelArea>,
    /// Requested file format.
    pub format: PictureFormat,
    /// Requested evaluator.
    pub backend: Backend,
}

impl Frame {
    /// Returns the frame of a whole picture.
    #[must_use]
    pub fn new(
        scene: &Scene,
        mesh: MeshSource,
        size_px: impl Into<PictureSize>,
        sampling: impl Into<Sampling>,
        (format, backend): (PictureFormat, Backend),
    ) -> Self {
        let scene_json = serde_json::to_string(scene).expect("a scene is finite numbers and words");
        let (size_px, sampling) = (size_px.into(), sampling.into());
        let objects = Vec::new();
        Self { scene_json, mesh, objects, size_px, sampling, area: None, format, backend }
    }

    /// Returns the frame with the scene's other objects, then its ground.
    #[must_use]
    pub fn with_objects(self, objects: Vec<ObjectSource>) -> Self {
        Self { objects, ..self }
    }

    /// Returns the frame with another area.
    #[must_use]
    pub fn with_area(self, area: Option<PixelArea>) -> Self {
        // The whole picture has one key, whether or not an area is given.
        let area = area.filter(|area| *area != PixelArea::whole(self.size_px));
        Self { area, ..self }
    }

    /// Returns the frame with a fixed exposure.
    ///
    /// # Errors
    /// Returns [`WireError::Malformed`] if the JSON text is not a scene.
    pub fn exposed(self, ev: f64) -> Result<Self, WireError> {
        let mut scene = self.scene()?;
        scene.film.exposure = Exposure::Ev(ev);
        let Self { mesh, objects, size_px, sampling, area, format, backend, .. } = self;
        let frame = Self::new(&scene, mesh, size_px, sampling, (format, backend));
        Ok(frame.with_objects(objects).with_area(area))
    }

    /// Returns the least number of camera rays that the picture takes.
    #[must_use]
    pub fn rays(&self) -> u64 {
        let area = self.area.unwrap_or(PixelArea::whole(self.size_px));
        area.pixels() * u64::from(self.sampling.min_rays())
    }

    /// Returns the scene.
    ///
    /// # Errors
    /// Returns [`WireError::Malformed`] if the JSON text is not a scene.
    pub fn scene(&self) -> Result<Scene, WireError> {
        serde_json::from_str(&self.scene_json).map_err(|e| WireError::Malformed(e.to_string()))
    }

    /// Returns the key of a program's picture in this frame.
    #[must_use]
    pub fn key(&self, program: &Program) -> PictureKey {
        PictureKey::of(&Subject::Program(program.hash()), &self.identity())
    }

    /// Returns the hash of everything that decides the pixels. An uploaded mesh counts by its
    /// content, an evaluator by its exactness class.
    #[must_use]
    pub fn identity(&self) -> blake3::Hash {
        let class = self.backend.exactness_class();
        let mut scene = self.scene_json.clone();
        let is_uploaded = |mesh: &MeshSource| matches!(mesh, MeshSource::Uploaded(_));
        let mut meshes =
            std::iter::once(&self.mesh).chain(self.objects.iter().map(|own| &own.mesh));
        if let (true, Ok(mut parsed)) = (meshes.any(is_uploaded), self.scene()) {
            // Two uploads of one file are the same mesh: clear the ids, the sources have the
            // content hashes.
            let others = parsed.objects.iter_mut().map(|object| &mut object.mesh);
            for mesh in std::iter::once(&mut parsed.mesh).chain(others) {
                if let brood_scene::MeshRef::Uploaded(id) = mesh {
                    id.clear();
                }
            }
            scene = serde_json::to_string(&parsed).expect("a scene is finite numbers and words");
        }
        let shape = (self.size_px, self.sampling, self.area);
        let parts = (scene, self.mesh, shape, self.format, class);
        let mut bytes = postcard::to_stdvec(&parts).expect("plain data serialises");
        if !self.objects.is_empty() {
            bytes = postcard::to_extend(&self.objects, bytes).expect("plain data serialises");
        }
        blake3::hash(&bytes)
    }
}

/// Results of a render job.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LeaseResults {
    /// Ticket of the lease.
    pub ticket: LeaseTicket,
    /// Outcome of the job.
    pub outcome: RenderOutcome,
}

/// Outcome of a render job.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum RenderOutcome {
    /// All pictures of the job, and the work counters.
    Pictures(Vec<RenderedPicture>, RenderStats),
    /// Permanent failure: the job must not be retried.
    Failed(String),
    /// The subject does not exist, such as the mask of a picture without one.
    Missing(String),
}

/// Picture that a worker has rendered.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RenderedPicture {
    /// Key of the picture.
    pub key: PictureKey,
    /// The encoded file.
    #[serde(with = "octets")]
    pub bytes: Vec<u8>,
    /// Exposure that was applied, in EV; 0 for linear files.
    pub exposure_ev: f64,
    /// Number of samples shaded.
    pub samples: u64,
    /// Number of scalar operations executed.
    pub operations: u64,
}

/// Serialises files as one byte string. Serde's implementation for `Vec<u8>` visits each byte,
/// which takes milliseconds for the pictures of a brood. The encoding on the wire is the same.
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

/// Encodes a message: the version prefix, then postcard.
#[must_use]
pub fn encode<T: Serialize>(message: &T) -> Vec<u8> {
    postcard::to_extend(message, MAGIC.to_vec()).expect("plain data serialises")
}

/// Decodes a message.
///
/// # Errors
/// Returns [`WireError::Version`] if the prefix is wrong, [`WireError::Malformed`] if the rest is
/// truncated, too long or not a `T`.
pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, WireError> {
    decode_body(bytes.strip_prefix(MAGIC).ok_or(WireError::Version)?)
}

/// Decodes a mesh, the start genomes of a search, programs that migrate among its islands, the
/// front of one, or the ticket of a search or an export. Accepts every protocol version: the
/// encoding of these types must never change.
///
/// # Errors
/// As for [`decode`].
pub fn decode_stored<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, WireError> {
    let [b'b', b'r', b'o', b'o', b'd', b'/', b'0'..=b'9' | b'a'..=b'z', b'\n', body @ ..] = bytes
    else {
        return Err(WireError::Version);
    };
    decode_body(body)
}

fn decode_body<T: DeserializeOwned>(body: &[u8]) -> Result<T, WireError> {
    match postcard::take_from_bytes(body) {
        Ok((message, [])) => Ok(message),
        Ok((_, rest)) => Err(WireError::Malformed(format!("{} bytes after the end", rest.len()))),
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
        let work = RenderStats { pictures: 1, samples_lit: 9, ..RenderStats::default() };
        LeaseResults {
            ticket,
            outcome: RenderOutcome::Pictures(vec![picture.clone(), picture], work),
        }
    }

    #[test]
    fn identity_of_a_square_frame_depends_on_its_side_alone() {
        let scene = Scene::default();
        let how = (PictureFormat::Png, Backend::Auto);
        let frame = |size_px: PictureSize| {
            Frame::new(&scene, MeshSource::Builtin, size_px, Sampling::Adaptive, how)
        };
        for side in [16_u32, 256, 2048] {
            let shape = (side, Sampling::Adaptive, None::<PixelArea>);
            let json = serde_json::to_string(&scene).unwrap();
            let class = Backend::Auto.exactness_class();
            let parts = (json, MeshSource::Builtin, shape, PictureFormat::Png, class);
            let alone = blake3::hash(&postcard::to_stdvec(&parts).unwrap());
            assert_eq!(frame(side.into()).identity(), alone, "{side}");
        }
        let sizes = [(64, 32), (32, 64), (64, 64)];
        let identities = sizes.map(|(width, height)| {
            let frame = frame(PictureSize { width, height });
            assert_eq!(decode::<Frame>(&encode(&frame)).unwrap(), frame);
            let whole = PixelArea { x: 0, y: 0, width, height };
            assert_eq!(frame.clone().with_area(Some(whole)), frame);
            frame.identity()
        });
        assert!(identities[0] != identities[1] && !identities[..2].contains(&identities[2]));
    }

    #[test]
    fn results_are_equal_when_encoded_and_decoded() {
        for bytes in [Vec::new(), (0..=255).cycle().take(70_000).collect()] {
            let sent = results(bytes);
            assert_eq!(decode::<LeaseResults>(&encode(&sent)).unwrap(), sent);
        }
    }

    #[test]
    fn decode_fails_when_message_has_another_version_or_length() {
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

    #[test]
    fn tickets_of_searches_and_exports_keep_their_encoding() {
        let job: JobId = "01890a5d-ac96-774b-bcce-b302099a8057".parse().unwrap();
        let search = encode(&crate::SearchTicket { job, epoch: 3 });
        let export = encode(&crate::ExportTicket { job, epoch: 3 });
        let mut bytes = MAGIC.to_vec();
        bytes.push(16);
        bytes.extend(b"\x01\x89\x0a\x5d\xac\x96\x77\x4b\xbc\xce\xb3\x02\x09\x9a\x80\x57\x03");
        assert_eq!((&search, &export), (&bytes, &bytes));
    }

    #[test]
    fn stored_data_is_decoded_when_another_version_wrote_it() {
        let genomes = vec![vec![1_u8, 2], Vec::new()];
        let mut old = encode(&genomes);
        old[6] = b'4';
        assert_eq!(decode_stored::<Vec<Vec<u8>>>(&old), Ok(genomes));
        old[0] = b'x';
        assert_eq!(decode_stored::<Vec<Vec<u8>>>(&old), Err(WireError::Version));
    }
}
