//! S3 server of the tests: s3s-fs, which keeps objects as files and checks the signatures of
//! requests. It is built from crates.io below the target folder.

use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};

use crate::shell;

/// Version of s3s-fs.
const VERSION: &str = "0.14.1";
/// Bucket of the tests, each of which has a folder of its own.
const BUCKET: &str = "brood-test";
const ACCESS_KEY: &str = "brood";
const SECRET_KEY: &str = "brood-secret";
/// Longest time to start.
const START: Duration = Duration::from_secs(10);

/// Server that is stopped, and whose files are removed, when it is dropped.
pub struct ObjectServer {
    child: Child,
    folder: PathBuf,
    address: SocketAddr,
}

impl ObjectServer {
    /// Builds the server if it is missing, and starts it with an empty bucket.
    pub fn start(target: &Path) -> Result<Self> {
        let program = install(target)?;
        let folder = std::env::temp_dir().join(format!("brood-s3-{}", std::process::id()));
        std::fs::create_dir_all(folder.join(BUCKET))
            .with_context(|| format!("create {}", folder.display()))?;
        // Free at this moment.
        let address = TcpListener::bind(("127.0.0.1", 0))?.local_addr()?;
        let child = shell::command(&program)
            .args(["--host", "127.0.0.1", "--port", &address.port().to_string()])
            .args(["--access-key", ACCESS_KEY, "--secret-key", SECRET_KEY])
            .arg(&folder)
            // Refused requests are part of the tests.
            .env("RUST_LOG", "off")
            .stdout(Stdio::null())
            .spawn()
            .with_context(|| format!("start {}", program.display()))?;
        let server = Self { child, folder, address };
        let start = Instant::now();
        while TcpStream::connect(server.address).is_err() {
            if start.elapsed() > START {
                bail!("the S3 server does not listen on {}", server.address);
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        Ok(server)
    }

    /// Adds the environment variables that tests and servers under test read.
    pub fn apply(&self, command: &mut Command) {
        command
            .env("BROOD_TEST_BLOBS", format!("s3://{BUCKET}"))
            .env("AWS_ENDPOINT", format!("http://{}", self.address))
            .env("AWS_ALLOW_HTTP", "true")
            .env("AWS_REGION", "us-east-1")
            .env("AWS_ACCESS_KEY_ID", ACCESS_KEY)
            .env("AWS_SECRET_ACCESS_KEY", SECRET_KEY);
    }
}

impl Drop for ObjectServer {
    fn drop(&mut self) {
        if let Err(error) = self.child.kill().and_then(|()| self.child.wait()) {
            eprintln!("cannot stop the S3 server: {error}");
        }
        if let Err(error) = std::fs::remove_dir_all(&self.folder) {
            eprintln!("cannot remove {}: {error}", self.folder.display());
        }
    }
}

/// Path of the server's program, which is built if it is missing.
fn install(target: &Path) -> Result<PathBuf> {
    let root = target.join(format!("s3s-fs-{VERSION}"));
    let program = root.join("bin/s3s-fs");
    if !program.is_file() {
        println!("missing: an S3 server (crates.io: s3s-fs)");
        let mut install = shell::cargo();
        install.args(["install", "--quiet", "--locked", "--debug", "--features", "binary"]);
        install.args(["--version", VERSION, "s3s-fs", "--root"]).arg(&root);
        shell::run(&mut install).context("build s3s-fs from crates.io")?;
    }
    Ok(program)
}
