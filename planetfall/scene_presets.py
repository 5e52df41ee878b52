"""The user's own scenes: saved from the panels, loaded into a scene that is being drawn."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import Any

import platformdirs

from ._kinds import KINDS
from ._scene_file import Description, describe, planets, scenes
from .components import Composite, Exposure, Planet, Sun
from .errors import PresetError
from .scene import Scene

__all__ = ["left_out", "load_parts", "preset_folder", "preset_names", "save_preset"]

_FORBIDDEN = set('/\\:*?"<>|')


def preset_folder() -> Path:
    """Where they are: PLANETFALL_PRESETS if set, else the user's configuration folder."""
    chosen = os.environ.get("PLANETFALL_PRESETS")
    return Path(chosen) if chosen else platformdirs.user_config_path("planetfall") / "scenes"


def preset_names() -> list[str]:
    """Names of the user's own, without the ending."""
    try:
        return sorted(path.stem for path in preset_folder().glob("*.toml"))
    except OSError:
        return []


def save_preset(scene: Scene, name: str) -> Path:
    """Write the scene under a name; where one of that name was, it is kept beside as NAME.toml.old.

    Written beside and renamed, so that it is whole at any time. PresetError for a name that makes no file, a name of a
    built-in planet, or a folder that takes none; SceneError when its parts don't fit together.
    """
    name = name.strip()
    if not name or set(name) & _FORBIDDEN or name.startswith("."):
        raise PresetError(f"{name!r} is no name for a preset; use letters, digits, spaces, - and _")
    if name in planets():
        raise PresetError(f"{name!r} is a built-in planet; choose another name")
    folder = preset_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PresetError(f"{folder} can't be made: {error.strerror or error}") from error
    path = folder / f"{name}.toml"
    if path.exists():
        beside = folder / f".{name}.toml.old.tmp"
        try:
            shutil.copy2(path, beside)
            os.replace(beside, folder / f"{name}.toml.old")
        except OSError as error:
            raise PresetError(f"{path} is there and can't be kept as {path.name}.old: {error}") from error
    scene.save(path)
    return path


def load_parts(name: str) -> dict[str, Any]:
    """{heading: component} of a user's preset, a built-in planet or scene, or a path. Nothing of any scene changes.

    Companions and objects in it are no parts: `left_out` names them. Raises PresetError or UnknownNameError, naming
    file, key, expected and found.
    """
    found = _described(name).components
    needed = {"planet": Planet(), "sun": Sun(), "exposure": Exposure(), "composite": Composite()}
    return {kind.__name__: {**needed, **found}[table] for table, kind in KINDS.items() if table in {**needed, **found}}


def left_out(name: str) -> list[str]:
    """What `load_parts` of the same name has no parts for: "companion moon", "3 objects". Raises as that does."""
    found = _described(name)
    said = [f"companion {told.name}" for told, _ in found.companions]
    if found.props:
        said.append("1 object" if len(found.props) == 1 else f"{len(found.props)} objects")
    return said


def _described(name: str) -> Description:
    if name in (*planets(), *scenes()):
        return describe(name)
    return describe(preset_folder() / f"{name}.toml" if name in preset_names() else Path(name))
