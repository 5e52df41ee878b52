"""Props: a game's own objects among the planet's surfaces."""

from .meshes import MeshError, is_file, load_mesh
from .system import PropsSystem

__all__ = ["MeshError", "PropsSystem", "is_file", "load_mesh"]
