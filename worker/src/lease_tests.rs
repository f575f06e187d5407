//! Tests of leased render jobs against a fake server on one socket.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use brood_genome::{BirthKey, Dialect, Variation};
use brood_light::{IesLight, Light};
use brood_program::Program;
use brood_protocol::{
    Aspect, Backend, ClientError, Frame, JobId, LeaseGrant, LeaseId, LeaseResults, LeaseTicket,
    MeshSource, PackedProgram, PictureFormat, RenderItem, RenderJob, RenderOutcome, Subject,
    TargetSource, WorkerClient, decode, encode,
};
use brood_scene::{MeshRef, Scene};
use tokio::io::{AsyncBufReadExt, AsyncReadExt, AsyncWriteExt, BufReader};
use tokio::net::{TcpListener, TcpStream};
use tokio_util::sync::CancellationToken;

use crate::job::RenderContext;
use crate::lease::renew_lease;
use crate::{WorkerConfig, WorkerError, run};

/// Status and body of a response.
pub(crate) type Answer = (u16, Vec<u8>);

/// Serves HTTP/1.1 with keep-alive. The handler gets `METHOD path` and the body. Returns the URL.
pub(crate) async fn serve<H, F>(handler: H) -> String
where
    H: Fn(String, Vec<u8>) -> F + Clone + Send + Sync + 'static,
    F: Future<Output = Answer> + Send + 'static,
{
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let url = format!("http://{}", listener.local_addr().unwrap());
    tokio::spawn(async move {
        while let Ok((stream, _)) = listener.accept().await {
            tokio::spawn(connection(stream, handler.clone()));
        }
    });
    url
}

async fn connection<H, F>(stream: TcpStream, handler: H)
where
    H: Fn(String, Vec<u8>) -> F + Send + Sync,
    F: Future<Output = Answer> + Send,
{
    let mut stream = BufReader::new(stream);
    loop {
        let mut head = String::new();
        while !head.ends_with("\r\n\r\n") {
            if stream.read_line(&mut head).await.unwrap_or(0) == 0 {
                return;
            }
        }
        let length = head.lines().find_map(|line| {
            let (name, value) = line.split_once(':')?;
            name.eq_ignore_ascii_case("content-length").then(|| value.trim().parse().unwrap())
        });
        let mut body = vec![0; length.unwrap_or(0)];
        stream.read_exact(&mut body).await.unwrap();
        let request = head.lines().next().unwrap().trim_end_matches(" HTTP/1.1").to_owned();
        let (status, body) = handler(request, body).await;
        let head = format!("HTTP/1.1 {status} X\r\nContent-Length: {}\r\n\r\n", body.len());
        if stream.write_all(head.as_bytes()).await.is_err()
            || stream.write_all(&body).await.is_err()
        {
            return;
        }
    }
}

fn config(server: String) -> WorkerConfig {
    WorkerConfig {
        server,
        token: "secret".to_owned(),
        backend: Backend::Cpu,
        name: "test".to_owned(),
        threads: std::num::NonZeroUsize::new(1),
        cache_bytes: 16 << 20,
    }
}

fn grant(scene: &Scene, size_px: u32) -> LeaseGrant {
    let random = Variation::random(Dialect::default());
    let program = Program::lower(&random.birth(BirthKey { seed: 8, slot: 0, attempt: 0 }));
    let how = (PictureFormat::Png, Backend::Auto);
    let frame = Frame::new(scene, MeshSource::Builtin, size_px, 1, how);
    let key = frame.key(&program);
    let packed = PackedProgram { words: program.to_words(), operations_written: 200 };
    LeaseGrant {
        ticket: LeaseTicket { lease: LeaseId::fresh(), epoch: 3 },
        job: JobId::fresh(),
        ttl_ms: 400,
        work: RenderJob::new(frame, vec![RenderItem { key, subject: Subject::Program(packed) }]),
    }
}

/// Fake server that grants one lease, records every request except the polls, and stops the worker
/// after results or a release.
struct FakeServer {
    grant: Mutex<Option<LeaseGrant>>,
    requests: Mutex<Vec<(String, Vec<u8>)>>,
    results_status: u16,
    heartbeat_status: u16,
    stop: CancellationToken,
}

impl FakeServer {
    fn new(grant: LeaseGrant, results_status: u16, heartbeat_status: u16) -> Arc<Self> {
        Arc::new(Self {
            grant: Mutex::new(Some(grant)),
            requests: Mutex::default(),
            results_status,
            heartbeat_status,
            stop: CancellationToken::new(),
        })
    }

    fn answer(&self, request: &str, body: &[u8]) -> Answer {
        if request == "POST /v1/leases" {
            let grant = self.grant.lock().unwrap().take();
            return grant.map_or((204, Vec::new()), |grant| (200, encode(&grant)));
        }
        self.requests.lock().unwrap().push((request.to_owned(), body.to_vec()));
        if request.starts_with("GET ") {
            // No download is known here.
            return (404, Vec::new());
        }
        if request.ends_with("/heartbeat") {
            return (self.heartbeat_status, Vec::new());
        }
        self.stop.cancel();
        (self.results_status, Vec::new())
    }

    async fn run_worker(self: &Arc<Self>) -> Vec<(String, Vec<u8>)> {
        let server = self.clone();
        let answer = move |request: String, body: Vec<u8>| {
            let answer = server.answer(&request, &body);
            async move {
                if answer.0 == 204 && request.ends_with("/leases") {
                    // A long poll without a job. A worker that shuts down must not wait for it.
                    tokio::time::sleep(Duration::from_millis(200)).await;
                }
                answer
            }
        };
        let url = serve(answer).await;
        let running = run(config(url), self.stop.clone());
        tokio::time::timeout(Duration::from_secs(30), running).await.unwrap().unwrap();
        std::mem::take(&mut *self.requests.lock().unwrap())
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn worker_returns_error_when_token_is_rejected() {
    let url = serve(|_, _| async { (401, Vec::new()) }).await;
    let result = run(config(url), CancellationToken::new()).await;
    assert!(matches!(result, Err(WorkerError::Refused(_))), "{result:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn worker_stops_when_server_is_unreachable() {
    let stop = CancellationToken::new();
    let running = tokio::spawn(run(config("http://127.0.0.1:9".to_owned()), stop.clone()));
    tokio::time::sleep(Duration::from_millis(300)).await;
    stop.cancel();
    let ended = tokio::time::timeout(Duration::from_secs(5), running).await;
    assert!(ended.unwrap().unwrap().is_ok());
}

#[tokio::test(flavor = "multi_thread")]
async fn pictures_are_submitted_with_their_keys() {
    let grant = grant(&Scene::default(), 32);
    let (ticket, key) = (grant.ticket, grant.work.items[0].key);
    let requests = FakeServer::new(grant, 204, 204).run_worker().await;
    let (request, body) = requests.iter().find(|(r, _)| !r.ends_with("/heartbeat")).unwrap();
    assert_eq!(*request, format!("POST /v1/leases/{}/results", ticket.lease));
    let results: LeaseResults = decode(body).unwrap();
    assert_eq!(results.ticket, ticket);
    let RenderOutcome::Pictures(pictures, work) = results.outcome else { panic!("{results:?}") };
    assert_eq!((pictures.len(), pictures[0].key), (1, key));
    assert!(work.pictures == 1 && work.rays >= 32 * 32, "{work:?}");
    assert_eq!(work.operations_written, 200 * work.rays);
    assert!(work.operations_executed > 0 && work.operations_executed < work.operations_written);
    assert!(work.inputs_read > 0 && work.inputs_read < work.inputs_known && work.busy_us > 0);
    assert!(work.samples_lit > 0);
    assert!(pictures[0].bytes.starts_with(b"\x89PNG"));
}

#[tokio::test(flavor = "multi_thread")]
async fn job_fails_with_reason_when_grant_is_invalid() {
    let mut broken = grant(&Scene::default(), 32);
    let packed = PackedProgram { words: vec![1, 2], operations_written: 0 };
    broken.work.items[0].subject = Subject::Program(packed);
    let scene = Scene { mesh: MeshRef::Uploaded("x".to_owned()), ..Scene::default() };
    for grant in [broken, grant(&scene, 32)] {
        let requests = FakeServer::new(grant, 204, 204).run_worker().await;
        let results: LeaseResults = decode(&requests.last().unwrap().1).unwrap();
        let RenderOutcome::Failed(reason) = results.outcome else { panic!("{results:?}") };
        assert!(!reason.is_empty());
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn job_is_returned_when_it_is_for_another_version() {
    let mut renderer = grant(&Scene::default(), 32);
    renderer.work.renderer_version += 1;
    let mut target = grant(&Scene::default(), 32);
    let source = TargetSource { kind: "of a later version".to_owned(), hash: [0; 32], view: None };
    target.work.items[0].subject = Subject::Target(source, Aspect::Picture);
    for grant in [renderer, target] {
        let released = format!("DELETE /v1/leases/{}", grant.ticket.lease);
        let requests = FakeServer::new(grant, 204, 204).run_worker().await;
        assert_eq!(requests.last().unwrap().0, released);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn job_fails_with_reason_when_download_is_rejected() {
    let asset = "0".repeat(64);
    let light = IesLight { profile: asset.clone(), ..IesLight::default() };
    let lit = Scene { lights: vec![Light::Ies(light)], ..Scene::default() };
    let mut meshed = grant(&Scene::default(), 32);
    meshed.work.frame.mesh = MeshSource::Uploaded([0; 32]);
    let mut targeted = grant(&Scene::default(), 32);
    let source = TargetSource { kind: "merl".to_owned(), hash: [0; 32], view: None };
    targeted.work.items[0].subject = Subject::Target(source, Aspect::Picture);
    let downloads = [(grant(&lit, 32), "light-assets"), (meshed, "meshes"), (targeted, "targets")];
    for (grant, route) in downloads {
        let requests = FakeServer::new(grant, 204, 204).run_worker().await;
        assert_eq!(requests[0].0, format!("GET /v1/leases/{route}/{asset}"));
        let results: LeaseResults = decode(&requests.last().unwrap().1).unwrap();
        let RenderOutcome::Failed(reason) = results.outcome else { panic!("{results:?}") };
        assert!(reason.contains("404"), "{reason}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn results_are_sent_once_when_lease_is_stale() {
    // Results are answered with 409: no retry and no release.
    let requests = FakeServer::new(grant(&Scene::default(), 32), 409, 204).run_worker().await;
    let others = requests.iter().filter(|(request, _)| !request.ends_with("/heartbeat"));
    assert_eq!(others.count(), 1, "{requests:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn lease_is_returned_when_worker_stops_while_rendering() {
    // Large enough to be still rendering when the first heartbeat, after a quarter of the lease,
    // stops the worker.
    let grant = grant(&Scene::default(), 2048);
    let lease = grant.ticket.lease;
    let server = FakeServer::new(grant, 204, 204);
    let stopper = server.clone();
    tokio::spawn(async move {
        // Not as soon as the lease is granted: the grant may not have reached the worker yet.
        while stopper.requests.lock().unwrap().is_empty() {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
        stopper.stop.cancel();
    });
    let requests = server.run_worker().await;
    let last = requests.last().expect("the lease is returned");
    assert_eq!(last.0, format!("DELETE /v1/leases/{lease}"));
}

#[tokio::test]
async fn renewals_end_when_server_does_not_answer_for_the_duration_of_a_lease() {
    let client = WorkerClient::new("http://127.0.0.1:9", "secret").unwrap();
    let ticket = LeaseTicket { lease: LeaseId::fresh(), epoch: 1 };
    let (ttl, started) = (Duration::from_millis(300), Instant::now());
    let renewals = renew_lease::<RenderContext, _>(ttl, || client.heartbeat(&ticket));
    tokio::time::timeout(Duration::from_secs(30), renewals).await.unwrap();
    assert!(started.elapsed() >= ttl);
}

#[tokio::test]
async fn renewals_continue_when_server_answers_with_errors() {
    let busy = || async { Err(ClientError::Busy) };
    let renewals = renew_lease::<RenderContext, _>(Duration::from_millis(50), busy);
    assert!(tokio::time::timeout(Duration::from_millis(500), renewals).await.is_err());
}

#[tokio::test]
async fn renewals_end_when_lease_is_stale() {
    let stale = || async { Err(ClientError::Stale) };
    let renewals = renew_lease::<RenderContext, _>(Duration::from_secs(1), stale);
    tokio::time::timeout(Duration::from_secs(30), renewals).await.unwrap();
}
