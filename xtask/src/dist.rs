//! `cargo xtask dist`: the files of a release, in `target/dist`.
//!
//! A tarball of the static binary with its files of deployment, its bill of materials
//! (CycloneDX), the Python wheel, and checksums of all. The binary is linked with musl, so that it
//! runs on any Linux and in an empty container; it has no GPU backend, because GPU drivers are
//! shared libraries.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::Stdio;

use anyhow::{Context, Result, bail, ensure};

use crate::prerequisite::install_debian;
use crate::sbom;
use crate::shell;
use crate::suite::target_directory;
use crate::wheel;

/// Compiler of the C code of dependencies, for musl.
const C_COMPILER: &str = "musl-gcc";

/// Files that are in the tarball beside the binary.
const FILES: [&str; 17] = [
    "packaging/brood.service",
    "packaging/brood-worker@.service",
    "packaging/compose.yaml",
    "packaging/Containerfile",
    "packaging/grafana.json",
    "packaging/haproxy.cfg",
    "packaging/kubernetes.yaml",
    "packaging/prometheus-adapter.yaml",
    "packaging/prometheus.yaml",
    "packaging/rules.yaml",
    "docs/operations.md",
    "docs/scale.md",
    "SECURITY.md",
    "docs/install.md",
    "CHANGELOG.md",
    "LICENSE-APACHE",
    "LICENSE-MIT",
];

/// Builds the release of the commit that is checked out.
pub fn run() -> Result<()> {
    ensure!(cfg!(target_os = "linux"), "releases are built on Linux");
    let changes = git(&["status", "--porcelain"])?;
    ensure!(changes.is_empty(), "the release names its commit: commit these first\n{changes}");
    let commit = git(&["log", "-1", "--format=%h", "--abbrev=12"])?;
    let target = target_directory()?;
    let out = target.join("dist");
    start_empty(&out)?;

    let binary = static_binary(&target)?;
    let name = format!("brood-{}-{}-linux", env!("CARGO_PKG_VERSION"), std::env::consts::ARCH);
    let folder = out.join(&name);
    gather(&binary, &folder)?;
    try_out(&folder.join("brood"), &commit)?;
    let tarball = format!("{name}.tar.gz");
    pack(&out, &name, &tarball)?;
    std::fs::remove_dir_all(&folder).context("remove the packed folder")?;

    let bill = format!("{name}.cdx.json");
    let document = sbom::document(&musl(), &commit)?;
    let document = serde_json::to_string_pretty(&document).context("write the bill")?;
    std::fs::write(out.join(&bill), document + "\n").context("write the bill of materials")?;

    let wheel = wheel::build()?;
    let wheel_name = wheel.file_name().context("the wheel has a name")?;
    std::fs::copy(&wheel, out.join(wheel_name)).context("copy the wheel")?;

    let mut sums = shell::command("sha256sum");
    sums.current_dir(&out).args([&tarball, &bill]).arg(wheel_name);
    std::fs::write(out.join("SHA256SUMS"), shell::output(&mut sums)?).context("write the sums")?;
    println!("release of commit {commit} in {}:", out.display());
    shell::run(shell::command("ls").current_dir(&out).args(["-s", "--block-size=KiB"]))
}

/// Builds the binary without the GPU backend, linked with musl.
fn static_binary(target: &Path) -> Result<PathBuf> {
    let triple = musl();
    if shell::find_program(C_COMPILER).is_none() {
        println!("missing: a C compiler for musl (Debian: musl-tools)");
        install_debian(&["musl-tools"])?;
    }
    if shell::find_program("rustup").is_some() {
        shell::run(shell::command("rustup").args(["target", "add", &triple]))?;
    }
    let mut build = shell::cargo();
    build.args(["build", "--release", "--locked", "--package", "brood", "--no-default-features"]);
    build.args(["--target", &triple]).env(format!("CC_{}", triple.replace('-', "_")), C_COMPILER);
    shell::run(&mut build)?;
    Ok(target.join(triple).join("release/brood"))
}

/// Target of the binary.
fn musl() -> String {
    format!("{}-unknown-linux-musl", std::env::consts::ARCH)
}

/// Copies the files of the tarball into a new folder.
fn gather(binary: &Path, folder: &Path) -> Result<()> {
    // The container file makes the data directory from this folder.
    std::fs::create_dir_all(folder.join("data")).context("make the folder of the tarball")?;
    // Line tables are four fifths of the file; names of functions stay, for backtraces.
    let mut strip = shell::command("strip");
    strip.arg("--strip-debug").arg("-o").arg(folder.join("brood")).arg(binary);
    shell::run(&mut strip)?;
    for file in FILES {
        let name = Path::new(file).file_name().expect("each file has a name");
        let from = shell::root().join(file);
        std::fs::copy(&from, folder.join(name)).with_context(|| format!("copy {file}"))?;
    }
    Ok(())
}

/// Packs a folder: the same bytes for the same files and commit.
fn pack(out: &Path, folder: &str, tarball: &str) -> Result<()> {
    let time = git(&["log", "-1", "--format=%cI"])?;
    let mut tar = shell::command("tar");
    tar.current_dir(out).args(["--sort=name", "--owner=0", "--group=0", "--numeric-owner"]);
    tar.args(["--mode=u=rwX,go=rX", "--format=gnu", "--mtime", &time]);
    // gzip without a time of its own.
    tar.args(["--use-compress-program", "gzip -9n", "--create", "--file", tarball, folder]);
    shell::run(&mut tar)
}

/// Starts the packed binary: it must name the commit, need no shared library, and serve.
fn try_out(binary: &Path, commit: &str) -> Result<()> {
    let version = shell::output(shell::command(binary).arg("--version"))?;
    ensure!(version.contains(commit), "{} does not name commit {commit}", version.trim());
    let headers = shell::output(shell::command("readelf").arg("--program-headers").arg(binary))?;
    ensure!(!headers.contains("INTERP"), "{} needs shared libraries", binary.display());
    let data = binary.with_file_name("try-out");
    let mut server = shell::command(binary);
    server.args(["serve", "--listen", "127.0.0.1:0", "--data"]).arg(&data);
    let mut server = server.stdout(Stdio::piped()).spawn().context("start the server")?;
    let answer = first_line(&mut server).and_then(|line| ready(&line));
    server.kill().and_then(|()| server.wait()).context("stop the server")?;
    std::fs::remove_dir_all(&data).context("remove the data of the trial")?;
    let answer = answer?;
    ensure!(answer.contains(" 200 "), "the server answers: {answer}");
    println!("{}: static, and serves", version.trim());
    Ok(())
}

/// First line that a program prints.
fn first_line(program: &mut std::process::Child) -> Result<String> {
    let output = program.stdout.take().context("stdout is piped")?;
    let mut line = String::new();
    BufReader::new(output).read_line(&mut line).context("read the output of the server")?;
    Ok(line)
}

/// Status line of the answer of the server that printed a line with its address.
fn ready(line: &str) -> Result<String> {
    let (_, address) = line.trim().split_once("http://").context("find the server's address")?;
    let mut stream = TcpStream::connect(address).context("connect to the server")?;
    let request = format!("GET /readyz HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).context("send a request")?;
    let mut answer = String::new();
    stream.read_to_string(&mut answer).context("read the answer")?;
    answer.lines().next().map(str::to_owned).context("the server sent no answer")
}

/// Makes a folder, or empties it.
fn start_empty(folder: &Path) -> Result<()> {
    if folder.exists() {
        std::fs::remove_dir_all(folder).with_context(|| format!("empty {}", folder.display()))?;
    }
    std::fs::create_dir_all(folder).with_context(|| format!("make {}", folder.display()))
}

fn git(arguments: &[&str]) -> Result<String> {
    let output = shell::output(shell::command("git").args(arguments));
    match output {
        Ok(text) => Ok(text.trim_end().to_owned()),
        Err(error) => bail!("releases are built from a git checkout: {error:#}"),
    }
}
