"""A scene as bytes that go to another machine, with its maps."""

from __future__ import annotations

import tempfile
from pathlib import Path

from ..components import Terrain
from ..engine.real_ground.tile_index import is_tiles
from ..errors import SceneError
from ..scene.kinds import SUFFIX
from ..scene.saving import left_out
from ..scene.scene import Scene, load_scene

__all__ = ["packed", "require_sendable", "unpacked"]


def require_sendable(scene: Scene) -> None:
    """SceneError for a scene with parts that no file can hold, or with tiles, which may be gigabytes."""
    unknown, functions = left_out(scene)
    if unknown or functions:
        raise SceneError(
            f"scene {scene.name!r}: {', '.join((*unknown, *functions))} can't be sent to other machines, since no file "
            "holds it; take it out, or render here (without a scheduler)"
        )
    for name, planet in scene.planets.items():
        terrain = planet.get(Terrain)
        for knob in ("height_map", "color_map") if terrain is not None else ():
            path = getattr(terrain, knob)
            if path and is_tiles(path):
                raise SceneError(
                    f"scene {scene.name!r}: planet {name!r}: Terrain.{knob} names a folder of tiles, {path}, which "
                    "can't be sent to other machines; expected one file, or none: render here (without a scheduler), "
                    "or copy the folder to the same place on each machine and have each make some of the frames "
                    "(--frames A:B)"
                )


def packed(scene: Scene) -> bytes:
    """The scene as Scene.share writes it. SceneError for one that can't be sent (require_sendable)."""
    require_sendable(scene)
    with tempfile.TemporaryDirectory() as folder:
        return scene.share(Path(folder) / f"scene{SUFFIX}").read_bytes()


def unpacked(content: bytes) -> Scene:
    """The scene again."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"scene{SUFFIX}"
        file.write_bytes(content)
        return load_scene(file)
