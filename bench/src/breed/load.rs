//! Load beside which broods are timed: long work that other clients ask for at the same time.

use std::sync::Arc;
use std::time::Duration;

use brood_protocol::{Generation, IndividualId, Lineage};
use serde_json::{Value, json};
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};

use crate::api::Api;

/// Time after which the clients of animations leave.
const PATIENCE: Duration = Duration::from_millis(1500);
/// Wait after a refusal.
const AGAIN: Duration = Duration::from_millis(200);

/// Kind of load.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Load {
    /// 20 clients with pictures of about 2048 px, 4 samples
    Pictures,
    /// 4 clients with broods of 256 under the energy limit
    Broods,
    /// 6 clients that ask for animations of 120 pictures and leave after 1.5 s
    Animations,
}

impl Load {
    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pictures => "pictures",
            Self::Broods => "broods",
            Self::Animations => "animations",
        }
    }

    /// Starts the clients. They end when the set is dropped.
    pub fn begin(self, api: &Arc<Api>, generation: &Generation) -> JoinSet<()> {
        let clients = match self {
            Self::Pictures => 20,
            Self::Broods => 4,
            Self::Animations => 6,
        };
        let children: Vec<_> = generation.individuals.iter().map(|one| one.id).collect();
        let mut set = JoinSet::new();
        for number in 0..clients {
            let child = children[number % children.len()];
            set.spawn(self.client(api.clone(), child, number));
        }
        set
    }

    async fn client(self, api: Arc<Api>, child: IndividualId, number: usize) {
        let mut lineage = None;
        // Each request has another size or seed, so that none is answered from a cache.
        for round in number.. {
            let done = match self {
                Self::Pictures => {
                    let size = 2048 - round % 512;
                    let path = format!("/v1/individuals/{child}/render.png?size={size}&samples=4");
                    api.read(&path).await
                }
                Self::Animations => {
                    let size = 512 - round % 128;
                    let path =
                        format!("/v1/individuals/{child}/render.apng?frames=120&size={size}");
                    timeout(PATIENCE, api.read(&path)).await.unwrap_or(Ok(()))
                }
                Self::Broods => large_brood(&api, &mut lineage).await,
            };
            if done.is_err() {
                sleep(AGAIN).await;
            }
        }
    }
}

/// Breeds a large brood in a lineage of its own.
async fn large_brood(api: &Api, lineage: &mut Option<Lineage>) -> anyhow::Result<()> {
    let own = match lineage {
        Some(own) => own,
        None => {
            let body = json!({ "name": "load", "start": "wild", "energy_limit": true });
            lineage.insert(api.post("/v1/lineages", &body).await?.0)
        }
    };
    let path = format!("/v1/lineages/{}/generations", own.id);
    api.post::<Value>(&path, &json!({ "count": 256, "energy_limit": true })).await?;
    Ok(())
}
