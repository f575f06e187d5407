//! Rule for dependencies between crates: the table of ARCHITECTURE.md, and the heavy dependencies
//! that only one crate may use.
//!
//! A new dependency is a change of the architecture: it is added here and in ARCHITECTURE.md
//! together.

use anyhow::{Context, Result};
use serde_json::Value;

use crate::shell;

/// Package, and the packages of this workspace that it may use directly, all without `brood-`.
const ARROWS: [(&str, &str); 21] = [
    ("brdf", ""),
    // The catalogue of inputs that programs read is direction maths, so the machine's words for it
    // are brdf's.
    ("genome", "brdf"),
    ("program", "genome brdf"),
    ("mesh", ""),
    // Lights are placed relative to a mesh and sampled in its frames of reference.
    ("light", "mesh"),
    ("scene", "light mesh brdf"),
    ("eval", "program genome scene light mesh brdf"),
    // Its tests run what export prints.
    ("gpu", "eval export program genome scene brdf"),
    ("export", "eval program genome brdf mesh scene"),
    ("inspect", "eval program genome scene light mesh brdf"),
    ("target", "eval program genome scene light mesh brdf"),
    ("search", "target eval program genome scene light mesh brdf"),
    ("protocol", "genome program brdf scene mesh"),
    ("storage", "protocol genome"),
    ("server", "protocol storage genome program mesh light scene eval export inspect target"),
    (
        "worker",
        "protocol genome program brdf mesh light scene eval gpu export inspect search target",
    ),
    (
        "bench",
        "protocol genome program brdf mesh light scene eval export inspect search target worker",
    ),
    ("python", "brdf genome program mesh scene eval export search target protocol worker"),
    ("fuzz", "brdf eval genome light mesh protocol scene target"),
    // Drives the binary from outside, over HTTP and the command line.
    ("tests", ""),
    ("xtask", ""),
];

/// The binary joins everything.
const MAY_USE_ALL: &str = "brood";

/// A dependency from outside, and the only packages that may name it.
const GUARDED: [(&str, &[&str]); 4] = [
    ("sqlx", &["brood-storage", "brood-tests"]),
    ("object_store", &["brood-storage"]),
    ("axum", &["brood-server"]),
    ("wgpu", &["brood-gpu"]),
];

/// A package, and the libraries that must not be anywhere in its tree.
const ABSENT: [(&str, &[&str]); 3] = [
    ("brood-worker", &["sqlx", "axum"]),
    ("brood-server", &["wgpu", "brood_search"]),
    ("brood-storage", &["axum", "wgpu"]),
];

/// All arrows that the table does not allow, and all guarded dependencies where they must not be.
pub fn violations() -> Result<Vec<String>> {
    let text =
        shell::output(shell::cargo().args(["metadata", "--no-deps", "--format-version", "1"]))?;
    let metadata: Value = serde_json::from_str(&text).context("read cargo metadata's answer")?;
    let mut found = direct(&metadata)?;
    for (package, absent) in ABSENT {
        let tree = shell::output(
            shell::cargo()
                .args(["tree", "--package", package, "--edges", "normal"])
                .args(["--prefix", "none", "--format", "{lib}"]),
        )?;
        let here = tree.lines().map(|line| line.split_whitespace().next().unwrap_or_default());
        for name in here.filter(|name| absent.contains(name)) {
            found.push(format!(
                "{package} has {name} in its tree (cargo tree -p {package} -i {name})"
            ));
        }
    }
    found.sort();
    found.dedup();
    Ok(found)
}

/// Checks every direct dependency, of whichever kind.
fn direct(metadata: &Value) -> Result<Vec<String>> {
    let packages = metadata["packages"].as_array().context("find the packages")?;
    let name_of = |value: &Value| value["name"].as_str().unwrap_or_default().to_owned();
    let members: Vec<String> = packages.iter().map(name_of).collect();
    let short = |name: &str| name.strip_prefix("brood-").unwrap_or(name).to_owned();
    let mut found = Vec::new();
    for package in packages {
        let name = name_of(package);
        let allowed = ARROWS.iter().find(|(from, _)| *from == short(&name)).map(|(_, to)| *to);
        if allowed.is_none() && name != MAY_USE_ALL {
            found.push(format!("{name} has no row in the table of crate arrows"));
            continue;
        }
        for dependency in package["dependencies"].as_array().into_iter().flatten() {
            let used = name_of(dependency);
            let inside = members.contains(&used);
            let is_allowed = |to: &str| to.split(' ').any(|to| to == short(&used));
            if inside && allowed.is_some_and(|to| !is_allowed(to)) {
                found.push(format!("{name} must not use {used}: no such arrow in ARCHITECTURE.md"));
            }
            let guard = GUARDED.iter().find(|(guarded, _)| *guarded == used);
            if guard.is_some_and(|(_, owners)| !owners.contains(&name.as_str())) {
                found.push(format!("{name} must not name {used}: it belongs to another crate"));
            }
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::direct;
    use serde_json::{Value, json};

    fn workspace(package: &str, uses: &[&str]) -> Value {
        let names =
            ["brood-genome", "brood-server", "brood"].into_iter().filter(|it| *it != package);
        let mut packages: Vec<Value> =
            names.map(|name| json!({"name": name, "dependencies": []})).collect();
        let dependencies: Vec<Value> = uses.iter().map(|name| json!({"name": name})).collect();
        packages.push(json!({"name": package, "dependencies": dependencies}));
        json!({"packages": packages})
    }

    #[test]
    fn arrow_is_refused_when_the_table_does_not_have_it() {
        let found = direct(&workspace("brood-program", &["brood-genome", "brood-server"])).unwrap();
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].contains("brood-program must not use brood-server"));
    }

    #[test]
    fn guarded_dependency_is_refused_when_named_outside_its_crate() {
        let found = direct(&workspace("brood", &["brood-server", "sqlx"])).unwrap();
        assert_eq!(found, ["brood must not name sqlx: it belongs to another crate"]);
    }

    #[test]
    fn package_is_refused_when_it_has_no_row() {
        let found = direct(&workspace("brood-utils", &[])).unwrap();
        assert_eq!(found, ["brood-utils has no row in the table of crate arrows"]);
    }
}
