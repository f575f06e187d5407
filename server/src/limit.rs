//! Limits of the service, reported by `/v1/system`.

use std::collections::BTreeMap;
use std::time::Duration;

use brood_scene::PictureSize;

use crate::problem::{ApiError, quote};

/// Largest JSON body or genome text in bytes; fits a genome of 1024 instructions.
pub const JSON_BYTES: usize = 256 << 10;
/// Deepest nesting of a JSON body.
pub const JSON_DEPTH: usize = 64;
/// Largest OBJ file in bytes.
pub const OBJ_BYTES: usize = 32 << 20;
/// Largest IES file in bytes.
pub const PROFILE_BYTES: usize = 4 << 20;
/// Most pixels of an environment image: 4096 x 2048. Decoding takes 30 bytes for each.
pub const ENVIRONMENT_PIXELS: u64 = 1 << 23;
/// Largest environment image in bytes.
pub const ENVIRONMENT_BYTES: usize = 64 << 20;
/// Most samples per point of a scene's lights.
pub const LIGHT_SAMPLES: u32 = 256;
/// Largest target in bytes.
pub const TARGET_BYTES: usize = 64 << 20;
/// Most samples of a target's pictures, if all were covered and lit; a search needs about 200 bytes
/// for each.
///
/// A search uses far fewer: about 10,000 pixels.
pub const TARGET_RAYS: u64 = (PICTURE_PX as u64) * (PICTURE_PX as u64);
/// Most queued searches.
pub const QUEUED_SEARCHES: u32 = 200;
/// Most threads of a search.
pub const SEARCH_THREADS: u64 = 256;
/// Longest search in seconds.
pub const SEARCH_SECONDS: f64 = 7.0 * 24.0 * 3600.0;
/// Most generations of a search.
pub const SEARCH_GENERATIONS: u32 = 100_000;
/// Most evaluations of a search.
pub const SEARCH_EVALUATIONS: u64 = 1_000_000_000_000;
/// Most islands of a search.
pub const ISLANDS: u64 = 64;
/// Most start individuals of a search.
pub const SEARCH_START: usize = 64;
/// Time after which a running search yields to queued ones.
pub const SEARCH_SLICE: Duration = Duration::from_secs(20);
/// Largest lineage file in bytes, for import and export.
pub const LINEAGE_FILE_BYTES: usize = 256 << 20;
/// Largest message of a render worker in bytes: a batch of large linear pictures.
pub const LEASE_BYTES: usize = 512 << 20;
/// Largest report of a search in bytes.
pub const SEARCH_REPORT_BYTES: usize = 256 << 20;
/// Memory budget of all clients' bodies in bytes, without the first [`BODY_FREE`] of each.
pub const BODIES_BYTES: usize = 256 << 20;
/// Most bodies larger than [`BODY_FREE`] that one client may send at the same time.
pub const CLIENT_BODIES: usize = 16;
/// Memory budget of all workers' messages in bytes, separate so that clients cannot block workers.
pub const MESSAGES_BYTES: usize = LEASE_BYTES;
/// Bytes of each body outside the budget; bounded by [`CONNECTIONS`].
pub const BODY_FREE: usize = JSON_BYTES;
/// Most children of a generation.
pub const CHILDREN: u32 = 256;
/// Most individuals on a page of generations, unless one generation has more.
pub const PAGE_INDIVIDUALS: u32 = 2048;
/// Most items per page of a list.
pub const PAGE: u32 = 200;
/// Default number of items per page.
pub const PAGE_DEFAULT: u32 = 50;
/// Longest name of a lineage, in characters.
pub const NAME_CHARS: usize = 200;
/// Most tags of a lineage.
pub const TAGS: usize = 12;
/// Longest tag, in characters.
pub const TAG_CHARS: usize = 30;
/// Longest search text, in characters.
pub const SEARCH_CHARS: usize = 200;
/// Longest notes, in characters.
pub const NOTE_CHARS: usize = 10_000;
/// Largest side of a picture in pixels.
pub const PICTURE_PX: u32 = 2048;
/// Smallest side of a picture in pixels.
pub const PICTURE_MIN_PX: u32 = 16;
/// Largest side of a thumbnail in pixels.
pub const THUMBNAIL_PX: u32 = 1024;
/// Most samples per pixel.
pub const SAMPLES: u32 = 64;
/// Most primary rays per picture: the largest picture at four samples per pixel.
pub const RAYS: u64 = 4 * (PICTURE_PX as u64) * (PICTURE_PX as u64);
/// Largest side of a sheet in pixels; cells shrink to fit.
pub const SHEET_PX: u32 = 4096;
/// Most cells of a sheet.
pub const SHEET_CELLS: usize = 256;
/// Most pictures of a light circle.
pub const CIRCLE_FRAMES: u32 = 120;
/// Most pixels of an animation or strip, over all pictures.
pub const CIRCLE_PIXELS: u64 = 1 << 25;
/// Most individuals of an archive; the largest brood fits.
pub const ARCHIVE_INDIVIDUALS: usize = CHILDREN as usize;
/// Most pixels of an archive, over all pictures.
pub const ARCHIVE_PIXELS: u64 = 1 << 25;
/// Most binary tables of an archive, each of 1 to 52 MB.
pub const ARCHIVE_TABLES: usize = 16;
/// Most binary tables of an export that is made as a job.
pub const EXPORT_TABLES: usize = 256;
/// Most queued exports.
pub const QUEUED_EXPORTS: u32 = 50;
/// Most bytes of the files of all exports on disk.
pub const EXPORTS_BYTES: u64 = 8 << 30;
/// Time for which an export that has ended is kept.
pub const EXPORT_TTL: Duration = Duration::from_secs(24 * 3600);
/// Largest report of an export in bytes: one file.
pub const EXPORT_REPORT_BYTES: usize = 128 << 20;
/// Most queued render jobs.
pub const QUEUED_JOBS: usize = 1000;
/// Most bytes of the render jobs that wait in a queue, as sent to workers.
pub const QUEUED_BYTES: usize = 128 << 20;
/// Most calls waiting for a processor.
pub const WAITING_BROODS: usize = 64;
/// Most open connections, without those of workers.
pub const CONNECTIONS: usize = 512;
/// Most open connections of workers. A worker has one for each lane, heartbeat and transfer: three
/// to eight.
pub const WORKER_CONNECTIONS: usize = 2048;
/// Most open event streams; leaves connections for other requests.
pub const EVENT_STREAMS: usize = 256;
/// Longest time from the first byte of a request's head to its last.
pub const HEAD: Duration = Duration::from_secs(5);
/// Time after which a body must have arrived, or have kept arriving at [`BODY_RATE`].
pub const BODY: Duration = Duration::from_secs(10);
/// Lowest rate of a body in bytes per second, over any time of [`BODY`].
pub const BODY_RATE: usize = 8 << 10;
/// Rate in bytes per second below which a body that holds memory is given up when another body
/// needs the memory.
pub const BODY_RATE_SPARED: usize = 64 << 10;
/// Idle time after which a connection is closed.
pub const IDLE: Duration = Duration::from_secs(30);
/// Time for which a closed connection is still read, so that its last answer arrives.
pub const LINGER: Duration = Duration::from_secs(2);
/// Longest wait of a GET.
pub const WAIT: Duration = Duration::from_secs(20);
/// Longest wait of a request whose answer is deferred.
pub const DEFERRED: Duration = Duration::from_secs(3600);
/// Most requests whose answers are deferred at the same time.
pub const DEFERRED_REQUESTS: usize = 64;
/// Most requests of one client whose answers are deferred at the same time.
pub const CLIENT_DEFERRED: usize = 16;
/// Most bytes of all deferred answers.
pub const DEFERRED_BYTES: usize = 64 << 20;
/// Most deferred answers that are kept.
pub const DEFERRED_KEPT: usize = 1000;
/// Time for which a deferred answer is kept.
pub const DEFERRED_TTL: Duration = Duration::from_secs(600);
/// Time to live of a lease without renewal.
pub const LEASE: Duration = Duration::from_secs(20);
/// Time to live of the lease of an interactive render job, for which a person waits.
pub const INTERACTIVE_LEASE: Duration = Duration::from_secs(2);
/// Time to live of the lease of a batch render job.
pub const BATCH_LEASE: Duration = Duration::from_secs(5);
/// Longest wait of a worker for a lease.
pub const LEASE_WAIT: Duration = Duration::from_secs(20);
/// Time for running requests at shutdown.
pub const DRAIN: Duration = Duration::from_secs(10);

/// Parses a query's `size`: the side of a picture in pixels, or width and height as in `640x360`.
///
/// # Errors
/// 400 if a side is not between [`PICTURE_MIN_PX`] and `most_px`.
pub fn size(text: &str, most_px: u32) -> Result<PictureSize, ApiError> {
    let known = text.parse().ok().filter(|size| is_size(*size, most_px));
    known.ok_or_else(|| {
        let words = format!(
            "must be {PICTURE_MIN_PX} to {most_px} pixels, or width and height such as 640x360, got {}",
            quote(text)
        );
        ApiError::bad_parameter("size", words)
    })
}

/// True if each side of a picture is between [`PICTURE_MIN_PX`] and `most_px`.
pub fn is_size(size: PictureSize, most_px: u32) -> bool {
    [size.width, size.height].iter().all(|side| (PICTURE_MIN_PX..=most_px).contains(side))
}

/// Checks a query's `size`, the side of a square picture in pixels.
///
/// # Errors
/// 400 if it is not between [`PICTURE_MIN_PX`] and `most_px`.
pub fn side(size_px: u32, most_px: u32) -> Result<u32, ApiError> {
    if (PICTURE_MIN_PX..=most_px).contains(&size_px) {
        return Ok(size_px);
    }
    let words = format!("must be {PICTURE_MIN_PX} to {most_px} pixels, got {size_px}");
    Err(ApiError::bad_parameter("size", words))
}

/// Returns the limits by name; a name ends in its unit.
pub fn report() -> BTreeMap<String, u64> {
    let seconds = |duration: Duration| duration.as_secs();
    [
        ("json_bytes", JSON_BYTES as u64),
        ("json_depth_levels", JSON_DEPTH as u64),
        ("obj_bytes", OBJ_BYTES as u64),
        ("profile_bytes", PROFILE_BYTES as u64),
        ("environment_bytes", ENVIRONMENT_BYTES as u64),
        ("environment_pixels", ENVIRONMENT_PIXELS),
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
        ("lineage_tags", TAGS as u64),
        ("tag_characters", TAG_CHARS as u64),
        ("picture_px", u64::from(PICTURE_PX)),
        ("thumbnail_px", u64::from(THUMBNAIL_PX)),
        ("samples_per_pixel", u64::from(SAMPLES)),
        ("picture_rays", RAYS),
        ("sheet_cells", SHEET_CELLS as u64),
        ("circle_frames", u64::from(CIRCLE_FRAMES)),
        ("circle_pixels", CIRCLE_PIXELS),
        ("archive_individuals", ARCHIVE_INDIVIDUALS as u64),
        ("archive_pixels", ARCHIVE_PIXELS),
        ("archive_tables", ARCHIVE_TABLES as u64),
        ("export_tables", EXPORT_TABLES as u64),
        ("queued_exports", u64::from(QUEUED_EXPORTS)),
        ("exports_bytes", EXPORTS_BYTES),
        ("export_kept_seconds", seconds(EXPORT_TTL)),
        ("queued_jobs", QUEUED_JOBS as u64),
        ("connections", CONNECTIONS as u64),
        ("worker_connections", WORKER_CONNECTIONS as u64),
        ("event_streams", EVENT_STREAMS as u64),
        ("head_seconds", seconds(HEAD)),
        ("body_seconds", seconds(BODY)),
        ("idle_seconds", seconds(IDLE)),
        ("wait_seconds", seconds(WAIT)),
        ("deferred_seconds", seconds(DEFERRED)),
        ("deferred_requests", DEFERRED_REQUESTS as u64),
        ("client_deferred_requests", CLIENT_DEFERRED as u64),
        ("deferred_bytes", DEFERRED_BYTES as u64),
        ("deferred_kept_seconds", seconds(DEFERRED_TTL)),
        ("lease_seconds", seconds(LEASE)),
        ("interactive_lease_seconds", seconds(INTERACTIVE_LEASE)),
        ("batch_lease_seconds", seconds(BATCH_LEASE)),
    ]
    .into_iter()
    .map(|(name, value)| (name.to_owned(), value))
    .collect()
}
