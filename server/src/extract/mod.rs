//! Request extractors: bodies, queries, paths and preconditions, each with an error that names the
//! invalid part.

mod body;
mod body_budget;
mod if_match;
mod json;
mod multipart;
mod objects;
mod path;
mod query;
mod strict;

/// U+0000 as it is written in an address.
const NUL: &str = "%00";

pub use body::{ContentType, read_body, read_message, read_upload};
pub use if_match::{IfMatch, etag};
pub use json::{Json, parse_json, parse_value};
pub use multipart::{Parts, boundary as multipart_boundary};
pub use path::Path;
pub use query::{PageQuery, Query, page};
