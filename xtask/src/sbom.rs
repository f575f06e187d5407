//! Software bill of materials of a release: the crates in the binary, with versions, licences and
//! checksums, in the JSON form of CycloneDX 1.5.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use anyhow::{Context, Result};
use serde_json::{Value, json};

use crate::shell;

/// Returns the document for a binary without the feature `gpu` on a target.
pub fn document(target: &str, commit: &str) -> Result<Value> {
    let mut cargo = shell::cargo();
    cargo.args(["metadata", "--format-version", "1", "--locked", "--no-default-features"]);
    let text = shell::output(cargo.args(["--filter-platform", target]))?;
    let metadata: Value = serde_json::from_str(&text).context("parse cargo metadata")?;
    let lock =
        std::fs::read_to_string(shell::root().join("Cargo.lock")).context("read Cargo.lock")?;
    Ok(from(&metadata, &checksums(&lock), commit))
}

fn from(metadata: &Value, checksums: &BTreeMap<(String, String), String>, commit: &str) -> Value {
    let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let packages = list(&metadata["packages"]);
    let nodes = list(&metadata["resolve"]["nodes"]);
    let by_id: BTreeMap<&str, &Value> = packages.iter().map(|one| (text(one, "id"), one)).collect();
    let needs: BTreeMap<&str, Vec<&str>> =
        nodes.iter().map(|node| (text(node, "id"), normal_needs(node))).collect();
    let binary = packages.iter().find(|one| text(one, "name") == "brood");
    let mut reached = BTreeSet::new();
    let mut next: VecDeque<&str> = binary.iter().map(|one| text(one, "id")).collect();
    while let Some(id) = next.pop_front() {
        if reached.insert(id) {
            next.extend(needs.get(id).into_iter().flatten());
        }
    }
    let external =
        reached.iter().filter_map(|id| by_id.get(id)).filter(|one| !one["source"].is_null());
    let components = external.map(|one| {
        let (name, version) = (text(one, "name"), text(one, "version"));
        let mut component = json!({
            "type": "library",
            "name": name,
            "version": version,
            "purl": format!("pkg:cargo/{name}@{version}"),
            "licenses": [{"expression": text(one, "license").replace('/', " OR ")}],
        });
        if let Some(sum) = checksums.get(&(name.to_owned(), version.to_owned())) {
            component["hashes"] = json!([{"alg": "SHA-256", "content": sum}]);
        }
        component
    });
    json!({
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {"component": {
            "type": "application",
            "name": "brood",
            "version": format!("{}+{commit}", env!("CARGO_PKG_VERSION")),
        }},
        "components": components.collect::<Vec<_>>(),
    })
}

/// Packages that a package needs to run, not to be built or tested.
fn normal_needs(node: &Value) -> Vec<&str> {
    let is_normal = |need: &&Value| {
        let kinds = need["dep_kinds"].as_array();
        kinds.is_some_and(|kinds| kinds.iter().any(|kind| kind["kind"].is_null()))
    };
    let needs = node["deps"].as_array().into_iter().flatten();
    needs.filter(is_normal).map(|need| text(need, "pkg")).collect()
}

fn text<'v>(value: &'v Value, field: &str) -> &'v str {
    value[field].as_str().unwrap_or("")
}

/// Checksums in Cargo.lock by name and version.
fn checksums(lock: &str) -> BTreeMap<(String, String), String> {
    let mut found = BTreeMap::new();
    for package in lock.split("[[package]]") {
        let value = |key: &str| {
            let line = package.lines().find_map(|line| line.strip_prefix(key))?;
            Some(line.trim_matches([' ', '=', '"']).to_owned())
        };
        if let (Some(name), Some(version), Some(sum)) =
            (value("name = "), value("version = "), value("checksum = "))
        {
            found.insert((name, version), sum);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_are_what_the_binary_needs_to_run() {
        let package = |name: &str, source: Value| {
            let id = format!("{name} id");
            json!({"id": id, "name": name, "version": "1.0.0", "license": "MIT/Zlib", "source": source})
        };
        let need = |name: &str, kind: Value| json!({"pkg": format!("{name} id"), "dep_kinds": [{"kind": kind}]});
        let registry = || json!("registry");
        let metadata = json!({
            "packages": [
                package("brood", Value::Null),
                package("own", Value::Null),
                package("used", registry()),
                package("tested", registry()),
                package("other", registry()),
            ],
            "resolve": {"nodes": [
                {"id": "brood id", "deps": [need("own", Value::Null), need("tested", json!("dev"))]},
                {"id": "own id", "deps": [need("used", Value::Null)]},
            ]},
        });
        let lock = "[[package]]\nname = \"used\"\nversion = \"1.0.0\"\nchecksum = \"ab12\"\n";
        let document = from(&metadata, &checksums(lock), "c0ffee");
        let components = document["components"].as_array().unwrap();
        assert_eq!(components.len(), 1);
        assert_eq!(components[0]["purl"], "pkg:cargo/used@1.0.0");
        assert_eq!(components[0]["licenses"][0]["expression"], "MIT OR Zlib");
        assert_eq!(components[0]["hashes"][0]["content"], "ab12");
    }
}
