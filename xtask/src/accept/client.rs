//! Client of the API that a generator writes from openapi.json.
//!
//! Owns the folder and the packages; `xtask/peer/openapi_client.py` generates the client, starts
//! brood, calls routes and checks the answers.

use std::path::Path;

use anyhow::Result;

use crate::python::Python;
use crate::shell;

/// Generates the client and calls routes of this brood with its functions.
pub fn run(brood: &Path, target: &Path) -> Result<()> {
    let folder = target.join("client");
    let peer = shell::root().join("xtask/peer");
    let python = Python::at(&folder);
    python.prepare()?;
    python.install(&peer.join("openapi-python-client.txt"))?;
    let mut script = python.command();
    script.arg(peer.join("openapi_client.py")).arg("--brood").arg(brood);
    script.arg("--document").arg(shell::root().join("openapi.json"));
    shell::run(script.arg("--folder").arg(&folder))
}
