"""Errors of the HTTP client: answers of the server that are problems, and missing answers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast

import httpx

__all__ = [
    "AccessDenied",
    "ApiError",
    "BadGenome",
    "BroodError",
    "Conflict",
    "Invalid",
    "NotFound",
    "SearchFailed",
    "TooBusy",
    "Unreachable",
]


class BroodError(Exception):
    """Base of all errors that the client raises."""


class Unreachable(BroodError, ConnectionError):
    """No complete answer arrived, after all attempts; the cause is the `httpx` error."""


class SearchFailed(BroodError):
    """A search ended with the state `failed`; the text is the reason that the server gave."""


class ExportFailed(BroodError):
    """A job that makes a ZIP file has failed or was cancelled."""


class ApiError(BroodError):
    """The server answered with an error.

    Attributes:
        status: HTTP status.
        type: Stable identifier of the kind of problem, such as `/problems/unknown-id`.
        title: Short title of the kind of problem.
        detail: Explanation of this occurrence.
        pointer: JSON pointer to the wrong value in the request's body, or None.
        line: Line of the mistake in a text body, from 1, or None.
        column: Column of the mistake in a text body, from 1, or None.
        request_id: Id of the request in the server's log, or None.
        method: Method of the request.
        url: URL of the request.
    """

    def __init__(self, status: int, problem: Mapping[str, Any], method: str, url: str) -> None:
        """Makes the error from the members of an `application/problem+json` object."""
        self.status = status
        self.type = str(problem.get("type") or "about:blank")
        self.title = str(problem.get("title") or "The request failed")
        self.detail = str(problem.get("detail") or "")
        self.pointer: str | None = problem.get("pointer")
        self.line: int | None = problem.get("line")
        self.column: int | None = problem.get("column")
        self.request_id: str | None = problem.get("request_id")
        self.method = method
        self.url = url
        super().__init__(status, problem, method, url)

    def __str__(self) -> str:
        """Returns the problem with its place, for people."""
        places = [
            f"line {self.line}" if self.line is not None else "",
            f"column {self.column}" if self.column is not None else "",
            f"at {self.pointer}" if self.pointer else "",
        ]
        place = ", ".join(place for place in places if place)
        words = [f"{self.title} ({self.status})", place, self.detail]
        path = httpx.URL(self.url).raw_path.decode("ascii")
        return ": ".join(word for word in words if word) + f" [{self.method} {path}]"


class NotFound(ApiError):
    """There is no such thing (404), or its picture is from an older renderer (410)."""


class Invalid(ApiError, ValueError):
    """The request has an invalid value (400, 413, 415 or 422); a retry cannot succeed."""


class BadGenome(Invalid):
    """A genome's text or JSON is invalid; `line`, `column` or `pointer` is the place."""


class Conflict(ApiError):
    """The present state does not allow the change (409), or it changed meanwhile (412)."""


class AccessDenied(ApiError):
    """A token is missing or unknown (401), or its scope is too small (403)."""


class TooBusy(ApiError):
    """The server was still busy (429 or 503) after all attempts."""


_BY_STATUS: dict[int, type[ApiError]] = {
    400: Invalid,
    401: AccessDenied,
    403: AccessDenied,
    404: NotFound,
    409: Conflict,
    410: NotFound,
    412: Conflict,
    413: Invalid,
    415: Invalid,
    422: Invalid,
    429: TooBusy,
    503: TooBusy,
}


def error_of(response: httpx.Response) -> ApiError:
    """Returns the error of an answer with a status of 400 or more, whose body was read.

    Args:
        response: The answer. A body that is no problem, such as that of a proxy, is tolerated.
    """
    try:
        body = response.json()
    except ValueError:
        body = None
    is_object = isinstance(body, dict)
    problem = cast(dict[str, Any], body) if is_object else {"detail": response.text[:500]}
    problem.setdefault("title", response.reason_phrase or "The request failed")
    problem.setdefault("request_id", response.headers.get("x-request-id"))
    kind = _BY_STATUS.get(response.status_code, ApiError)
    if problem.get("type") == "/problems/bad-genome":
        kind = BadGenome
    request = response.request
    return kind(response.status_code, problem, request.method, str(request.url))
