//! Archives: several individuals in several formats as one ZIP file.
//!
//! Entries are made while the file is sent. They have no times, so the same request gives the same
//! bytes.

use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};
use std::io::{self, Write as _};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use async_stream::try_stream;
use axum::body::Body;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use brood_export::{Format, Within, check_material};
use brood_genome::GenomeHash;
use brood_protocol::{IndividualId, PictureFormat, SceneId};
use brood_scene::{PictureSize, Sampling};
use brood_storage::StoredIndividual;
use bytes::Bytes;
use futures::stream::{self, Stream, StreamExt};
use http::header;
use serde::Deserialize;
use zip::write::{SimpleFileOptions, StreamWriter};
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::picture_query::{check_rays, size};
use super::{export, file_name};
use crate::extract::Query;
use crate::library::Framing;
use crate::limit;
use crate::problem::{ApiError, quote};
use crate::processors::run_blocking;
use crate::state::App;

/// Number of entries made at a time: enough to keep render workers busy.
const AT_ONCE: usize = 8;
/// Most waits of [`limit::WAIT`] for one picture.
const WAITS: u32 = 15;

/// Content of an archive.
#[derive(Debug, Clone, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct ArchiveQuery {
    /// Ids separated by commas, at most 128.
    individuals: String,
    /// Formats separated by commas: `brood`, `png`, `exr`, and names from `GET /v1/exports`;
    /// default `brood,png`.
    formats: Option<String>,
    /// Size of the pictures in pixels: the side of a square, or width and height as in `640x360`;
    /// each side 16 to 2048, default 256. All pictures together may have 2^25 pixels.
    #[param(pattern = "^[0-9]+(x[0-9]+)?$")]
    size: Option<String>,
    /// True to apply the energy limit to exports; default: true for formats that path tracers read,
    /// as in the genome for others.
    energy_limit: Option<bool>,
}

/// Returns individuals as a ZIP file, with pictures in the scenes of their lineages.
///
/// Formats that a material cannot be exported in are left out. At most 16 of the files may be
/// tables (`rgl-bsdf`, `merl`).
#[utoipa::path(get, path = "/v1/exports.zip", operation_id = "get_archive", tag = "exports",
    params(ArchiveQuery),
    responses((status = 200, description = "ZIP file of the individuals", content_type = "application/zip")))]
pub async fn get(
    State(app): State<App>,
    Query(query): Query<ArchiveQuery>,
) -> Result<Response, ApiError> {
    let ids = ids(&query.individuals)?;
    let formats = formats(query.formats.as_deref().unwrap_or("brood,png"))?;
    let size_px = size(query.size.as_deref())?;
    check_pictures(ids.len(), &formats, size_px)?;
    check_tables(ids.len(), &formats)?;
    let individuals = app.store.individuals(&ids).await?;
    let mut lineages = HashMap::new();
    for one in &individuals {
        if let Entry::Vacant(entry) = lineages.entry(one.lineage) {
            entry.insert(app.store.lineage(one.lineage).await?);
        }
    }
    let mut entries = Vec::with_capacity(individuals.len() * formats.len());
    let mut taken = HashSet::new();
    // Why the first skipped file is left out.
    let mut skipped = None;
    for one in individuals {
        let name = unique(&mut taken, &lineages[&one.lineage].name, one.hash);
        let material = app.library.material(one.hash).await?;
        for format in &formats {
            let name = format.file_name(&name);
            let what = match format {
                Kind::Source(format) => {
                    // Not each material is one of each format.
                    if let Err(error) =
                        check_material(&material.program, *format, Within::default())
                    {
                        skipped.get_or_insert(error);
                        continue;
                    }
                    What::Source(one.hash, *format, query.energy_limit)
                }
                Kind::Brood => What::Text(one.hash),
                Kind::Picture(format) => {
                    let scene = lineages[&one.lineage].scene;
                    let view = framing(&app, scene, size_px, *format);
                    app.library.frame(view).await?.check(&material.program)?;
                    What::Picture(Box::new(one.clone()), view)
                }
            };
            entries.push((name, what));
        }
    }
    if let (Some(error), true) = (skipped, entries.is_empty()) {
        let words = format!("no individual can be exported in these formats: {error}");
        return Err(ApiError::refused(words));
    }
    let headers = [
        (header::CONTENT_TYPE, "application/zip"),
        (header::CONTENT_DISPOSITION, "attachment; filename=\"brood-materials.zip\""),
        (header::CACHE_CONTROL, "private, no-cache"),
    ];
    Ok((headers, Body::from_stream(written(app, entries))).into_response())
}

/// Format of an entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Brood,
    Picture(PictureFormat),
    Source(Format),
}

impl Kind {
    fn parse(name: &str) -> Option<Self> {
        match name {
            "brood" => Some(Self::Brood),
            "png" => Some(Self::Picture(PictureFormat::Png)),
            "exr" => Some(Self::Picture(PictureFormat::Exr)),
            name => name.parse().ok().map(Self::Source),
        }
    }

    fn file_name(self, stem: &str) -> String {
        match self {
            Self::Brood => format!("{stem}.brood"),
            Self::Picture(format) => format!("{stem}.{}", format.name()),
            Self::Source(format) => format.file_name(stem),
        }
    }

    fn is_binary_table(self) -> bool {
        matches!(self, Self::Source(format) if format.is_binary())
    }
}

/// Content of an entry.
enum What {
    Text(GenomeHash),
    Source(GenomeHash, Format, Option<bool>),
    Picture(Box<StoredIndividual>, Framing),
}

fn ids(text: &str) -> Result<Vec<IndividualId>, ApiError> {
    let mut ids = Vec::new();
    for id in text.split(',') {
        let wrong =
            |_| ApiError::bad_parameter("individuals", format!("{} is not an id", quote(id)));
        let id = id.trim().parse().map_err(wrong)?;
        if !ids.contains(&id) {
            ids.push(id);
        }
    }
    if ids.len() > limit::ARCHIVE_INDIVIDUALS {
        let words =
            format!("must have at most {} ids, got {}", limit::ARCHIVE_INDIVIDUALS, ids.len());
        return Err(ApiError::bad_parameter("individuals", words));
    }
    Ok(ids)
}

fn formats(text: &str) -> Result<Vec<Kind>, ApiError> {
    let mut formats = Vec::new();
    for name in text.split(',').map(str::trim) {
        let format = Kind::parse(name).ok_or_else(|| {
            let known: Vec<_> = Format::ALL.iter().map(|format| format.name()).collect();
            let words =
                format!("must be of brood, png, exr, {}, got {}", known.join(", "), quote(name));
            ApiError::bad_parameter("formats", words)
        })?;
        if !formats.contains(&format) {
            formats.push(format);
        }
    }
    Ok(formats)
}

/// # Errors
/// 422 if there are more tables than an archive may have.
fn check_tables(individuals: usize, formats: &[Kind]) -> Result<(), ApiError> {
    let tables = individuals * formats.iter().filter(|format| format.is_binary_table()).count();
    if tables > limit::ARCHIVE_TABLES {
        let most = limit::ARCHIVE_TABLES;
        let words =
            format!("{tables} tables of {individuals} individuals; an archive has at most {most}");
        return Err(ApiError::refused(words));
    }
    Ok(())
}

fn check_pictures(count: usize, formats: &[Kind], size_px: PictureSize) -> Result<(), ApiError> {
    let kinds = formats.iter().filter(|format| matches!(format, Kind::Picture(_))).count();
    if kinds == 0 {
        return Ok(());
    }
    let each = u64::from(size_px.width) * u64::from(size_px.height);
    check_rays(each, Sampling::default())?;
    let pixels = each * (count * kinds) as u64;
    if pixels > limit::ARCHIVE_PIXELS {
        let words = format!(
            "the pictures have {pixels} pixels; at most {} are allowed: ask for smaller or fewer",
            limit::ARCHIVE_PIXELS
        );
        return Err(ApiError::refused(words));
    }
    Ok(())
}

fn framing(app: &App, scene: SceneId, size_px: PictureSize, format: PictureFormat) -> Framing {
    Framing {
        scene,
        light_deg: None,
        size_px,
        sampling: Sampling::default(),
        area: None,
        format,
        backend: app.backend,
    }
}

/// Returns the name of an individual's files without ending, as of single downloads; a longer hash
/// or a number if another individual has it.
fn unique(taken: &mut HashSet<String>, name: &str, hash: GenomeHash) -> String {
    let (slug, hash) = (file_name::slug(name), hash.to_string());
    let marked = [&hash[..4], &hash[..12]].map(|mark| format!("{slug}-{mark}"));
    let numbered = (2..).map(|number| format!("{slug}-{}-{number}", &hash[..12]));
    let name = marked.into_iter().chain(numbered).find(|name| !taken.contains(name));
    let name = name.expect("numbers do not end");
    taken.insert(name.clone());
    name
}

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

type Writer = ZipWriter<StreamWriter<Sink>>;

/// Streams the file. An error ends the stream, so that the client sees a broken transfer.
fn written(
    app: App,
    entries: Vec<(String, What)>,
) -> impl Stream<Item = Result<Bytes, io::Error>> + Send {
    try_stream! {
        let sink = Sink::default();
        let mut writer = ZipWriter::new_stream(sink.clone());
        let making = entries.into_iter().map(|(name, what)| {
            let app = app.clone();
            async move { made(&app, what).await.map(|bytes| (name, bytes)) }
        });
        let mut made = std::pin::pin!(stream::iter(making).buffered(AT_ONCE));
        while let Some(entry) = made.next().await {
            let (name, bytes) = entry.map_err(broken)?;
            writer = run_blocking(move || add(writer, name, &bytes)).await.map_err(broken)??;
            yield sink.take();
        }
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

async fn made(app: &App, what: What) -> Result<Bytes, ApiError> {
    match what {
        What::Text(hash) => Ok(app.library.material(hash).await?.genome.to_string().into()),
        What::Source(hash, format, limited) => {
            Ok(export::bytes(app, hash, format, limited, Within::default()).await?.into())
        }
        What::Picture(one, view) => {
            let framed = app.library.frame(view).await?;
            let material = app.library.material(one.hash).await?;
            let key = framed.key(material.program.hash());
            let row = app.pictures.store_row(framed.row(key, one.hash)).await?;
            let mut waits = 1;
            loop {
                match app.pictures.get(&row).await {
                    Err(error) if error.status() == 503 && waits < WAITS => {
                        waits += 1;
                        tokio::time::sleep(Duration::from_secs(1)).await;
                    }
                    other => return other,
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_differ_when_lineages_and_hashes_begin_alike() {
        let mut taken = HashSet::new();
        let hash = |last: u8| {
            let mut bytes = [7; 32];
            bytes[31] = last;
            GenomeHash::from_bytes(bytes)
        };
        let names: Vec<_> = (0..5).map(|n| unique(&mut taken, "Matt Clay", hash(n % 2))).collect();
        assert_eq!(names[0], "matt-clay-0707");
        assert_eq!(names[1], "matt-clay-070707070707");
        assert_eq!(taken.len(), 5, "{names:?}");
        assert_eq!(names[4], "matt-clay-070707070707-4");
    }

    #[test]
    fn pictures_are_refused_when_they_have_too_many_pixels_together() {
        let formats = formats("png, brood,png,wgsl").unwrap();
        assert_eq!(formats.len(), 3);
        assert!(check_pictures(128, &formats, 512.into()).is_ok());
        assert_eq!(check_pictures(129, &formats, 512.into()).unwrap_err().status(), 422);
        assert!(check_pictures(1000, &formats[1..], 512.into()).is_ok());
    }
}
