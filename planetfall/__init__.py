"""Planetfall: whole planets for Python, from 36 000 km out down to a beach.

>>> import planetfall as pf
>>> scene = pf.load_scene("earth")
>>> renderer = pf.Renderer(scene, size=(640, 360))
>>> picture = renderer.render(pf.view("orbit"))["color"]
"""

import importlib as _importlib
from pathlib import Path as _Path
from typing import TYPE_CHECKING as _TYPE_CHECKING
from typing import Any as _Any

from ._version import __version__

# In a checkout the library's folders (engine, systems, components, assets, games, benchmarks) lie beside this one; in
# an installed wheel they lie inside it. Either way they are imported as planetfall.engine and so on.
_root = _Path(__file__).resolve().parent
if not (_root / "engine").is_dir():
    __path__.append(str(_root.parent))
ASSETS = (_root if (_root / "assets").is_dir() else _root.parent) / "assets"

# ruff: noqa: E402 - the folders have to be found first
from .camera.camera import Camera
from .camera.intrinsics import Intrinsics
from .camera.read_place import read_place
from .camera.views import View, view, views
from .components import (
    Atmosphere,
    CloudLayer,
    Clouds,
    Composite,
    Cover,
    CoverSpecies,
    DebugView,
    Exposure,
    Ocean,
    Orbit,
    Planet,
    Shape,
    Stars,
    Sun,
    Terrain,
    Transform,
    Wave,
    Wind,
)
from .engine.space import direction, latitude_longitude
from .engine.world import World
from .errors import (
    CameraError,
    ContextLostError,
    MissingError,
    NotSettled,
    OutputError,
    PresetError,
    SceneError,
    SettingError,
    SizeError,
    UnknownNameError,
    UnknownSettingError,
)
from .quality import qualities
from .render.host_space import HostDepth, HostSpace
from .scene.file import planets
from .scene.scene import Companion, PlanetHandle, PropHandle, Scene, load_scene

if _TYPE_CHECKING:
    from .app.window import fly
    from .camera.flights import path, paths
    from .capture.captures import save_capture
    from .capture.dataset import dataset
    from .capture.photos import photo
    from .capture.recording import record
    from .capture.sensor import Sensor
    from .capture.shot import load_shot
    from .engine.gpu import GLLimitError, GLVersionError, ShaderError
    from .engine.graph import GraphError
    from .engine.hosts.headless import NoEGLError
    from .engine.hosts.window import has_display
    from .expected import expected_errors
    from .query.atmosphere import AtmosphereProbe
    from .query.climate import Climate
    from .query.clouds import CloudProbe
    from .query.cover import CoverSampler
    from .query.drainage import Drainage, River
    from .query.ocean import OceanSampler
    from .query.terrain import TerrainSampler
    from .query.trunk_bodies import TrunkBodies
    from .query.water import Water
    from .render.host_light import sun_direction
    from .render.renderer import Renderer
    from .systems.cover.mask import clearing, road

# What pulls in OpenGL or much code is imported when it is first used: a program that only reads heights or presets
# neither waits for it nor needs a GPU.
_LAZY = {
    "AtmosphereProbe": "query.atmosphere",
    "Climate": "query.climate",
    "CloudProbe": "query.clouds",
    "CoverSampler": "query.cover",
    "Drainage": "query.drainage",
    "GLLimitError": "errors",
    "GLVersionError": "errors",
    "GraphError": "errors",
    "NoEGLError": "errors",
    "OceanSampler": "query.ocean",
    "Renderer": "render.renderer",
    "River": "query.drainage",
    "Sensor": "capture.sensor",
    "ShaderError": "errors",
    "TerrainSampler": "query.terrain",
    "TrunkBodies": "query.trunk_bodies",
    "Water": "query.water",
    "clearing": "systems.cover.mask",
    "dataset": "capture.dataset",
    "expected_errors": "expected",
    "fly": "app.window",
    "has_display": "engine.hosts.window",
    "load_shot": "capture.shot",
    "path": "camera.flights",
    "paths": "camera.flights",
    "photo": "capture.photos",
    "record": "capture.recording",
    "road": "systems.cover.mask",
    "save_capture": "capture.captures",
    "sun_direction": "render.host_light",
}

__all__ = [
    "ASSETS",
    "Atmosphere",
    "AtmosphereProbe",
    "Camera",
    "CameraError",
    "Climate",
    "CloudLayer",
    "CloudProbe",
    "Clouds",
    "Companion",
    "Composite",
    "ContextLostError",
    "Cover",
    "CoverSampler",
    "CoverSpecies",
    "DebugView",
    "Drainage",
    "Exposure",
    "GLLimitError",
    "GLVersionError",
    "GraphError",
    "HostDepth",
    "HostSpace",
    "Intrinsics",
    "MissingError",
    "NoEGLError",
    "NotSettled",
    "Ocean",
    "OceanSampler",
    "Orbit",
    "OutputError",
    "Planet",
    "PlanetHandle",
    "PresetError",
    "PropHandle",
    "Renderer",
    "River",
    "Scene",
    "SceneError",
    "Sensor",
    "SettingError",
    "ShaderError",
    "Shape",
    "SizeError",
    "Stars",
    "Sun",
    "Terrain",
    "TerrainSampler",
    "Transform",
    "TrunkBodies",
    "UnknownNameError",
    "UnknownSettingError",
    "View",
    "Water",
    "Wave",
    "Wind",
    "World",
    "__version__",
    "clearing",
    "dataset",
    "direction",
    "expected_errors",
    "fly",
    "has_display",
    "latitude_longitude",
    "load_scene",
    "load_shot",
    "path",
    "paths",
    "photo",
    "planets",
    "qualities",
    "read_place",
    "record",
    "road",
    "save_capture",
    "sun_direction",
    "view",
    "views",
]


def __getattr__(name: str) -> _Any:
    module = _LAZY.get(name)
    if module is None:
        raise AttributeError(f"module 'planetfall' has no attribute {name!r}")
    from .engine.uncollected import uncollected

    with uncollected():  # some of these bring hundreds of modules
        value = getattr(_importlib.import_module(f".{module}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
