//! `brood serve` as a process: its printed address, its workers, its shutdown. Unix only, because
//! of the signals.
#![cfg(unix)]
#![expect(clippy::unwrap_used, reason = "a test may fail by panicking anywhere")]

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Server process, killed when dropped.
struct ServerProcess {
    child: Child,
    address: String,
}

impl ServerProcess {
    fn start(data: &Path, workers: &str) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_brood"))
            .args(["serve", "--listen", "127.0.0.1:0", "--backend", "cpu", "--workers", workers])
            .arg("--data")
            .arg(data)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let address = line.trim_end().strip_prefix("brood is listening on http://");
        let address = address.unwrap_or_else(|| panic!("{line:?}")).to_owned();
        Self { child, address }
    }

    /// Sends a request on a new connection and returns the whole response.
    fn request(&self, method: &str, path: &str, body: &str) -> String {
        let mut stream = TcpStream::connect(&self.address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
        let head = format!(
            "{method} {path} HTTP/1.1\r\nHost: {}\r\nConnection: close\r\nContent-Type: application/json\r\nContent-Length: {}\r\n\r\n{body}",
            self.address,
            body.len()
        );
        stream.write_all(head.as_bytes()).unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        String::from_utf8_lossy(&answer).into_owned()
    }

    fn signal(&self, name: &str) {
        let pid = self.child.id().to_string();
        assert!(Command::new("kill").args([name, &pid]).status().unwrap().success());
    }

    /// Ids of the server's child processes, except the search worker.
    fn workers(&self) -> Vec<u32> {
        let threads = std::fs::read_dir(format!("/proc/{}/task", self.child.id())).unwrap();
        let children = threads.map(|thread| {
            // The thread may have ended.
            std::fs::read_to_string(thread.unwrap().path().join("children")).unwrap_or_default()
        });
        let children: Vec<String> = children.collect();
        let pids = children.iter().flat_map(|text| text.split_whitespace());
        let searches = |pid: &&str| {
            // Between fork and exec the command line is the server's; such a process is skipped for
            // now.
            let command = std::fs::read_to_string(format!("/proc/{pid}/cmdline"));
            command
                .is_ok_and(|command| command.contains("--searches") || !command.contains("worker"))
        };
        let pids = pids.filter(|pid| !searches(pid));
        pids.map(|pid| pid.parse().unwrap()).collect()
    }
}

impl Drop for ServerProcess {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Polls until the condition holds, at most 30 s.
fn until(what: &str, mut condition: impl FnMut() -> bool) {
    let start = Instant::now();
    while !condition() {
        assert!(start.elapsed() < Duration::from_secs(30), "{what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn is_running(pid: u32) -> bool {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
    stat.rsplit(')').next().is_some_and(|rest| !rest.trim().is_empty() && !rest.starts_with(" Z"))
}

#[test]
fn server_breeds_and_ends_with_0_when_terminated() {
    let data = tempfile::tempdir().unwrap();
    let mut served = ServerProcess::start(data.path(), "1");
    let answer = served.request("POST", "/v1/lineages", r#"{"name": "first", "thumbnail_px": 32}"#);
    assert!(answer.starts_with("HTTP/1.1 201"), "{answer}");
    let json: serde_json::Value =
        serde_json::from_str(answer.split("\r\n\r\n").nth(1).unwrap()).unwrap();
    let path = format!("/v1/lineages/{}/generations", json["id"].as_str().unwrap());
    let answer = served.request("POST", &path, r#"{"seed": 7}"#);
    let json: serde_json::Value =
        serde_json::from_str(answer.split("\r\n\r\n").nth(1).unwrap()).unwrap();
    // The command line breeds the same children from the same options.
    let offline = tempfile::tempdir().unwrap();
    let bred = Command::new(env!("CARGO_BIN_EXE_brood"))
        .args(["breed", "--seed", "7", "--size", "16", "-o"])
        .arg(offline.path())
        .output()
        .unwrap();
    for (line, child) in String::from_utf8(bred.stdout).unwrap().lines().zip(0..) {
        assert!(line.contains(json["individuals"][child]["hash"].as_str().unwrap()), "{line}");
    }
    let thumbnail = json["individuals"][3]["thumbnail"].as_str().unwrap();
    let picture = served.request("GET", thumbnail, "");
    assert!(picture.starts_with("HTTP/1.1 200") && picture.contains("PNG"), "expected a PNG");
    served.signal("-TERM");
    assert_eq!(served.child.wait().unwrap().code(), Some(0));
}

#[cfg(target_os = "linux")]
#[test]
fn dead_worker_is_replaced_and_none_outlives_its_server() {
    let data = tempfile::tempdir().unwrap();
    let mut served = ServerProcess::start(data.path(), "1");
    until("a worker is started", || served.workers().len() == 1);
    let first = served.workers()[0];
    assert!(Command::new("kill").args(["-KILL", &first.to_string()]).status().unwrap().success());
    let mut second = None;
    until("another worker is started", || {
        second = served.workers().into_iter().find(|pid| *pid != first && is_running(*pid));
        second.is_some()
    });
    let second = second.unwrap();
    served.signal("-KILL");
    served.child.wait().unwrap();
    until("the worker ends with its server", || !is_running(second));
}

#[test]
fn second_server_fails_with_one_line() {
    let data = tempfile::tempdir().unwrap();
    let served = ServerProcess::start(data.path(), "0");
    let serve = |listen: &str, data: &Path| {
        let output = Command::new(env!("CARGO_BIN_EXE_brood"))
            .args(["serve", "--workers", "0", "--listen", listen, "--data"])
            .arg(data)
            .env("BROOD_LOG", "off")
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(1));
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert!(stderr.starts_with("error: ") && stderr.lines().count() == 1, "{stderr}");
        stderr
    };
    serve("127.0.0.1:0", data.path());
    let other = tempfile::tempdir().unwrap();
    let line = serve(&served.address, other.path());
    assert!(line.contains(served.address.rsplit(':').next().unwrap()), "{line}");
    serve("0.0.0.0:0", other.path());
}
