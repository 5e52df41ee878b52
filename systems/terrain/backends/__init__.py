"""What cuts the ground into triangles: the interchangeable backends of Terrain.backend."""

from __future__ import annotations

from ....engine.frame import Views
from ....engine.methods import Methods
from ....engine.settings import SettingError, Settings
from .base import Backend, Ground, GroundRevision
from .grid import GridBackend
from .icosphere import IcosphereBackend
from .paper_grid import PaperGridBackend
from .paper_icosphere import PaperIcosphereBackend
from .paper_quadtree import PaperQuadtreeBackend
from .quadtree import QuadtreeBackend

__all__ = ["BACKENDS", "Backend", "Ground", "GroundRevision", "use_backend"]

BACKENDS: dict[str, type[Backend]] = {"grid": GridBackend, "quadtree": QuadtreeBackend, "icosphere": IcosphereBackend}
"""By the names that Terrain.backend takes."""
_PAPER: dict[str, type[Backend]] = {
    "grid": PaperGridBackend,
    "quadtree": PaperQuadtreeBackend,
    "icosphere": PaperIcosphereBackend,
}
"""Those whose source's method has little in common with ours."""


def use_backend(backends: Methods[Backend], name: str, method: str, settings: Settings, views: Views) -> bool:
    """The backend of that name and method, whether it is another. SettingError for a method that it doesn't have."""
    found = _PAPER.get(name, BACKENDS[name]) if method == "paper" else BACKENDS[name]
    if method not in found.methods:
        raise SettingError(
            f"Terrain.method {method!r} is not there for Terrain.backend {name!r}, which has"
            f" {', '.join(map(repr, found.methods))}; choose one of these, or another backend"
        )
    return backends.use(found, lambda gpu: found(gpu, settings, method, views), method)
