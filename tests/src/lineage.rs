//! A lineage on a test server, and readers of what comes back from breeding.
//!
//! Owns the few shapes that most tests share. Refuses to check anything but the status.

use serde_json::{Value, json};

use crate::TestServer;

/// A lineage with small thumbnails.
pub struct TestLineage<'a> {
    /// The server that has it.
    pub server: &'a TestServer,
    /// Its id.
    pub id: String,
}

impl<'a> TestLineage<'a> {
    /// Makes one with thumbnails of 32 x 32.
    pub async fn new(server: &'a TestServer) -> Self {
        Self::with(server, json!({"name": "first", "thumbnail_px": 32})).await
    }

    /// Makes one from this body.
    pub async fn with(server: &'a TestServer, body: Value) -> Self {
        let made = server.post("/v1/lineages", &body).await.expect(201).json();
        Self { server, id: text_of(&made["id"]) }
    }

    /// Breeds, and gives the generation.
    pub async fn breed(&self, body: Value) -> Value {
        self.server.post(&self.path("/generations"), &body).await.expect(201).json()
    }

    /// Breeds a small random brood, and gives the generation.
    pub async fn random(&self, seed: u64) -> Value {
        self.breed(json!({"parents": [], "count": 4, "seed": seed})).await
    }

    /// The route of something below this lineage.
    #[must_use]
    pub fn path(&self, rest: &str) -> String {
        format!("/v1/lineages/{}{rest}", self.id)
    }
}

/// A JSON string.
///
/// # Panics
/// Where it is no string.
#[must_use]
#[track_caller]
pub fn text_of(value: &Value) -> String {
    value.as_str().unwrap_or_else(|| panic!("{value} is no string")).to_owned()
}

/// A seed in either of its forms.
///
/// # Panics
/// Where it is neither.
#[must_use]
#[track_caller]
pub fn seed_of(generation: &Value) -> u64 {
    let seed = &generation["seed"];
    seed.as_u64()
        .or_else(|| seed.as_str()?.parse().ok())
        .unwrap_or_else(|| panic!("{seed} is no seed"))
}

/// Hashes of the children by slot.
#[must_use]
#[track_caller]
pub fn hashes(generation: &Value) -> Vec<String> {
    column(generation, "hash")
}

/// Ids of the children by slot.
#[must_use]
#[track_caller]
pub fn ids(generation: &Value) -> Vec<String> {
    column(generation, "id")
}

#[track_caller]
fn column(generation: &Value, name: &str) -> Vec<String> {
    let children = generation["individuals"].as_array();
    let children = children.unwrap_or_else(|| panic!("no individuals in {generation}"));
    children.iter().map(|child| text_of(&child[name])).collect()
}
