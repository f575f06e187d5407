//! Client that breeds one brood after the other in a lineage of its own.

use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use brood_protocol::{IndividualId, Lineage};
use serde::Deserialize;
use serde_json::json;
use tokio::time::sleep;

use super::tally::Tally;
use crate::api::Api;

/// Side of a thumbnail in pixels, the least possible: pictures are not measured.
const THUMBNAIL_PX: u32 = 16;
/// Wait after a refusal, doubled with each further one, and the longest.
const AGAIN: Duration = Duration::from_millis(50);
const LONGEST: Duration = Duration::from_secs(1);

/// Client with a lineage.
pub struct Breeder {
    api: Arc<Api>,
    /// Path of the generations of the lineage.
    path: String,
    /// Number of children of each brood.
    children: u32,
    /// True if the client waits for the pictures of each brood before the next.
    awaits_pictures: bool,
    /// Seed of the first brood; later broods use the numbers after it.
    seed: u64,
}

/// Part of a generation that the client reads.
#[derive(Deserialize)]
struct Born {
    individuals: Vec<BornChild>,
}

#[derive(Deserialize)]
struct BornChild {
    id: IndividualId,
    thumbnail: String,
}

impl Breeder {
    /// Creates the lineage.
    pub async fn new(
        api: Arc<Api>,
        number: u64,
        children: u32,
        awaits_pictures: bool,
    ) -> Result<Self> {
        let body = json!({ "name": format!("throughput {number}"), "thumbnail_px": THUMBNAIL_PX });
        let (lineage, _): (Lineage, _) = api.post("/v1/lineages", &body).await?;
        let path = format!("/v1/lineages/{}/generations", lineage.id);
        Ok(Self { api, path, children, awaits_pictures, seed: number << 32 })
    }

    /// Breeds after `delay` until the measurement is over: a random brood, then each from a child
    /// of the last.
    pub async fn run(self, delay: Duration, tally: Arc<Tally>) -> Result<()> {
        sleep(delay).await;
        let mut parents: Vec<IndividualId> = Vec::new();
        let mut round = 0;
        while !tally.is_over() {
            let seed = self.seed + round;
            let body = json!({ "parents": parents, "count": self.children, "seed": seed });
            let key = format!("brood {round}");
            let start = Instant::now();
            let mut again = AGAIN;
            let born: Born = loop {
                if let Some(born) = self.api.post_once(&self.path, &key, &body).await? {
                    break born;
                }
                again = refused(&tally, again).await;
            };
            tally.born(start.elapsed());
            let last = born.individuals.last().context("a brood has children")?;
            parents = vec![last.id];
            if self.awaits_pictures {
                let mut again = AGAIN;
                while !self.api.read_unless_busy(&last.thumbnail).await? {
                    again = refused(&tally, again).await;
                }
            }
            round += 1;
        }
        Ok(())
    }
}

/// Counts a refusal and waits. Returns the wait after the next one.
async fn refused(tally: &Tally, wait: Duration) -> Duration {
    tally.refused();
    sleep(wait).await;
    (2 * wait).min(LONGEST)
}
