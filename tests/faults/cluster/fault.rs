//! Kinds of faults, and the cluster that they happen to.

use std::time::{Duration, Instant};

use tempfile::TempDir;

use super::balancer::Balancer;
use super::part::{Database, Host, Network, Process, Program, signal};
use crate::layer::Layer;
use crate::workers_of;

/// Error of a clock, in seconds.
const SKEW: i64 = 60;
/// Time for which a worker is stopped before it is killed.
const STOPPED: Duration = Duration::from_millis(100);
/// Longest time until a restarted server is ready.
const READY: Duration = Duration::from_secs(60);

/// Fault of a round.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// kill -9 of a server, which is started again.
    ServerKilled,
    /// kill -9 of a worker that renders.
    WorkerKilled,
    /// kill -9 of the worker that searches and exports.
    SearcherKilled,
    /// kill -9 of all processes of PostgreSQL.
    DatabaseKilled,
    /// PostgreSQL stopped without a checkpoint and started again.
    DatabaseRestarted,
    /// A server without its link to the database.
    CutFromDatabase,
    /// A server without its link to people and workers.
    CutFromPeople,
    /// A jump of a server's time of day while it runs, and its restart.
    ClockSkewed,
    /// All servers stopped and started, one by one.
    ServersRolled,
    /// All servers and workers replaced by those of another build, one by one.
    BuildChanged,
}

impl Kind {
    /// Every kind. The last one needs two builds.
    pub const ALL: [Self; 10] = [
        Self::ServerKilled,
        Self::WorkerKilled,
        Self::SearcherKilled,
        Self::DatabaseKilled,
        Self::DatabaseRestarted,
        Self::CutFromDatabase,
        Self::CutFromPeople,
        Self::ClockSkewed,
        Self::ServersRolled,
        Self::BuildChanged,
    ];

    /// Kinds that need one build.
    pub const OF_ONE_BUILD: &[Self] = Self::ALL.split_at(Self::ALL.len() - 1).0;

    /// Kinds that need neither a database of their own nor networks.
    pub const OF_PROCESSES: [Self; 3] =
        [Self::ServerKilled, Self::WorkerKilled, Self::ServersRolled];

    /// Words for the figures.
    pub fn name(self) -> &'static str {
        match self {
            Self::ServerKilled => "kill -9 of a server",
            Self::WorkerKilled => "kill -9 of a worker",
            Self::SearcherKilled => "kill -9 of the searching worker",
            Self::DatabaseKilled => "kill -9 of PostgreSQL",
            Self::DatabaseRestarted => "immediate restart of PostgreSQL",
            Self::CutFromDatabase => "server cut from the database",
            Self::CutFromPeople => "server cut from people and workers",
            Self::ClockSkewed => "clock of a server moved by 60 s or back",
            Self::ServersRolled => "restart of all servers, one by one",
            Self::BuildChanged => "upgrade to another build or back, one by one",
        }
    }
}

/// Server with what it needs.
pub struct Server {
    /// Process.
    pub process: Process,
    /// Namespace; `None` in the short form.
    pub host: Option<Host>,
    /// Clock of the server, and its present error; `None` in the short form.
    pub clock: Option<(Layer, i64)>,
    /// Data directory, kept as long as the server.
    pub _data: TempDir,
}

/// Cluster under test.
pub struct Cluster {
    /// Servers.
    pub servers: Vec<Server>,
    /// Workers that render; empty if they are children of the servers.
    pub renderers: Vec<Process>,
    /// Worker that searches and exports; empty if it is a child of a server.
    pub searchers: Vec<Process>,
    /// Database; `None` in the short form.
    pub database: Option<Database>,
    /// Program of servers and workers; `None` in the short form.
    pub program: Option<Program>,
}

impl Cluster {
    /// Lets a fault happen and mends it. Returns the time for which the database was away.
    pub async fn suffer(
        &mut self,
        kind: Kind,
        next: &mut impl FnMut(u64) -> u64,
        balancer: &Balancer,
    ) -> Duration {
        let start = Instant::now();
        let one = next(self.servers.len() as u64) as usize;
        let away = Duration::from_millis(500 + next(3000));
        match kind {
            Kind::ServerKilled => {
                self.servers[one].process.kill9();
                tokio::time::sleep(away).await;
                self.servers[one].process.restart();
                until_ready(balancer, one).await;
            }
            Kind::WorkerKilled if self.renderers.is_empty() => {
                // The server starts another one.
                signal("-KILL", &workers_of(self.servers[one].process.id(), false));
            }
            Kind::WorkerKilled => {
                let one = next(self.renderers.len() as u64) as usize;
                // A stopped worker gets a job before it is killed.
                signal("-STOP", &[self.renderers[one].id()]);
                tokio::time::sleep(STOPPED).await;
                kill_and_restart(&mut self.renderers[one], away).await;
            }
            Kind::SearcherKilled => kill_and_restart(&mut self.searchers[0], away).await,
            Kind::DatabaseKilled => {
                self.database.as_ref().unwrap().kill9();
                self.database.as_ref().unwrap().start();
                return start.elapsed();
            }
            Kind::DatabaseRestarted => {
                self.database.as_ref().unwrap().restart();
                return start.elapsed();
            }
            Kind::CutFromDatabase | Kind::CutFromPeople => {
                let from_database = kind == Kind::CutFromDatabase;
                let network = if from_database { Network::Database } else { Network::People };
                let host = self.servers[one].host.as_ref().unwrap();
                host.cut(network);
                tokio::time::sleep(Duration::from_millis(5000 + next(3000))).await;
                host.connect(network);
            }
            Kind::ClockSkewed => {
                let server = &mut self.servers[one];
                let (layer, error) = server.clock.as_mut().unwrap();
                let others: Vec<i64> =
                    [-SKEW, 0, SKEW].into_iter().filter(|other| other != error).collect();
                *error = others[next(2) as usize];
                layer.move_clock(*error);
                tokio::time::sleep(away).await;
                assert_eq!(server.process.terminate(), 0, "{}", server.process.log());
                server.process.restart();
                until_ready(balancer, one).await;
            }
            Kind::ServersRolled => self.roll(balancer).await,
            Kind::BuildChanged => {
                self.program.as_mut().unwrap().change();
                self.roll(balancer).await;
                for worker in self.renderers.iter_mut().chain(&mut self.searchers) {
                    assert_eq!(worker.terminate(), 0, "{}", worker.log());
                    worker.restart();
                }
            }
        }
        Duration::ZERO
    }

    /// Restarts all servers, one by one.
    async fn roll(&mut self, balancer: &Balancer) {
        for (index, server) in self.servers.iter_mut().enumerate() {
            assert_eq!(server.process.terminate(), 0, "{}", server.process.log());
            server.process.restart();
            until_ready(balancer, index).await;
            balancer.until_up(index).await;
        }
    }

    /// Asserts that all processes run and none has panicked.
    pub fn expect_sound(&mut self) {
        let servers = self.servers.iter_mut().map(|server| &mut server.process);
        let workers = self.renderers.iter_mut().chain(&mut self.searchers);
        servers.chain(workers).for_each(Process::expect_sound);
    }
}

async fn kill_and_restart(process: &mut Process, away: Duration) {
    process.kill9();
    tokio::time::sleep(away).await;
    process.restart();
}

/// Waits until a server that was started is ready.
pub async fn until_ready(balancer: &Balancer, index: usize) {
    let start = Instant::now();
    while !balancer.is_ready(index).await {
        assert!(start.elapsed() < READY, "server {index} does not become ready");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}
