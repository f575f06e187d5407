//! Real server: the built binary on a free port with its own data directory.
//!
//! Owns the process, its directory and its log; terminates it on drop and prints the log if the
//! test has failed.

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use reqwest::Method;
use serde_json::Value;
use tempfile::TempDir;

use crate::{Answer, binary, database, http_client};

/// Longest time to start, on a busy machine with two cores.
const START_TIMEOUT: Duration = Duration::from_secs(60);
/// Longer than the server's longest wait.
const REQUEST_TIMEOUT: Duration = Duration::from_secs(90);

/// Options of a server.
#[derive(Debug, Clone)]
pub struct ServerOptions {
    /// Value of `--backend`.
    pub backend: &'static str,
    /// Value of `--workers`.
    pub workers: u32,
    /// Further arguments.
    pub arguments: Vec<String>,
    /// Environment variables.
    pub environment: Vec<(&'static str, PathBuf)>,
}

impl Default for ServerOptions {
    /// One worker on the CPU: enough for most tests, and quick to start.
    fn default() -> Self {
        Self { backend: "cpu", workers: 1, arguments: Vec::new(), environment: Vec::new() }
    }
}

/// Running server.
pub struct TestServer {
    options: ServerOptions,
    data: TempDir,
    child: Child,
    address: String,
    log: Arc<Mutex<String>>,
    client: reqwest::Client,
}

impl TestServer {
    /// Starts a server on an empty data directory and waits until it listens.
    ///
    /// # Panics
    /// If it does not start; prints its log.
    #[must_use]
    pub fn start() -> Self {
        Self::start_with(ServerOptions::default())
    }

    /// Starts a server with these options on an empty data directory.
    ///
    /// # Panics
    /// If it does not start; prints its log.
    #[must_use]
    pub fn start_with(options: ServerOptions) -> Self {
        Self::start_on(options, TempDir::new().expect("a temporary folder can be made"))
    }

    /// Starts a server with these options on this data directory.
    ///
    /// # Panics
    /// If it does not start; prints its log.
    #[must_use]
    pub fn start_on(options: ServerOptions, data: TempDir) -> Self {
        let log = Arc::new(Mutex::new(String::new()));
        let (child, address) = spawn(&options, data.path(), &log);
        let client = http_client()
            .timeout(REQUEST_TIMEOUT)
            .redirect(reqwest::redirect::Policy::none())
            .build()
            .expect("a client can be made");
        Self { options, data, child, address, log, client }
    }

    /// Starts another server on the PostgreSQL database of this one, with a data directory of its
    /// own; `None` on SQLite.
    ///
    /// # Panics
    /// If it does not start; prints its log.
    #[must_use]
    pub fn beside(&self, mut options: ServerOptions) -> Option<Self> {
        let address = database::of(self.data.path())?;
        options.environment.push(("BROOD_DATABASE", address.into()));
        Some(Self::start_with(options))
    }

    /// Returns the `host:port` that the server listens on.
    #[must_use]
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Returns the address of the PostgreSQL database; `None` on SQLite.
    #[must_use]
    pub fn database(&self) -> Option<String> {
        database::of(self.data.path())
    }

    /// Returns the server's process id.
    #[must_use]
    pub fn process(&self) -> u32 {
        self.child.id()
    }

    /// Returns the data directory.
    #[must_use]
    pub fn data(&self) -> &Path {
        self.data.path()
    }

    /// Returns the text on stderr so far, over all starts.
    ///
    /// # Panics
    /// Never in practice: no reader of the log panics.
    #[must_use]
    pub fn log(&self) -> String {
        self.log.lock().expect("no reader of the log panics").clone()
    }

    /// Kills the server, like a power cut, and waits for its end.
    ///
    /// # Panics
    /// If the process cannot be killed.
    pub fn kill9(&mut self) {
        self.child.kill().expect("a child can be killed");
        self.child.wait().expect("a killed child ends");
    }

    /// Terminates the server; returns its exit code.
    ///
    /// # Panics
    /// If it does not end within 30 s.
    #[must_use]
    pub fn terminate(&mut self) -> i32 {
        let signal = Command::new("kill").args(["-TERM", &self.child.id().to_string()]).status();
        assert!(signal.is_ok_and(|status| status.success()), "the server can be signalled");
        self.wait()
    }

    /// Returns the exit code if the server has ended by itself.
    ///
    /// # Panics
    /// Never in practice: a child can be asked for its end.
    pub fn ended(&mut self) -> Option<i32> {
        let status = self.child.try_wait().expect("a child can be asked for its end");
        status.map(|status| status.code().unwrap_or(-1))
    }

    /// Waits until the server ends by itself; returns its exit code.
    ///
    /// # Panics
    /// If it does not end within 30 s.
    #[must_use]
    pub fn wait(&mut self) -> i32 {
        let deadline = Instant::now() + Duration::from_secs(30);
        loop {
            if let Some(code) = self.ended() {
                return code;
            }
            assert!(Instant::now() < deadline, "the server did not end\n{}", self.log());
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Starts an ended server again on the same data directory, with these options.
    ///
    /// # Panics
    /// If it does not start; prints its log.
    pub fn restart_with(&mut self, options: ServerOptions) {
        self.options = options;
        self.restart();
    }

    /// Starts an ended server again on the same data directory with the same options.
    ///
    /// # Panics
    /// If it does not start; prints its log.
    pub fn restart(&mut self) {
        let (child, address) = spawn(&self.options, self.data.path(), &self.log);
        (self.child, self.address) = (child, address);
    }

    /// Returns a request to this server, for cases that the other methods do not cover.
    pub fn request(&self, method: Method, path: &str) -> reqwest::RequestBuilder {
        self.client.request(method, format!("http://{}{path}", self.address))
    }

    /// Sends a request and reads the answer.
    ///
    /// # Panics
    /// If there is no answer.
    pub async fn send(&self, request: reqwest::RequestBuilder) -> Answer {
        match self.try_send(request).await {
            Ok(answer) => answer,
            Err(error) => panic!("no answer: {error:?}"),
        }
    }

    /// Sends a request to a server that may be gone.
    ///
    /// # Errors
    /// If the request cannot be sent or the answer is incomplete.
    pub async fn try_send(&self, request: reqwest::RequestBuilder) -> reqwest::Result<Answer> {
        let request = request.build()?;
        let name = format!("{} {}", request.method(), request.url().path());
        let response = self.client.execute(request).await?;
        let (status, headers) = (response.status().as_u16(), response.headers().clone());
        let body = response.bytes().await?.to_vec();
        Ok(Answer { request: name, status, headers, body })
    }

    /// Sends a GET.
    pub async fn get(&self, path: &str) -> Answer {
        self.send(self.request(Method::GET, path)).await
    }

    /// Returns a metric without labels.
    ///
    /// # Panics
    /// If the server has no metric of this name.
    pub async fn metric(&self, name: &str) -> u64 {
        let text = self.get("/metrics").await.expect(200).text();
        let value = text.lines().find_map(|line| line.strip_prefix(&format!("{name} ")));
        let value = value.and_then(|value| value.parse().ok());
        value.unwrap_or_else(|| panic!("{name} in {text}"))
    }

    /// Sends a POST of JSON.
    pub async fn post(&self, path: &str, body: &Value) -> Answer {
        self.send(self.request(Method::POST, path).json(body)).await
    }

    /// Sends a POST of bytes of this media type.
    pub async fn post_bytes(&self, path: &str, kind: &str, body: impl Into<Vec<u8>>) -> Answer {
        let request = self.request(Method::POST, path).header("content-type", kind);
        self.send(request.body(body.into())).await
    }

    /// Sends a PATCH of JSON, with `If-Match` if a version is given.
    pub async fn patch(&self, path: &str, version: Option<&str>, body: &Value) -> Answer {
        let mut request = self.request(Method::PATCH, path).json(body);
        if let Some(version) = version {
            request = request.header("if-match", version);
        }
        self.send(request).await
    }

    /// Sends a DELETE.
    pub async fn delete(&self, path: &str) -> Answer {
        self.send(self.request(Method::DELETE, path)).await
    }
}

impl Drop for TestServer {
    fn drop(&mut self) {
        // The server may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
        if std::thread::panicking() {
            let log = self.log();
            let from = log.len().saturating_sub(6000);
            let from = (from..=log.len()).find(|at| log.is_char_boundary(*at)).unwrap_or(0);
            eprintln!("--- end of the server's log:\n{}", &log[from..]);
        }
    }
}

/// Starts the binary and reads the address from its first line.
fn spawn(options: &ServerOptions, data: &Path, log: &Arc<Mutex<String>>) -> (Child, String) {
    let mut child = Command::new(binary())
        .args(["serve", "--listen", "127.0.0.1:0", "--backend", options.backend])
        .args(["--workers", &options.workers.to_string()])
        .arg("--data")
        .arg(data)
        .args(&options.arguments)
        .envs(database::of(data).map(|address| ("BROOD_DATABASE", address)))
        .envs(options.environment.iter().map(|(name, value)| (name, value)))
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the built brood can be started");
    let stderr = child.stderr.take().expect("stderr is piped");
    let stdout = child.stdout.take().expect("stdout is piped");
    let kept = Arc::clone(log);
    std::thread::spawn(move || keep(stderr, &kept));
    let (told, address) = mpsc::channel();
    std::thread::spawn(move || {
        for line in BufReader::new(stdout).lines().map_while(Result::ok) {
            if let Some(address) = line.strip_prefix("brood is listening on http://") {
                // The receiver is dropped once the address is known.
                let _ = told.send(address.trim_end_matches('/').to_owned());
            }
        }
    });
    if let Ok(address) = address.recv_timeout(START_TIMEOUT) {
        return (child, address);
    }
    let _ = child.kill();
    let status = child.wait();
    let log = log.lock().expect("no reader of the log panics");
    panic!("the server did not say that it is listening ({status:?}); its log:\n{log}");
}

/// Appends a stream to the log as it arrives.
fn keep(mut stream: impl Read, log: &Mutex<String>) {
    let mut buffer = [0; 4096];
    while let Ok(count) = stream.read(&mut buffer) {
        if count == 0 {
            return;
        }
        let text = String::from_utf8_lossy(&buffer[..count]);
        log.lock().expect("no reader of the log panics").push_str(&text);
    }
}
