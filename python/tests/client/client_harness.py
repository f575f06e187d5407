"""A real server, and a proxy that loses connections, for the tests of the client."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import threading
from contextlib import suppress
from pathlib import Path
from types import TracebackType

ROOT = Path(__file__).resolve().parents[3]
PNG = b"\x89PNG\r\n\x1a\n"
# Smallest pictures, so that a debug build renders a brood in a moment.
SIZE_PX = 32


def brood_binary() -> Path:
    """Returns `$BROOD_BIN`, else the debug build of this repository."""
    binary = Path(os.environ.get("BROOD_BIN") or ROOT / "target" / "debug" / "brood")
    assert binary.is_file(), f"there is no {binary}: run `cargo build`, or set BROOD_BIN"
    return binary


class BroodServer:
    """Server on a free port with its own data folder; a context manager."""

    def __init__(self, folder: Path) -> None:
        """Starts the server and waits until it listens; its log is `folder/log`."""
        self.data = folder / "data"
        self._log = (folder / "log").open("ab")
        options = ["--listen", "127.0.0.1:0", "--backend", "cpu", "--json"]
        self._process = subprocess.Popen(
            [brood_binary(), "serve", "--data", self.data, *options],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=self._log,
        )
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        assert line, f"the server did not start; see {self._log.name}"
        self.url: str = json.loads(line)["listening"]

    def command(self, *arguments: str) -> str:
        """Runs an offline command on the server's data, and returns what it prints."""
        command = [str(brood_binary()), *arguments, "--data", str(self.data)]
        done = subprocess.run(command, check=True, stdout=subprocess.PIPE, encoding="utf-8")
        return done.stdout

    def __enter__(self) -> BroodServer:
        """Returns itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Stops the server."""
        self.stop()

    def stop(self) -> None:
        """Ends the process and waits for its end."""
        self._process.terminate()
        try:
            self._process.wait(timeout=30)
        finally:
            self._process.kill()
            assert self._process.stdout is not None
            self._process.stdout.close()
            self._log.close()


class CuttingProxy:
    """TCP proxy to a server, whose connections a test can cut; a context manager.

    Attributes:
        url: URL of the proxy.
        connections: Number of connections so far.
        answers_to_swallow: Number of answers after which the connection ends in their place.
    """

    def __init__(self, url: str) -> None:
        """Listens on a free port for connections to the server at this URL."""
        self.lead_to(url)
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.url = f"http://127.0.0.1:{self._listener.getsockname()[1]}"
        self.connections = 0
        self.answers_to_swallow = 0
        self._open: list[socket.socket] = []
        self._lock = threading.Lock()
        threading.Thread(target=self._accept, daemon=True).start()

    def lead_to(self, url: str) -> None:
        """Leads later connections to the server at this URL."""
        host, port = url.removeprefix("http://").split(":")
        self._server = (host, int(port))

    def cut(self) -> None:
        """Ends all connections at once, without the end of what they carry."""
        with self._lock:
            ends, self._open = self._open, []
        for end in ends:
            _shut(end)

    def _accept(self) -> None:
        while True:
            try:
                client, _ = self._listener.accept()
            except OSError:
                return
            try:
                server = socket.create_connection(self._server)
            except OSError:
                _shut(client)
                continue
            with self._lock:
                self.connections += 1
                self._open += [client, server]
            for ends, is_answer in [((client, server), False), ((server, client), True)]:
                arguments = (*ends, is_answer)
                threading.Thread(target=self._copy, args=arguments, daemon=True).start()

    def _copy(self, source: socket.socket, sink: socket.socket, is_answer: bool) -> None:
        with suppress(OSError):
            while data := source.recv(65536):
                if is_answer and self.answers_to_swallow > 0:
                    self.answers_to_swallow -= 1
                    break
                sink.sendall(data)
        _shut(sink)
        _shut(source)

    def __enter__(self) -> CuttingProxy:
        """Returns itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Ends all connections and listens no more."""
        _shut(self._listener)
        self.cut()


def _shut(end: socket.socket) -> None:
    # `close` alone does not wake a thread that reads.
    with suppress(OSError):
        end.shutdown(socket.SHUT_RDWR)
    end.close()


def glossy_csv(rows: int = 300) -> bytes:
    """Returns samples of a reciprocal material of a matt and a glossy part."""
    state = 1
    lines = ["wix,wiy,wiz,wox,woy,woz,r,g,b"]

    def draw() -> float:
        nonlocal state
        state = (state * 6364136223846793005 + 1442695040888963407) % 2**64
        return (state >> 11) / 2**53

    def direction() -> list[float]:
        # Points of the unit disk, lifted to the hemisphere.
        while True:
            x, y = 2 * draw() - 1, 2 * draw() - 1
            if x * x + y * y < 0.99:
                return [x, y, (1 - x * x - y * y) ** 0.5]

    for _ in range(rows):
        i, o = direction(), direction()
        half = [a + b for a, b in zip(i, o, strict=True)]
        cosine = half[2] / sum(part * part for part in half) ** 0.5
        color = [diffuse + 0.3 * cosine**24 for diffuse in (0.25, 0.12, 0.05)]
        lines.append(",".join(map(str, [*i, *o, *color])))
    return "\n".join(lines).encode() + b"\n"
