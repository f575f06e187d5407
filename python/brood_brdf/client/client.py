"""The synchronous and the asynchronous client: they send, sleep and close, and know no route."""

from __future__ import annotations

import asyncio
import ipaddress
import time
import uuid
from collections.abc import Awaitable, Callable, Mapping
from types import TracebackType
from typing import Any, TypeVar

import httpx

from .call import AsyncSender, Call, Sender
from .error import error_of
from .retry import Pause, Retry, Steps, exchange
from .routes import Routes

__all__ = ["DEFAULT_URL", "AsyncClient", "Client"]

T = TypeVar("T")

DEFAULT_URL = "http://127.0.0.1:7320"
"""Address of `brood serve` without options."""

_TIMEOUT = httpx.Timeout(90.0, connect=10.0)
"""The server answers waiting requests after at most 20 s; breeding large broods takes longer."""


class _Settings:
    """Options of a client, and the requests and steps that they lead to."""

    def __init__(self, url: str, token: str | None, retry: Retry | None, **http: Any) -> None:
        self.url = httpx.URL(url if "://" in url else f"http://{url}")
        self.retry = retry or Retry()
        headers = {"Authorization": f"Bearer {token}"} if token is not None else {}
        # Proxies of the environment do not lead to this machine.
        trust_env = not _is_loopback(self.url.host)
        self.http: dict[str, Any] = {
            "base_url": self.url,
            "headers": headers,
            "trust_env": trust_env,
            **http,
        }

    def exchange(
        self, http: httpx.Client | httpx.AsyncClient, call: Call[Any], stream: bool
    ) -> Steps[httpx.Response]:
        request = self.request(http, call)
        answer = yield from exchange(request, self.retry, stream)
        if answer.is_error:
            raise error_of(answer)
        return answer

    def request(self, http: httpx.Client | httpx.AsyncClient, call: Call[Any]) -> httpx.Request:
        if not call.path.startswith("/") or call.path.startswith("//"):
            # Another host must not get the token.
            raise ValueError(f"the path must begin with one slash, got {call.path!r}")
        headers = dict(call.headers)
        if call.method == "POST":
            # Made here, once for all attempts: the server answers a repeated request as the first.
            headers = {"Idempotency-Key": uuid.uuid4().hex, **headers}
        timeout: Any = httpx.USE_CLIENT_DEFAULT
        if call.silence_s is not None:
            timeout = httpx.Timeout(http.timeout.connect, read=call.silence_s)
        request = http.build_request(
            call.method,
            call.path,
            # None keeps a query that is part of the path; an empty one would remove it.
            params={name: _query_text(value) for name, value in call.query.items()} or None,
            json=call.json,
            content=call.content,
            files=list(call.files) or None,
            headers=headers,
            timeout=timeout,
        )
        # Multipart bodies are generated; as bytes they can be sent again.
        request.read()
        return request


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _query_text(value: Any) -> Any:
    return str(value).lower() if isinstance(value, bool) else value


def _described(
    method: str,
    path: str,
    query: Mapping[str, Any] | None,
    json: Any,
    content: bytes | None,
    headers: Mapping[str, str] | None,
) -> Call[httpx.Response]:
    query = {name: value for name, value in (query or {}).items() if value is not None}
    return Call(
        method.upper(),
        path,
        lambda answer, _: answer,
        query=query,
        json=json,
        content=content,
        headers=headers or {},
    )


class Client(Routes, Sender):
    """Synchronous client of a brood server.

    It must not be used by several threads at a time. Use it as a context manager, or close it.

    Example:
        >>> with Client() as client:
        ...     lineage = client.create_lineage("first")
        ...     brood = lineage.breed(seed=1)
        ...     child = lineage.breed([brood[2]], mutation=0.3, seed=2)[0]
        ...     png = child.picture(512)
    """

    def __init__(
        self,
        url: str = DEFAULT_URL,
        *,
        token: str | None = None,
        timeout: float | httpx.Timeout = _TIMEOUT,
        retry: Retry | None = None,
        transport: httpx.BaseTransport | None = None,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        """Makes a client, which connects with the first request.

        Args:
            url: Address of the server.
            token: Access token, as `brood token add` prints it; needed by remote servers.
            timeout: Seconds without progress after which an attempt fails, or `httpx.Timeout`.
            retry: Policy of retries; `Retry(attempts=1)` never retries.
            transport: Transport in place of the network, for tests.
            sleep: Sleeps the given seconds.
        """
        self._settings = _Settings(url, token, retry, timeout=timeout, transport=transport)
        self._http = httpx.Client(**self._settings.http)
        self._sleep = sleep

    def request(
        self,
        method: str,
        path: str,
        *,
        query: Mapping[str, Any] | None = None,
        json: Any = None,
        content: bytes | None = None,
        headers: Mapping[str, str] | None = None,
    ) -> httpx.Response:
        """Sends any request of the API, with the same retries and errors as the methods.

        Args:
            method: HTTP method.
            path: Path, such as `/v1/system`.
            query: Query parameters; those that are None are left out.
            json: JSON body.
            content: Body.
            headers: Further headers, such as `Content-Type` or an `Idempotency-Key` of your own.
        """
        return _described(method, path, query, json, content, headers).sync(self)

    def exchange(self, call: Call[Any], stream: bool = False) -> Steps[httpx.Response]:
        """Returns the steps of a request; they raise `ApiError` for an error answer."""
        return self._settings.exchange(self._http, call, stream)

    def run(self, steps: Steps[T]) -> T:
        """Runs steps to their result."""
        try:
            step = next(steps)
            while True:
                if isinstance(step, Pause):
                    self._sleep(step.seconds)
                    step = steps.send(None)
                    continue
                try:
                    answer = self._http.send(step.request, stream=step.stream)
                    if answer.is_error:
                        answer.read()
                except httpx.TransportError as error:
                    step = steps.throw(error)
                else:
                    step = steps.send(answer)
        except StopIteration as end:
            result: T = end.value
            return result
        finally:
            steps.close()

    def pause_s(self, attempt: int) -> float:
        """Returns the seconds to wait after the given number of failures in a row, from 1."""
        return self._settings.retry.pause_s(attempt, None)

    def clock_s(self) -> float:
        """Returns monotonic seconds."""
        return self._settings.retry.clock()

    @property
    def url(self) -> str:
        """Address of the server."""
        return str(self._settings.url)

    @property
    def is_closed(self) -> bool:
        """True once the client was closed."""
        return self._http.is_closed

    def close(self) -> None:
        """Closes all connections."""
        self._http.close()

    def __enter__(self) -> Client:
        """Returns itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Closes all connections."""
        self.close()


class AsyncClient(Routes, AsyncSender):
    """Asynchronous client of a brood server; it has the methods of `Client`.

    Results are awaited, lists and events are asynchronous iterators. Its records have no methods:
    pass them to those of the client.

    Example:
        >>> async with AsyncClient() as client:
        ...     lineage = await client.create_lineage("first")
        ...     brood = await client.breed(lineage, seed=1)
        ...     png = await client.picture(brood[2], 512)
    """

    def __init__(
        self,
        url: str = DEFAULT_URL,
        *,
        token: str | None = None,
        timeout: float | httpx.Timeout = _TIMEOUT,
        retry: Retry | None = None,
        transport: httpx.AsyncBaseTransport | None = None,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    ) -> None:
        """Makes a client, which connects with the first request.

        Args:
            url: Address of the server.
            token: Access token, as `brood token add` prints it; needed by remote servers.
            timeout: Seconds without progress after which an attempt fails, or `httpx.Timeout`.
            retry: Policy of retries; `Retry(attempts=1)` never retries.
            transport: Transport in place of the network, for tests.
            sleep: Sleeps the given seconds; `trio.sleep` under trio.
        """
        self._settings = _Settings(url, token, retry, timeout=timeout, transport=transport)
        self._http = httpx.AsyncClient(**self._settings.http)
        self._sleep = sleep

    async def request(
        self,
        method: str,
        path: str,
        *,
        query: Mapping[str, Any] | None = None,
        json: Any = None,
        content: bytes | None = None,
        headers: Mapping[str, str] | None = None,
    ) -> httpx.Response:
        """Sends any request of the API; the arguments are those of `Client.request`."""
        return await _described(method, path, query, json, content, headers).asynchronous(self)

    def exchange(self, call: Call[Any], stream: bool = False) -> Steps[httpx.Response]:
        """Returns the steps of a request; they raise `ApiError` for an error answer."""
        return self._settings.exchange(self._http, call, stream)

    async def run(self, steps: Steps[T]) -> T:
        """Runs steps to their result."""
        try:
            step = next(steps)
            while True:
                if isinstance(step, Pause):
                    await self._sleep(step.seconds)
                    step = steps.send(None)
                    continue
                try:
                    answer = await self._http.send(step.request, stream=step.stream)
                    if answer.is_error:
                        await answer.aread()
                except httpx.TransportError as error:
                    step = steps.throw(error)
                else:
                    step = steps.send(answer)
        except StopIteration as end:
            result: T = end.value
            return result
        finally:
            steps.close()

    def pause_s(self, attempt: int) -> float:
        """Returns the seconds to wait after the given number of failures in a row, from 1."""
        return self._settings.retry.pause_s(attempt, None)

    def clock_s(self) -> float:
        """Returns monotonic seconds."""
        return self._settings.retry.clock()

    @property
    def url(self) -> str:
        """Address of the server."""
        return str(self._settings.url)

    @property
    def is_closed(self) -> bool:
        """True once the client was closed."""
        return self._http.is_closed

    async def aclose(self) -> None:
        """Closes all connections."""
        await self._http.aclose()

    async def __aenter__(self) -> AsyncClient:
        """Returns itself."""
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Closes all connections."""
        await self.aclose()
