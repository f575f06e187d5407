"""Retries, most of them against a made-up transport with a made-up clock."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterable
from email.utils import formatdate
from typing import Any

import httpx
import pytest

from brood_brdf.client import (
    ApiError,
    AsyncClient,
    Client,
    Conflict,
    NotFound,
    Retry,
    TooBusy,
    Unreachable,
)
from client_harness import SIZE_PX, BroodServer, CuttingProxy

NOW_S = 1_800_000_000.0
Reply = httpx.Response | Exception


class Script:
    """Transport that gives the replies in their order, and a clock that sleeping moves."""

    def __init__(self, replies: Iterable[Reply]) -> None:
        self.replies = list(replies)
        self.requests: list[httpx.Request] = []
        self.bodies: list[bytes] = []
        self.slept_s: list[float] = []

    def handle(self, request: httpx.Request) -> httpx.Response:
        self.requests.append(request)
        self.bodies.append(request.read())
        reply = self.replies.pop(0)
        if isinstance(reply, Exception):
            raise reply
        return reply

    def clock(self) -> float:
        return sum(self.slept_s)

    def now(self) -> float:
        return NOW_S + self.clock()

    def retry(self, **options: Any) -> Retry:
        return Retry(clock=self.clock, now=self.now, chance=lambda: 0.0, **options)

    def client(self, **options: Any) -> Client:
        transport = httpx.MockTransport(self.handle)
        retry = self.retry(**options)
        return Client("http://brood", retry=retry, transport=transport, sleep=self.slept_s.append)

    def keys(self) -> list[str | None]:
        return [request.headers.get("idempotency-key") for request in self.requests]


def busy(status: int, after: str | None = None) -> httpx.Response:
    headers = {} if after is None else {"Retry-After": after}
    problem = {"type": "/problems/busy", "title": "The server is busy", "detail": "later"}
    return httpx.Response(status, headers=headers, json=problem)


def conflict(kind: str) -> httpx.Response:
    return httpx.Response(409, json={"type": f"/problems/{kind}", "title": "Conflict"})


def stored() -> httpx.Response:
    return httpx.Response(201, json={"hash": "ab"})


def test_retry_after_is_honoured_in_seconds_and_as_a_date() -> None:
    script = Script(
        [
            busy(429, "7"),
            busy(503, formatdate(NOW_S + 7 + 5, usegmt=True)),
            busy(503, "0"),
            stored(),
        ]
    )
    assert script.client().store_genome("brood 1") == "ab"
    assert script.slept_s == [7.0, 5.0, 0.0]


def test_pause_doubles_up_to_the_longest_without_retry_after() -> None:
    script = Script([busy(503), busy(502), busy(504), busy(503, "soon"), stored()])
    script.client(first_s=1.0, longest_s=4.0).store_genome("brood 1")
    assert script.slept_s == [1.0, 2.0, 4.0, 4.0]


def test_chance_shortens_pauses_by_up_to_a_half() -> None:
    retry = Retry(first_s=1.0, longest_s=8.0, chance=lambda: 1.0)
    assert [retry.pause_s(attempt, None) for attempt in (1, 2, 3, 9999)] == [0.5, 1.0, 2.0, 4.0]


def test_key_and_body_are_kept_over_all_attempts() -> None:
    lost = httpx.ReadError("lost")
    script = Script([lost, busy(502), httpx.ConnectError("refused"), conflict("still-running")])
    script.replies += [stored(), stored()]
    client = script.client()
    client.store_genome("brood 1")
    client.store_genome("brood 1")
    first, second = script.keys()[0], script.keys()[-1]
    assert script.keys() == [first] * 5 + [second]
    assert first and second and first != second
    assert set(script.bodies) == {b"brood 1"}


def test_nothing_is_born_twice_if_answers_are_lost(server: BroodServer, client: Client) -> None:
    lineage = client.create_lineage("once", thumbnail_px=SIZE_PX)
    with CuttingProxy(server.url) as proxy, Client(proxy.url) as remote:
        proxy.answers_to_swallow = 2
        brood = remote.breed(lineage, count=2)
        assert proxy.answers_to_swallow == 0 and proxy.connections == 3
    assert [each.id for each in lineage.generations()] == [brood.id]


def test_multipart_body_is_sent_again() -> None:
    target = {"id": "t", "kind": "samples", "name": "", "hash": "h", "bytes": 1, "samples": 1}
    counts = {"fitted_samples": 1, "held_out_samples": 0, "skipped_samples": 0}
    answer = {**target, **counts, "largest_f": 1.0, "created_ms": 0}
    script = Script([busy(503), httpx.Response(201, json=answer)])
    script.client().upload_target("samples", b"wix")
    assert script.bodies[0] == script.bodies[1] and b"wix" in script.bodies[0]
    assert script.keys()[0] == script.keys()[1] is not None


def test_attempts_and_seconds_are_bounded() -> None:
    script = Script(busy(503, "1") for _ in range(9))
    with pytest.raises(TooBusy, match="later") as caught:
        script.client(attempts=4).system()
    assert caught.value.status == 503 and len(script.requests) == 4
    script = Script(busy(429, "40") for _ in range(9))
    with pytest.raises(TooBusy):
        script.client(total_s=100.0).system()
    assert script.slept_s == [40.0, 40.0]
    script = Script([httpx.ConnectError("refused") for _ in range(9)])
    with pytest.raises(Unreachable, match="3 attempts") as lost:
        script.client(connection_attempts=3).system()
    assert isinstance(lost.value.__cause__, httpx.ConnectError) and len(script.requests) == 3


def test_other_errors_are_not_retried() -> None:
    replies = [conflict("conflict"), httpx.Response(500, text="oops"), httpx.Response(422, json=[])]
    script = Script(replies)
    client = script.client()
    for kind in (Conflict, ApiError, ValueError):
        with pytest.raises(kind):
            client.store_genome("brood 1")
    assert len(script.requests) == 3 and script.slept_s == []


def test_change_of_a_version_is_not_repeated_after_a_lost_answer() -> None:
    script = Script([httpx.ReadError("lost")])
    with pytest.raises(Unreachable):
        script.client().mark("x", note="n", version=3)
    assert script.requests[0].headers["if-match"] == '"3"'
    script = Script([httpx.ConnectError("refused"), busy(503), conflict("stale-version")])
    with pytest.raises(Conflict):
        script.client().mark("x", note="n", version=3)
    script = Script([httpx.ReadError("lost"), conflict("conflict")])
    with pytest.raises(Conflict):
        script.client().mark("x", note="n")
    assert script.requests[0].headers["if-match"] == "*"


def test_repeated_deletion_finds_nothing() -> None:
    gone = httpx.Response(404, json={"type": "/problems/unknown-id", "title": "Not found"})
    script = Script([httpx.ReadError("lost"), gone, gone])
    client = script.client()
    client.delete_target("x")
    with pytest.raises(NotFound):
        client.delete_target("x")


def test_token_is_sent_to_the_server() -> None:
    script = Script([busy(503), stored()])
    transport = httpx.MockTransport(script.handle)
    with Client("brood:1", token="s3cret", transport=transport, sleep=lambda _: None) as client:
        client.store_genome("brood 1")
        assert client.url == "http://brood:1"
    assert {request.headers["authorization"] for request in script.requests} == {"Bearer s3cret"}


def test_asynchronous_client_retries_likewise() -> None:
    script = Script([busy(429, "7"), httpx.ReadError("lost"), conflict("still-running"), stored()])

    async def sleep(seconds: float) -> None:
        script.slept_s.append(seconds)

    async def store(finish: Callable[[httpx.Request], httpx.Response]) -> str:
        transport = httpx.MockTransport(finish)
        options: dict[str, Any] = {
            "retry": script.retry(first_s=1.0),
            "transport": transport,
            "sleep": sleep,
        }
        async with AsyncClient("http://brood", **options) as client:
            return await client.store_genome("brood 1")

    assert asyncio.run(store(script.handle)) == "ab"
    assert script.slept_s == [7.0, 2.0, 4.0]
    assert len(set(script.keys())) == 1 and len(script.keys()) == 4
