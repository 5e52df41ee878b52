"""A scene with its maps in one file, which opens on another machine: a zip of scene.toml and files/."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import tempfile
import zipfile
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import Any

import platformdirs

from ..engine.settings import PresetError, read_toml, rules_of, write_toml
from ..engine.user_paths import place_of
from .kinds import KINDS, SUFFIX

__all__ = ["count_from", "opened", "pack"]

_SCENE, _FILES = "scene.toml", "files"
_EPOCH = (1980, 1, 1, 0, 0, 0)
"""Of what is in it, so that the same scene makes the same file."""
_NUMBER = re.compile(r"^\d+-")
_HASHED = 16
"""Digits of the content's checksum in the name of the folder that it is unpacked into."""
_TILED = {"height_map": "elevation", "color_map": "pictures"}


def pack(saved: Path, out: Path) -> Path:
    """Write a saved scene file, and the files that its knobs name, into one. Written beside, then renamed.

    PresetError for another ending than .planetfall, a file that is missing, or a folder that takes none.
    """
    if out.suffix != SUFFIX:
        raise PresetError(f"{out}: expected a name that ends in {SUFFIX}; load_scene knows shared scenes by it")
    if not out.parent.is_dir():
        raise PresetError(f"{out}: the folder {out.parent.absolute()} doesn't exist; make it first")
    data = read_toml(saved)
    inside: dict[Path, str] = {}
    for table, knob in _files_named(data):
        source = saved.parent / table[knob]
        if knob in _TILED and (source.is_dir() or source.suffix.lower() == ".toml"):
            raise PresetError(
                f"{out}: {knob} names tiles of {_TILED[knob]}, {source}, which are no part of a shared scene; give the "
                "folder along, and let the scene name one file or none"
            )
        if not source.is_file():
            raise PresetError(f"{out}: {knob}: no such file: {source}; a shared scene holds the files that it names")
        # Those of a scene that was shared before have a number already.
        plain = _NUMBER.sub("", source.name) if source.parent.name == _FILES else source.name
        name = inside.setdefault(source.resolve(), f"{_FILES}/{len(inside)}-{plain}")
        table[knob] = name
    handle, beside = tempfile.mkstemp(prefix=f".{out.name}.", suffix=".tmp", dir=out.parent)
    os.close(handle)
    try:
        with tempfile.TemporaryDirectory() as folder, zipfile.ZipFile(beside, "w", zipfile.ZIP_DEFLATED) as archive:
            text = Path(folder) / _SCENE
            write_toml(text, data)
            for source, name in ((text, _SCENE), *inside.items()):
                info = zipfile.ZipInfo(name, _EPOCH)
                info.compress_type = zipfile.ZIP_DEFLATED
                with source.open("rb") as read, archive.open(info, "w", force_zip64=True) as write:
                    shutil.copyfileobj(read, write)
        os.replace(beside, out)
    except OSError as error:
        raise PresetError(f"{out}: can't be written: {error.strerror or error}") from error
    finally:
        Path(beside).unlink(missing_ok=True)
    return out


def opened(path: Path) -> Path:
    """The scene file of a shared scene, unpacked into the user's cache unless it is there already.

    PresetError, naming the file, when it is missing, no such zip, damaged, or would write outside its folder.
    """
    try:
        with path.open("rb") as file:
            content = hashlib.file_digest(file, "sha256").hexdigest()[:_HASHED]
    except FileNotFoundError:
        raise PresetError(f"{path}: no such file (looked from {Path.cwd()}); check its name and folder") from None
    except OSError as error:
        raise PresetError(f"{path}: can't be read: {error.strerror or error}; check its rights") from error
    folder = _cache() / content
    if not (folder / _SCENE).is_file():
        _unpack(path, folder)
    return folder / _SCENE


def _cache() -> Path:
    chosen = os.environ.get("PLANETFALL_CACHE")
    return (Path(chosen) if chosen else platformdirs.user_cache_path("planetfall")) / "shared"


def _unpack(path: Path, folder: Path) -> None:
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with zipfile.ZipFile(path) as archive, tempfile.TemporaryDirectory(dir=folder.parent) as beside:
            names = archive.namelist()
            strange = [name for name in names if not _belongs(name)]
            if strange or _SCENE not in names:
                what = f"holds {strange[0]!r}" if strange else f"has no {_SCENE}"
                raise PresetError(f"{path}: no shared scene: it {what}; make one with planetfall share")
            whole = Path(beside) / "whole"
            archive.extractall(whole)
            try:
                whole.rename(folder)
            except OSError:
                if not (folder / _SCENE).is_file():  # else another process was first
                    raise
    except zipfile.BadZipFile as error:
        raise PresetError(f"{path}: no shared scene, or damaged: {error}; copy it again") from None
    except OSError as error:
        raise PresetError(f"{path}: can't be unpacked into {folder.parent}: {error.strerror or error}") from error


def _belongs(name: str) -> bool:
    parts = PurePosixPath(name).parts
    return name == _SCENE or (len(parts) == 2 and parts[0] == _FILES and ".." not in parts and "\\" not in name)


def count_from(data: dict[str, Any], folder: Path) -> None:
    """Paths of maps and meshes in a scene file's content, counted from here so far, as its folder counts them: from
    there if they are in it, so that both can be moved, and in full if not."""
    for table, knob in _files_named(data):
        at = Path(os.path.normpath(place_of(table[knob]).absolute()))
        inside = at.is_relative_to(folder.absolute())
        table[knob] = (at.relative_to(folder.absolute()) if inside else at).as_posix()


def _files_named(data: dict[str, Any]) -> Iterator[tuple[dict[str, Any], str]]:
    """(table, knob) of each knob in a scene file's content that names a file."""
    from ..systems.props import is_file

    for table in (data, *data.get("companions", ())):
        for key, value in table.items():
            kind = KINDS.get(key)
            if kind is not None and isinstance(value, dict):
                rules = rules_of(kind)
                yield from ((value, k) for k in value if value[k] and k in rules and rules[k].knob.widget == "path")
        for prop in table.get("props", ()):
            if is_file(prop.get("shape", {}).get("form", "sphere")):
                yield prop["shape"], "form"
