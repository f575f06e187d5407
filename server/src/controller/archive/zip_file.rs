//! ZIP files that are made while they are sent. Entries have no times, so the same plan gives the
//! same bytes.

use std::collections::HashMap;
use std::io::{self, Write as _};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use async_stream::try_stream;
use brood_export::{Exported, Within};
use brood_protocol::{JobId, Queue};
use brood_scene::PictureSize;
use brood_storage::StoredExportFile;
use bytes::Bytes;
use futures::stream::{self, Stream, StreamExt};
use http::{HeaderName, header};
use zip::write::{SimpleFileOptions, StreamWriter};
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::kind::Kind;
use super::plan::{Plan, PlannedMaterial, framing};
use crate::controller::export;
use crate::controller::picture_query::SIZE;
use crate::problem::ApiError;
use crate::processors::run_blocking;
use crate::state::App;

/// Number of entries made at a time: enough to keep render workers busy.
const AT_ONCE: usize = 8;
/// Most waits of [`limit::WAIT`](crate::limit::WAIT) for one picture.
const WAITS: u32 = 15;
/// Last entry of an archive.
const MANIFEST: &str = "manifest.json";

/// Buffer that a [`ZipWriter`] fills and a stream empties.
#[derive(Clone, Default)]
struct Sink(Arc<Mutex<Vec<u8>>>);

impl Sink {
    fn take(&self) -> Bytes {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner)).into()
    }
}

impl io::Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Headers of an archive.
pub const HEADERS: [(HeaderName, &str); 3] = [
    (header::CONTENT_TYPE, "application/zip"),
    (header::CONTENT_DISPOSITION, "attachment; filename=\"brood-materials.zip\""),
    (header::CACHE_CONTROL, "private, no-cache"),
];

/// Files of exports that are made already, by number within the plan.
pub type Stored = HashMap<u32, (JobId, StoredExportFile)>;

/// Entry of an archive.
enum Entry {
    /// File of an export.
    Stored(JobId, StoredExportFile),
    /// Bytes, and the note of a table.
    Made(Bytes, Option<String>),
}

type Writer = ZipWriter<StreamWriter<Sink>>;

/// Streams an archive. An error ends the stream, so that the client sees a broken transfer.
pub fn zip_file(
    app: App,
    mut plan: Plan,
    mut stored: Stored,
) -> impl Stream<Item = Result<Bytes, io::Error>> + Send {
    try_stream! {
        let sink = Sink::default();
        let mut writer = ZipWriter::new_stream(sink.clone());
        let files: Vec<_> = plan.files().map(|(of, file)| (of.clone(), file.clone())).collect();
        let mut notes = Vec::with_capacity(files.len());
        let options = (plan.energy_limit, plan.size.unwrap_or(SIZE.into()));
        let making = (0..).zip(files).map(|(number, (of, file))| {
            let (app, stored) = (app.clone(), stored.remove(&number));
            async move {
                let made = match stored {
                    Some((job, file)) => Ok(Entry::Stored(job, file)),
                    None => made(&app, &of, file.format, options).await,
                };
                made.map(|made| (file.name, made))
            }
        });
        let mut made = std::pin::pin!(stream::iter(making).buffered(AT_ONCE));
        while let Some(entry) = made.next().await {
            let (name, entry) = entry.map_err(broken)?;
            let (bytes, note) = match entry {
                // Read now, so that one file at a time is in memory.
                Entry::Stored(job, file) => {
                    (app.exports.read_file(job, &file).await.map_err(broken)?, file.note)
                }
                Entry::Made(bytes, note) => (bytes, note),
            };
            notes.push(note);
            writer = run_blocking(move || add(writer, name, &bytes)).await.map_err(broken)??;
            yield sink.take();
        }
        plan.note(notes);
        let manifest = serde_json::to_vec_pretty(&plan).map_err(io::Error::other)?;
        writer = add(writer, MANIFEST.to_owned(), &manifest)?;
        let done = run_blocking(move || writer.finish()).await.map_err(broken)?;
        done.map_err(io::Error::other)?;
        yield sink.take();
    }
}

fn add(mut writer: Writer, name: String, bytes: &[u8]) -> io::Result<Writer> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .compression_level(Some(1))
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    writer.start_file(name, options)?;
    writer.write_all(bytes)?;
    Ok(writer)
}

fn broken(error: ApiError) -> io::Error {
    tracing::warn!(reason = %error.problem().detail, "an archive was not finished");
    io::Error::other(error.problem().detail.clone())
}

/// Makes an entry. `options`: energy limit and size of pictures.
async fn made(
    app: &App,
    of: &PlannedMaterial,
    format: Kind,
    options: (Option<bool>, PictureSize),
) -> Result<Entry, ApiError> {
    let material = app.library.material(of.hash).await?;
    match format {
        Kind::Brood => Ok(Entry::Made(material.genome.to_string().into(), None)),
        Kind::Source(format) => {
            let made = export::exported(app, material, format, options.0, Within::default());
            let Exported { bytes, note } = made.await?;
            Ok(Entry::Made(bytes.into(), note))
        }
        Kind::Picture(format) => {
            let framed = app.library.frame(framing(app, of.scene, options.1, format)).await?;
            let key = framed.key(material.program.hash());
            let row = app.pictures.store_row(framed.row(key, of.hash)).await?;
            let mut waits = 1;
            loop {
                match app.pictures.get_from(Queue::Batch, &row).await {
                    Err(error) if error.status() == 503 && waits < WAITS => {
                        waits += 1;
                        tokio::time::sleep(Duration::from_secs(1)).await;
                    }
                    other => return Ok(Entry::Made(other?, None)),
                }
            }
        }
    }
}
