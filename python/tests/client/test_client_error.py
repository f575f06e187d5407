"""Errors of a real server, as exceptions."""

from __future__ import annotations

import dataclasses
import pickle
from collections.abc import Callable

import pytest

from brood_brdf.client import (
    AccessDenied,
    ApiError,
    AsyncClient,
    BadGenome,
    BroodError,
    Client,
    Conflict,
    Invalid,
    Lineage,
    NotFound,
    Retry,
    Unreachable,
)
from client_harness import SIZE_PX, BroodServer


def test_bad_genome_has_its_place(client: Client, lineage: Lineage) -> None:
    text = "brood 1\n.model lambert\nalbedo 1 2 x\n"
    calls: list[Callable[[], object]] = [
        lambda: client.store_genome(text),
        lambda: client.render(text),
        lambda: client.export_genome(text, "wgsl"),
        lambda: lineage.adopt(texts=[text]),
    ]
    for call in calls:
        with pytest.raises(ValueError) as caught:
            call()
        error = caught.value
        assert isinstance(error, BadGenome)
        assert (error.status, error.type) == (422, "/problems/bad-genome")
        assert error.line == 3 and error.column is not None
        assert f"line 3, column {error.column}" in str(error) and error.request_id
    with pytest.raises(BadGenome) as pointed:
        client.store_genome({"brood": 1, "nonsense": 2})
    assert pointed.value.pointer == "/nonsense"


def test_invalid_values_are_pointed_at(lineage: Lineage) -> None:
    with pytest.raises(Invalid, match="must be 1 to 256") as caught:
        lineage.breed(count=0)
    assert (caught.value.pointer, caught.value.method) == ("/count", "POST")
    with pytest.raises(Invalid, match="16 to 2048"):
        lineage.breed(count=1)[0].picture(1)


def test_missing_and_conflicting_things(client: Client, lineage: Lineage) -> None:
    missing = "01900000-0000-7000-8000-000000000000"
    for call in [client.lineage, client.individual, client.search, client.target, client.job]:
        with pytest.raises(NotFound) as caught:
            call(missing)
        assert caught.value.status == 404
    child = lineage.breed(count=1, seed=1)[0]
    assert child.mark(note="a", version=child.version).note == "a"
    with pytest.raises(Conflict) as stale:
        child.mark(note="b", version=child.version)
    assert stale.value.status == 412


def test_records_are_pickled_without_their_client(lineage: Lineage) -> None:
    brood = lineage.breed(count=2, seed=1)
    copy = pickle.loads(pickle.dumps(brood))
    assert copy == brood and copy[1] == brood[1]
    with pytest.raises(TypeError, match="has no methods"):
        copy[1].picture()


def test_error_survives_pickling(client: Client) -> None:
    with pytest.raises(NotFound) as caught:
        client.lineage("nonsense")
    copy = pickle.loads(pickle.dumps(caught.value))
    assert isinstance(copy, ApiError) and str(copy) == str(caught.value)


def test_token_is_needed_and_its_scope_counts(tmp_path_factory: pytest.TempPathFactory) -> None:
    with BroodServer(tmp_path_factory.mktemp("guarded")) as server:
        tokens = {
            scope: server.command("token", "add", scope, "--scope", scope).split()[-1]
            for scope in ("read", "breed")
        }
        retry = Retry(attempts=1)
        with Client(server.url, retry=retry) as client, pytest.raises(AccessDenied) as caught:
            client.system()
        assert caught.value.status == 401
        with Client(server.url, token=tokens["read"]) as client:
            assert list(client.lineages()) == []
            with pytest.raises(AccessDenied) as caught:
                client.create_lineage("x")
            assert caught.value.status == 403
        with Client(server.url, token=tokens["breed"]) as client:
            lineage = client.create_lineage("x", thumbnail_px=SIZE_PX)
            with lineage.events() as events:
                lineage.breed(count=1)
                assert next(events).name == "generation"


def test_server_that_is_away_is_reported() -> None:
    retry = Retry(attempts=2, first_s=0.01)
    with Client("http://127.0.0.1:9", retry=retry) as client:
        with pytest.raises(Unreachable, match="2 attempts"):
            client.system()
        with pytest.raises(ConnectionError):
            client.system()


def test_records_without_a_client_name_the_way(lineage: Lineage) -> None:
    bare = Lineage.of(_fields(lineage))
    with pytest.raises(TypeError, match=r"await client\.breed"):
        bare.breed()
    with pytest.raises(BroodError, match="is no Lineage"):
        Lineage.of({"id": "x"})
    assert AsyncClient.breed is Client.breed


def test_unknown_fields_are_kept(lineage: Lineage) -> None:
    later = Lineage.of({**_fields(lineage), "colour": "red"})
    assert later.extra == {"colour": "red"} and later == lineage
    assert hash(later) == hash(lineage)


def _fields(lineage: Lineage) -> dict[str, object]:
    names = {each.name for each in dataclasses.fields(lineage)} - {"extra", "_client"}
    wire = {own: name for name, own in Lineage.renamed.items()}
    return {wire.get(name, name): getattr(lineage, name) for name in names}
