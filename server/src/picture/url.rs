//! URLs of pictures.

use brood_protocol::PictureKey;

/// Returns the URL of a thumbnail.
pub fn thumbnail_url(key: PictureKey) -> String {
    format!("/v1/thumbnails/{key}.png")
}
