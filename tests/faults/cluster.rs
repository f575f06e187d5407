//! Faults of a cluster under load: three servers over one PostgreSQL database, workers at all of
//! them, and people who breed through a balancer. `cargo xtask faults --cluster` runs the long
//! form, in namespaces of its own.
//!
//! Every acknowledged generation is there once and unchanged, every picture has the same bytes
//! everywhere, every search ends like an undisturbed one, and no job is stuck.

mod balancer;
mod fault;
mod load;
mod part;

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::time::{Duration, Instant};

use brood_tests::{binary, database_of, text_of};
use serde_json::Value;
use tempfile::TempDir;
use tokio::task::JoinSet;

use self::balancer::{Balancer, Call};
use self::fault::{Cluster, Kind, Server, until_ready};
use self::load::{Load, PEOPLE, Waits, hash, hash_of};
use self::part::{Database, Host, Network, Process, Program, make_networks, name_hosts};
use crate::layer::Layer;
use crate::{compare_by, draw};

const SERVERS: usize = 3;
const RENDERERS: usize = 3;
/// Number of the first server's host; host 1 is the machine of all others.
const FIRST_HOST: usize = 11;
const PORT: u16 = 7320;
/// Name that resolves to the addresses of all servers.
const NAME: &str = "servers";
/// Rounds after which everything acknowledged since is compared.
const CHECK_EVERY: u64 = 10;
/// Longest time until service is whole after a fault was mended.
const WHOLE: Duration = Duration::from_secs(120);
/// Longest time until no job runs after the load has ended.
const IDLE: Duration = Duration::from_secs(30);
/// Longest wait for a brood or a picture after the loss of a process.
const GOAL: Duration = Duration::from_secs(5);
/// Number of pictures that a server with an empty cache renders again at the end.
const RENDERED_AGAIN: usize = 2000;

/// Size of a campaign.
struct Plan {
    seed: u64,
    rounds: u64,
    /// Least time of a round.
    each: Duration,
    kinds: &'static [Kind],
    /// True if searches and exports run.
    has_jobs: bool,
}

/// Number in an environment variable.
fn number(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.parse().ok()
}

#[tokio::test(flavor = "multi_thread")]
async fn campaign_loses_nothing_and_leaves_nothing_behind() {
    // Only in the namespaces that `cargo xtask faults --cluster` has made.
    let Some(database) = Database::find() else { return };
    let rounds = number("BROOD_CLUSTER_ROUNDS").unwrap_or(100);
    let each = Duration::from_secs(60 * number("BROOD_CLUSTER_MINUTES").unwrap_or(0));
    let each = each / u32::try_from(rounds).unwrap();
    let seed = number("BROOD_CLUSTER_SEED").unwrap_or(1);
    make_networks();
    database.start();
    let folder = TempDir::new().unwrap();
    let logs = PathBuf::from(std::env::var_os("BROOD_CLUSTER_LOGS").unwrap());
    let address = format!("postgres://brood@{}/postgres", Network::Database.address(1));
    let program = Program::find(folder.path());
    let token = |name: &str, scope: &str| {
        let mut add = Command::new(program.path());
        add.args(["token", "add", name, "--scope", scope, "--database", &address, "--data"]);
        let output = add.arg(folder.path().join("commands")).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    };
    let (people, work) = (token("people", "admin"), token("workers", "work"));

    let addresses: Vec<String> =
        (0..SERVERS).map(|index| Network::People.address(FIRST_HOST + index)).collect();
    name_hosts(NAME, &addresses, folder.path());
    let servers = addresses.iter().enumerate().map(|(index, host_address)| {
        let (host, layer, data) =
            (Host::new(FIRST_HOST + index), Layer::build(), TempDir::new().unwrap());
        let mut environment = layer.options(data.path()).environment;
        environment.push(("BROOD_DATABASE", PathBuf::from(&address)));
        let mut words = host.enter();
        words.extend(serve(program.path(), &format!("{host_address}:{PORT}"), "0", &data));
        words.extend(["--allow-host", NAME].map(OsString::from));
        let log = logs.join(format!("server-{index}.log"));
        let process = Process::start(words, environment, log);
        Server { process, host: Some(host), clock: Some((layer, 0)), _data: data }
    });
    let servers = servers.collect();
    let worker = |name: String, options: &[&str]| {
        let url = format!("http://{NAME}:{PORT}");
        let mut words = vec![program.path().into()];
        words.extend(["worker", "--server", &url, "--backend", "cpu"].map(OsString::from));
        words.extend(["--threads", "1", "--name", &name].map(OsString::from));
        words.extend(options.iter().map(OsString::from));
        let log = logs.join(format!("{name}.log"));
        Process::start(words, vec![("BROOD_TOKEN", PathBuf::from(&work))], log)
    };
    let renderers = (0..RENDERERS).map(|index| worker(format!("worker-{index}"), &[])).collect();
    let searchers = vec![worker("searching".to_owned(), &["--searches"])];
    let addresses: Vec<String> =
        addresses.iter().map(|address| format!("{address}:{PORT}")).collect();
    let balancer = Balancer::start(&addresses, Some(people.clone()));
    let kinds = if program.can_change() { &Kind::ALL } else { Kind::OF_ONE_BUILD };
    let (database, program) = (Some(database), Some(program));
    let cluster = Cluster { servers, renderers, searchers, database, program };
    let plan = Plan { seed, rounds, each, kinds, has_jobs: true };
    let load = survive(cluster, &balancer, plan, |data| {
        let host = Network::People.address(1);
        let words = serve(&binary(), &format!("{host}:{PORT}"), "1", data);
        let environment = vec![("BROOD_DATABASE", PathBuf::from(&address))];
        let log = logs.join("undisturbed.log");
        let server = Process::start(words, environment, log);
        (server, Balancer::start(&[format!("{host}:{PORT}")], Some(people)))
    });
    load.await;
}

/// Short form for each run of the tests on PostgreSQL: servers with workers of their own.
#[tokio::test(flavor = "multi_thread")]
async fn servers_that_are_killed_under_load_lose_nothing() {
    let (folder, shared) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let Some(address) = database_of(shared.path()) else { return };
    // The sockets are open until all numbers are known, so that they differ.
    let ports: Vec<_> =
        (0..=SERVERS).map(|_| std::net::TcpListener::bind("127.0.0.1:0").unwrap()).collect();
    let addresses: Vec<String> =
        ports.iter().map(|port| port.local_addr().unwrap().to_string()).collect();
    drop(ports);
    let environment = vec![("BROOD_DATABASE", PathBuf::from(&address))];
    let servers = addresses[1..].iter().enumerate().map(|(index, listen)| {
        let data = TempDir::new().unwrap();
        let log = folder.path().join(format!("server-{index}.log"));
        let words = serve(&binary(), listen, "1", &data);
        let process = Process::start(words, environment.clone(), log);
        Server { process, host: None, clock: None, _data: data }
    });
    let servers = servers.collect();
    let (renderers, searchers) = (Vec::new(), Vec::new());
    let cluster = Cluster { servers, renderers, searchers, database: None, program: None };
    let balancer = Balancer::start(&addresses[1..], None);
    let kinds = &Kind::OF_PROCESSES;
    let rounds = kinds.len() as u64;
    let plan = Plan { seed: 1, rounds, each: Duration::ZERO, kinds, has_jobs: false };
    let last = |data: &TempDir| {
        let log = folder.path().join("undisturbed.log");
        let words = serve(&binary(), &addresses[0], "1", data);
        let server = Process::start(words, environment.clone(), log);
        (server, Balancer::start(&addresses[..1], None))
    };
    survive(cluster, &balancer, plan, last).await;
}

/// Command of a server.
fn serve(program: &Path, listen: &str, workers: &str, data: &TempDir) -> Vec<OsString> {
    let mut words = vec![program.into()];
    words.extend(["serve", "--listen", listen, "--workers", workers].map(OsString::from));
    words.extend(["--backend", "cpu", "--data"].map(OsString::from));
    words.push(data.path().into());
    words
}

/// Runs a campaign and prints its figures. `undisturbed` starts a server with an empty cache, which
/// renders pictures again at the end.
async fn survive(
    mut cluster: Cluster,
    balancer: &Arc<Balancer>,
    plan: Plan,
    undisturbed: impl FnOnce(&TempDir) -> (Process, Arc<Balancer>),
) {
    let prepared = Instant::now();
    for index in 0..balancer.count() {
        until_ready(balancer, index).await;
        balancer.until_up(index).await;
    }
    let (load, mut tasks) = (Load::new(Arc::clone(balancer), plan.seed), JoinSet::new());
    if plan.has_jobs {
        load.start_jobs(&mut tasks).await;
    }
    load.start(&mut tasks);
    println!("cluster: load runs after {:.1} s", prepared.elapsed().as_secs_f64());
    let (mut next, start) = (draw(plan.seed), Instant::now());
    let (mut deck, mut kinds) = (Vec::new(), BTreeMap::<Kind, Outcome>::new());
    for round in 1..=plan.rounds {
        let begun = Instant::now();
        if deck.is_empty() {
            deck.extend(plan.kinds);
        }
        let kind = deck.swap_remove(next(deck.len() as u64) as usize);
        let away = cluster.suffer(kind, &mut next, balancer).await;
        until_whole(&load, balancer, &mut tasks).await;
        let waits = std::mem::take(&mut load.record.lock().unwrap().waits);
        println!(
            "round {round}: {}: {:.1} s; longest wait for a brood {:.1} s, for a picture {:.1} s, {} clicks",
            kind.name(),
            begun.elapsed().as_secs_f64(),
            waits.brood.as_secs_f64(),
            waits.picture.as_secs_f64(),
            waits.clicks
        );
        kinds.entry(kind).or_default().add(waits, away);
        cluster.expect_sound();
        if round % CHECK_EVERY == 0 {
            let _alone = load.turn.write().await;
            compare_all(&load, balancer, round, false).await;
        }
        tokio::time::sleep(plan.each.saturating_sub(begun.elapsed())).await;
    }
    let seconds = start.elapsed().as_secs();
    load.stop();
    while let Some(ended) = tasks.join_next().await {
        ended.unwrap();
    }
    compare_all(&load, balancer, plan.rounds, true).await;
    expect_idle(&load, balancer, &cluster).await;
    cluster.expect_sound();
    let data = TempDir::new().unwrap();
    let (server, alone) = undisturbed(&data);
    let again = render_again(&load, &alone).await;
    drop(server);
    print_figures(&load, &plan, seconds, again, &kinds);
    let faults = balancer.faults();
    assert!(faults.is_empty(), "answers with status 500: {faults:#?}");
}

/// Outcome of all rounds of a kind.
#[derive(Default)]
struct Outcome {
    count: u32,
    missed: u32,
    waits: Waits,
    away: Duration,
}

impl Outcome {
    fn add(&mut self, waits: Waits, away: Duration) {
        self.count += 1;
        self.missed += u32::from(waits.brood.max(waits.picture) > GOAL || waits.clicks > 0);
        self.waits.add(waits);
        self.away = self.away.max(away);
    }
}

/// Waits until every server gets requests, and each person has a brood that was asked for after
/// the call.
async fn until_whole(load: &Load, balancer: &Balancer, tasks: &mut JoinSet<()>) {
    let broods = || load.record.lock().unwrap().broods;
    let (before, start) = (broods(), Instant::now());
    for index in 0..balancer.count() {
        balancer.until_up(index).await;
    }
    // The first brood may have been asked for before the call.
    while (0..PEOPLE).any(|person| broods()[person] < before[person] + 2) {
        if let Some(ended) = tasks.try_join_next() {
            panic!("load has ended by itself: {ended:?}");
        }
        assert!(start.elapsed() < WHOLE, "service is not whole: {before:?} {:?}", broods());
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}

/// Compares lineages with what was acknowledged: those with news, or all.
async fn compare_all(load: &Load, balancer: &Balancer, round: u64, all: bool) {
    let lineages = load.record.lock().unwrap().lineages.clone();
    let newest = lineages.len().saturating_sub(2 * PEOPLE);
    for (number, lineage) in &lineages {
        if lineage.checked && !all {
            continue;
        }
        let (mut listed, mut page) = (Vec::new(), format!("{}?limit=200", lineage.path));
        loop {
            let mut list = balancer.send(*number, &Call::get(page)).await.json();
            listed.append(list["items"].as_array_mut().unwrap());
            match &list["next"] {
                Value::Null => break,
                cursor => page = format!("{}?limit=200&cursor={}", lineage.path, text_of(cursor)),
            }
        }
        compare_by(&lineage.births, &listed, round, hash_of);
        let mut record = load.record.lock().unwrap();
        record.lineages.get_mut(number).unwrap().checked = *number < newest;
    }
}

/// Asserts that no job is left, and that no search or export was made twice.
async fn expect_idle(load: &Load, balancer: &Balancer, cluster: &Cluster) {
    let start = Instant::now();
    for index in 0..cluster.servers.len() {
        loop {
            let text = balancer.send(index, &Call::get("/metrics")).await.body;
            let text = String::from_utf8(text).unwrap();
            let left = text.lines().filter(|line| {
                let is_job = ["brood_jobs{", "brood_searches{", "brood_exports{"];
                let is_open = ["queued", "leased", "running"];
                is_job.iter().any(|name| line.starts_with(name))
                    && is_open.iter().any(|state| line.contains(&format!("state=\"{state}\"")))
                    && !line.ends_with(" 0")
            });
            let left: Vec<&str> = left.collect();
            let (searches, exports) = {
                let record = load.record.lock().unwrap();
                (record.searches, record.exports)
            };
            if left.is_empty() {
                assert_eq!(sum(&text, "brood_searches{"), searches, "{text}");
                assert_eq!(sum(&text, "brood_exports{"), exports, "{text}");
                break;
            }
            assert!(start.elapsed() < IDLE, "stuck at server {index}: {left:?}");
            tokio::time::sleep(Duration::from_millis(200)).await;
        }
    }
}

/// Sum of a metric over its labels.
fn sum(text: &str, name: &str) -> u64 {
    let lines = text.lines().filter(|line| line.starts_with(name));
    lines.filter_map(|line| line.rsplit_once(' ')?.1.parse::<u64>().ok()).sum()
}

/// Loads pictures from a server with an empty cache and compares them. Returns their number.
async fn render_again(load: &Load, alone: &Balancer) -> usize {
    until_ready(alone, 0).await;
    alone.until_up(0).await;
    let pictures = load.record.lock().unwrap().pictures.clone();
    let step = pictures.len().div_ceil(RENDERED_AGAIN).max(1);
    let mut count = 0;
    for (url, first) in pictures.iter().step_by(step) {
        let body = alone.send(0, &Call::get(url)).await.body;
        assert_eq!(hash(&body), *first, "{url} has other bytes at an undisturbed server");
        count += 1;
    }
    count
}

fn print_figures(
    load: &Load,
    plan: &Plan,
    seconds: u64,
    again: usize,
    kinds: &BTreeMap<Kind, Outcome>,
) {
    let record = load.record.lock().unwrap();
    println!(
        "fault: cluster: {} rounds in {seconds} s, seed {}: {} generations acknowledged in {} lineages, 0 lost, \
         0 twice; {} pictures loaded, {again} rendered again, {} searches, {} exports, all with the right bits, 0 stuck",
        plan.rounds,
        plan.seed,
        record.broods.iter().sum::<u64>(),
        record.lineages.len(),
        record.loaded,
        record.searches,
        record.exports
    );
    for (kind, outcome) in kinds {
        let away = match outcome.away {
            Duration::ZERO => String::new(),
            away => format!("; PostgreSQL was away for {:.1} s at most", away.as_secs_f64()),
        };
        println!(
            "fault: cluster, {}: {} times, longest wait for a brood {:.1} s, for a picture {:.1} s, {} clicks, \
             goal of {} s missed {} times{away}",
            kind.name(),
            outcome.count,
            outcome.waits.brood.as_secs_f64(),
            outcome.waits.picture.as_secs_f64(),
            outcome.waits.clicks,
            GOAL.as_secs(),
            outcome.missed
        );
    }
}
