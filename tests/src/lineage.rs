//! Lineage on a test server, and readers of breeding answers. Asserts only the status.

use serde_json::{Value, json};

use crate::TestServer;

/// Lineage with small thumbnails.
pub struct TestLineage<'a> {
    /// Server of the lineage.
    pub server: &'a TestServer,
    /// Id of the lineage.
    pub id: String,
}

impl<'a> TestLineage<'a> {
    /// Creates a lineage with thumbnails of 32 x 32.
    pub async fn new(server: &'a TestServer) -> Self {
        Self::with(server, json!({"name": "first", "thumbnail_px": 32})).await
    }

    /// Creates a lineage from this body.
    pub async fn with(server: &'a TestServer, body: Value) -> Self {
        let made = server.post("/v1/lineages", &body).await.expect(201).json();
        Self { server, id: text_of(&made["id"]) }
    }

    /// Breeds; returns the generation.
    pub async fn breed(&self, body: Value) -> Value {
        self.server.post(&self.path("/generations"), &body).await.expect(201).json()
    }

    /// Breeds a small random brood; returns the generation.
    pub async fn random(&self, seed: u64) -> Value {
        self.breed(json!({"parents": [], "count": 4, "seed": seed})).await
    }

    /// Breeds a small random brood; returns the id of its first child.
    pub async fn random_child(&self, seed: u64) -> String {
        ids(&self.random(seed).await).swap_remove(0)
    }

    /// Returns a route below this lineage.
    #[must_use]
    pub fn path(&self, rest: &str) -> String {
        format!("/v1/lineages/{}{rest}", self.id)
    }
}

/// Returns a JSON string.
///
/// # Panics
/// If the value is not a string.
#[must_use]
#[track_caller]
pub fn text_of(value: &Value) -> String {
    value.as_str().unwrap_or_else(|| panic!("{value} is no string")).to_owned()
}

/// Returns a seed, given as a number or a string.
///
/// # Panics
/// If it is neither.
#[must_use]
#[track_caller]
pub fn seed_of(generation: &Value) -> u64 {
    let seed = &generation["seed"];
    seed.as_u64()
        .or_else(|| seed.as_str()?.parse().ok())
        .unwrap_or_else(|| panic!("{seed} is no seed"))
}

/// Returns the hashes of the children by slot.
#[must_use]
#[track_caller]
pub fn hashes(generation: &Value) -> Vec<String> {
    column(generation, "hash")
}

/// Returns the ids of the children by slot.
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
