"""Fixtures of the tests of the client."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from types import FrameType

import pytest

from brood_brdf.client import Client, Lineage
from client_harness import SIZE_PX, BroodServer

TEST_S = 60


@pytest.fixture(autouse=True)
def deadline() -> Iterator[None]:
    """Fails a test that waits too long, such as for an event that does not come."""

    def fail(_: int, __: FrameType | None) -> None:
        pytest.fail(f"the test took more than {TEST_S} s")

    before = signal.signal(signal.SIGALRM, fail)
    signal.alarm(TEST_S)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.fixture(scope="session")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[BroodServer]:
    """Server that needs no token, shared by all tests."""
    with BroodServer(tmp_path_factory.mktemp("server")) as server:
        yield server


@pytest.fixture
def client(server: BroodServer) -> Iterator[Client]:
    """Client of the shared server."""
    with Client(server.url) as client:
        yield client


@pytest.fixture
def lineage(client: Client) -> Lineage:
    """New lineage with small pictures."""
    return client.create_lineage("test", thumbnail_px=SIZE_PX)
