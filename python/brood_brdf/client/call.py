"""Descriptions of requests: what to send and how to read the answer.

Each route is described once, by a function that returns a description. `Route` makes such a
function a method of both clients: the synchronous client returns the result, the asynchronous one
an awaitable or an asynchronous iterator. This file knows no route.
"""

from __future__ import annotations

import functools
import inspect
import os
from abc import ABC, abstractmethod
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Generic, ParamSpec, Protocol, TypeVar, overload
from urllib.parse import quote

import httpx

from .retry import Steps

__all__ = [
    "AsyncSender",
    "Call",
    "Description",
    "File",
    "Flow",
    "Identified",
    "Listing",
    "Ref",
    "Requester",
    "Route",
    "Sender",
    "bytes_of",
    "face",
    "given",
    "id_of",
    "path_of",
]

T = TypeVar("T")
S = TypeVar("S")
A = TypeVar("A")
P = ParamSpec("P")


class Requester(ABC):
    """Base of both clients, as the descriptions see it."""

    @abstractmethod
    def exchange(self, call: Call[Any], stream: bool = False) -> Steps[httpx.Response]:
        """Sends a request with retries; raises `ApiError` for an error answer.

        Args:
            call: The request.
            stream: True to return before the body is read.
        """

    @abstractmethod
    def pause_s(self, attempt: int) -> float:
        """Returns the seconds to wait after the given number of failures in a row, from 1."""

    @abstractmethod
    def clock_s(self) -> float:
        """Returns monotonic seconds."""

    @property
    @abstractmethod
    def is_closed(self) -> bool:
        """True once the client was closed."""


class Sender(Requester):
    """Synchronous client, as descriptions and records see it."""

    @abstractmethod
    def run(self, steps: Steps[T]) -> T:
        """Runs steps to their result."""


class AsyncSender(Requester):
    """Asynchronous client, as descriptions see it."""

    @abstractmethod
    async def run(self, steps: Steps[T]) -> T:
        """Runs steps to their result."""


class Description(ABC, Generic[S, A]):
    """Something that a client can do: `S` of the synchronous client, `A` of the asynchronous."""

    @abstractmethod
    def sync(self, client: Sender) -> S:
        """Does it, or returns an iterator that does."""

    @abstractmethod
    def asynchronous(self, client: AsyncSender) -> A:
        """Returns an awaitable or an asynchronous iterator that does it."""


class Flow(Description[T, Awaitable[T]]):
    """One or several requests that lead to one result."""

    @abstractmethod
    def steps(self, client: Requester) -> Steps[T]:
        """Returns the steps to the result."""

    def sync(self, client: Sender) -> T:
        """Returns the result."""
        return client.run(self.steps(client))

    def asynchronous(self, client: AsyncSender) -> Awaitable[T]:
        """Returns an awaitable of the result."""
        return client.run(self.steps(client))


@dataclass(frozen=True, slots=True)
class Call(Flow[T]):
    """One request, and how its answer is read.

    Attributes:
        method: HTTP method.
        path: Path below the server's URL, percent-encoded.
        read: Makes the result of the answer. The second argument is the client that results may
            use later; None for the asynchronous client.
        query: Query parameters; those that are None are left out.
        json: JSON body, or None.
        content: Body, or None.
        files: Parts of a multipart body: name and bytes.
        headers: Further headers.
        silence_s: Seconds without bytes after which the answer is lost; None for the client's.
    """

    method: str
    path: str
    read: Callable[[httpx.Response, Sender | None], T]
    query: Mapping[str, Any] = field(default_factory=dict[str, Any])
    json: Any = None
    content: bytes | None = None
    files: Sequence[tuple[str, bytes]] = ()
    headers: Mapping[str, str] = field(default_factory=dict[str, str])
    silence_s: float | None = None

    def steps(self, client: Requester) -> Steps[T]:
        """Returns the steps of the request."""
        answer = yield from client.exchange(self)
        return self.read(answer, client if isinstance(client, Sender) else None)


@dataclass(frozen=True, slots=True)
class Listing(Description[Iterator[T], AsyncIterator[T]]):
    """List of any length, whose pages are requested while it is read.

    Attributes:
        first: Request of the first page: its items, and the cursor of the next page or None.
    """

    first: Call[tuple[Sequence[T], str | None]]

    def sync(self, client: Sender) -> Iterator[T]:
        """Returns an iterator over the items of all pages."""
        call: Call[tuple[Sequence[T], str | None]] | None = self.first
        while call is not None:
            items, cursor = call.sync(client)
            yield from items
            call = self._after(cursor)

    async def asynchronous(self, client: AsyncSender) -> AsyncIterator[T]:
        """Returns an asynchronous iterator over the items of all pages."""
        call: Call[tuple[Sequence[T], str | None]] | None = self.first
        while call is not None:
            items, cursor = await call.asynchronous(client)
            for item in items:
                yield item
            call = self._after(cursor)

    def _after(self, cursor: str | None) -> Call[tuple[Sequence[T], str | None]] | None:
        if cursor is None:
            return None
        return replace(self.first, query={**self.first.query, "cursor": cursor})


class Route(Generic[P, S, A]):
    """Method of both clients, made of the function that describes a request."""

    def __init__(self, describe: Callable[P, Description[S, A]]) -> None:
        """Makes the method of a function that returns a description."""
        self._describe = describe
        self.__doc__ = describe.__doc__

    @overload
    def __get__(self, client: None, owner: type) -> Callable[P, Description[S, A]]: ...
    @overload
    def __get__(self, client: Sender, owner: type) -> Callable[P, S]: ...
    @overload
    def __get__(self, client: AsyncSender, owner: type) -> Callable[P, A]: ...
    def __get__(self, client: Sender | AsyncSender | None, owner: type) -> Callable[P, Any]:
        """Returns the method of a client; of the class, the describing function."""
        describe = self._describe
        if client is None:
            return describe
        if isinstance(client, Sender):
            return face(describe, lambda made: made.sync(client))
        return face(describe, lambda made: made.asynchronous(client))


def face(
    describe: Callable[..., Description[S, A]],
    perform: Callable[[Description[S, A]], Any],
    *bound: Any,
) -> Callable[..., Any]:
    """Returns a function that performs a description, with the name and help of `describe`.

    Args:
        describe: Function that returns the description.
        perform: Does what the description says.
        bound: First arguments of `describe`, which the result does not take.
    """

    @functools.wraps(describe)
    def method(*arguments: Any, **named: Any) -> Any:
        return perform(describe(*bound, *arguments, **named))

    # Notebooks show the signature: without the bound arguments, and without the description.
    signature = inspect.signature(describe)
    parameters = list(signature.parameters.values())[len(bound) :]
    empty = inspect.Signature.empty
    shown = signature.replace(parameters=parameters, return_annotation=empty)
    method.__signature__ = shown  # type: ignore[attr-defined]
    return method


class Identified(Protocol):
    """Anything with an id: a lineage, a generation, an individual, a target, a search, a scene."""

    @property
    def id(self) -> str:
        """Id of the thing."""
        ...


Ref = str | Identified
"""A thing of the server, or its id."""

File = bytes | str | os.PathLike[str]
"""Bytes, or the path of a file to read."""


def id_of(thing: Ref) -> str:
    """Returns the id of a thing or of itself."""
    return thing if isinstance(thing, str) else thing.id


def path_of(*parts: str) -> str:
    """Returns the path below `/v1` of these parts, percent-encoded."""
    return "/v1/" + "/".join(quote(part, safe="") for part in parts)


def given(**values: Any) -> dict[str, Any]:
    """Returns the values that are not None: the server has defaults for the others."""
    return {name: value for name, value in values.items() if value is not None}


def bytes_of(file: File) -> bytes:
    """Returns bytes as they are, or those of the file at a path."""
    return file if isinstance(file, bytes) else Path(file).read_bytes()
