"""Records: typed answers of the server, and the readers that make them."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Concatenate, Generic, ParamSpec, TypeVar, overload

import httpx

from .call import Call, Description, Listing, Sender, face, given
from .error import BroodError

__all__ = ["Method", "Record", "items_of", "listing", "nothing", "read_bytes"]
__all__ += ["read_bytes_if_any", "read_json", "read_text", "record_of"]

T = TypeVar("T")
S = TypeVar("S")
A = TypeVar("A")
P = ParamSpec("P")
R = TypeVar("R", bound="Record")


@dataclass(frozen=True, slots=True, kw_only=True)
class Record:
    """Answer of the server. It is a snapshot: it does not follow later changes.

    Attributes:
        extra: Fields of the answer that this version of the client does not name.
    """

    nested: ClassVar[Mapping[str, type[Record]]] = {}
    """Fields that hold records, or lists of records."""

    renamed: ClassVar[Mapping[str, str]] = {}
    """Names of the answer's fields whose names are taken, and their names here."""

    extra: Mapping[str, Any] = field(default_factory=dict[str, Any], repr=False, compare=False)
    _client: Sender | None = field(default=None, repr=False, compare=False)

    @classmethod
    def of(cls: type[R], data: Mapping[str, Any], client: Sender | None = None) -> R:
        """Returns the record of a JSON object.

        Args:
            data: The object.
            client: Client that the record's methods use; None for a record without methods.

        Raises:
            BroodError: If a field without a default is missing.
        """
        own = {each.name for each in dataclasses.fields(cls)} - {"extra", "_client"}
        values: dict[str, Any] = {}
        extra: dict[str, Any] = {}
        for wire_name, value in data.items():
            name = cls.renamed.get(wire_name, wire_name)
            if name in own:
                values[name] = cls._value(name, value, client)
            else:
                extra[name] = value
        try:
            return cls(**values, extra=extra, _client=client)
        except TypeError as error:
            words = f"the answer is no {cls.__name__}: {error}; is the server of another version?"
            raise BroodError(words) from error

    @classmethod
    def _value(cls, name: str, value: Any, client: Sender | None) -> Any:
        kind = cls.nested.get(name)
        if isinstance(value, list):
            return tuple(kind.of(item, client) if kind else item for item in value)
        return kind.of(value, client) if kind and value is not None else value

    def __reduce__(self) -> tuple[Callable[[], Any], tuple[()]]:
        """Pickles the fields without the client: other processes get a record without methods."""
        names = {each.name for each in dataclasses.fields(self)} - {"_client"}
        values = {name: getattr(self, name) for name in names}
        return functools.partial(type(self), **values), ()

    @property
    def _shown_by(self) -> Sender | None:
        """Client that can load pictures for a notebook; None if there is none or it is closed."""
        client = self._client
        return client if client is not None and not client.is_closed else None


class Method(Generic[P, S, A]):
    """Method of a record, made of the function that describes a request about it."""

    def __init__(self, describe: Callable[Concatenate[Any, P], Description[S, A]]) -> None:
        """Makes the method of a function whose first parameter is the record."""
        self._describe = describe
        self.__doc__ = describe.__doc__

    @overload
    def __get__(
        self, record: None, owner: type
    ) -> Callable[Concatenate[Any, P], Description[S, A]]: ...
    @overload
    def __get__(self, record: Record, owner: type) -> Callable[P, S]: ...
    def __get__(self, record: Record | None, owner: type) -> Callable[..., Any]:
        """Returns the method of a record; of the class, the describing function.

        Raises:
            TypeError: If the record has no client.
        """
        if record is None:
            return self._describe
        client = record._client
        if client is None:
            kind, name = owner.__name__, getattr(self._describe, "__name__", "?")
            raise TypeError(
                f"this {kind} has no methods, because it is not from `Client`; with `AsyncClient`, "
                f"pass it to the client's method, such as `await client.{name}(...)`"
            )
        return face(self._describe, lambda made: made.sync(client), record)


def record_of(kind: type[R]) -> Callable[[httpx.Response, Sender | None], R]:
    """Returns the reader of an answer that is one record."""
    return lambda answer, client: kind.of(answer.json(), client)


def items_of(kind: type[R]) -> Callable[[httpx.Response, Sender | None], tuple[R, ...]]:
    """Returns the reader of an answer that is an array of records."""
    return lambda answer, client: tuple(kind.of(item, client) for item in answer.json())


def listing(kind: type[R], path: str, page_size: int | None, **query: Any) -> Listing[R]:
    """Returns the description of a list in pages.

    Args:
        kind: Type of the items.
        path: Path of the list.
        page_size: Items per request, 1 to 200; None for the server's default.
        query: Further query parameters.
    """

    def read(answer: httpx.Response, client: Sender | None) -> tuple[Sequence[R], str | None]:
        page = answer.json()
        return [kind.of(item, client) for item in page["items"]], page.get("next")

    return Listing(Call("GET", path, read, query=given(**query, limit=page_size)))


def read_bytes(answer: httpx.Response, _: Sender | None) -> bytes:
    """Reads an answer that is a file."""
    return answer.content


def read_bytes_if_any(answer: httpx.Response, _: Sender | None) -> bytes | None:
    """Reads an answer that is a file, or None without a body."""
    return answer.content or None


def read_text(answer: httpx.Response, _: Sender | None) -> str:
    """Reads an answer that is text."""
    return answer.content.decode("utf-8")


def read_json(answer: httpx.Response, _: Sender | None) -> Any:
    """Reads an answer that is JSON of any form."""
    return answer.json()


def nothing(_: httpx.Response, __: Sender | None) -> None:
    """Reads an answer without a body."""
