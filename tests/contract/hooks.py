"""Hooks of schemathesis: bytes for bodies that are no JSON, and ids that the server knows.

Three of four ids in addresses and bodies are replaced by known ones, so that requests reach more
than the answer 404. `BROOD_CONTRACT_IDS` lists them by kind.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
from typing import Any

import schemathesis
from hypothesis import strategies as st

KNOWN: dict[str, list[str]] = json.loads(os.environ["BROOD_CONTRACT_IDS"])

# Kinds of ids by the place in an address.
COLLECTIONS = {
    "environments": "image",
    "generations": "generation",
    "genomes": "genome",
    "images": "image",
    "individuals": "individual",
    "jobs": "job",
    "lineages": "lineage",
    "meshes": "mesh",
    "scenes": "scene",
    "targets": "target",
    "thumbnails": "thumbnail",
}
# Kinds of ids by the name of a field or parameter.
FIELDS = {
    "cover_individual": "individual",
    "generation": "generation",
    "genomes": "genome",
    "individual": "individual",
    "individuals": "individual",
    "job": "job",
    "lineage": "lineage",
    "material": "genome",
    "materials": "genome",
    "parent": "individual",
    "parents": "individual",
    "scene": "scene",
    "start": "individual",
    "target": "target",
}
BINARY = [
    "application/vnd.brood.lease",
    "image/vnd.radiance",
    "image/x-exr",
    "image/png",
    "image/jpeg",
    "application/octet-stream",
    "model/obj",
]
HEADS = [b"", b"#?RADIANCE\n\n-Y 4 +X 4\n", b"\x76\x2f\x31\x01\x02\x00\x00\x00", b"\x89PNG\r\n\x1a\n"]

for media_type in BINARY:
    schemathesis.openapi.media_type(
        media_type,
        st.tuples(st.sampled_from(HEADS), st.binary(max_size=200)).map(b"".join),
    )


def known(kind: str, generated: object) -> object:
    """Returns a known id in place of three of four generated values."""
    ids = KNOWN.get(kind, [])
    number = int.from_bytes(hashlib.blake2b(repr(generated).encode(), digest_size=8).digest())
    return ids[number // 4 % len(ids)] if ids and number % 4 else generated


def replaced(value: Any) -> Any:
    """Returns JSON with known ids in the fields that hold ids."""
    if isinstance(value, list):
        return [replaced(one) for one in value]
    if not isinstance(value, dict):
        return value
    found = {}
    for name, one in value.items():
        kind = FIELDS.get(name)
        if kind and isinstance(one, str):
            found[name] = known(kind, one)
        elif kind and isinstance(one, list) and all(isinstance(each, str) for each in one):
            found[name] = [known(kind, each) for each in one]
        else:
            found[name] = replaced(one)
    return found


@schemathesis.hook
def map_case(context: Any, case: Any) -> Any:
    """Puts known ids into a case."""
    place = re.match(r"^/v1/([a-z-]+)/\{(\w+)\}", case.path)
    if place and place[1] in COLLECTIONS and isinstance(case.path_parameters, dict):
        name = place[2]
        if name in case.path_parameters:
            case.path_parameters[name] = known(COLLECTIONS[place[1]], case.path_parameters[name])
    if isinstance(case.query, dict):
        case.query = replaced(case.query)
    if isinstance(case.body, (dict, list)):
        case.body = replaced(case.body)
    return case
