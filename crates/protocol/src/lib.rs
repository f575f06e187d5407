//! What server, workers and clients say to each other: ids, requests, answers, leases, problems.
//!
//! This crate owns the shapes and their binary and JSON forms. It refuses to know routes, tables and evaluators.

mod breed;
mod client;
mod id;
mod individual;
mod job;
mod lease;
mod light_asset;
mod lineage;
mod mesh;
mod page;
mod picture;
mod problem;
mod schema;
mod search;
mod search_lease;
mod seed;
mod system;
mod target;
mod work;

/// How a picture is sampled and which part of it is wanted: words of requests, for those who know no scenes.
pub use brood_scene::{PixelArea, Sampling};

pub use breed::{Adopt, Breed, Curation, DialectConstraints, ParentRef, ParentRefError};
pub use client::{ClientError, WorkerClient};
pub use id::{
    GenerationId, IndividualId, JobId, LeaseId, LineageId, MeshId, RequestId, SceneId, TargetId,
};
pub use individual::{Generation, Individual, IndividualDetail, PatchIndividual};
pub use job::{JobAnswer, JobStatus, JobTimes};
pub use lease::{
    CONTENT_TYPE, Frame, LeaseGrant, LeaseRequest, LeaseResults, LeaseTicket, MeshSource, Outcome,
    RenderItem, RenderJob, RenderedPicture, WireError, WorkerReport, decode, encode,
};
pub use light_asset::{LightAssetAnswer, LightAssetFile, LightAssetKind};
pub use lineage::{CreateLineage, Lineage, ListedLineage, PatchLineage};
pub use mesh::{MeshAnswer, MeshWarning, SceneAnswer};
pub use page::Page;
pub use picture::{Backend, ExactnessClass, PictureFormat, PictureKey, RENDERER_VERSION};
pub use problem::Problem;
pub use search::{
    AnyJob, Budget, CreateSearch, FoundMaterial, FoundView, Front, SearchAnswer, SearchLine,
    SearchOptions, SearchState,
};
pub use search_lease::{
    Directive, GenerationLine, MeasuredMaterial, SearchGrant, SearchNews, SearchReport,
    SearchRequest, SearchTicket, TargetBytes,
};
pub use seed::Seed;
pub use system::{BackendReport, SystemAnswer};
pub use target::{
    LargestAlbedo, Target, TargetPixels, TargetSpec, TargetUpload, TargetView, ViewSpec,
};
pub use work::Work;
