//! Load on the cluster: people who breed and look at pictures, searches whose results are known,
//! and exports.

use std::collections::hash_map::DefaultHasher;
use std::collections::{BTreeMap, HashMap};
use std::hash::Hasher;
use std::io::{Cursor, Read};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use brood_tests::{glossy_csv, ids, text_of, upload};
use reqwest::Method;
use serde_json::{Value, json};
use tokio::sync::RwLock;
use tokio::task::JoinSet;

use super::balancer::{Balancer, Call};
use crate::draw;

/// People who breed.
pub const PEOPLE: usize = 6;
/// Searches at a time; each has its own seed.
const SEARCHES: u64 = 2;
/// Generations of a search.
const GENERATIONS: u32 = 12;
/// Formats of exports.
const FORMATS: [&str; 3] = ["brood", "rgl-bsdf", "wgsl"];
/// Number of generations after which a person starts a new lineage.
const LINEAGE: usize = 200;
/// Pause of a person after a brood and its picture.
const PAUSE: Duration = Duration::from_millis(100);
/// Pause between exports. Each one keeps about 50 MB in the database for a day.
const EXPORT_PAUSE: Duration = Duration::from_secs(10);
/// Longest time for a search or an export, which may lose its worker several times.
const JOB: Duration = Duration::from_secs(240);

/// Acknowledged lineage: hashes of its generations by seed.
#[derive(Debug, Clone)]
pub struct Lineage {
    /// Path of its generations.
    pub path: String,
    /// Hash of each answer that acknowledged a generation, by seed.
    pub births: BTreeMap<u64, u64>,
    /// True if it is complete and was compared.
    pub checked: bool,
}

/// Longest waits of people, and the number of clicks.
#[derive(Debug, Clone, Copy, Default)]
pub struct Waits {
    /// Longest time from the request of a brood to its 201.
    pub brood: Duration,
    /// Longest time from the request of a picture to its bytes.
    pub picture: Duration,
    /// Number of times that a person would have clicked.
    pub clicks: u32,
}

impl Waits {
    /// Adds other waits.
    pub fn add(&mut self, other: Self) {
        self.brood = self.brood.max(other.brood);
        self.picture = self.picture.max(other.picture);
        self.clicks += other.clicks;
    }
}

/// Broods, pictures and searches that the cluster has acknowledged.
#[derive(Default)]
pub struct Record {
    /// Lineages by their number; those of one person are `PEOPLE` apart.
    pub lineages: BTreeMap<usize, Lineage>,
    /// Hash of each picture that was loaded, by address.
    pub pictures: HashMap<String, u64>,
    /// Number of pictures that were loaded.
    pub loaded: u64,
    /// Number of broods of each person.
    pub broods: [u64; PEOPLE],
    /// Number of searches that have ended, the undisturbed ones included.
    pub searches: u64,
    /// Number of exports whose archive was compared.
    pub exports: u64,
    /// Waits since they were last taken.
    pub waits: Waits,
}

/// Running load.
pub struct Load {
    balancer: Arc<Balancer>,
    seed: u64,
    /// Held by each person during a brood; a check holds it alone.
    pub turn: RwLock<()>,
    /// Acknowledged work.
    pub record: Mutex<Record>,
    stopped: AtomicBool,
}

impl Load {
    /// Makes a load that starts with the calls of its methods.
    pub fn new(balancer: Arc<Balancer>, seed: u64) -> Arc<Self> {
        let (turn, record) = (RwLock::default(), Mutex::default());
        Arc::new(Self { balancer, seed, turn, record, stopped: AtomicBool::new(false) })
    }

    /// Starts the people.
    pub fn start(self: &Arc<Self>, tasks: &mut JoinSet<()>) {
        for person in 0..PEOPLE {
            tasks.spawn(Arc::clone(self).breed(person));
        }
    }

    /// Runs searches and an export undisturbed, and then again and again.
    pub async fn start_jobs(self: &Arc<Self>, tasks: &mut JoinSet<()>) {
        let spec = json!({"kind": "samples", "name": "glossy"}).to_string();
        let body = Some(upload(&spec, glossy_csv(600, 1).as_bytes()));
        let path = "/v1/targets".to_owned();
        let call = Call { method: Method::POST, path, key: Some("target".to_owned()), body };
        let target = text_of(&self.balancer.send(0, &call).await.json()["id"]);
        let whole = (1..=SEARCHES).map(|seed| self.search(&target, seed, 0));
        let whole = futures::future::join_all(whole).await;
        let exported = self.exported().await;
        self.note(|record| record.searches += SEARCHES);
        for (seed, whole) in (1..=SEARCHES).zip(whole) {
            tasks.spawn(Arc::clone(self).search_again(target.clone(), seed, whole));
        }
        tasks.spawn(Arc::clone(self).export(exported));
    }

    /// Lets all tasks end after what they have begun.
    pub fn stop(&self) {
        self.stopped.store(true, Ordering::Relaxed);
    }

    fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }

    fn note(&self, change: impl FnOnce(&mut Record)) {
        change(&mut self.record.lock().unwrap());
    }

    /// Breeds in lineages of one person, and loads a picture of each brood from two servers.
    async fn breed(self: Arc<Self>, person: usize) {
        let mut next = draw(self.seed + person as u64);
        let servers = self.balancer.count() as u64;
        let mut number = person;
        let (mut path, mut parents) = (String::new(), Vec::new());
        for count in 0.. {
            if self.is_stopped() {
                return;
            }
            let turn = self.turn.read().await;
            let server = next(servers) as usize;
            if count % LINEAGE == 0 {
                let body = json!({"name": format!("person {person}"), "thumbnail_px": 64});
                let call = Call::post("/v1/lineages", format!("lineage-{number}"), &body);
                let made = self.balancer.send(server, &call).await.json();
                path = format!("/v1/lineages/{}/generations", text_of(&made["id"]));
                let lineage =
                    Lineage { path: path.clone(), births: BTreeMap::new(), checked: false };
                self.note(|record| drop(record.lineages.insert(number, lineage)));
                parents.clear();
                number += PEOPLE;
            }
            let seed = (count * PEOPLE + person) as u64;
            let body = json!({"parents": parents, "count": 4, "seed": seed});
            let call = Call::post(path.as_str(), format!("brood-{seed}"), &body);
            let start = Instant::now();
            let reply = self.balancer.send(server, &call).await;
            let brood = start.elapsed();
            let born = reply.json();
            assert_eq!(born["individuals"].as_array().map(Vec::len), Some(4), "{born}");
            self.note(|record| {
                let lineage = record.lineages.get_mut(&(number - PEOPLE)).unwrap();
                lineage.births.insert(seed, hash_of(&born));
                record.broods[person] += 1;
                record.waits.add(Waits { brood, clicks: reply.clicks, ..Waits::default() });
            });
            parents = ids(&born);
            parents.truncate(next(3) as usize);
            let url = text_of(&born["individuals"][next(4) as usize]["thumbnail"]);
            for other in [0, 1 + next(servers - 1)] {
                let start = Instant::now();
                let reply = self.balancer.send(server + other as usize, &Call::get(&url)).await;
                let waits =
                    Waits { picture: start.elapsed(), clicks: reply.clicks, ..Waits::default() };
                self.note(|record| {
                    record.waits.add(waits);
                    record.loaded += 1;
                    let hash = hash(&reply.body);
                    let first = *record.pictures.entry(url.clone()).or_insert(hash);
                    assert_eq!(first, hash, "{url} has other bytes at another server");
                });
            }
            drop(turn);
            tokio::time::sleep(PAUSE).await;
        }
    }

    /// Runs searches with one seed, and compares each with the undisturbed one.
    async fn search_again(self: Arc<Self>, target: String, seed: u64, whole: Found) {
        for number in 1.. {
            if self.is_stopped() {
                return;
            }
            let found = self.search(&target, seed, number).await;
            assert_eq!(found, whole, "search {number} with seed {seed} has another result");
            self.note(|record| record.searches += 1);
        }
    }

    /// Runs a search.
    async fn search(&self, target: &str, seed: u64, number: u64) -> Found {
        let body = json!({
            "kind": "fit", "target": target, "strategy": "lobes", "generations": GENERATIONS,
            "threads": 1, "seed": seed,
        });
        let call = Call::post("/v1/jobs", format!("search-{seed}-{number}"), &body);
        let first = (seed + number) as usize;
        let id = text_of(&self.balancer.send(first, &call).await.json()["id"]);
        let job = self.until_ended(first, &id).await;
        let log = Call::get(format!("/v1/jobs/{id}/log"));
        let log = String::from_utf8(self.balancer.send(first, &log).await.body).unwrap();
        let line = |line: &str| {
            let mut line: Value = serde_json::from_str(line).unwrap();
            line.as_object_mut().unwrap().remove("seconds");
            line
        };
        let lines: Vec<_> = log.lines().map(line).collect();
        assert_eq!(lines.len(), GENERATIONS as usize, "search {id}: each generation is there once");
        Found {
            population: text_of(&job["population"]),
            best: text_of(&job["best"]["hash"]),
            lines,
        }
    }

    /// Breeds a brood and returns it with its files, by a request.
    async fn exported(&self) -> (String, Vec<Entry>) {
        let call = json!({"name": "exports", "thumbnail_px": 32});
        let call = Call::post("/v1/lineages", "lineage-of-exports".to_owned(), &call);
        let lineage = text_of(&self.balancer.send(0, &call).await.json()["id"]);
        let path = format!("/v1/lineages/{lineage}/generations");
        let body = json!({"parents": [], "count": 1, "seed": 1});
        let call = Call::post(path, "exported".to_owned(), &body);
        let brood = text_of(&self.balancer.send(0, &call).await.json()["id"]);
        let path = format!("/v1/exports.zip?generation={brood}&formats={}", FORMATS.join(","));
        let files = entries(self.balancer.send(0, &Call::get(path)).await.body);
        (brood, files)
    }

    /// Exports a brood now and then, and compares archives of two servers with its files.
    async fn export(self: Arc<Self>, (brood, files): (String, Vec<Entry>)) {
        for number in 0_usize.. {
            if self.is_stopped() {
                return;
            }
            let body = json!({"generation": brood, "formats": FORMATS});
            let call = Call::post("/v1/exports", format!("export-{number}"), &body);
            let id = text_of(&self.balancer.send(number, &call).await.json()["id"]);
            self.until_ended(number, &id).await;
            let archive = Call::get(format!("/v1/jobs/{id}/archive.zip"));
            for server in [number, number + 1] {
                let archive = self.balancer.send(server, &archive).await.body;
                assert!(entries(archive) == files, "export {id} has other files than a request");
            }
            self.note(|record| record.exports += 1);
            tokio::time::sleep(EXPORT_PAUSE).await;
        }
    }

    /// Waits until a job has succeeded, and returns it.
    async fn until_ended(&self, first: usize, id: &str) -> Value {
        let start = Instant::now();
        for turn in 0.. {
            let call = Call::get(format!("/v1/jobs/{id}"));
            let job = self.balancer.send(first + turn, &call).await.json();
            if !["queued", "running"].iter().any(|state| job["state"] == *state) {
                assert_eq!(job["state"], "succeeded", "{job}");
                return job;
            }
            assert!(start.elapsed() < JOB, "stuck: {job}");
            tokio::time::sleep(Duration::from_millis(500)).await;
        }
        unreachable!("the job ends or the loop panics")
    }
}

/// Result of a search.
#[derive(Debug, Clone, PartialEq)]
struct Found {
    population: String,
    best: String,
    /// Log without durations.
    lines: Vec<Value>,
}

/// Name and bytes of a file in an archive.
type Entry = (String, Vec<u8>);

/// Entries of a ZIP file, in order.
fn entries(bytes: Vec<u8>) -> Vec<Entry> {
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
    let entries = (0..archive.len()).map(|index| {
        let mut entry = archive.by_index(index).unwrap();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).unwrap();
        (entry.name().unwrap().into_owned(), bytes)
    });
    entries.collect()
}

/// Hash of bytes.
pub fn hash(bytes: &[u8]) -> u64 {
    let mut hasher = DefaultHasher::new();
    hasher.write(bytes);
    hasher.finish()
}

/// Hash of JSON, independent of the order of fields.
pub fn hash_of(value: &Value) -> u64 {
    hash(value.to_string().as_bytes())
}
