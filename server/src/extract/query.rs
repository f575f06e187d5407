//! Strict query parameters, and pages of lists.

use axum::extract::FromRequestParts;
use brood_protocol::Page;
use http::request::Parts;
use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::NUL;
use crate::limit;
use crate::problem::{ApiError, quote, serde_words};

/// Parsed query. Unknown names, duplicates and bad values are refused, as is U+0000, which
/// PostgreSQL refuses.
#[derive(Debug, Clone)]
pub struct Query<T>(pub T);

impl<T: DeserializeOwned, S: Send + Sync> FromRequestParts<S> for Query<T> {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, ApiError> {
        if parts.uri.query().is_some_and(|query| query.contains(NUL)) {
            let words = "a query parameter must not contain the character U+0000";
            return Err(ApiError::bad_request(words));
        }
        let query = axum::extract::Query::<T>::try_from_uri(&parts.uri);
        query.map(|query| Self(query.0)).map_err(|error| {
            let words = error.body_text();
            let words = words.strip_prefix("Failed to deserialize query string: ");
            ApiError::bad_request(match words {
                Some(words) => query_words(words),
                None => "the query string is malformed".to_owned(),
            })
        })
    }
}

/// Returns serde's message about a query with the name of the parameter, and without the words of
/// the parsers of numbers and ids.
fn query_words(message: &str) -> String {
    let Some((name, words)) = message.split_once(": ") else {
        return format!("query: {}", serde_words(message));
    };
    if words.starts_with("unknown field ") {
        return format!("query: {}", serde_words(words));
    }
    let words = match words {
        "invalid float literal" => "must be a number".to_owned(),
        "provided string was not `true` or `false`" => "must be true or false".to_owned(),
        _ if words.starts_with("UUID parsing failed") => "must be an id".to_owned(),
        _ if words.contains("digit found in string") || words.contains("number too ") => {
            "must be a whole number, at least 0 and not too large".to_owned()
        }
        _ if words.starts_with("cannot parse ") => "must not be empty".to_owned(),
        _ => serde_words(words),
    };
    format!("query parameter `{}`: {words}", quote(name))
}

/// Page of a list.
#[derive(Debug, Clone, Default, PartialEq, Eq, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct PageQuery {
    /// `next` of the previous page.
    #[serde(default)]
    pub cursor: Option<String>,
    /// Items per page, 1 to 200; default 50.
    #[serde(default)]
    #[param(minimum = 1, maximum = 200)]
    pub limit: Option<u32>,
}

impl PageQuery {
    /// Returns the number of items.
    ///
    /// # Errors
    /// 400 if it is out of range.
    pub fn limit(&self) -> Result<u32, ApiError> {
        let limit = self.limit.unwrap_or(limit::PAGE_DEFAULT);
        if !(1..=limit::PAGE).contains(&limit) {
            let words = format!("must be 1 to {}, got {limit}", limit::PAGE);
            return Err(ApiError::bad_parameter("limit", words));
        }
        Ok(limit)
    }

    /// Returns the cursor.
    ///
    /// # Errors
    /// 400 if it is malformed.
    pub fn cursor<C: std::str::FromStr>(&self) -> Result<Option<C>, ApiError> {
        let malformed = |_| ApiError::bad_parameter("cursor", "must be the `next` of a page");
        self.cursor.as_deref().map(str::parse).transpose().map_err(malformed)
    }
}

/// Makes a page of at most `limit` of the items; an extra item means that the list continues.
pub fn page<T, U>(
    mut items: Vec<T>,
    limit: u32,
    cursor: impl Fn(&T) -> String,
    present: impl FnMut(T) -> U,
) -> Page<U> {
    let limit = limit as usize;
    let next = (items.len() > limit).then(|| cursor(&items[limit - 1]));
    items.truncate(limit);
    Page { items: items.into_iter().map(present).collect(), next }
}

#[cfg(test)]
mod tests {
    use super::*;

    async fn read(query: &str) -> Result<PageQuery, u16> {
        let uri = format!("http://localhost/v1/lineages?{query}");
        let (mut parts, ()) = http::Request::builder().uri(uri).body(()).unwrap().into_parts();
        let query = Query::<PageQuery>::from_request_parts(&mut parts, &()).await;
        query.map(|query| query.0).map_err(|error| error.status())
    }

    #[tokio::test]
    async fn query_is_refused_when_a_parameter_is_unknown_or_bad() {
        assert_eq!(read("limit=7").await.unwrap().limit().unwrap(), 7);
        assert_eq!(read("colour=red").await, Err(400));
        assert_eq!(read("limit=x").await, Err(400));
        assert_eq!(read("limit=1&limit=2").await, Err(400));
        assert_eq!(read("cursor=a%00b").await, Err(400));
        assert!(read("limit=0").await.unwrap().limit().is_err());
        assert!(read("limit=201").await.unwrap().limit().is_err());
    }

    #[derive(Debug, Default, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    struct Anything {
        count: u8,
        share: f64,
        all: bool,
        id: Option<uuid::Uuid>,
        operator: Option<Operator>,
    }

    #[derive(Debug, Deserialize)]
    #[serde(rename_all = "lowercase")]
    enum Operator {
        Mutate,
        Adopt,
    }

    #[test]
    fn errors_name_the_parameter_and_what_it_must_be() {
        for (query, words) in [
            (
                "count=x",
                "query parameter `count`: must be a whole number, at least 0 and not too large",
            ),
            (
                "count=-1",
                "query parameter `count`: must be a whole number, at least 0 and not too large",
            ),
            (
                "count=256",
                "query parameter `count`: must be a whole number, at least 0 and not too large",
            ),
            ("count=", "query parameter `count`: must not be empty"),
            ("share=x", "query parameter `share`: must be a number"),
            ("share=", "query parameter `share`: must not be empty"),
            ("all=1", "query parameter `all`: must be true or false"),
            ("id=7", "query parameter `id`: must be an id"),
            (
                "operator=x",
                "query parameter `operator`: unknown variant `x`, expected `mutate` or `adopt`",
            ),
            ("count=1&count=2", "query: duplicate field `count`"),
        ] {
            let uri = format!("http://localhost/?{query}").parse().unwrap();
            let error = axum::extract::Query::<Anything>::try_from_uri(&uri).unwrap_err();
            let message = error.body_text();
            let message = message.strip_prefix("Failed to deserialize query string: ").unwrap();
            assert_eq!(query_words(message), words);
        }
        let uri = "http://localhost/?side=1".parse().unwrap();
        let error = axum::extract::Query::<Anything>::try_from_uri(&uri).unwrap_err();
        let message = error.body_text();
        let message = message.strip_prefix("Failed to deserialize query string: ").unwrap();
        assert!(query_words(message).starts_with("query: unknown field `side`, expected one of "));
    }

    #[test]
    fn page_has_a_cursor_when_the_list_goes_on() {
        let full = page(vec![1, 2, 3], 2, i32::to_string, |n| n);
        assert_eq!((full.items, full.next), (vec![1, 2], Some("2".to_owned())));
        let last = page(vec![1, 2], 2, i32::to_string, |n| n);
        assert_eq!((last.items, last.next), (vec![1, 2], None));
    }
}
