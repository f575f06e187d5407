//! Tests of claims at several servers, against fake servers that grant exports.

use std::collections::HashMap;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use brood_protocol::{
    ClientError, ExportGrant, ExportRequest, ExportTicket, JobId, WorkerClient, decode, encode,
};
use tokio::sync::{Barrier, mpsc};
use tokio::task::JoinHandle;
use tokio::time::{sleep, timeout};
use tokio_util::sync::CancellationToken;

use crate::claim::{Claims, LONG_POLL_MS, Servers, claim_at_all, preferred};
use crate::lease::{JobKind, WorkerError};
use crate::lease_tests::{Answer, serve};

const CLAIM: &str = "POST /v1/leases/exports";
const FIRST: IpAddr = IpAddr::V4(Ipv4Addr::new(192, 0, 2, 1));
const SECOND: IpAddr = IpAddr::V4(Ipv4Addr::new(192, 0, 2, 2));
/// Interval between resolutions of the name.
const INTERVAL: Duration = Duration::from_millis(20);
/// Longest time of a step of a test.
const LIMIT: Duration = Duration::from_secs(30);

fn grant(job: JobId) -> ExportGrant {
    ExportGrant {
        ticket: ExportTicket { job, epoch: 1 },
        ttl_ms: 20_000,
        energy_limit: None,
        genomes: Vec::new(),
        files: Vec::new(),
    }
}

/// Fake server. A claim without delay is answered with a job of `queued`. A long poll waits until
/// `polls` of all servers have arrived, and is answered with a job of `late`.
struct FakeServer {
    queued: Mutex<Vec<JobId>>,
    late: Mutex<Vec<JobId>>,
    polls: Option<Arc<Barrier>>,
    /// Number of claims that are refused: the server has another version until then.
    refusals: AtomicUsize,
    /// Delays of the claims, in milliseconds.
    waits: Mutex<Vec<u32>>,
    released: Mutex<Vec<JobId>>,
}

impl FakeServer {
    fn new(queued: usize, late: usize, polls: Option<&Arc<Barrier>>) -> Arc<Self> {
        let jobs = |count| Mutex::new((0..count).map(|_| JobId::fresh()).collect());
        Arc::new(Self {
            queued: jobs(queued),
            late: jobs(late),
            polls: polls.cloned(),
            refusals: AtomicUsize::default(),
            waits: Mutex::default(),
            released: Mutex::default(),
        })
    }

    async fn answer(self: Arc<Self>, request: String, body: Vec<u8>) -> Answer {
        if request == CLAIM {
            let ExportRequest { wait_ms, .. } = decode(&body).unwrap();
            self.waits.lock().unwrap().push(wait_ms);
            let less = |left: usize| left.checked_sub(1);
            if self.refusals.fetch_update(Ordering::Relaxed, Ordering::Relaxed, less).is_ok() {
                return (412, b"{}".to_vec());
            }
            let job = if wait_ms == 0 {
                self.queued.lock().unwrap().pop()
            } else {
                if let Some(polls) = &self.polls {
                    polls.wait().await;
                }
                self.late.lock().unwrap().pop()
            };
            if wait_ms > 0 && job.is_none() {
                sleep(Duration::from_millis(5)).await;
            }
            return job.map_or((204, Vec::new()), |job| (200, encode(&grant(job))));
        }
        assert!(request.starts_with("DELETE "), "{request}");
        let ExportTicket { job, .. } = decode(&body).unwrap();
        self.released.lock().unwrap().push(job);
        self.queued.lock().unwrap().push(job);
        (204, Vec::new())
    }

    fn waits(&self) -> Vec<u32> {
        self.waits.lock().unwrap().clone()
    }

    fn released(&self) -> Vec<JobId> {
        self.released.lock().unwrap().clone()
    }
}

/// Name of fake servers, whose addresses may change.
#[derive(Default)]
struct FakeName {
    found: Mutex<Vec<IpAddr>>,
    urls: HashMap<IpAddr, String>,
    resolved: AtomicUsize,
}

impl FakeName {
    async fn new(servers: &[(IpAddr, &Arc<FakeServer>)]) -> Arc<Self> {
        let mut name = Self::default();
        for (address, server) in servers {
            let server = Arc::clone(server);
            let url = serve(move |request, body| server.clone().answer(request, body)).await;
            name.urls.insert(*address, url);
            name.found.lock().unwrap().push(*address);
        }
        Arc::new(name)
    }

    /// Waits until the name has been resolved this number of times.
    async fn rounds(&self, count: usize) {
        let before = self.resolved.load(Ordering::Relaxed);
        until(|| self.resolved.load(Ordering::Relaxed) >= before + count).await;
    }
}

impl Servers for Arc<FakeName> {
    async fn resolve(&self) -> Vec<IpAddr> {
        self.resolved.fetch_add(1, Ordering::Relaxed);
        self.found.lock().unwrap().clone()
    }

    fn client(&self, address: Option<IpAddr>) -> Result<WorkerClient, ClientError> {
        WorkerClient::new(&self.urls[&address.expect("all servers have addresses")], "secret")
    }
}

/// Kind that reports each job that starts, and ends jobs when `end` is cancelled.
#[derive(Clone)]
struct FakeKind {
    started: mpsc::UnboundedSender<JobId>,
    running: Arc<AtomicUsize>,
    /// True if two jobs have run at once.
    has_two: Arc<AtomicBool>,
    end: CancellationToken,
    /// True if the next request panics.
    panics: Arc<AtomicBool>,
}

impl JobKind for FakeKind {
    const HEARTBEAT: Duration = Duration::from_secs(5);
    type Request = ExportRequest;
    type Ticket = ExportTicket;

    fn at(self, _: WorkerClient) -> Self {
        self
    }

    fn name(&self) -> &'static str {
        "fake"
    }

    fn concurrent(&self) -> usize {
        1
    }

    fn request(&self, worker: &str, wait_ms: u32) -> ExportRequest {
        assert!(!self.panics.swap(false, Ordering::Relaxed), "a request panics");
        ExportRequest { worker: worker.to_owned(), wait_ms }
    }

    fn lease(grant: &ExportGrant) -> (JobId, ExportTicket) {
        (grant.ticket.job, grant.ticket)
    }

    async fn run(self, grant: ExportGrant) {
        if self.running.fetch_add(1, Ordering::Relaxed) > 0 {
            self.has_two.store(true, Ordering::Relaxed);
        }
        let _ = self.started.send(grant.ticket.job);
        self.end.cancelled().await;
        self.running.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Worker that claims jobs until it is dropped.
struct FakeWorker {
    started: mpsc::UnboundedReceiver<JobId>,
    end: CancellationToken,
    has_two: Arc<AtomicBool>,
    claims: JoinHandle<Result<(), WorkerError>>,
}

impl FakeWorker {
    fn start(name: &Arc<FakeName>, panics: bool) -> Self {
        let (sender, started) = mpsc::unbounded_channel();
        let kind = FakeKind {
            started: sender,
            running: Arc::default(),
            has_two: Arc::default(),
            end: CancellationToken::new(),
            panics: Arc::new(AtomicBool::new(panics)),
        };
        let (name, end, has_two) = (name.clone(), kind.end.clone(), kind.has_two.clone());
        let claims = Claims::new("test", kind.concurrent(), CancellationToken::new());
        let claim = async move { claim_at_all(&name, &claims, kind, INTERVAL).await };
        Self { started, end, has_two, claims: tokio::spawn(claim) }
    }

    async fn next(&mut self) -> JobId {
        let next = timeout(LIMIT, self.started.recv()).await.unwrap().unwrap();
        assert!(!self.has_two.load(Ordering::Relaxed), "two jobs run at once");
        next
    }
}

impl Drop for FakeWorker {
    fn drop(&mut self) {
        self.claims.abort();
    }
}

/// Waits until a condition holds.
async fn until(condition: impl Fn() -> bool) {
    let wait = async {
        while !condition() {
            sleep(Duration::from_millis(1)).await;
        }
    };
    timeout(LIMIT, wait).await.unwrap();
}

#[tokio::test(flavor = "multi_thread")]
async fn second_grant_is_returned_when_two_servers_grant_at_once() {
    let polls = Arc::new(Barrier::new(2));
    let servers = [FakeServer::new(0, 1, Some(&polls)), FakeServer::new(0, 1, Some(&polls))];
    let name = FakeName::new(&[(FIRST, &servers[0]), (SECOND, &servers[1])]).await;
    let mut worker = FakeWorker::start(&name, false);
    let released = || servers.iter().flat_map(|server| server.released()).collect::<Vec<_>>();
    let job = worker.next().await;
    until(|| !released().is_empty()).await;
    let other = released()[0];
    assert_ne!(job, other);
    // Neither server is asked again while the job runs.
    sleep(Duration::from_millis(100)).await;
    for server in &servers {
        assert_eq!(server.waits(), [0, LONG_POLL_MS]);
    }
    assert!(worker.started.try_recv().is_err());
    // The job that was returned runs after it.
    worker.end.cancel();
    assert_eq!(worker.next().await, other);
    assert_eq!(released(), [other]);
}

#[tokio::test(flavor = "multi_thread")]
async fn servers_are_served_in_turn_when_all_have_jobs() {
    let servers = [FakeServer::new(40, 0, None), FakeServer::new(40, 0, None)];
    let name = FakeName::new(&[(FIRST, &servers[0]), (SECOND, &servers[1])]).await;
    let jobs_of_first = servers[0].queued.lock().unwrap().clone();
    let mut worker = FakeWorker::start(&name, false);
    worker.end.cancel();
    let mut is_of_first = async || jobs_of_first.contains(&worker.next().await);
    // One of the servers may begin.
    let begins = is_of_first().await;
    while is_of_first().await == begins {}
    let mut first = 0;
    for _ in 0..20 {
        first += usize::from(is_of_first().await);
    }
    assert!((5..=15).contains(&first), "{first} of 20 jobs are of the first server");
    assert!(servers.iter().all(|server| server.released().is_empty()));
}

#[tokio::test(flavor = "multi_thread")]
async fn single_server_gets_long_polls_only() {
    let server = FakeServer::new(0, 10, None);
    let name = FakeName::new(&[(FIRST, &server)]).await;
    let mut worker = FakeWorker::start(&name, false);
    worker.next().await;
    // No request while the job runs.
    sleep(Duration::from_millis(100)).await;
    assert_eq!(server.waits(), [LONG_POLL_MS]);
    worker.end.cancel();
    for _ in 1..10 {
        worker.next().await;
    }
    assert!(server.waits().iter().all(|wait_ms| *wait_ms == LONG_POLL_MS));
    assert!(server.released().is_empty());
}

#[tokio::test(flavor = "multi_thread")]
async fn poll_ends_after_its_claim_when_the_name_loses_the_server() {
    // The first server never answers its long poll.
    let (silent, polls) = (Arc::new(Barrier::new(2)), Arc::new(Barrier::new(2)));
    let servers = [FakeServer::new(0, 0, Some(&silent)), FakeServer::new(0, 1, Some(&polls))];
    let leaving = servers[1].late.lock().unwrap()[0];
    let name = FakeName::new(&[(FIRST, &servers[0]), (SECOND, &servers[1])]).await;
    let mut worker = FakeWorker::start(&name, false);
    for server in &servers {
        until(|| server.waits() == [0, LONG_POLL_MS]).await;
    }
    name.found.lock().unwrap().retain(|address| *address == FIRST);
    name.rounds(2).await;
    // The server answers a claim that was sent before.
    polls.wait().await;
    assert_eq!(worker.next().await, leaving);
    worker.end.cancel();
    name.rounds(5).await;
    assert_eq!(servers[1].waits(), [0, LONG_POLL_MS]);
    assert!(servers[1].released().is_empty());
}

#[tokio::test(flavor = "multi_thread")]
async fn poll_is_started_again_when_it_panics() {
    let server = FakeServer::new(0, 1, None);
    let name = FakeName::new(&[(FIRST, &server)]).await;
    FakeWorker::start(&name, true).next().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn servers_of_another_version_are_asked_again_while_others_give_jobs() {
    let servers = [FakeServer::new(1, 0, None), FakeServer::new(1, 0, None)];
    servers[0].refusals.store(1, Ordering::Relaxed);
    let jobs = servers.each_ref().map(|server| server.queued.lock().unwrap()[0]);
    let name = FakeName::new(&[(FIRST, &servers[0]), (SECOND, &servers[1])]).await;
    let mut worker = FakeWorker::start(&name, false);
    assert_eq!(worker.next().await, jobs[1]);
    worker.end.cancel();
    // The first server is replaced by one of the worker's version.
    assert_eq!(worker.next().await, jobs[0]);
    assert_eq!(servers[0].refusals.load(Ordering::Relaxed), 0);
    assert!(!worker.claims.is_finished());
}

#[test]
fn second_version_of_ip_is_used_when_the_first_is_unreachable() {
    let v6 = IpAddr::V6(Ipv6Addr::LOCALHOST);
    let unreachable = |those: &'static [IpAddr]| move |address| those.contains(&address);
    let both = vec![FIRST, SECOND, v6];
    assert_eq!(preferred(both.clone(), unreachable(&[])), [FIRST, SECOND]);
    assert_eq!(preferred(both.clone(), unreachable(&[FIRST])), [FIRST, SECOND]);
    assert_eq!(preferred(both.clone(), unreachable(&[FIRST, SECOND])), both);
    assert_eq!(preferred(vec![v6], unreachable(&[])), [v6]);
    assert_eq!(preferred(vec![FIRST], unreachable(&[FIRST])), [FIRST]);
    assert!(preferred(Vec::new(), unreachable(&[])).is_empty());
}
