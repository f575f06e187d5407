//! The limits of the service in one place: what `/v1/system` reports and what the tests attack.

use std::collections::BTreeMap;
use std::time::Duration;

use crate::problem::ApiError;

/// Most bytes of a JSON body or of a genome's text; a genome of 1024 instructions stays below.
pub const JSON_BYTES: usize = 256 << 10;
/// Deepest nesting of a JSON body.
pub const JSON_DEPTH: usize = 64;
/// Most bytes of an OBJ file.
pub const OBJ_BYTES: usize = 32 << 20;
/// Most bytes of an IES file.
pub const PROFILE_BYTES: usize = 4 << 20;
/// Most bytes of a picture of an environment.
pub const ENVIRONMENT_BYTES: usize = 64 << 20;
/// Most samples that the lights of a scene make at one place.
pub const LIGHT_SAMPLES: u32 = 256;
/// Most bytes of a target's file.
pub const TARGET_BYTES: usize = 64 << 20;
/// Most samples of a target's pictures, were they all covered and lit; each takes some two hundred bytes of whoever searches. Of far fewer
/// a search looks at ten thousand pixels.
pub const TARGET_RAYS: u64 = (PICTURE_PX as u64) * (PICTURE_PX as u64);
/// Most searches that wait for a worker.
pub const QUEUED_SEARCHES: u32 = 200;
/// Most threads of a search.
pub const SEARCH_THREADS: u64 = 256;
/// Longest time of a search.
pub const SEARCH_SECONDS: f64 = 7.0 * 24.0 * 3600.0;
/// Most generations of a search.
pub const SEARCH_GENERATIONS: u32 = 100_000;
/// Most evaluations of a search.
pub const SEARCH_EVALUATIONS: u64 = 1_000_000_000_000;
/// Most individuals that a search starts from.
pub const SEARCH_START: usize = 64;
/// A search that has had so much time goes behind those that wait.
pub const SEARCH_SLICE: Duration = Duration::from_secs(20);
/// Most bytes of a lineage file, given out or taken in.
pub const LINEAGE_FILE_BYTES: usize = 256 << 20;
/// Most bytes of a worker's message: a sheet of large linear pictures.
pub const LEASE_BYTES: usize = 512 << 20;
/// Most bytes of what a worker reports of a search.
pub const SEARCH_REPORT_BYTES: usize = 256 << 20;
/// Most bytes of all bodies that are held at once, besides the first [`BODY_FREE`] of each.
pub const BODIES_BYTES: usize = 256 << 20;
/// The same for workers' messages, so that no client's body is in a worker's way.
pub const MESSAGES_BYTES: usize = LEASE_BYTES;
/// Bytes of a body that always find room: [`CONNECTIONS`] bounds how many there are.
pub const BODY_FREE: usize = JSON_BYTES;
/// Most children of one generation.
pub const CHILDREN: u32 = 256;
/// Most items of one page of a list.
pub const PAGE: u32 = 200;
/// Items of a page unless asked otherwise.
pub const PAGE_DEFAULT: u32 = 50;
/// Longest name of a lineage, in characters.
pub const NAME_CHARS: usize = 200;
/// Longest notes, in characters.
pub const NOTE_CHARS: usize = 10_000;
/// Largest picture side.
pub const PICTURE_PX: u32 = 2048;
/// Smallest picture side.
pub const PICTURE_MIN_PX: u32 = 16;
/// Largest thumbnail side.
pub const THUMBNAIL_PX: u32 = 1024;
/// Most samples a pixel.
pub const SAMPLES: u32 = 64;
/// Most primary rays of one picture: the largest picture at four samples a pixel.
pub const RAYS: u64 = 4 * (PICTURE_PX as u64) * (PICTURE_PX as u64);
/// Largest side of a sheet; cells shrink to keep to it.
pub const SHEET_PX: u32 = 4096;
/// Most cells of a sheet.
pub const SHEET_CELLS: usize = 256;
/// Most pictures of a light circle.
pub const CIRCLE_FRAMES: u32 = 120;
/// Most pixels of all pictures of one animation or strip.
pub const CIRCLE_PIXELS: u64 = 1 << 25;
/// Most render jobs that wait.
pub const QUEUED_JOBS: u64 = 1000;
/// Most broods that wait for a processor.
pub const WAITING_BROODS: usize = 64;
/// Most connections at once.
pub const CONNECTIONS: usize = 512;
/// Most event streams at once; the other connections stay free for requests that end.
pub const EVENT_STREAMS: usize = 256;
/// A request's head must be complete in this time from its first byte.
pub const HEAD: Duration = Duration::from_secs(5);
/// A body must begin, and go on by [`BODY_RATE`], in this time.
pub const BODY: Duration = Duration::from_secs(10);
/// Least bytes a second of a body once [`BODY`] is over.
pub const BODY_RATE: u64 = 64 << 10;
/// A connection on which nothing moves is closed after this time.
pub const IDLE: Duration = Duration::from_secs(30);
/// A closed connection is read to its end for this long, so that its last answer arrives.
pub const LINGER: Duration = Duration::from_secs(2);
/// A waiting GET waits this long.
pub const WAIT: Duration = Duration::from_secs(20);
/// A lease lapses unless renewed in this time.
pub const LEASE: Duration = Duration::from_secs(20);
/// Longest wait of a request for a lease.
pub const LEASE_WAIT: Duration = Duration::from_secs(20);
/// At shutdown, requests under way have this long.
pub const DRAIN: Duration = Duration::from_secs(10);

/// What comes of the work, or a word that it has not been done in [`WAIT`].
pub async fn in_time<T>(work: impl Future<Output = Result<T, ApiError>>) -> Result<T, ApiError> {
    let done = tokio::time::timeout(WAIT, work).await;
    done.map_err(|_| ApiError::not_yet("ask again in a moment"))?
}

/// The side of a picture that was asked for in a query's `size`, of at most that many pixels.
pub fn side(size_px: u32, most_px: u32) -> Result<u32, ApiError> {
    if (PICTURE_MIN_PX..=most_px).contains(&size_px) {
        return Ok(size_px);
    }
    let words = format!("{PICTURE_MIN_PX} to {most_px} pixels, not {size_px}");
    Err(ApiError::bad_parameter("size", words))
}

/// The limits by name, in the unit that the name ends in.
pub fn report() -> BTreeMap<String, u64> {
    let seconds = |duration: Duration| duration.as_secs();
    [
        ("json_bytes", JSON_BYTES as u64),
        ("json_depth_levels", JSON_DEPTH as u64),
        ("obj_bytes", OBJ_BYTES as u64),
        ("profile_bytes", PROFILE_BYTES as u64),
        ("environment_bytes", ENVIRONMENT_BYTES as u64),
        ("light_samples", u64::from(LIGHT_SAMPLES)),
        ("lineage_file_bytes", LINEAGE_FILE_BYTES as u64),
        ("target_bytes", TARGET_BYTES as u64),
        ("target_rays", TARGET_RAYS),
        ("queued_searches", u64::from(QUEUED_SEARCHES)),
        ("search_threads", SEARCH_THREADS),
        ("search_seconds", SEARCH_SECONDS as u64),
        ("search_generations", u64::from(SEARCH_GENERATIONS)),
        ("search_evaluations", SEARCH_EVALUATIONS),
        ("generation_children", u64::from(CHILDREN)),
        ("page_items", u64::from(PAGE)),
        ("name_characters", NAME_CHARS as u64),
        ("note_characters", NOTE_CHARS as u64),
        ("picture_px", u64::from(PICTURE_PX)),
        ("thumbnail_px", u64::from(THUMBNAIL_PX)),
        ("samples_per_pixel", u64::from(SAMPLES)),
        ("picture_rays", RAYS),
        ("sheet_cells", SHEET_CELLS as u64),
        ("circle_frames", u64::from(CIRCLE_FRAMES)),
        ("circle_pixels", CIRCLE_PIXELS),
        ("queued_jobs", QUEUED_JOBS),
        ("connections", CONNECTIONS as u64),
        ("event_streams", EVENT_STREAMS as u64),
        ("head_seconds", seconds(HEAD)),
        ("body_seconds", seconds(BODY)),
        ("idle_seconds", seconds(IDLE)),
        ("wait_seconds", seconds(WAIT)),
        ("lease_seconds", seconds(LEASE)),
    ]
    .into_iter()
    .map(|(name, value)| (name.to_owned(), value))
    .collect()
}
