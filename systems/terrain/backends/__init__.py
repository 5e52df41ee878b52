"""What cuts the ground into triangles: the interchangeable backends of Terrain.backend."""

from __future__ import annotations

from ....engine.frame import Views
from ....engine.methods import Methods
from ....engine.settings import Settings
from .base import Backend, Ground, GroundRevision
from .grid import GridBackend
from .icosphere import IcosphereBackend
from .paper_grid import PaperGridBackend
from .paper_icosphere import PaperIcosphereBackend
from .paper_quadtree import PaperQuadtreeBackend
from .quadtree import QuadtreeBackend

__all__ = ["Backend", "Ground", "GroundRevision", "backend_of", "use_backend"]

_BACKENDS: dict[str, dict[str, type[Backend]]] = {
    "grid": {"ours": GridBackend, "paper": PaperGridBackend},
    "quadtree": {"ours": QuadtreeBackend, "paper": PaperQuadtreeBackend},
    "icosphere": {"ours": IcosphereBackend, "paper": PaperIcosphereBackend},
}


def backend_of(name: str, method: str) -> type[Backend]:
    """That of Terrain.backend and Terrain.method."""
    return _BACKENDS[name][method]


def use_backend(backends: Methods[Backend], kind: type[Backend], settings: Settings, views: Views) -> bool:
    """Draw with a backend; whether it is another."""
    return backends.use(kind, lambda gpu: kind(gpu, settings, views))
