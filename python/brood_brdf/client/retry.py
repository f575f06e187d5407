"""Retries: when a request is sent again, and after how long.

The decisions are a generator of steps without input or output, so that the synchronous and the
asynchronous client share them. A client sends the requests, sleeps, and returns the results.
"""

from __future__ import annotations

import random
import time
from collections.abc import Callable, Generator
from dataclasses import dataclass
from email.utils import parsedate_to_datetime
from typing import TypeVar

import httpx

from .error import Unreachable

__all__ = ["Pause", "Retry", "Send", "Steps", "exchange"]

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Send:
    """Step: send the request, and return the answer or throw the `httpx.TransportError`."""

    request: httpx.Request
    stream: bool = False
    """True to return before the body is read; the receiver must close the answer."""


@dataclass(frozen=True, slots=True)
class Pause:
    """Step: sleep."""

    seconds: float


Steps = Generator[Send | Pause, httpx.Response | None, T]
"""Generator of steps that returns a result. It gets an answer for `Send`, and None for `Pause`."""


@dataclass(frozen=True, slots=True)
class Retry:
    """Policy of retries.

    A request is repeated after 429, 502, 503 and 504 and after connection errors, and if a repeated
    write finds that its first attempt still runs. `Retry-After` decides the pause if present, else
    the pause doubles with each attempt, minus a random part of up to a half.

    Attributes:
        attempts: Most attempts of a request, at least 1; 1 never retries.
        connection_attempts: Most attempts without any answer, so that a wrong address is reported
            soon.
        total_s: Most seconds from the first attempt to the start of the last.
        first_s: First pause without `Retry-After`, in seconds.
        longest_s: Longest pause without `Retry-After`, in seconds.
        clock: Returns monotonic seconds.
        now: Returns seconds since 1970, to read a `Retry-After` that is a date.
        chance: Returns a random number from 0 to 1.
    """

    attempts: int = 12
    connection_attempts: int = 6
    total_s: float = 300.0
    first_s: float = 0.25
    longest_s: float = 10.0
    clock: Callable[[], float] = time.monotonic
    now: Callable[[], float] = time.time
    # The system's source: `random.random` would shift the numbers of a seeded script.
    chance: Callable[[], float] = random.SystemRandom().random

    def pause_s(self, attempt: int, answer: httpx.Response | None) -> float:
        """Returns the seconds to wait after an attempt.

        Args:
            attempt: Number of attempts so far, from 1.
            answer: The answer, or None after a connection error.
        """
        asked = None if answer is None else self._asked_s(answer.headers.get("retry-after"))
        if asked is not None:
            return asked
        # Bounded exponent: the power must not overflow with very many attempts.
        pause_s = min(self.longest_s, self.first_s * 2.0 ** min(attempt - 1, 60))
        return pause_s * (1.0 - 0.5 * self.chance())

    def _asked_s(self, value: str | None) -> float | None:
        if value is None:
            return None
        if value.strip().isdecimal():
            return float(value)
        try:
            return max(0.0, parsedate_to_datetime(value).timestamp() - self.now())
        except (ValueError, OverflowError):
            return None


_REPEATABLE = frozenset({"GET", "HEAD", "OPTIONS", "PUT", "DELETE"})


def exchange(request: httpx.Request, retry: Retry, stream: bool = False) -> Steps[httpx.Response]:
    """Sends a request until it has a final answer; returns the answer, which may be an error.

    Args:
        request: The request. Its body must be bytes, so that it can be sent again.
        retry: The policy.
        stream: True to return a final answer before its body is read.

    Raises:
        Unreachable: If no attempt had an answer.
    """
    begun_s = retry.clock()
    has_key = "idempotency-key" in request.headers
    # `If-Match: *` states the new values whatever the old ones are; with a version, a repeated
    # change would fail although its first attempt succeeded.
    is_absolute = request.method == "PATCH" and request.headers.get("if-match") == "*"
    is_repeatable = has_key or is_absolute or request.method in _REPEATABLE
    attempt = failures = 0
    while True:
        attempt += 1
        answer: httpx.Response | None = None
        failure: httpx.TransportError | None = None
        try:
            answer = yield Send(request, stream)
            assert answer is not None, "a client answers `Send` with a response"
            is_final = not _may_repeat(answer, has_key, is_repeatable)
        except httpx.TransportError as error:
            failure = error
            failures += 1
            # A request whose connection was refused has had no effect.
            never_sent = isinstance(error, httpx.ConnectError | httpx.ConnectTimeout)
            is_hopeless = isinstance(error, httpx.UnsupportedProtocol)
            is_final = is_hopeless or not (never_sent or is_repeatable)
            is_final = is_final or failures >= retry.connection_attempts
        pause_s = retry.pause_s(attempt, answer)
        is_late = retry.clock() - begun_s + pause_s > retry.total_s
        if is_final or attempt >= retry.attempts or is_late:
            if answer is not None:
                is_done = request.method == "DELETE" and failures > 0
                # An attempt whose answer was lost has deleted it.
                return _deleted(request) if is_done and answer.status_code == 404 else answer
            words = f"no answer from {request.url} after {attempt} attempts: {failure!r}"
            raise Unreachable(words) from failure
        yield Pause(pause_s)


def _may_repeat(answer: httpx.Response, has_key: bool, is_repeatable: bool) -> bool:
    """Returns true if the same request may have another answer later."""
    if answer.status_code in (429, 503):
        return True
    if answer.status_code == 409 and has_key:
        return _is_still_running(answer)
    return answer.status_code in (502, 504) and is_repeatable


def _deleted(request: httpx.Request) -> httpx.Response:
    return httpx.Response(204, request=request)


def _is_still_running(answer: httpx.Response) -> bool:
    """Returns true if the first request with the same key is not done yet."""
    try:
        problem = answer.json()
    except ValueError:
        return False
    return isinstance(problem, dict) and "/problems/still-running" in problem.values()
