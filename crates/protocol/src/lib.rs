//! Protocol of the server: ids, requests, responses, leases and problem details.
//!
//! Clients use JSON: [`Breed`], [`Generation`], [`CreateSearch`], [`SearchAnswer`] and others, each
//! with an OpenAPI schema. Workers use binary messages ([`encode`], [`decode`]) through
//! [`WorkerClient`]: [`LeaseGrant`] and [`LeaseResults`] for render jobs, [`SearchGrant`] and
//! [`SearchReport`] for searches. The crate does not depend on routes, tables or evaluators.
//!
//! ```
//! use brood_protocol::{Breed, LeaseId, LeaseTicket, Seed, decode, encode};
//!
//! // Seeds above 2^53 are given as strings, because JavaScript cannot represent them as numbers.
//! let breed: Breed = serde_json::from_str(r#"{"count": 9, "seed": "9007199254740993"}"#)?;
//! assert_eq!((breed.count, breed.mutation), (9, 0.3));
//! assert_eq!(breed.seed, Some(Seed(9007199254740993)));
//!
//! let ticket = LeaseTicket { lease: LeaseId::fresh(), epoch: 1 };
//! assert_eq!(decode::<LeaseTicket>(&encode(&ticket))?, ticket);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod breed;
mod claim;
mod client;
mod export;
mod export_lease;
mod http;
mod id;
mod individual;
mod job;
mod lease;
mod light_asset;
mod lineage;
mod mesh;
mod page;
mod painted;
mod picture;
mod priority;
mod problem;
mod random;
mod render_stats;
mod schema;
mod search;
mod search_lease;
mod seed;
mod subject;
mod system;
mod target;

/// Sampling and area of a picture, re-exported for crates that do not depend on scenes.
pub use brood_scene::{PictureSize, PixelArea, Sampling};

pub use breed::{Adopt, AmountError, Breed, BreedOptions, Curation, ParentRef, ParentRefError};
/// Overrides of a dialect, re-exported because [`BreedOptions`] has them.
pub use brood_genome::DialectConstraints;
pub use claim::{ClaimRequest, Ticket};
pub use client::{ClientError, TOKEN_VARIABLE, WorkerClient};
pub use export::{CreateExport, ExportAnswer};
pub use export_lease::{
    ExportFile, ExportGrant, ExportReport, ExportRequest, ExportTicket, ExportUpdate,
};
pub use http::{ServerUrl, ServerUrlError, TlsError, tls_config};
pub use id::{
    GenerationId, IndividualId, JobId, LeaseId, LineageId, MeshId, RequestId, SceneId, TargetId,
};
pub use individual::{
    Generation, GenerationOutline, Individual, IndividualDetail, PatchIndividual,
};
pub use job::{DeferredAnswer, JobAnswer, JobStatus, JobTimes};
pub use lease::{
    CONTENT_TYPE, Frame, LeaseGrant, LeaseRenewal, LeaseRequest, LeaseResults, LeaseTicket,
    MeshSource, ObjectSource, PackedProgram, Queue, RenderItem, RenderJob, RenderOutcome,
    RenderedPicture, WORKER_HEADER, WireError, WorkerReport, decode, decode_stored, encode,
    worker_version,
};
pub use light_asset::{LightAssetAnswer, LightAssetFile, LightAssetKind};
pub use lineage::{CreateLineage, Lineage, ListedLineage, PatchLineage};
pub use mesh::{MeshAnswer, MeshWarning, SceneAnswer};
pub use page::Page;
pub use painted::{PaintedError, check_painted_defaults};
pub use picture::{Backend, ExactnessClass, PictureFormat, PictureKey, RENDERER_VERSION};
pub use priority::{idle_thread_priority, lower_thread_priority};
pub use problem::Problem;
pub use random::{random_bytes, random_token};
pub use render_stats::RenderStats;
pub use search::{
    AnyJob, Budget, CreateSearch, FoundMaterial, FoundView, Front, IslandAnswer, MaterialSpread,
    NextScene, SearchAnswer, SearchLine, SearchOptions, SearchState,
};
pub use search_lease::{
    Arrival, CalibratedView, Directive, GenerationLine, MeasuredMaterial, NOTABLE_RATIO,
    ReportedSpread, SearchGrant, SearchReport, SearchRequest, SearchTicket, SearchUpdate,
    TargetBytes,
};
pub use seed::Seed;
pub use subject::{Aspect, Subject, TargetSource};
pub use system::{BackendReport, SystemAnswer};
pub use target::{
    CorrectedScene, LargestAlbedo, SceneCorrection, Target, TargetPixels, TargetSpec, TargetUpload,
    TargetView, ViewSpec,
};
