"""The user's own scenes: saved from the panels, loaded into a scene that is being drawn."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import Any

import platformdirs

from ..components import Composite, Exposure, Orbit, Planet, Sun
from ..engine.settings import plain_table
from ..errors import PresetError
from .file import Description, describe, planets, scenes
from .kinds import KINDS, PLANET_KINDS
from .saving import companion_table
from .scene import Companion, Scene

__all__ = [
    "brief_companion",
    "left_out",
    "load_companions",
    "load_parts",
    "preset_folder",
    "preset_names",
    "save_preset",
]

_FORBIDDEN = set('/\\:*?"<>|')
_LONGEST = 100
"""Bytes of a name: file systems take 255, and endings are added."""
_DEVICES = {"con", "prn", "aux", "nul", *(f"{kind}{n}" for kind in ("com", "lpt") for n in range(1, 10))}
"""Names that are no files on Windows, whatever their ending."""


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
    if len(name.encode()) > _LONGEST:
        raise PresetError(f"{name[:20]!r}... is too long for a preset's name; expected at most {_LONGEST} bytes")
    if name.split(".")[0].strip().lower() in _DEVICES:
        raise PresetError(f"{name!r} is the name of a device on Windows; choose another name")
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

    Its companions are told by `load_companions`; objects in it are no parts: `left_out` names them. Raises PresetError
    or UnknownNameError, naming file, key, expected and found.
    """
    found = _described(name).components
    needed = {"planet": Planet(), "sun": Sun(), "exposure": Exposure(), "composite": Composite()}
    return {kind.__name__: {**needed, **found}[table] for table, kind in KINDS.items() if table in {**needed, **found}}


def load_companions(name: str) -> list[tuple[Description, Orbit]]:
    """Companions of what `load_parts` loads, for `scene_of`, and their orbits. Raises as that does."""
    return list(_described(name).companions)


def left_out(name: str) -> list[str]:
    """What of a preset is no part of a scene that is being drawn: "3 objects". Raises as load_parts does."""
    count = len(_described(name).props)
    return [] if not count else ["1 object" if count == 1 else f"{count} objects"]


def brief_companion(companion: Companion) -> dict[str, Any]:
    """A companion as a table of a scene file: what differs from its planet's preset; whole where it has none, or where
    something of the preset was taken away, which no table can say."""
    whole, preset = companion_table(companion), companion.scene.preset
    if preset not in planets():
        return whole
    below = {key: plain_table(part) for key, part in describe(preset).components.items() if key in PLANET_KINDS}
    if any(not set(table) <= set(whole.get(key, ())) for key, table in below.items()):
        return whole
    plain = plain_table(Orbit())
    if not set(plain) <= set(whole["orbit"]):
        return whole
    below["orbit"] = plain
    found: dict[str, Any] = {"name": companion.name, "base": preset}
    for key in ("orbit", *PLANET_KINDS):
        if key not in whole:
            continue
        table = {k: v for k, v in whole[key].items() if k not in below.get(key, {}) or below[key][k] != v}
        if table or key not in below:
            found[key] = table
    return found


def _described(name: str) -> Description:
    if name in (*planets(), *scenes()):
        return describe(name)
    return describe(preset_folder() / f"{name}.toml" if name in preset_names() else Path(name))
