//! Files of the page: embedded in the binary and bundled, or read from a directory during
//! development.
//!
//! `/` of the embedded page loads one script and one style sheet, whose names contain their hash,
//! so that browsers keep them. The modules stay at their addresses, and `/web/index.html` loads
//! them one by one.

use std::borrow::Cow;
use std::path::{Component, Path as FilePath};
use std::sync::LazyLock;

use axum::extract::State;
use axum::response::Response;
use bytes::Bytes;
use http::HeaderMap;
use rust_embed::RustEmbed;

use super::file::{FileHead, IMMUTABLE};
use crate::bundle::{BundleError, bundle};
use crate::extract::Path;
use crate::problem::ApiError;
use crate::processors::run_blocking;
use crate::state::App;

const CACHE: &str = "no-cache";
/// `Cache-Control` of embedded pictures, which change at most with the binary.
const PICTURE_CACHE: &str = "private, max-age=86400";

#[derive(RustEmbed)]
#[folder = "../web"]
struct Embedded;

/// The page with one script and one style sheet.
struct Bundled {
    index: Bytes,
    /// Name, without the folder, and bytes.
    files: [(String, Bytes); 2],
}

/// `None` if the page cannot be bundled, which a test prevents.
static BUNDLED: LazyLock<Option<Bundled>> = LazyLock::new(|| {
    Bundled::of(&|path| embedded(path).and_then(|bytes| String::from_utf8(bytes.into()).ok()))
        .inspect_err(|error| tracing::error!(%error, "the page is served in modules"))
        .ok()
});

impl Bundled {
    fn of(read: &dyn Fn(&str) -> Option<String>) -> Result<Self, BundleError> {
        let script = bundle("main.js", read)?;
        let (mut style, mut index) = (String::new(), String::new());
        let page = read("index.html").ok_or_else(|| BundleError::missing("index.html"))?;
        let hashed = |text: &str, kind: &str| {
            format!("{}.{kind}", &blake3::hash(text.as_bytes()).to_hex()[..16])
        };
        for line in page.lines() {
            let sheet = line.split_once("rel=\"stylesheet\" href=\"/web/").map(|(_, rest)| rest);
            match sheet.and_then(|rest| rest.split('"').next()) {
                Some(path) => {
                    let sheet = read(path).ok_or_else(|| BundleError::missing(path))?;
                    style.push_str(&sheet);
                }
                None => {
                    index.push_str(line);
                    index.push('\n');
                }
            }
        }
        let (script_name, style_name) = (hashed(&script, "js"), hashed(&style, "css"));
        let links = format!(
            "<link rel=\"stylesheet\" href=\"/web/{style_name}\" />\n    \
             <script type=\"module\" src=\"/web/{script_name}\"></script>"
        );
        let index = index.replace("<script type=\"module\" src=\"/web/main.js\"></script>", &links);
        let files = [(script_name, script.into()), (style_name, style.into())];
        Ok(Self { index: index.into(), files })
    }
}

/// Serves the page.
pub async fn index(State(app): State<App>, headers: HeaderMap) -> Result<Response, ApiError> {
    if app.web_dir.is_none()
        && let Some(page) = run_blocking(|| BUNDLED.as_ref()).await?
    {
        return Ok(head("index.html", &page.index, CACHE)?.answer(&headers, page.index.clone()));
    }
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
    let (bytes, cache) = match &app.web_dir {
        Some(folder) => {
            let is_plain =
                FilePath::new(path).components().all(|c| matches!(c, Component::Normal(_)));
            if !is_plain {
                return Err(missing());
            }
            let file = folder.join(path);
            let read = run_blocking(move || std::fs::read(file)).await?;
            (Bytes::from(read.map_err(|_| missing())?), CACHE)
        }
        None => match run_blocking(|| BUNDLED.as_ref()).await?.and_then(|page| {
            page.files.iter().find(|(name, _)| name == path).map(|(_, bytes)| bytes.clone())
        }) {
            Some(bytes) => (bytes, IMMUTABLE),
            None => (embedded(path).ok_or_else(missing)?, cache_of(path)),
        },
    };
    Ok(head(path, &bytes, cache)?.answer(headers, bytes))
}

fn head(path: &str, bytes: &[u8], cache: &'static str) -> Result<FileHead<'static>, ApiError> {
    let content_type = content_type(path).ok_or_else(missing)?;
    let etag = format!("\"{}\"", &blake3::hash(bytes).to_hex()[..32]);
    Ok(FileHead { etag, content_type, cache })
}

fn missing() -> ApiError {
    ApiError::no_route("the page has no file of this name")
}

fn embedded(path: &str) -> Option<Bytes> {
    Some(match Embedded::get(path)?.data {
        Cow::Borrowed(bytes) => Bytes::from_static(bytes),
        Cow::Owned(bytes) => Bytes::from(bytes),
    })
}

/// `Cache-Control` of an embedded file.
fn cache_of(path: &str) -> &'static str {
    let is_picture = [".png", ".svg"].iter().any(|ending| path.ends_with(ending));
    if is_picture { PICTURE_CACHE } else { CACHE }
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

    #[test]
    fn embedded_page_is_bundled_completely() {
        let page = BUNDLED.as_ref().expect("the page can be bundled");
        let index = std::str::from_utf8(&page.index).unwrap();
        assert!(!index.contains("main.js") && !index.contains("page.css"), "{index}");
        for (name, bytes) in &page.files {
            assert!(index.contains(name) && content_type(name).is_some(), "{index}");
            assert!(bytes.len() > 10_000, "{name}: {} bytes", bytes.len());
        }
        let script = std::str::from_utf8(&page.files[0].1).unwrap();
        for line in script.lines() {
            assert!(!line.starts_with("import ") && !line.starts_with("export "), "{line}");
        }
        assert!(!script.contains(";export"), "no module syntax is left");
    }
}
