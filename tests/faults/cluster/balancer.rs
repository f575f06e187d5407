//! Requests as a person's page sends them through the balancer of `packaging/haproxy.cfg`: servers
//! that are not ready get none, a broken request is sent to another server with the same key, and
//! the page repeats what was refused.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use brood_tests::http_client;
use reqwest::{Client, Method};
use serde_json::Value;
use tokio::sync::watch;

/// Interval of checks, and the longest time for an answer to one.
const CHECK: Duration = Duration::from_millis(500);
/// Interval of checks of a server that has failed one.
const FAST_CHECK: Duration = Duration::from_millis(200);
/// Number of failed checks after which a server gets no requests.
const FALL: u32 = 2;
const CONNECT: Duration = Duration::from_secs(1);
/// Number of times that the balancer sends a broken request again.
const RETRIES: u32 = 3;
/// Number of attempts of the page. After them a person has to click.
const ATTEMPTS: u32 = 5;
/// Number of attempts of the page within [`EARLY`] of the first.
const EARLY_ATTEMPTS: u32 = 9;
/// Time in which the page makes more attempts.
const EARLY: Duration = Duration::from_secs(10);
/// Longest wait of the page without `Retry-After`.
const LONGEST_BACKOFF: Duration = Duration::from_secs(1);
/// Longest wait of the page that a server can ask for.
const LONGEST_PAUSE: Duration = Duration::from_secs(5);
/// Time from which the attempts of a request are printed.
const SLOW: Duration = Duration::from_secs(3);
/// Time after which a request without a success fails the test.
const LIMIT: Duration = Duration::from_secs(120);

/// Request that can be sent again.
#[derive(Debug, Clone)]
pub struct Call {
    /// Method.
    pub method: Method,
    /// Path with query.
    pub path: String,
    /// Idempotency key.
    pub key: Option<String>,
    /// Media type and bytes of the body.
    pub body: Option<(String, Vec<u8>)>,
}

impl Call {
    /// Returns a GET.
    pub fn get(path: impl Into<String>) -> Self {
        Self { method: Method::GET, path: path.into(), key: None, body: None }
    }

    /// Returns a POST of JSON with a key.
    pub fn post(path: impl Into<String>, key: String, body: &Value) -> Self {
        let body = Some(("application/json".to_owned(), body.to_string().into_bytes()));
        Self { method: Method::POST, path: path.into(), key: Some(key), body }
    }
}

/// Success of a call.
#[derive(Debug)]
pub struct Reply {
    /// Body.
    pub body: Vec<u8>,
    /// Number of times that a person would have clicked.
    pub clicks: u32,
}

impl Reply {
    /// Returns the body as JSON.
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap()
    }
}

/// Answer to one attempt: status, wanted pause, body.
type Answer = (u16, Option<Duration>, Vec<u8>);

/// Balancer before servers.
pub struct Balancer {
    client: Client,
    token: Option<String>,
    servers: Vec<(String, watch::Sender<bool>)>,
    faults: Mutex<BTreeMap<String, u32>>,
}

impl Balancer {
    /// Starts to check the servers at these addresses.
    pub fn start(addresses: &[String], token: Option<String>) -> Arc<Self> {
        let client = http_client().connect_timeout(CONNECT).build().unwrap();
        let servers = addresses.iter().map(|address| (address.clone(), watch::Sender::new(false)));
        let (servers, faults) = (servers.collect(), Mutex::default());
        let balancer = Arc::new(Self { client, token, servers, faults });
        for index in 0..balancer.servers.len() {
            tokio::spawn(check(Arc::downgrade(&balancer), index));
        }
        balancer
    }

    /// Number of servers.
    pub fn count(&self) -> usize {
        self.servers.len()
    }

    /// Returns the answers with status 500 by their text, with their numbers. They are repeated,
    /// but an outage must be answered with 503.
    pub fn faults(&self) -> BTreeMap<String, u32> {
        self.faults.lock().unwrap().clone()
    }

    /// True if this server is ready now.
    pub async fn is_ready(&self, index: usize) -> bool {
        let url = format!("http://{}/readyz", self.servers[index].0);
        let answer = self.client.get(url).timeout(CHECK).send().await;
        answer.is_ok_and(|answer| answer.status() == 200)
    }

    /// Waits until this server gets requests.
    pub async fn until_up(&self, index: usize) {
        let mut is_up = self.servers[index].1.subscribe();
        let is_up = tokio::time::timeout(LIMIT, is_up.wait_for(|is_up| *is_up)).await;
        assert!(is_up.is_ok_and(|is_up| is_up.is_ok()), "server {index} does not become ready");
    }

    /// Sends a request to the first server that is up, in turn from `first`, until it succeeds.
    pub async fn send(&self, first: usize, call: &Call) -> Reply {
        let (start, mut clicks, mut trail) = (Instant::now(), 0, String::new());
        loop {
            let mut last = None;
            let began = Instant::now();
            for attempt in 1.. {
                let first = first + attempt as usize - 1;
                let (status, pause, body) = self.attempt(first, call, start, &mut trail).await;
                match status {
                    200..300 => {
                        if start.elapsed() > SLOW {
                            let seconds = start.elapsed().as_secs_f64();
                            println!("{} {}: {seconds:.1} s:{trail}", call.method, call.path);
                        }
                        return Reply { body, clicks };
                    }
                    409 if call.method == Method::POST => {}
                    429 | 502 | 503 | 504 => {}
                    500 => self.note_fault(call, &body),
                    _ => panic!("{call:?}: {status} {}", String::from_utf8_lossy(&body)),
                }
                last = Some((status, String::from_utf8_lossy(&body).into_owned()));
                let most = if began.elapsed() < EARLY { EARLY_ATTEMPTS } else { ATTEMPTS };
                if attempt >= most {
                    break;
                }
                let own = Duration::from_millis(250 << attempt).min(LONGEST_BACKOFF);
                tokio::time::sleep(pause.map_or(own, |pause| pause.min(LONGEST_PAUSE))).await;
            }
            clicks += 1;
            assert!(start.elapsed() < LIMIT, "no success of {call:?} in {LIMIT:?}: {last:?}");
        }
    }

    fn note_fault(&self, call: &Call, body: &[u8]) {
        let problem: Value = serde_json::from_slice(body).unwrap_or_default();
        // Ids differ.
        let place = call.path.split('/').take(3).collect::<Vec<_>>().join("/");
        let words = format!("{} {place}: {}", call.method, problem["detail"]);
        *self.faults.lock().unwrap().entry(words).or_default() += 1;
    }

    /// Sends a request as the balancer does; 503 and 502 are its own answers.
    async fn attempt(
        &self,
        first: usize,
        call: &Call,
        start: Instant,
        trail: &mut String,
    ) -> Answer {
        for retry in 0..=RETRIES {
            let turn = (0..self.servers.len())
                .map(|step| (first + retry as usize + step) % self.servers.len());
            let Some(index) = turn.into_iter().find(|index| *self.servers[*index].1.borrow())
            else {
                return (503, None, b"no server is ready".to_vec());
            };
            let answer = self.send_once(index, call).await;
            let status = answer.as_ref().map_or(0, |answer| answer.0);
            // A broken connection is 0.
            let seconds = start.elapsed().as_secs_f64();
            let _ = write!(trail, " server {index} {status} at {seconds:.1} s;");
            if let Some(answer) = answer {
                return answer;
            }
        }
        (502, None, b"every server broke the connection".to_vec())
    }

    /// Sends a request to one server; `None` if the connection breaks or the server falls.
    async fn send_once(&self, index: usize, call: &Call) -> Option<Answer> {
        let (address, is_up) = &self.servers[index];
        let mut request =
            self.client.request(call.method.clone(), format!("http://{address}{}", call.path));
        if let Some(token) = &self.token {
            request = request.header("authorization", format!("Bearer {token}"));
        }
        if let Some(key) = &call.key {
            request = request.header("idempotency-key", key);
        }
        if let Some((kind, body)) = &call.body {
            request = request.header("content-type", kind).body(body.clone());
        }
        let answer = async {
            let response = request.send().await.ok()?;
            let pause = response.headers().get("retry-after");
            let pause = pause.and_then(|pause| pause.to_str().ok()?.parse().ok());
            let status = response.status().as_u16();
            let body = response.bytes().await.ok()?.to_vec();
            Some((status, pause.map(Duration::from_secs), body))
        };
        let mut is_up = is_up.subscribe();
        tokio::select! {
            answer = answer => answer,
            _ = is_up.wait_for(|is_up| !*is_up) => None,
        }
    }
}

/// Checks a server as long as the balancer exists.
async fn check(balancer: std::sync::Weak<Balancer>, index: usize) {
    let mut failures = FALL;
    while let Some(balancer) = balancer.upgrade() {
        let is_ready = balancer.is_ready(index).await;
        failures = if is_ready { 0 } else { failures + 1 };
        let is_up = &balancer.servers[index].1;
        is_up.send_if_modified(|is_up| {
            let before = *is_up;
            *is_up = if *is_up { failures < FALL } else { is_ready };
            before != *is_up
        });
        drop(balancer);
        tokio::time::sleep(if is_ready { CHECK } else { FAST_CHECK }).await;
    }
}
