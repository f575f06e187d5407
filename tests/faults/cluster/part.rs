//! Parts of the cluster: processes with logs, their program, the network between servers, database
//! and people, and the database itself.

use std::ffi::OsString;
use std::fs::File;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Bytes of a log that are printed if the test fails.
const SHOWN: usize = 3000;
/// Longest time for the end of a process after SIGTERM.
const END: Duration = Duration::from_secs(40);

/// Process that can be started again with the same arguments.
pub struct Process {
    words: Vec<OsString>,
    environment: Vec<(&'static str, PathBuf)>,
    log: PathBuf,
    child: Child,
}

impl Process {
    /// Starts a process that appends its output to `log`.
    pub fn start(
        words: Vec<OsString>,
        environment: Vec<(&'static str, PathBuf)>,
        log: PathBuf,
    ) -> Self {
        let child = spawn(&words, &environment, &log);
        Self { words, environment, log, child }
    }

    /// Starts the ended process again.
    pub fn restart(&mut self) {
        self.child = spawn(&self.words, &self.environment, &self.log);
    }

    /// Returns the process id.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Kills the process and waits for its end.
    pub fn kill9(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// Terminates the process; returns its exit code, -1 if a signal ended it.
    pub fn terminate(&mut self) -> i32 {
        signal("-TERM", &[self.child.id()]);
        let start = Instant::now();
        loop {
            if let Some(code) = self.ended() {
                return code;
            }
            assert!(start.elapsed() < END, "{:?} does not end: {}", self.words, self.log());
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Returns the exit code if the process has ended.
    pub fn ended(&mut self) -> Option<i32> {
        let status = self.child.try_wait().unwrap();
        status.map(|status| status.code().unwrap_or(-1))
    }

    /// Returns the output over all starts.
    pub fn log(&self) -> String {
        String::from_utf8_lossy(&std::fs::read(&self.log).unwrap()).into_owned()
    }

    /// Asserts that the process runs and has never panicked.
    pub fn expect_sound(&mut self) {
        let log = self.log();
        if let Some(at) = log.find("panicked") {
            panic!("{}: {}", self.log.display(), log[at..].chars().take(SHOWN).collect::<String>());
        }
        let code = self.ended();
        assert!(code.is_none(), "{} has ended by itself: {code:?}", self.log.display());
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
        if std::thread::panicking() {
            let log = self.log();
            let from = log.len().saturating_sub(SHOWN);
            let from = (from..=log.len()).find(|at| log.is_char_boundary(*at)).unwrap_or(0);
            eprintln!("--- end of {}:\n{}", self.log.display(), &log[from..]);
        }
    }
}

fn spawn(words: &[OsString], environment: &[(&'static str, PathBuf)], log: &Path) -> Child {
    let output = File::options().append(true).create(true).open(log).unwrap();
    Command::new(&words[0])
        .args(&words[1..])
        .envs(environment.iter().map(|(name, value)| (name, value)))
        .stdin(Stdio::null())
        .stdout(output.try_clone().unwrap())
        .stderr(output)
        .spawn()
        .unwrap()
}

/// Program of servers and workers, of which there may be an older build.
pub struct Program {
    path: PathBuf,
    /// Builds to which `path` can lead, the present one first.
    builds: Option<[PathBuf; 2]>,
}

impl Program {
    /// Finds the programs. If there are two, the older one is present, by a link in `folder`.
    pub fn find(folder: &Path) -> Self {
        let newer = brood_tests::binary();
        let Some(older) = std::env::var_os("BROOD_CLUSTER_OLDER") else {
            return Self { path: newer, builds: None };
        };
        let path = folder.join("brood");
        let mut program = Self { path, builds: Some([newer, older.into()]) };
        program.change();
        program
    }

    /// Returns the path of the present build.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// True if there are two builds.
    pub fn can_change(&self) -> bool {
        self.builds.is_some()
    }

    /// Makes the other build the present one, for processes that start from now on.
    pub fn change(&mut self) {
        let builds = self.builds.as_mut().unwrap();
        builds.reverse();
        let new = self.path.with_extension("new");
        symlink(&builds[0], &new).unwrap();
        std::fs::rename(&new, &self.path).unwrap();
    }
}

/// Sends a signal to processes, of which some may have ended.
pub fn signal(name: &str, processes: &[u32]) {
    let ids = processes.iter().map(u32::to_string);
    let _ = Command::new("kill").arg(name).args(ids).stderr(Stdio::null()).status();
}

/// Runs a command.
fn run<S: Into<OsString>>(words: impl IntoIterator<Item = S>) {
    let words: Vec<OsString> = words.into_iter().map(Into::into).collect();
    let output = Command::new(&words[0]).args(&words[1..]).output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{words:?}: {error}");
}

/// Network that connects each server with the database, or with people and workers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Network {
    /// Link of servers to the database.
    Database,
    /// Link of servers to people and workers.
    People,
}

impl Network {
    const ALL: [Self; 2] = [Self::Database, Self::People];

    fn name(self) -> &'static str {
        match self {
            Self::Database => "database",
            Self::People => "people",
        }
    }

    /// Returns an address in this network. Host 1 is the machine of database, people and workers.
    pub fn address(self, host: usize) -> String {
        let network = if self == Self::Database { 1 } else { 2 };
        format!("10.77.{network}.{host}")
    }
}

/// Makes a bridge for each network, in the namespace of this process. `cargo xtask faults` makes
/// that namespace, which ends with the process.
pub fn make_networks() {
    run("ip link set lo up".split(' '));
    for network in Network::ALL {
        let (name, address) = (network.name(), network.address(1));
        run(format!("ip link add {name} type bridge").split(' '));
        run(format!("ip addr add {address}/24 dev {name}").split(' '));
        run(format!("ip link set {name} up").split(' '));
    }
}

/// Lets a name resolve to these addresses, for processes in the mount namespace of this one.
pub fn name_hosts(name: &str, addresses: &[String], folder: &Path) {
    let lines = addresses.iter().map(|address| format!("{address} {name}\n"));
    let hosts = folder.join("hosts");
    std::fs::write(&hosts, format!("127.0.0.1 localhost\n{}", lines.collect::<String>())).unwrap();
    run(["mount".into(), "--bind".into(), hosts.into_os_string(), "/etc/hosts".into()]);
}

/// Network namespace of a server, with a link to each bridge. Links and namespace end with the
/// process that holds them.
pub struct Host {
    number: usize,
    holder: Child,
}

impl Host {
    /// Makes the namespace with this number in both networks.
    pub fn new(number: usize) -> Self {
        let holder = ["--net", "sleep", "infinity"];
        let holder = Command::new("unshare").args(holder).stdin(Stdio::null()).spawn().unwrap();
        let host = Self { number, holder };
        let space = |id: &str| std::fs::read_link(format!("/proc/{id}/ns/net")).unwrap();
        let (id, start) = (host.holder.id().to_string(), Instant::now());
        while space(&id) == space("self") {
            assert!(start.elapsed() < END, "no network namespace was made");
            std::thread::sleep(Duration::from_millis(5));
        }
        for network in Network::ALL {
            let (bridge, link, address) =
                (network.name(), host.link(network), network.address(number));
            run(format!("ip link add {link} type veth peer name {bridge} netns {id}").split(' '));
            run(format!("ip link set {link} master {bridge} up").split(' '));
            for inner in [
                "ip link set lo up".to_owned(),
                format!("ip addr add {address}/24 dev {bridge}"),
                format!("ip link set {bridge} up"),
            ] {
                run(host.enter().into_iter().chain(inner.split(' ').map(OsString::from)));
            }
        }
        host
    }

    /// Returns the words before a command that runs in the namespace. The command replaces them: it
    /// has their process id.
    pub fn enter(&self) -> Vec<OsString> {
        let id = self.holder.id().to_string();
        ["nsenter", "--target", &id, "--net", "--"].map(OsString::from).into()
    }

    /// Takes the link to a network down at the bridge: packets are lost, and neither side gets an
    /// error.
    pub fn cut(&self, network: Network) {
        run(format!("ip link set {} down", self.link(network)).split(' '));
    }

    /// Takes the link up again.
    pub fn connect(&self, network: Network) {
        run(format!("ip link set {} up", self.link(network)).split(' '));
    }

    /// Name of the link's end at the bridge.
    fn link(&self, network: Network) -> String {
        format!("{}{}", network.name(), self.number)
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        let _ = self.holder.kill();
        let _ = self.holder.wait();
    }
}

/// PostgreSQL cluster that `cargo xtask faults` has made.
pub struct Database {
    /// `pg_ctl` with its arguments, without its command.
    control: Vec<OsString>,
    data: PathBuf,
}

impl Database {
    /// Returns the cluster; `None` if there is none.
    pub fn find() -> Option<Self> {
        let control = std::env::var("BROOD_CLUSTER_CONTROL").ok()?;
        let data = std::env::var_os("BROOD_CLUSTER_DATA")?.into();
        Some(Self { control: control.lines().map(OsString::from).collect(), data })
    }

    /// Starts the cluster and waits until it answers.
    pub fn start(&self) {
        self.run(&["start"]);
    }

    /// Ends the cluster without a checkpoint and starts it again.
    pub fn restart(&self) {
        self.run(&["--mode=immediate", "restart"]);
    }

    /// Kills all processes of the cluster.
    pub fn kill9(&self) {
        let text = std::fs::read_to_string(self.data.join("postmaster.pid")).unwrap();
        let postmaster: u32 = text.lines().next().unwrap().parse().unwrap();
        let mut processes = vec![postmaster];
        processes.extend(children(postmaster));
        signal("-KILL", &processes);
        let start = Instant::now();
        while processes.iter().any(|id| Path::new(&format!("/proc/{id}")).exists()) {
            assert!(start.elapsed() < END, "PostgreSQL does not end");
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    fn run(&self, command: &[&str]) {
        let output = Command::new(&self.control[0])
            .args(&self.control[1..])
            .args(command)
            // The folder of the repository may be closed to the user of the cluster.
            .current_dir(std::env::temp_dir())
            .stdin(Stdio::null())
            .output()
            .unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        assert!(output.status.success(), "{} {}", text(&output.stdout), text(&output.stderr));
    }
}

/// Children of a process.
fn children(parent: u32) -> Vec<u32> {
    let all = std::fs::read_dir("/proc").unwrap().filter_map(|entry| {
        let id: u32 = entry.ok()?.file_name().to_str()?.parse().ok()?;
        // The process may have ended meanwhile.
        let status = std::fs::read_to_string(format!("/proc/{id}/status")).ok()?;
        let found = status.lines().find_map(|line| line.strip_prefix("PPid:"))?;
        (found.trim() == parent.to_string()).then_some(id)
    });
    all.collect()
}
