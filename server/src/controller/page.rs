//! Files of the page: embedded in the binary, or read from a directory during development.

use std::path::{Component, Path as FilePath};

use axum::extract::State;
use axum::response::Response;
use bytes::Bytes;
use http::HeaderMap;
use rust_embed::RustEmbed;

use super::file::FileHead;
use crate::extract::Path;
use crate::problem::ApiError;
use crate::processors::run_blocking;
use crate::state::App;

const CACHE: &str = "no-cache";

#[derive(RustEmbed)]
#[folder = "../web"]
struct Embedded;

/// Serves the page.
pub async fn index(State(app): State<App>, headers: HeaderMap) -> Result<Response, ApiError> {
    serve(&app, "index.html", &headers).await
}

/// Serves a file of the page.
pub async fn asset(
    State(app): State<App>,
    Path(path): Path<String>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    serve(&app, &path, &headers).await
}

async fn serve(app: &App, path: &str, headers: &HeaderMap) -> Result<Response, ApiError> {
    let missing = || ApiError::no_route("the page has no file of this name");
    let content_type = content_type(path).ok_or_else(missing)?;
    let bytes = match &app.web_dir {
        Some(folder) => {
            let is_plain =
                FilePath::new(path).components().all(|c| matches!(c, Component::Normal(_)));
            if !is_plain {
                return Err(missing());
            }
            let file = folder.join(path);
            let read = run_blocking(move || std::fs::read(file)).await?;
            Bytes::from(read.map_err(|_| missing())?)
        }
        None => match Embedded::get(path).ok_or_else(missing)?.data {
            std::borrow::Cow::Borrowed(bytes) => Bytes::from_static(bytes),
            std::borrow::Cow::Owned(bytes) => Bytes::from(bytes),
        },
    };
    let etag = format!("\"{}\"", &blake3::hash(&bytes).to_hex()[..32]);
    Ok(FileHead { etag, content_type, cache: CACHE }.answer(headers, bytes))
}

/// Returns the media type of a file of the page; other files in the directory are not served.
fn content_type(path: &str) -> Option<&'static str> {
    if path.split('/').any(|part| part.starts_with('.') || part == "node_modules") {
        return None;
    }
    Some(match path.rsplit_once('.')?.1 {
        "html" => "text/html; charset=utf-8",
        "js" | "mjs" => "text/javascript; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "svg" => "image/svg+xml",
        "png" => "image/png",
        "ico" => "image/x-icon",
        "woff2" => "font/woff2",
        "txt" => "text/plain; charset=utf-8",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_files_of_a_page_are_served() {
        assert_eq!(content_type("main.js"), Some("text/javascript; charset=utf-8"));
        assert_eq!(content_type("vendor/preact.js"), Some("text/javascript; charset=utf-8"));
        for path in ["jsconfig.json", "node_modules/a.js", ".git/a.js", "Makefile", ""] {
            assert_eq!(content_type(path), None, "{path}");
        }
    }
}
