"""Calls every route of a server as openapi.json describes it, and as it does not.

A server on an empty data directory gets some of everything; then schemathesis generates requests
for all routes, alone and in sequences. No answer may be 500, differ from its schema or break the
connection, and nothing in the log may have panicked. Usage: run.py SECONDS
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
import urllib.error
import urllib.request
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parent
ROOT = FOLDER.parent.parent
MESH = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n"
# Runs up to this long, as in the test suite, always begin with the same requests.
SHORT_SECONDS = 60
PHASES = "examples,coverage,fuzzing,stateful"


class Server:
    """Server under test, with a token for everything."""

    def __init__(self, folder: Path) -> None:
        """Starts it on an empty folder."""
        binary = os.environ["BROOD_BIN"]
        self.data = folder / "data"
        self.log = folder / "log"
        where = ["--data", str(self.data)]
        add = [binary, "token", "add", "contract", "--scope", "admin", "--json", *where]
        made = subprocess.run(add, check=True, capture_output=True, text=True)
        self.token = json.loads(made.stdout)["token"]
        with self.log.open("w") as log:
            self.process = subprocess.Popen(
                [binary, "serve", "--listen", "127.0.0.1:0", "--backend", "cpu", *where],
                stdout=subprocess.PIPE,
                stderr=log,
                text=True,
            )
        assert self.process.stdout
        self.url = re.sub(r".* (http://\S+)\s*", r"\1", self.process.stdout.readline())

    def post(self, path: str, body: Any, kind: str = "application/json") -> Any:
        """Sends a POST and returns the answer."""
        data = body.encode() if isinstance(body, str) else json.dumps(body).encode()
        headers = {"authorization": f"Bearer {self.token}", "content-type": kind}
        request = urllib.request.Request(self.url + path, data, headers)
        try:
            with urllib.request.urlopen(request, timeout=60) as answer:
                return json.load(answer)
        except urllib.error.HTTPError as error:
            raise RuntimeError(f"{path}: {error.read().decode()}") from error


def samples() -> str:
    """Returns samples of a grey material, as an upload of a target."""
    sines = [k / 500 for k in range(400)]
    rows = "".join(f"0,0,1,0,{sine},{(1 - sine * sine) ** 0.5},.2,.2,.2\n" for sine in sines)
    csv = "wix,wiy,wiz,wox,woy,woz,r,g,b\n" + rows
    parts = [("spec", '{"kind":"samples","name":"grey"}'), ("file", csv)]
    part = '--b\r\nContent-Disposition: form-data; name="{}"\r\n\r\n{}\r\n'
    return "".join(part.format(*each) for each in parts) + "--b--\r\n"


def fill(server: Server) -> dict[str, list[str]]:
    """Makes some of everything; returns the ids by kind."""
    ids: dict[str, list[str]] = {"thumbnail": []}
    add = ids.setdefault
    for start in ["believable", "models", "painted", "wild"] * 6:
        lineage = server.post("/v1/lineages", {"name": start, "start": start, "thumbnail_px": 16})
        add("lineage", []).append(lineage["id"])
        add("scene", []).append(lineage["scene"])
        parents: list[str] = []
        for seed in range(2):
            born = server.post(
                f"/v1/lineages/{lineage['id']}/generations",
                {"parents": parents, "count": 3, "seed": seed},
            )
            add("generation", []).append(born["id"])
            for one in born["individuals"]:
                add("individual", []).append(one["id"])
                add("genome", []).append(one["hash"])
                ids["thumbnail"].append(one["thumbnail"].rsplit("/", 1)[-1])
            parents = [born["individuals"][0]["id"]]
    add("mesh", []).append(server.post("/v1/meshes", MESH, "model/obj")["id"])
    target = server.post("/v1/targets", samples(), "multipart/form-data; boundary=b")["id"]
    add("target", []).append(target)
    for strategy in ["lobes", "gp"]:
        search = {"kind": "fit", "target": target, "strategy": strategy, "generations": 2}
        add("job", []).append(server.post("/v1/jobs", search)["id"])
    return ids


def main() -> int:
    """Runs the test."""
    seconds = int(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        server = Server(Path(folder))
        try:
            ids = fill(server)
            report = Path(folder) / "report.json"
            command = [sys.executable, "-m", "schemathesis.cli", "--config-file", str(FOLDER / "schemathesis.toml")]
            command += ["run", str(ROOT / "openapi.json"), "--url", server.url]
            command += ["-H", f"Authorization: Bearer {server.token}"]
            # Streams of events have no end.
            command += ["--exclude-path-regex", "events$", "--continue-on-failure"]
            command += ["--phases", PHASES, "--max-time", str(seconds), "--no-color"]
            if seconds <= SHORT_SECONDS:
                command += ["--seed", "1"]
            command += ["--report", "json", "--report-json-path", str(report)]
            environment = {
                **os.environ,
                "BROOD_CONTRACT_IDS": json.dumps(ids),
                "PYTHONPATH": str(FOLDER),
                "SCHEMATHESIS_HOOKS": "hooks",
            }
            # It writes what it has found into its working directory.
            outcome = subprocess.run(command, cwd=folder, env=environment)
            ended = server.process.poll()
        finally:
            server.process.kill()
            server.process.wait()
        log = server.log.read_text("utf-8", "replace")
        found = json.loads(report.read_text()) if report.exists() else {}
    panics = log.count("panicked")
    cases = found.get("test_cases", {}).get("generated", 0)
    failures = sum(one.get("count", 0) for one in found.get("failures", []))
    print(f"contract: {cases} requests, {failures} failures, {panics} panics, exit {outcome.returncode}")
    return int(outcome.returncode != 0 or panics > 0 or ended is not None)


if __name__ == "__main__":
    sys.exit(main())
