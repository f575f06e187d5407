//! `cargo xtask packaging`: checks the files of `packaging/` with the programs that read them, as
//! far as those run without a network, a cluster and containers.
//!
//! The metrics that the files name must exist in the server, and every expression must be PromQL.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use anyhow::{Context, Result, ensure};
use regex::Regex;
use serde_json::{Value, json};

use crate::prerequisite::{self, PACKAGING_PROGRAMS};
use crate::python::Python;
use crate::{shell, suite};

/// Oldest version of Kubernetes that the manifests are for, and the newest that is known.
const KUBERNETES: [&str; 2] = ["1.29", "1.37"];
/// Units of systemd.
const UNITS: [&str; 2] = ["brood.service", "brood-worker@.service"];
/// Program of the units, which is not installed here.
const BINARY: &str = "/usr/local/bin/brood";
/// Files with names of metrics.
const WITH_METRICS: [&str; 4] =
    ["grafana.json", "kubernetes.yaml", "prometheus-adapter.yaml", "rules.yaml"];

static METRIC: LazyLock<Regex> =
    LazyLock::new(|| Regex::new(r"\bbrood_[a-z0-9_]+").expect("pattern is valid"));

/// Runs all checks.
pub fn run() -> Result<()> {
    check(&suite::target_directory()?)
}

/// Runs all checks, with files of their own in the target directory. A failed one does not stop the
/// others.
pub fn check(target: &Path) -> Result<()> {
    prerequisite::install_programs(&PACKAGING_PROGRAMS)?;
    let folder = target.join("packaging");
    let python = Python::at(&folder);
    python.prepare()?;
    python.install(&shell::root().join("tests/packaging/packages.txt"))?;
    let checks = [
        ("metrics", metrics()),
        ("expressions", expressions(&folder)),
        ("rules", promtool(&["check", "rules"], "rules.yaml")),
        // The file with the token is missing here.
        ("Prometheus", promtool(&["check", "config", "--syntax-only"], "prometheus.yaml")),
        ("Kubernetes", kubernetes(&python)),
        ("container file", shell::run(python.tool("hadolint").arg(packaging("Containerfile")))),
        ("YAML", yaml(&python)),
        ("HAProxy", haproxy()),
        ("systemd", systemd(&folder)),
        ("Compose", compose()),
    ];
    let mut failed = Vec::new();
    for (name, outcome) in checks {
        if let Err(error) = outcome {
            eprintln!("{name}: {error:#}");
            failed.push(name);
        }
    }
    ensure!(failed.is_empty(), "files of packaging/ are wrong: {}", failed.join(", "));
    Ok(())
}

/// Path of a file of `packaging/`.
fn packaging(name: &str) -> PathBuf {
    shell::root().join("packaging").join(name)
}

fn read(name: &str) -> Result<String> {
    let path = packaging(name);
    std::fs::read_to_string(&path).with_context(|| format!("read {}", path.display()))
}

/// Every metric that a file names must be one that the server has.
fn metrics() -> Result<()> {
    let server = source(&shell::root().join("server/src"))?;
    let mut missing = Vec::new();
    for file in WITH_METRICS {
        let text = read(file)?;
        let names: BTreeSet<&str> = METRIC.find_iter(&text).map(|found| found.as_str()).collect();
        ensure!(!names.is_empty(), "{file} names no metric");
        missing.extend(
            names
                .into_iter()
                .filter(|name| !is_in(&server, name))
                .map(|name| format!("{name} in {file}")),
        );
    }
    ensure!(missing.is_empty(), "metrics that the server does not have: {}", missing.join(", "));
    Ok(())
}

/// True if source code has the name of a metric. The series of a histogram have longer names.
fn is_in(source: &str, name: &str) -> bool {
    let has = |name: &str| source.contains(&format!("\"{name}\""));
    let series = ["_bucket", "_count", "_sum"];
    has(name) || series.iter().filter_map(|suffix| name.strip_suffix(*suffix)).any(has)
}

/// Text of all Rust files below a folder.
fn source(folder: &Path) -> Result<String> {
    let mut text = String::new();
    let entries =
        std::fs::read_dir(folder).with_context(|| format!("list {}", folder.display()))?;
    for entry in entries {
        let path = entry?.path();
        if path.is_dir() {
            text += &source(&path)?;
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let file = std::fs::read_to_string(&path);
            text += &file.with_context(|| format!("read {}", path.display()))?;
        }
    }
    Ok(text)
}

/// Checks the expressions of the dashboard and of the adapter: promtool reads those of rules.
fn expressions(folder: &Path) -> Result<()> {
    let dashboard: Value = serde_json::from_str(&read("grafana.json")?).context("parse it")?;
    let mut found = Vec::new();
    collect_expressions(&dashboard, &mut found);
    let adapter = read("prometheus-adapter.yaml")?;
    let queries = adapter.lines().filter_map(|line| line.trim().strip_prefix("metricsQuery: "));
    let before = found.len();
    found.extend(queries.map(|query| {
        let named = query.replace("<<.Series>>", "brood_jobs");
        named.replace("<<.LabelMatchers>>", "namespace=\"default\"")
    }));
    ensure!(before > 0 && found.len() > before, "expressions are in places that are not known");
    let rules: Vec<Value> = found
        .iter()
        .enumerate()
        .map(|(number, text)| json!({"record": format!("expression:{number}"), "expr": text}))
        .collect();
    // YAML includes JSON.
    let document = json!({"groups": [{"name": "expressions", "rules": rules}]});
    let file = folder.join("expressions.json");
    std::fs::write(&file, document.to_string()).context("write the expressions")?;
    shell::run(shell::command("promtool").args(["check", "rules"]).arg(&file))
}

/// Adds the strings of all fields `expr`.
fn collect_expressions(value: &Value, found: &mut Vec<String>) {
    match value {
        Value::Array(items) => items.iter().for_each(|item| collect_expressions(item, found)),
        Value::Object(fields) => {
            found.extend(fields.get("expr").and_then(Value::as_str).map(str::to_owned));
            fields.values().for_each(|field| collect_expressions(field, found));
        }
        _ => {}
    }
}

fn promtool(arguments: &[&str], file: &str) -> Result<()> {
    shell::run(shell::command("promtool").args(arguments).arg(packaging(file)))
}

/// Checks the manifests with the schemas of Kubernetes, which know every field.
fn kubernetes(python: &Python) -> Result<()> {
    let mut validate = python.tool("kubernetes-validate");
    validate.args(["--strict", "--quiet"]);
    for version in KUBERNETES {
        validate.args(["--kubernetes-version", version]);
    }
    shell::run(validate.arg(packaging("kubernetes.yaml")))
}

/// Reads the YAML files that no other program checks.
fn yaml(python: &Python) -> Result<()> {
    let read = "import sys, yaml\nfor name in sys.argv[1:]: yaml.safe_load(open(name))";
    let mut command = python.command();
    command.args(["-c", read]);
    shell::run(command.arg(packaging("compose.yaml")).arg(packaging("prometheus-adapter.yaml")))
}

/// Checks the balancer's configuration. A warning is an error.
fn haproxy() -> Result<()> {
    let program = shell::find_program("haproxy").context("find haproxy")?;
    let mut haproxy = shell::command(program);
    haproxy.env("SERVERS", "localhost:7320").args(["-c", "-dW", "-f"]);
    shell::run(haproxy.arg(packaging("haproxy.cfg")))
}

/// Checks the units, with a program that is installed here.
fn systemd(folder: &Path) -> Result<()> {
    let mut verify = shell::command("systemd-analyze");
    verify.args(["verify", "--recursive-errors=no"]);
    for unit in UNITS {
        let text = read(unit)?;
        ensure!(text.contains(BINARY), "{unit} does not start {BINARY}");
        let file = folder.join(unit);
        std::fs::write(&file, text.replace(BINARY, "/bin/true"))
            .with_context(|| format!("write {}", file.display()))?;
        verify.arg(file);
    }
    shell::run(&mut verify)
}

/// Checks the compose file if Docker has its plugin Compose, which no package of Debian has.
fn compose() -> Result<()> {
    let docker = || shell::command("docker");
    if shell::output(docker().args(["compose", "version"])).is_err() {
        println!("skipped: docker compose config, since Docker with its plugin Compose is missing");
        return Ok(());
    }
    let mut config = docker();
    config.args(["compose", "--file"]).arg(packaging("compose.yaml")).args(["config", "--quiet"]);
    shell::run(config.env("DATABASE_PASSWORD", "secret"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metrics_of_the_source_are_found_by_the_names_of_their_series() {
        let source = r#"histogram("brood_make_seconds", ""), counter("brood_births_total", "")"#;
        for name in ["brood_make_seconds", "brood_make_seconds_bucket", "brood_births_total"] {
            assert!(is_in(source, name), "{name}");
        }
        for name in ["brood_make", "brood_births", "brood_make_seconds_total"] {
            assert!(!is_in(source, name), "{name}");
        }
    }

    #[test]
    fn expressions_are_found_at_every_depth() {
        let mut found = Vec::new();
        let panels = json!({"panels": [{"targets": [{"expr": "a"}, {"expr": "b"}]}], "expr": "c"});
        collect_expressions(&panels, &mut found);
        found.sort();
        assert_eq!(found, ["a", "b", "c"]);
    }

    #[test]
    fn files_name_metrics_that_the_server_has() {
        metrics().unwrap();
    }
}
