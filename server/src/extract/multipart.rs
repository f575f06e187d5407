//! Zero-copy parser of `multipart/form-data` bodies: the parts are views of the body.

use bytes::Bytes;
use http::{HeaderMap, header};
use memchr::memmem;

use super::ContentType;
use crate::problem::{ApiError, quote};

/// Most parts of a body: a target of 16 pictures with their masks and the spec.
const MOST_PARTS: usize = 33;
/// Longest head of a part, in bytes.
const HEAD_BYTES: usize = 4096;
/// Longest boundary that the format allows, in bytes.
const BOUNDARY_BYTES: usize = 70;

/// Returns the boundary that a request declares.
///
/// # Errors
/// 415 if the body is not multipart, 400 if there is no valid boundary.
pub fn boundary(headers: &HeaderMap) -> Result<String, ApiError> {
    ContentType::of(headers).require(&["multipart/form-data"])?;
    let value = headers.get(header::CONTENT_TYPE).and_then(|value| value.to_str().ok());
    let mut parameters = value.unwrap_or_default().split(';').skip(1);
    let boundary = parameters.find_map(|parameter| {
        let (name, value) = parameter.split_once('=')?;
        let is_it = name.trim().eq_ignore_ascii_case("boundary");
        is_it.then(|| value.trim().trim_matches('"').to_owned())
    });
    boundary.filter(|boundary| (1..=BOUNDARY_BYTES).contains(&boundary.len())).ok_or_else(|| {
        ApiError::bad_request("the content type must have a boundary of 1 to 70 bytes")
    })
}

/// Parts of a body by name; names are unique.
#[derive(Debug)]
pub struct Parts {
    parts: Vec<(String, Bytes)>,
}

impl Parts {
    /// Parses a body.
    ///
    /// # Errors
    /// 400 if it is malformed or has two parts of one name.
    pub fn of(boundary: &str, body: &Bytes) -> Result<Self, ApiError> {
        let mut parts: Vec<(String, Bytes)> = Vec::new();
        for (name, bytes) in split(boundary, body)? {
            if parts.iter().any(|(known, _)| *known == name) {
                let words = format!("there are two parts {}", quote(&name));
                return Err(ApiError::bad_request(words));
            }
            parts.push((name, bytes));
        }
        Ok(Self { parts })
    }

    /// Returns the part of this name, if any.
    pub fn get(&self, name: &str) -> Option<&Bytes> {
        self.parts.iter().find(|(known, _)| known == name).map(|(_, bytes)| bytes)
    }

    /// Returns the part of this name.
    ///
    /// # Errors
    /// 400 if there is none.
    pub fn need(&self, name: &str) -> Result<&Bytes, ApiError> {
        let missing = || ApiError::bad_request(format!("there is no part {}", quote(name)));
        self.get(name).ok_or_else(missing)
    }

    /// Checks that all parts have one of these names.
    ///
    /// # Errors
    /// 400 if a part has another name.
    pub fn only(&self, names: &[&str]) -> Result<(), ApiError> {
        match self.parts.iter().find(|(name, _)| !names.contains(&name.as_str())) {
            None => Ok(()),
            Some((name, _)) => {
                let known: Vec<String> = names.iter().map(|name| quote(name)).collect();
                let (name, known) = (quote(name), known.join(", "));
                let words = format!("there is a part {name}; allowed are {known}");
                Err(ApiError::bad_request(words))
            }
        }
    }

    /// Iterates over all parts in the order of the body.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Bytes)> {
        self.parts.iter().map(|(name, bytes)| (name.as_str(), bytes))
    }
}

fn split(boundary: &str, body: &Bytes) -> Result<Vec<(String, Bytes)>, ApiError> {
    let broken = || ApiError::bad_request("the body must be complete multipart/form-data");
    let delimiter = format!("\r\n--{boundary}");
    // The first delimiter may stand at the start of the body, without a line break before it.
    let first = &delimiter.as_bytes()[2..];
    let mut at = match body.strip_prefix(first) {
        Some(_) => first.len(),
        None => memmem::find(body, delimiter.as_bytes()).ok_or_else(broken)? + delimiter.len(),
    };
    let finder = memmem::Finder::new(delimiter.as_bytes());
    let mut parts = Vec::new();
    loop {
        let rest = &body[at..];
        if rest.starts_with(b"--") {
            return Ok(parts);
        }
        if parts.len() == MOST_PARTS || !rest.starts_with(b"\r\n") {
            return Err(broken());
        }
        let head = &rest[..rest.len().min(HEAD_BYTES)];
        let end = memmem::find(head, b"\r\n\r\n").ok_or_else(broken)?;
        let name = name(&head[..end]).ok_or_else(broken)?;
        let begin = at + end + 4;
        let length = finder.find(&body[begin..]).ok_or_else(broken)?;
        parts.push((name, body.slice(begin..begin + length)));
        at = begin + length + delimiter.len();
    }
}

/// Returns the name in a part's head.
fn name(head: &[u8]) -> Option<String> {
    let head = std::str::from_utf8(head).ok()?;
    let disposition = head.lines().find_map(|line| {
        let (name, value) = line.split_once(':')?;
        name.trim().eq_ignore_ascii_case("content-disposition").then_some(value)
    })?;
    let mut parameters = disposition.split(';').skip(1);
    parameters.find_map(|parameter| {
        let (name, value) = parameter.split_once('=')?;
        let is_it = name.trim().eq_ignore_ascii_case("name");
        is_it.then(|| value.trim().trim_matches('"').to_owned())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(text: &str) -> Bytes {
        Bytes::from(text.replace('\n', "\r\n"))
    }

    const FORM: &str = "--b\nContent-Disposition: form-data; name=\"spec\"\n\n{}\n--b\n\
        content-disposition: form-data; name=\"file\"; filename=\"a; name=x.csv\"\n\
        Content-Type: text/csv\n\n1\n--bogus\n2\n--b--\n";

    #[test]
    fn parts_are_found_by_name_and_unchanged() {
        let body = Bytes::from(FORM.replace('\n', "\r\n").replace("--bogus", "-- b"));
        let parts = Parts::of("b", &body).unwrap();
        let (file, spec) = (parts.need("file").unwrap(), parts.need("spec").unwrap());
        assert_eq!((&file[..], &spec[..]), (&b"1\r\n-- b\r\n2"[..], &b"{}"[..]));
        let names: Vec<&str> = parts.iter().map(|(name, _)| name).collect();
        assert_eq!(names, ["spec", "file"]);
    }

    #[test]
    fn body_is_refused_when_it_is_broken_or_has_other_parts() {
        let whole = body(&FORM.replace("--bogus", "x"));
        let parts = Parts::of("b", &whole).unwrap();
        assert!(parts.only(&["file", "spec"]).is_ok());
        assert!(parts.only(&["file"]).is_err() && parts.need("more").is_err());
        for end in [0, 3, 40, 80, whole.len() - 5] {
            assert!(Parts::of("b", &whole.slice(..end)).is_err(), "{end}");
        }
        assert!(Parts::of("c", &whole).is_err());
        let twice = body(&FORM.replace("--bogus", "x").replace("name=\"spec\"", "name=\"file\""));
        assert!(Parts::of("b", &twice).is_err());
        let many = "--b\nContent-Disposition: form-data; name=\"NAME\"\n\n1\n";
        let many = (0..=MOST_PARTS).map(|k| many.replace("NAME", &k.to_string()));
        assert!(Parts::of("b", &body(&(many.collect::<String>() + "--b--\n"))).is_err());
    }

    #[test]
    fn boundary_is_read_with_and_without_quotes() {
        let of = |value: &'static str| {
            let mut headers = HeaderMap::new();
            headers.insert(header::CONTENT_TYPE, value.parse().unwrap());
            boundary(&headers).map_err(|error| error.status())
        };
        assert_eq!(of("multipart/form-data; boundary=abc"), Ok("abc".to_owned()));
        assert_eq!(of("Multipart/Form-Data; charset=x; Boundary=\"a-b\""), Ok("a-b".to_owned()));
        assert_eq!(of("multipart/form-data"), Err(400));
        assert_eq!(of("application/json"), Err(415));
    }
}
