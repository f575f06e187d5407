"""The client agrees with openapi.json, and all public names have docstrings and annotations."""

from __future__ import annotations

import dataclasses
import inspect
import json
import re
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import pytest

import brood_brdf.client as package
from brood_brdf.client import Client, Lineage, Record
from brood_brdf.client.call import Call, Listing, Route
from brood_brdf.client.event import Watch
from brood_brdf.client.export import Archive
from brood_brdf.client.genome import Render
from brood_brdf.client.lineage import Adoption
from brood_brdf.client.routes import Routes
from brood_brdf.client.search import Wait
from client_harness import ROOT

OPENAPI = json.loads((ROOT / "openapi.json").read_text("utf-8"))
ROUTES = {name: each for name, each in vars(Routes).items() if isinstance(each, Route)}
# Samples of parameters that may not be any text, by name, or by route and name.
SAMPLES: dict[str, Any] = {
    "dialect": {},
    "file": b"\x89PNG",
    "files": {"a": b"x"},
    "layer": "pixels",
    "locks": {},
    "mask": b"x",
    "painting": {},
    "refine": {"light_deg": 2.0},
    "views": [{"picture": "a"}],
    "store_scene.scene": {},
    "thumbnail.individual": SimpleNamespace(thumbnail_path="/v1/thumbnails/x.png"),
    "develop.file": b"#?RADIANCE",
    "upload_environment.file": b"#?RADIANCE",
}
SCHEMAS = {
    "Asset": "LightAssetAnswer",
    "DeferredAnswer": "DeferredAnswer",
    "ExportFormat": "ExportFormat",
    "ExportJob": "ExportAnswer",
    "FoundMaterial": "FoundMaterial",
    "FoundView": "FoundView",
    "Generation": "Generation",
    "Individual": "IndividualDetail",
    "Island": "IslandAnswer",
    "Lineage": "ListedLineage",
    "MaterialSpread": "MaterialSpread",
    "Mesh": "MeshAnswer",
    "MeshWarning": "MeshWarning",
    "Model": "ModelAnswer",
    "NextScene": "NextScene",
    "Parameter": "ParameterAnswer",
    "Preset": "PresetAnswer",
    "RenderJob": "JobAnswer",
    "Scene": "SceneAnswer",
    "Search": "SearchAnswer",
    "SearchLine": "SearchLine",
    "System": "SystemAnswer",
    "Target": "Target",
}
# Left to `Client.request`: workers, the page, operations, and what other routes answer as well.
LEFT_OUT = re.compile(
    r"^/v1/(leases|session|images/)|^/(healthz|metrics)|"
    r"/(lit-angles|outlines|ray-ends|geometry|mean|difference.png|answer)$|/views/.n./(mask|picture|scene).png$"
)


def schema(name: str) -> tuple[dict[str, Any], set[str]]:
    """Returns the properties and the required ones of a schema, by its name or reference."""
    properties: dict[str, Any] = {}
    required: set[str] = set()
    whole = OPENAPI["components"]["schemas"][name.rsplit("/", 1)[-1]]
    for part in whole.get("allOf", [whole]):
        if "$ref" in part:
            more, needed = schema(part["$ref"])
        else:
            more, needed = part.get("properties", {}), set(part.get("required", []))
        properties |= more
        required |= needed
    return properties, required


def calls(made: object) -> Iterator[Call[Any]]:
    """Returns the requests of a description."""
    if isinstance(made, Call):
        yield made
    elif isinstance(made, Listing):
        yield made.first
    elif isinstance(made, Watch | Render):
        yield made.call
    elif isinstance(made, Archive):
        yield made.begin
    else:
        assert isinstance(made, Adoption | Wait), made


def described(name: str) -> Iterator[tuple[str, Call[Any]]]:
    """Returns the path templates and requests of a route, with a sample for each parameter."""
    describe = ROUTES[name]._describe
    named = inspect.signature(describe).parameters.values()
    fields = {
        each.name: SAMPLES.get(f"{name}.{each.name}", SAMPLES.get(each.name, "1"))
        for each in named
        if each.kind is not each.VAR_KEYWORD
    }
    for call in calls(describe(**fields)):
        fitting = [
            template
            for template in OPENAPI["paths"]
            if re.fullmatch(re.sub(r"\{\w+\}", "[^/]+", template), call.path)
        ]
        assert fitting, f"the server has no {call.path}"
        yield min(fitting, key=lambda template: template.count("{")), call


@pytest.mark.parametrize("name", ROUTES)
def test_route_is_documented_by_the_server(name: str) -> None:
    for template, call in described(name):
        operation = OPENAPI["paths"][template][call.method.lower()]
        known = {each["name"] for each in operation.get("parameters", []) if each["in"] == "query"}
        assert set(call.query) <= known
        body = operation.get("requestBody", {}).get("content", {})
        if call.json is not None:
            reference = body["application/json"]["schema"]["$ref"]
            assert set(call.json) <= set(schema(reference)[0])
        if "Content-Type" in call.headers:
            assert call.headers["Content-Type"] in body


def test_all_routes_for_scripts_are_there() -> None:
    used = {template for name in ROUTES for template, _ in described(name)}
    used.add("/v1/lineages/{id}/adoptions")  # made while the steps of `adopt` run
    missing = {path for path in OPENAPI["paths"] if not LEFT_OUT.search(path)} - used
    assert missing == set(), "describe them, or add them to LEFT_OUT"


@pytest.mark.parametrize("name", SCHEMAS)
def test_record_has_the_fields_of_the_server(name: str) -> None:
    record: type[Record] = getattr(package, name)
    properties, required = schema(SCHEMAS[name])
    wire = {own: theirs for theirs, own in record.renamed.items()}
    fields = {wire.get(each.name, each.name): each for each in dataclasses.fields(record)}
    del fields["extra"], fields["_client"]
    assert set(fields) <= set(properties), "only what the server returns"
    if name != "Scene":
        assert set(properties) - {"kind"} <= set(fields), "name them, or they are only in `extra`"
        missing = dataclasses.MISSING
        needed = {
            theirs
            for theirs, each in fields.items()
            if each.default is missing and each.default_factory is missing
        }
        assert needed <= required


def test_all_records_are_compared() -> None:
    records = {name for name in package.__all__ if _is_record(getattr(package, name))}
    assert records - {"Record"} == set(SCHEMAS)


def _is_record(value: object) -> bool:
    return isinstance(value, type) and issubclass(value, Record)


def public() -> list[tuple[str, Any]]:
    """Returns the public classes and their public functions, with their names."""
    found: list[tuple[str, Any]] = []
    for name in package.__all__:
        value = getattr(package, name)
        if inspect.isclass(value):
            found.append((name, value))
            # The `__init__` of a dataclass is generated.
            has_init = "__init__" in vars(value) and not dataclasses.is_dataclass(value)
            for member, each in inspect.getmembers(value):
                each = each.fget if isinstance(each, property) else each
                is_own = inspect.isfunction(each) and each.__module__.startswith("brood_brdf")
                if is_own and (not member.startswith("_") or (member == "__init__" and has_init)):
                    found.append((f"{name}.{member}", each))
    return found


@pytest.mark.parametrize(("name", "value"), public())
def test_public_name_has_a_docstring_and_annotations(name: str, value: Any) -> None:
    assert value.__doc__ and value.__doc__[0].isupper(), "a sentence"
    assert all(len(line) <= 100 for line in value.__doc__.splitlines())
    if inspect.isfunction(value):
        signature = inspect.signature(value)
        assert signature.return_annotation is not signature.empty
        for parameter in signature.parameters.values():
            assert parameter.name == "self" or parameter.annotation is not parameter.empty
    if dataclasses.is_dataclass(value):
        fields = {each.name for each in dataclasses.fields(value)} - {"extra", "_client"}
        missing = {each for each in fields if f"\n        {each}: " not in value.__doc__}
        assert missing == set()


@pytest.mark.parametrize("name", ROUTES)
def test_parameters_are_documented(name: str) -> None:
    text = ROUTES[name].__doc__ or ""
    parameters = list(inspect.signature(ROUTES[name]._describe).parameters)
    if "arguments are those of" not in text and "Args:" in text:
        assert [each for each in parameters if f"\n        {each}: " not in text] == []
    else:
        assert len(parameters) <= 1 or parameters[1:] == ["page_size"] or "those of" in text


def test_methods_show_their_signature() -> None:
    with Client() as client:
        shown = inspect.signature(client.breed)
        assert list(shown.parameters)[:2] == ["lineage", "parents"]
        assert client.breed.__name__ == "breed" and "Breeds" in (client.breed.__doc__ or "")
        bound = Lineage.of(dict.fromkeys(schema("Lineage")[1], "x"), client)
        assert next(iter(inspect.signature(bound.breed).parameters)) == "parents"
