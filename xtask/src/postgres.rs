//! A temporary cluster of PostgreSQL, and the tests of the store and of the API on it and on an S3
//! server. `cluster.rs` lets a test start, kill and restart such a cluster.
//!
//! The cluster listens on a Unix socket in its own folder below the folder of temporary files, and
//! for connections with TLS, which need a password, on a port of 127.0.0.1. As root it runs as the
//! user `postgres`, whom the Debian package makes: PostgreSQL refuses root.

use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result, bail};

use crate::object_server::ObjectServer;
use crate::prerequisite::{self, Prerequisites};
use crate::{shell, suite};

/// Folder with a folder for each installed version.
const PROGRAMS: &str = "/usr/lib/postgresql";
/// Options of the cluster. Tests open many connections.
const OPTIONS: &str = "-c listen_addresses=127.0.0.1 -c max_connections=500 -c ssl=on";
/// Options of `openssl` for a key and a certificate of `localhost` that signs itself.
const CERTIFICATE: [&str; 13] = [
    "req",
    "-x509",
    "-newkey",
    "ec",
    "-pkeyopt",
    "ec_paramgen_curve:P-256",
    "-noenc",
    "-days",
    "2",
    "-subj",
    "/CN=localhost",
    "-addext",
    "subjectAltName=DNS:localhost",
];
/// Database that each cluster has.
pub const DATABASE: &str = "postgres";
/// Tests of the API that run on PostgreSQL in each run of all tests: those of what is stored.
const STORED: &str = "test(/^(access|blobs|breed|comparison|edit|export_job|genome|idempotency|individual|\
    islands|job|lineage|lineage_list|lock|mesh|operation|rolling_upgrade|scene|search|several_servers|\
    start|target)::/)";
/// Tests that read or change SQLite's files.
const OF_FILES: &str = "test(/^upgrade::/) or test(/an_earlier_version/) or test(/^command_line::/) \
    or test(=access::routes_require_a_token_of_the_right_scope_when_a_token_exists)";
/// Short form of `cargo xtask faults --cluster`.
const CLUSTER: &str = "binary(faults) and test(/^cluster::/)";
/// Tests at a time. They mostly wait.
const THREADS: &str = "--test-threads=4";

/// Cluster that is removed when it is dropped.
pub struct Cluster {
    programs: PathBuf,
    folder: PathBuf,
    port: u16,
    user: Option<&'static str>,
}

impl Cluster {
    /// Installs PostgreSQL if it is missing, and makes an empty cluster that does not run.
    pub fn make() -> Result<Self> {
        if newest().is_none() {
            println!("missing: a database server (Debian: postgresql, openssl)");
            prerequisite::install_debian(&["postgresql", "openssl"])?;
        }
        let programs = newest().context("find PostgreSQL below /usr/lib/postgresql")?;
        let is_root = shell::is_root()?;
        let folder = std::env::temp_dir().join(format!("brood-pg-{}", std::process::id()));
        // Free at this moment.
        let port = TcpListener::bind(("127.0.0.1", 0))?.local_addr()?.port();
        let cluster = Self { programs, folder, port, user: is_root.then_some("postgres") };
        shell::run(cluster.command("mkdir").args(["-m", "700"]).arg(&cluster.folder))?;
        shell::run(
            cluster
                .command(cluster.programs.join("initdb"))
                .args(["--username=brood", "--auth-local=trust", "--auth-host=scram-sha-256"])
                .arg("--encoding=UTF8")
                .args(["--locale=C.UTF-8", "--no-instructions", "--pgdata"])
                .arg(cluster.data()),
        )?;
        // Of an authority it would not be accepted as a server's.
        let is_leaf = ["-addext", "basicConstraints=critical,CA:FALSE"];
        shell::run(
            cluster
                .command("openssl")
                .args(CERTIFICATE)
                .args(is_leaf)
                .arg("-keyout")
                .arg(cluster.data().join("server.key"))
                .arg("-out")
                .arg(cluster.data().join("server.crt")),
        )?;
        Ok(cluster)
    }

    /// Makes a cluster and starts it. Commits are flushed to disk, as by default.
    pub fn start() -> Result<Self> {
        let cluster = Self::make()?;
        let options = format!("{OPTIONS} -c port={}", cluster.port);
        shell::run(cluster.control_with(&options).arg("start"))?;
        Ok(cluster)
    }

    /// Returns `pg_ctl` that waits, for a command that starts the cluster with these options.
    pub fn control_with(&self, options: &str) -> Command {
        let folder = self.folder.display();
        let mut control = self.control();
        control.args(["--wait", "--log"]).arg(self.folder.join("log"));
        control.args(["--options", &format!("{options} -c unix_socket_directories={folder}")]);
        control
    }

    /// Address of a database, for `brood serve --database`.
    pub fn address_of(&self, database: &str) -> String {
        let folder = self.folder.display().to_string().replace('/', "%2F");
        format!("postgres://brood@{folder}:{}/{database}", self.port)
    }

    /// Runs a statement in a database. Returns its rows, a line each.
    pub fn query(&self, database: &str, statement: &str) -> Result<String> {
        let mut psql = self.command(self.programs.join("psql"));
        psql.args(["--no-psqlrc", "--quiet", "--tuples-only", "--no-align"]);
        psql.args(["--set=ON_ERROR_STOP=1", "--username=brood", "--host"]).arg(&self.folder);
        psql.args(["--port", &self.port.to_string()]);
        psql.args(["--dbname", database, "--command", statement]);
        Ok(shell::output(&mut psql)?.trim().to_owned())
    }

    /// Process that started all others of the cluster.
    pub fn process(&self) -> Result<u32> {
        let file = self.data().join("postmaster.pid");
        let text =
            std::fs::read_to_string(&file).with_context(|| format!("read {}", file.display()))?;
        let first = text.lines().next().and_then(|line| line.trim().parse().ok());
        first.with_context(|| format!("find a process in {}", file.display()))
    }

    /// Folder of the data.
    pub fn data(&self) -> PathBuf {
        self.folder.join("data")
    }

    fn control(&self) -> Command {
        let mut control = self.command(self.programs.join("pg_ctl"));
        control.arg("--pgdata").arg(self.data());
        control
    }

    /// Command of the user of the cluster.
    fn command(&self, program: impl AsRef<Path>) -> Command {
        let Some(user) = self.user else { return shell::command(program.as_ref()) };
        let mut command = shell::command("runuser");
        command.args(["-u", user, "--"]).arg(program.as_ref());
        // The folder of the repository may be closed to that user.
        command.current_dir(std::env::temp_dir());
        command
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        if let Err(error) = shell::run(self.control().args(["--mode=immediate", "stop"])) {
            eprintln!("cannot stop PostgreSQL: {error:#}");
        }
        if let Err(error) = std::fs::remove_dir_all(&self.folder) {
            eprintln!("cannot remove {}: {error}", self.folder.display());
        }
    }
}

/// Programs of the newest version that is installed.
fn newest() -> Option<PathBuf> {
    let version = |path: &PathBuf| path.file_name()?.to_str()?.parse::<u32>().ok();
    let versions = std::fs::read_dir(PROGRAMS).ok()?.filter_map(|entry| Some(entry.ok()?.path()));
    let newest = versions.filter(|path| path.join("bin/initdb").is_file()).max_by_key(version)?;
    Some(newest.join("bin"))
}

/// Runs the tests of the store on PostgreSQL, and those of the API about what is stored.
pub fn short(target: &Path, found: &Prerequisites) -> Result<()> {
    test(target, found, &[STORED])
}

/// Runs the tests of the store and of the API on PostgreSQL, or those that a filter of nextest
/// chooses.
pub fn run(filter: &[&str]) -> Result<()> {
    let target = suite::target_directory()?;
    shell::run(shell::cargo().args(["build", "--locked", "--package", "brood"]))?;
    let filter = if filter.is_empty() { &["all()"] } else { filter };
    test(&target, &Prerequisites::find(), filter)
}

fn test(target: &Path, found: &Prerequisites, filter: &[&str]) -> Result<()> {
    if !found.nextest {
        bail!("the tests on PostgreSQL need cargo-nextest");
    }
    let start = Instant::now();
    let cluster = Cluster::start()?;
    let objects = ObjectServer::start(target)?;
    println!("PostgreSQL and an S3 server run after {:.1} s", start.elapsed().as_secs_f64());
    let chosen = filter.join(" or ");
    let api = format!("binary(api) and ({chosen}) and not ({OF_FILES})");
    let tests = format!("package(brood-tests) and ({api} or {CLUSTER})");
    let mut command = suite::prepared(shell::cargo(), found, target);
    command.env("BROOD_TEST_DATABASE", cluster.address_of(DATABASE));
    objects.apply(&mut command);
    // The whole workspace, as in the other steps: with fewer packages, others would be built with
    // fewer features again.
    command.args(["nextest", "run", "--workspace", "--no-fail-fast", THREADS]);
    shell::run(command.args(["-E", &format!("package(brood-storage) or ({tests})")]))
}
