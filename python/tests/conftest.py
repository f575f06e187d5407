"""Server for the tests of documents."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent / "client"))

from client_harness import BroodServer  # noqa: E402


@pytest.fixture(scope="session")
def server_url(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Address of a server that needs no token."""
    with BroodServer(tmp_path_factory.mktemp("documents")) as server:
        yield server.url
