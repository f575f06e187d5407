//! Genomes: storing and reading, as text or JSON.

use axum::Json;
use axum::body::Body;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use brood_eval::express;
use brood_genome::{Genome, GenomeHash, Model, live_instructions};
use brood_storage::NewGenome;
use http::{HeaderMap, HeaderValue, Request, StatusCode, header};

use super::create_once;
use super::file::has_already;
use crate::control_image;
use crate::extract::{Path, parse_json, read_upload};
use crate::idempotency::IdempotencyKey;
use crate::limit;
use crate::problem::ApiError;
use crate::state::App;

/// Media type of a genome's text.
pub const TEXT: &str = "text/x-brood";
const COLLECTION: &str = "/v1/genomes";

/// Hash of a stored genome.
#[derive(Debug, Clone, serde::Serialize, utoipa::ToSchema)]
pub struct GenomeAnswer {
    /// Content hash, 64 hexadecimal digits.
    hash: String,
}

/// Stores a genome.
#[utoipa::path(post, path = "/v1/genomes", operation_id = "create_genome", tag = "genomes",
    request_body(content((serde_json::Value = "application/json"), (String = "text/x-brood"))),
    params(IdempotencyKey),
    responses((status = 201, description = "hash of the genome", body = GenomeAnswer)))]
pub async fn create(
    State(app): State<App>,
    key: IdempotencyKey,
    request: Request<Body>,
) -> Result<Response, ApiError> {
    let types = ["application/json", TEXT];
    let (content_type, bytes) = read_upload(request, &types, limit::JSON_BYTES).await?;
    let is_text = content_type.is(TEXT);
    create_once(&app, key, COLLECTION, bytes.clone(), async |attempt| {
        let parsed = app.processors.run(move || -> Result<_, ApiError> {
            let genome = parse(&bytes, is_text)?;
            let program = express(&genome);
            let live = live_instructions(&genome).into_iter().filter(|live| *live).count();
            Ok((genome, program, live))
        });
        let (genome, program, live) = parsed.await??;
        control_image::check(&app.store, &genome).await?;
        let hash = genome.hash();
        let live = u32::try_from(live).expect("genomes have at most 1024 instructions");
        let new = NewGenome {
            hash,
            bytes: genome.canonical_bytes(),
            program_hash: *program.hash().as_bytes(),
            live_instructions: live,
            layers: genome.layers().iter().map(Model::kind).collect(),
        };
        app.store.put_genome(new).await?;
        app.library.insert_material(hash, genome, program).await;
        let answer = GenomeAnswer { hash: hash.to_string() };
        attempt.store(&app.store, StatusCode::CREATED, &answer).await?;
        Ok(answer)
    })
    .await
}

/// Returns a genome as JSON, or as text if `Accept` asks for `text/x-brood`.
#[utoipa::path(get, path = "/v1/genomes/{hash}", operation_id = "get_genome", tag = "genomes",
    params(("hash" = String, Path, description = "64 hexadecimal digits")),
    responses((status = 200, description = "genome as JSON or text",
        content((serde_json::Value = "application/json"), (String = "text/x-brood"))),
        (status = 304)))]
pub async fn get(
    State(app): State<App>,
    Path(hash): Path<String>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let hash: GenomeHash = hash
        .parse()
        .map_err(|_| ApiError::not_found("a genome hash must be 64 hexadecimal digits"))?;
    let accept = headers.get_all(header::ACCEPT).iter();
    let text = accept.filter_map(|value| value.to_str().ok()).any(|value| value.contains(TEXT));
    let material = app.library.material(hash).await?;
    let etag = format!("\"{hash}{}\"", if text { "-text" } else { "" });
    let mut response = if has_already(&headers, &etag) {
        StatusCode::NOT_MODIFIED.into_response()
    } else if text {
        let content_type = (header::CONTENT_TYPE, "text/x-brood; charset=utf-8");
        ([content_type], material.genome.to_string()).into_response()
    } else {
        Json(material.genome.to_json()).into_response()
    };
    let headers = response.headers_mut();
    headers.insert(header::ETAG, HeaderValue::from_str(&etag).expect("hexadecimal digits"));
    headers.insert(header::VARY, HeaderValue::from_static("accept"));
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("private, no-cache"));
    Ok(response)
}

/// Parses a genome, as text or as JSON.
///
/// # Errors
/// [`ApiError`] with the line or the JSON pointer of the mistake.
pub(super) fn parse(bytes: &[u8], is_text: bool) -> Result<Genome, ApiError> {
    if is_text { from_text(bytes) } else { from_json(bytes) }
}

fn from_text(bytes: &[u8]) -> Result<Genome, ApiError> {
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let good = &bytes[..error.valid_up_to()];
        let line = good.iter().filter(|byte| **byte == b'\n').count() + 1;
        ApiError::bad_genome("the text must be UTF-8")
            .at_line(u32::try_from(line).unwrap_or(u32::MAX), None)
    })?;
    Ok(text.parse::<Genome>()?)
}

fn from_json(bytes: &[u8]) -> Result<Genome, ApiError> {
    Ok(Genome::from_json(parse_json(bytes)?)?)
}
