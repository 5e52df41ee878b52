"""What cuts the ground into triangles: the interchangeable backends of Terrain.backend."""

from __future__ import annotations

from importlib import import_module

from ....engine.frame import Views
from ....engine.methods import Methods
from ....engine.settings import Settings
from .base import Backend, Ground, GroundRevision

__all__ = ["Backend", "Ground", "GroundRevision", "backend_of", "use_backend"]

_BACKENDS: dict[str, dict[str, tuple[str, str]]] = {
    "grid": {"ours": ("grid", "GridBackend"), "paper": ("paper_grid", "PaperGridBackend")},
    "quadtree": {"ours": ("quadtree", "QuadtreeBackend"), "paper": ("paper_quadtree", "PaperQuadtreeBackend")},
    "icosphere": {"ours": ("icosphere", "IcosphereBackend"), "paper": ("paper_icosphere", "PaperIcosphereBackend")},
}
"""Module and class: a scene has one of them."""


def backend_of(name: str, method: str) -> type[Backend]:
    """That of Terrain.backend and Terrain.method."""
    module, kind = _BACKENDS[name][method]
    return getattr(import_module(f".{module}", __package__), kind)


def use_backend(backends: Methods[Backend], kind: type[Backend], settings: Settings, views: Views) -> bool:
    """Draw with a backend; whether it is another."""
    return backends.use(kind, lambda gpu: kind(gpu, settings, views))
