"""Server-sent events as iterators that continue after a lost connection."""

from __future__ import annotations

import json
from collections.abc import AsyncGenerator, Callable, Generator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from types import TracebackType
from typing import Any, cast

import httpx

from .call import AsyncSender, Call, Description, Requester, Sender
from .error import Unreachable
from .retry import Pause, Steps

__all__ = ["AsyncEventStream", "Event", "EventParser", "EventStream", "Watch"]

_SILENCE_S = 45.0
"""Seconds without bytes after which a connection is lost: the server sends some every 15 s."""
_FRUITLESS_MAX = 10
"""Connections in a row without bytes after which a stream fails."""


@dataclass(frozen=True, slots=True)
class Event:
    """Change of a lineage or a search.

    Attributes:
        name: Kind of the event. Of a lineage: `generation`, `thumbnail`, `lineage`, `individual`,
            `job`. Of a search: `state`, `progress`, `best`. Of both: `resync`, if events were
            missed, so that what you know may be outdated.
        data: Fields of the event.
        id: Id of the event; None if it has none.
    """

    name: str
    data: Mapping[str, Any] = field(default_factory=dict[str, Any], hash=False)
    id: str | None = None


class EventParser:
    """Parser of `text/event-stream`. Bytes may arrive in pieces of any size."""

    def __init__(self) -> None:
        """Makes a parser at the start of a stream."""
        self.last_id: str | None = None
        self._pending = b""
        self._name = ""
        self._data: list[str] = []
        self._id: str | None = None

    def restart(self) -> None:
        """Forgets an unfinished event, for a new connection. The last id stays."""
        self._pending, self._name, self._data, self._id = b"", "", [], None

    def feed(self, chunk: bytes) -> list[Event]:
        """Returns the events that these bytes complete."""
        *lines, self._pending = (self._pending + chunk).split(b"\n")
        events = [self._line(line.removesuffix(b"\r").decode("utf-8", "replace")) for line in lines]
        return [event for event in events if event is not None]

    def _line(self, line: str) -> Event | None:
        if not line:
            return self._dispatch()
        name, _, value = line.partition(":")
        value = value.removeprefix(" ")
        if name == "event":
            self._name = value
        elif name == "data":
            self._data.append(value)
        elif name == "id" and "\0" not in value:
            self._id = value
        return None

    def _dispatch(self) -> Event | None:
        event_id, self._id = self._id, None
        # An event counts as received only when it is complete.
        if event_id is not None:
            self.last_id = event_id
        name, self._name = self._name or "message", ""
        data, self._data = "\n".join(self._data), []
        if not data:
            return None
        value = json.loads(data)
        fields = cast(dict[str, Any], value) if isinstance(value, dict) else {"value": value}
        return Event(name, fields, event_id)


@dataclass(frozen=True, slots=True)
class Watch(Description["EventStream", "AsyncEventStream"]):
    """Stream of events.

    Attributes:
        call: Request of the stream.
        ended: Request that returns the last event if there will be no more, else None. It is sent
            when events may have been missed. Without it, the stream has no end.
        is_last: Returns true for an event that no other follows.
    """

    call: Call[None]
    ended: Call[Event | None] | None = None
    is_last: Callable[[Event], bool] = lambda _: False

    def sync(self, client: Sender) -> EventStream:
        """Returns the stream of the synchronous client."""
        return EventStream(client, self)

    def asynchronous(self, client: AsyncSender) -> AsyncEventStream:
        """Returns the stream of the asynchronous client."""
        return AsyncEventStream(client, self)


class _Position:
    """Place in a stream: what both clients share of reading and continuing it."""

    def __init__(self, watch: Watch) -> None:
        self.watch = watch
        self.is_over = False
        self._parser = EventParser()
        self._connections = 0
        self._fruitless = 0
        """Number of connections in a row that sent no bytes."""

    def connect(self, client: Requester) -> Steps[tuple[httpx.Response, list[Event]]]:
        """Opens the stream after the last event; returns the answer, and events due before it."""
        if self._fruitless >= _FRUITLESS_MAX:
            words = f"{self.watch.call.path} ended {self._fruitless} times before it sent anything"
            raise Unreachable(words)
        if self._connections > 0:
            yield Pause(client.pause_s(max(1, self._fruitless)))
        self._fruitless += 1
        self._parser.restart()
        last_id = self._parser.last_id
        headers = {"Accept": "text/event-stream", "Cache-Control": "no-store"}
        if last_id is not None:
            headers["Last-Event-ID"] = last_id
        call = replace(self.watch.call, headers=headers, silence_s=_SILENCE_S)
        answer = yield from client.exchange(call, stream=True)
        self._connections += 1
        events: list[Event] = []
        if self._connections == 1:
            events = yield from self._end(client)
        elif last_id is None:
            # The server cannot know what the lost connection did not send.
            events = [Event("resync"), *(yield from self._end(client))]
        return answer, events

    def read(self, client: Requester, chunk: bytes) -> Steps[list[Event]]:
        """Returns the events that these bytes complete, up to the last one."""
        self._fruitless = 0
        events: list[Event] = []
        for event in self._parser.feed(chunk):
            events.append(event)
            if event.name == "resync":
                events += yield from self._end(client)
            self.is_over = self.is_over or self.watch.is_last(event)
            if self.is_over:
                break
        return events

    def _end(self, client: Requester) -> Steps[list[Event]]:
        if self.watch.ended is None:
            return []
        last = yield from self.watch.ended.steps(client)
        self.is_over = last is not None
        return [] if last is None else [last]


class EventStream:
    """Iterator over events, which continues after lost connections.

    It connects with the first event that is asked for, or on entry as a context manager: enter it
    before you cause events that you want to see. Leaving it, or `close`, ends the connection.
    """

    def __init__(self, client: Sender, watch: Watch) -> None:
        """Makes a stream that is not connected yet."""
        self._client = client
        self._position = _Position(watch)
        self._answer: httpx.Response | None = None
        self._early: list[Event] = []
        self._events = self._read()

    def _connect(self) -> httpx.Response:
        answer, self._early = self._client.run(self._position.connect(self._client))
        self._answer = answer
        return answer

    def _read(self) -> Generator[Event, None, None]:
        position = self._position
        try:
            while not position.is_over:
                answer = self._answer or self._connect()
                yield from self._early
                if position.is_over:
                    return
                with suppress(httpx.TransportError):
                    for chunk in answer.iter_bytes():
                        yield from self._client.run(position.read(self._client, chunk))
                        if position.is_over:
                            return
                self._drop()
        finally:
            self._drop()

    def _drop(self) -> None:
        answer, self._answer = self._answer, None
        if answer is not None:
            answer.close()

    def __iter__(self) -> EventStream:
        """Returns itself."""
        return self

    def __next__(self) -> Event:
        """Waits for the next event and returns it."""
        return next(self._events)

    def __enter__(self) -> EventStream:
        """Connects: later events are not missed."""
        if self._answer is None:
            self._connect()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Closes the connection."""
        self.close()

    def close(self) -> None:
        """Closes the connection; the iterator has no further events."""
        self._events.close()
        self._drop()


class AsyncEventStream:
    """Asynchronous iterator over events, which continues after lost connections.

    It connects with the first event that is awaited, or on entry as an asynchronous context
    manager: enter it before you cause events that you want to see.
    """

    def __init__(self, client: AsyncSender, watch: Watch) -> None:
        """Makes a stream that is not connected yet."""
        self._client = client
        self._position = _Position(watch)
        self._answer: httpx.Response | None = None
        self._early: list[Event] = []
        self._events = self._read()

    async def _connect(self) -> httpx.Response:
        answer, self._early = await self._client.run(self._position.connect(self._client))
        self._answer = answer
        return answer

    async def _read(self) -> AsyncGenerator[Event, None]:
        position = self._position
        try:
            while not position.is_over:
                answer = self._answer or await self._connect()
                for event in self._early:
                    yield event
                if position.is_over:
                    return
                with suppress(httpx.TransportError):
                    async for chunk in answer.aiter_bytes():
                        for event in await self._client.run(position.read(self._client, chunk)):
                            yield event
                        if position.is_over:
                            return
                await self._drop()
        finally:
            await self._drop()

    async def _drop(self) -> None:
        answer, self._answer = self._answer, None
        if answer is not None:
            await answer.aclose()

    def __aiter__(self) -> AsyncEventStream:
        """Returns itself."""
        return self

    async def __anext__(self) -> Event:
        """Waits for the next event and returns it."""
        return await anext(self._events)

    async def __aenter__(self) -> AsyncEventStream:
        """Connects: later events are not missed."""
        if self._answer is None:
            await self._connect()
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Closes the connection."""
        await self.aclose()

    async def aclose(self) -> None:
        """Closes the connection; the iterator has no further events."""
        await self._events.aclose()
        await self._drop()
