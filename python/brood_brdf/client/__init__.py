"""HTTP client of a brood server, for scripts and notebooks.

    from brood_brdf.client import Client

    with Client() as client:
        lineage = client.create_lineage("first", start="believable")
        brood = lineage.breed(seed=1)
        brood = lineage.breed([brood[2]], mutation=0.3, seed=2)
        print(brood[0].text())

`AsyncClient` has the same methods, to be awaited. Requests are repeated while the server is busy or
away; one that creates something is executed once all the same.
"""

from .client import DEFAULT_URL, AsyncClient, Client
from .error import (
    AccessDenied,
    ApiError,
    BadGenome,
    BroodError,
    Conflict,
    ExportFailed,
    Invalid,
    NotFound,
    SearchFailed,
    TooBusy,
    Unreachable,
)
from .event import AsyncEventStream, Event, EventStream
from .export import ExportJob
from .generation import Generation
from .genome import ExportFormat, Model, Parameter, Preset
from .individual import Individual
from .island import Island
from .job import DeferredAnswer, RenderJob
from .lineage import Lineage
from .record import Record
from .retry import Retry
from .scene import Asset, Mesh, MeshWarning, Scene
from .search import (
    FoundMaterial,
    FoundView,
    MaterialSpread,
    NextScene,
    Search,
    SearchLine,
)
from .system import System
from .target import Target

__all__ = [
    "DEFAULT_URL",
    "AccessDenied",
    "ApiError",
    "Asset",
    "AsyncClient",
    "AsyncEventStream",
    "BadGenome",
    "BroodError",
    "Client",
    "Conflict",
    "DeferredAnswer",
    "Event",
    "EventStream",
    "ExportFailed",
    "ExportFormat",
    "ExportJob",
    "FoundMaterial",
    "FoundView",
    "Generation",
    "Individual",
    "Invalid",
    "Island",
    "Lineage",
    "MaterialSpread",
    "Mesh",
    "MeshWarning",
    "Model",
    "NextScene",
    "NotFound",
    "Parameter",
    "Preset",
    "Record",
    "RenderJob",
    "Retry",
    "Scene",
    "Search",
    "SearchFailed",
    "SearchLine",
    "System",
    "Target",
    "TooBusy",
    "Unreachable",
]
