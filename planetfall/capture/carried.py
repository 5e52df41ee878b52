"""A scene as bytes that go to another machine, with its maps."""

from __future__ import annotations

import tempfile
from pathlib import Path

from ..errors import SceneError
from ..scene.file import SUFFIX
from ..scene.saving import left_out
from ..scene.scene import Scene, load_scene

__all__ = ["packed", "unpacked"]


def packed(scene: Scene) -> bytes:
    """The scene as Scene.share writes it. SceneError for one with parts that no file can hold."""
    unknown, functions = left_out(scene)
    if unknown or functions:
        raise SceneError(
            f"scene {scene.name!r}: {', '.join((*unknown, *functions))} can't be sent to other machines, since no file "
            "holds it; take it out, or render here (without a scheduler)"
        )
    with tempfile.TemporaryDirectory() as folder:
        return scene.share(Path(folder) / f"scene{SUFFIX}").read_bytes()


def unpacked(content: bytes) -> Scene:
    """The scene again."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"scene{SUFFIX}"
        file.write_bytes(content)
        return load_scene(file)
