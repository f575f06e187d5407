"""Events: parsing, and streams that continue after a lost connection."""

from __future__ import annotations

import asyncio
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import httpx
import pytest

from brood_brdf.client import AsyncClient, Client, Event, Retry, Unreachable
from brood_brdf.client.event import EventParser
from client_harness import SIZE_PX, BroodServer, CuttingProxy


def generations(events: list[Event]) -> list[str]:
    return [event.data["id"] for event in events if event.name == "generation"]


def test_parser_takes_pieces_of_any_size() -> None:
    note = "a\u2028b\u0085c"
    stream = (
        ": open\n\n"
        'id: 1\nevent: individual\ndata: {"note":\n'
        f'data: "{note}"}}\n\n'
        "event: resync\r\ndata:{}\r\n\r\n"
        "id: 3\n\n"
        "id: 4\nevent: job\ndata: {}\n"
    ).encode()
    for step in (1, 2, 3, 7, len(stream)):
        parser = EventParser()
        events = [
            event
            for start in range(0, len(stream), step)
            for event in parser.feed(stream[start : start + step])
        ]
        assert events == [Event("individual", {"note": note}, "1"), Event("resync")]
        assert parser.last_id == "3", "the event 4 is not complete"
        parser.restart()
        assert parser.feed(b"data: 5\n\n") == [Event("message", {"value": 5})]


def test_events_continue_after_a_cut(server: BroodServer, client: Client) -> None:
    lineage = client.create_lineage("cut", thumbnail_px=SIZE_PX)
    with CuttingProxy(server.url) as proxy, Client(proxy.url) as remote:
        with remote.lineage_events(lineage) as events:
            born = [lineage.breed(count=1, seed=1).id]
            seen = [next(events)]
            proxy.cut()
            # While the connection is away, nothing may be lost.
            born += [lineage.breed(count=1, seed=seed).id for seed in (2, 3)]
            while len(generations(seen)) < 3:
                seen.append(next(events))
            proxy.cut()
            born.append(lineage.breed(count=1, seed=4).id)
            while len(generations(seen)) < 4:
                seen.append(next(events))
        assert generations(seen) == born
        ids = [event.id for event in seen]
        assert None not in ids and len(set(ids)) == len(ids), "no event is seen twice"
        assert "resync" not in {event.name for event in seen}
        assert proxy.connections == 3
        assert next(events, None) is None, "a closed stream has no further events"


def test_stream_without_an_id_asks_to_resync_after_a_cut(
    server: BroodServer, client: Client
) -> None:
    lineage = client.create_lineage("resync", thumbnail_px=SIZE_PX)
    with (
        CuttingProxy(server.url) as proxy,
        Client(proxy.url) as remote,
        remote.lineage_events(lineage) as events,
    ):
        proxy.cut()
        assert next(events) == Event("resync")


def test_stream_survives_a_restart_of_the_server(tmp_path: Path) -> None:
    # The first pause is the time to start the server again.
    def restart(_: float) -> None:
        if servers:
            proxy.lead_to(running.enter_context(BroodServer(tmp_path)).url)
            servers.clear()

    with ExitStack() as running:
        servers = [running.enter_context(BroodServer(tmp_path))]
        proxy = running.enter_context(CuttingProxy(servers[0].url))
        client = running.enter_context(Client(proxy.url, sleep=restart))
        lineage = client.create_lineage("restarted", thumbnail_px=SIZE_PX)
        events = running.enter_context(lineage.events())
        first = lineage.breed(count=1, seed=1)
        assert next(events).data["id"] == first.id
        servers[0].stop()
        assert "resync" in (event.name for event in events)
        second = lineage.breed(count=1, seed=2)
        assert [each.id for each in lineage.generations()] == [first.id, second.id]
        assert second.id in (event.data.get("id") for event in events)


def test_stream_that_never_sends_anything_fails() -> None:
    slept_s: list[float] = []
    answers = httpx.MockTransport(lambda _: httpx.Response(200, content=b""))
    options: dict[str, Any] = {
        "retry": Retry(chance=lambda: 0.0),
        "transport": answers,
        "sleep": slept_s.append,
    }
    words = "before it sent anything"
    with Client("http://brood", **options) as client, pytest.raises(Unreachable, match=words):
        list(client.lineage_events("x"))
    assert slept_s == [0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 10.0, 10.0, 10.0]


def test_asynchronous_events_continue_after_a_cut(server: BroodServer) -> None:
    async def watch(proxy: CuttingProxy) -> tuple[list[str], list[str]]:
        async with AsyncClient(server.url) as client, AsyncClient(proxy.url) as remote:
            lineage = await client.create_lineage("cut", thumbnail_px=SIZE_PX)
            async with remote.lineage_events(lineage) as events:
                born = [(await client.breed(lineage, count=1, seed=1)).id]
                seen = [await anext(events)]
                proxy.cut()
                born += [(await client.breed(lineage, count=1, seed=2)).id]
                async for event in events:
                    seen.append(event)
                    if len(generations(seen)) == 2:
                        break
            return born, generations(seen)

    with CuttingProxy(server.url) as proxy:
        born, seen = asyncio.run(watch(proxy))
        assert seen == born and proxy.connections == 2
