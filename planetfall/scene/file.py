"""Scene files: TOML with a table per component, on top of a base if it names one."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..components import Orbit
from ..engine.settings import PresetError, build_components, did_you_mean, read_toml, rules_of
from ..engine.user_paths import place_of
from ..errors import UnknownNameError
from .kinds import KINDS, PLANET_KINDS, PRESETS, PROP_KINDS, SUFFIX

__all__ = ["FORMAT", "Description", "describe", "described_companions", "planets", "scenes"]

# Top-level keys beside the tables: how it is called, what it is, the preset or file it changes, and the preset whose
# named views apply to it.
_KEYS = ("name", "about", "base", "like")
_FORMAT = "format"
FORMAT = 1
"""Of the files that are written; files without are of format 0."""
_COMPANIONS = "companions"  # [[companions]]: further planets; a file's own replace its base's
_PROPS = "props"  # [[props]]: objects, each with a name and tables of its components; a file's own replace its base's
_ALSO = (*_KEYS, _FORMAT, _PROPS, _COMPANIONS)


def planets() -> list[str]:
    """Names of the planet presets, for load_scene."""
    return sorted(path.stem for path in (PRESETS / "planets").glob("*.toml"))


def scenes() -> list[str]:
    """Names of the presets of several planets, for load_scene."""
    return sorted(path.stem for path in (PRESETS / "scenes").glob("*.toml"))


@dataclass(frozen=True)
class Description:
    """What a scene file says. components: by table. preset: the planet preset whose named views apply, if any.

    props: (name, components) of the objects in it. companions: (description, orbit) of further planets.
    """

    path: Path
    name: str
    about: str
    preset: str | None
    components: Mapping[str, Any]
    props: Sequence[tuple[str, Sequence[Any]]] = ()
    companions: Sequence[tuple[Description, Orbit]] = ()


def describe(source: str | os.PathLike[str]) -> Description:
    """Read and check a scene file without making a scene; see load_scene."""
    return _described(_path_of(source), ())


def _described(path: Path, inside: tuple[Path, ...]) -> Description:
    if path in inside:
        raise PresetError(f"{path}: {_COMPANIONS}: it would be a companion of itself")
    data = _merged(path, ())
    components = build_components(data, KINDS, path, also=_ALSO)
    preset = data.get("like", path.stem if path.parent == PRESETS / "planets" else None)
    name, about = data.get("name", path.stem), data.get("about", "")
    companions = described_companions(data.get(_COMPANIONS, []), path, (*inside, path))
    return Description(path, name, about, preset, components, _props(data, path), companions)


def described_companions(entries: Any, path: Path, inside: tuple[Path, ...] = ()) -> list[tuple[Description, Orbit]]:
    """Further planets from a file's [[companions]]: each has a name, a `base` (a preset or file) with tables laid over
    it, or tables alone, and its [companions.orbit]. PresetError, naming file, entry, expected and found."""
    if not isinstance(entries, list) or not all(isinstance(entry, Mapping) for entry in entries):
        raise PresetError(
            f"{path}: {_COMPANIONS}: expected tables, found {entries!r}. Write [[{_COMPANIONS}]] for each planet"
        )
    return [_companion(entry, path, f"{path}: {_COMPANIONS}[{n}]", inside) for n, entry in enumerate(entries)]


def _companion(entry: Mapping[str, Any], path: Path, where: str, inside: tuple[Path, ...]) -> tuple[Description, Orbit]:
    keys = ("name", "base", "like")
    for key in keys:
        if not isinstance(entry.get(key, ""), str):
            raise PresetError(f"{where}: {key}: expected a text, found {entry[key]!r}. Put it in quotes")
    own = {key: value for key, value in entry.items() if key not in (*keys, "orbit", _PROPS)}
    build_components(own, PLANET_KINDS, where, also=(*keys, "orbit", _PROPS))
    base, preset = entry.get("base"), entry.get("like")
    below: dict[str, Any] = {}
    props = _props(_with_places(dict(entry), path.parent), where)
    if base is not None:
        at = _source_beside(base, path, where)
        described = _described(at, inside)
        if described.companions:
            raise PresetError(f"{where}: base: {base!r} has companions itself; name a single planet")
        below, preset = _merged(at, ()), preset or described.preset
        props = props if _PROPS in entry else described.props
    elif not own:
        raise PresetError(f"{where}: base: missing; name a preset ({', '.join(planets())}) or a TOML file")
    elif "name" not in entry:
        raise PresetError(f"{where}: name: missing; every planet of a scene has one")
    laid = _laid_over(below, _with_places(own, path.parent))
    components = build_components({k: v for k, v in laid.items() if k in PLANET_KINDS}, PLANET_KINDS, where)
    orbit = build_components({"orbit": entry.get("orbit", {})}, {"orbit": Orbit}, where)["orbit"]
    return Description(path, entry.get("name") or Path(str(base)).stem, "", preset, components, props), orbit


def _source_beside(source: str, path: Path, where: str) -> Path:
    """A preset's file, or one beside the file that names it."""
    try:
        if source in (*planets(), *scenes()):
            return _preset_path(source)
        beside = path.parent / source
        return beside if beside.exists() else _preset_path(source)
    except UnknownNameError as error:
        raise PresetError(f"{where}: base: {error}") from None


def _props(data: Mapping[str, Any], path: Path | str) -> list[tuple[str, Sequence[Any]]]:
    entries = data.get(_PROPS, [])
    if not isinstance(entries, list) or not all(isinstance(entry, Mapping) for entry in entries):
        raise PresetError(f"{path}: {_PROPS}: expected tables, found {entries!r}. Write [[{_PROPS}]] for each object")
    made: list[tuple[str, Sequence[Any]]] = []
    for number, entry in enumerate(entries):
        where = f"{path}: {_PROPS}[{number}]"
        name = entry.get("name", "")
        if not isinstance(name, str):
            raise PresetError(f"{where}: name: expected a text, found {name!r}. Put it in quotes")
        made.append((name, tuple(build_components(entry, PROP_KINDS, where, also=("name",)).values())))
    return made


def _path_of(source: str | os.PathLike[str]) -> Path:
    if isinstance(source, str):
        text = source.strip()
        if text and not text.endswith((".toml", SUFFIX)) and not set(text) & {"/", os.sep}:
            return _preset_path(text)
    elif not isinstance(source, os.PathLike):
        raise UnknownNameError(f"load_scene: expected the name of a planet or a path, found {source!r}")
    if not os.fspath(source):
        raise UnknownNameError(f"load_scene: the name is empty; planets: {', '.join(planets())}")
    path = Path(source)
    if path.suffix != SUFFIX:
        return path
    from .shared import opened  # with zip files, of which an import of planetfall would be a tenth longer

    return opened(path)


def _preset_path(name: str) -> Path:
    known = planets()
    if name in known:
        return PRESETS / "planets" / f"{name}.toml"
    if name in scenes():
        return PRESETS / "scenes" / f"{name}.toml"
    hint = did_you_mean(name, [*known, *scenes()], "planets")
    raise UnknownNameError(f"no planet {name!r}; {hint}. A path to a TOML file works as well")


def _with_places(data: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The file's tables with the paths in them counted from its own folder."""
    names = {cls.__name__: table for table, cls in KINDS.items()}
    found = dict(data)
    for key, value in data.items():
        kind = KINDS.get(names.get(key, key))
        if kind is None or not isinstance(value, Mapping):
            continue
        rules = rules_of(kind)
        places = {k: os.path.normpath(folder.absolute() / place_of(v)) for k, v in value.items()
                  if v and k in rules and rules[k].knob.widget == "path"}  # fmt: skip
        found[key] = {**value, **places}
    props = data.get(_PROPS)
    if isinstance(props, list):
        found[_PROPS] = [_prop_with_place(prop, folder) for prop in props]
    return found


def _prop_with_place(prop: Any, folder: Path) -> Any:
    """The object with its mesh file counted from this folder, if it is there."""
    shape = prop.get("shape") if isinstance(prop, Mapping) else None
    if not isinstance(shape, Mapping):
        return prop
    form = shape.get("form")
    if not isinstance(form, str) or not os.path.isfile(beside := folder.absolute() / place_of(form)):
        return prop
    return {**prop, "shape": {**shape, "form": os.path.normpath(beside)}}


def _of_this_format(data: dict[str, Any], path: Path) -> dict[str, Any]:
    """A file's content as this version says it. PresetError for a file of a newer one."""
    found = data.pop(_FORMAT, 0)
    if not isinstance(found, int) or isinstance(found, bool) or found < 0:
        raise PresetError(f"{path}: {_FORMAT}: expected a whole number, found {found!r}")
    if found > FORMAT:
        raise PresetError(
            f"{path}: {_FORMAT}: {found}, of a newer version; this one reads files up to {FORMAT}. Update planetfall"
        )
    for change in _CHANGES[found:]:
        change(data)
    return data


def _kinds_of_clouds(data: dict[str, Any]) -> None:
    """Format 0 called layers after what they are made of."""
    for planet in (data, *data.get(_COMPANIONS, ())):
        clouds = planet.get("clouds", planet.get("Clouds", {})) if isinstance(planet, Mapping) else {}
        layers = clouds.get("layers", ()) if isinstance(clouds, Mapping) else ()
        for layer in layers if isinstance(layers, list) else ():
            if isinstance(layer, dict) and layer.get("kind") in _FORMAT_0_KINDS:
                layer["kind"] = _FORMAT_0_KINDS[layer["kind"]]


_FORMAT_0_KINDS = {"water": "cumulus", "ice": "cirrus"}
_CHANGES = (_kinds_of_clouds,)
"""What turns a file's content from format n into n + 1."""


def _merged(path: Path, inside: tuple[Path, ...]) -> dict[str, Any]:
    """The file's tables laid over those of its base, which may have a base itself."""
    if path in inside:
        raise PresetError(f"{path}: base: goes round in a circle: {' -> '.join(p.name for p in (*inside, path))}")
    data = _of_this_format(read_toml(path), path)
    for key in _KEYS:
        if not isinstance(data.get(key, ""), str):
            raise PresetError(f"{path}: {key}: expected a text, found {data[key]!r}. Put it in quotes")
    build_components(data, KINDS, path, also=_ALSO)  # complains with this file's name
    data = _with_places(data, path.parent)
    base = data.get("base")
    if base is None:
        return data
    try:
        base_path = _preset_path(base) if base in (*planets(), *scenes()) else path.parent / base
        if not base_path.exists():
            _preset_path(base)
    except UnknownNameError as error:
        raise PresetError(f"{path}: base: {error}") from None
    below = _merged(base_path, (*inside, path))
    merged: dict[str, Any] = {k: v for k, v in below.items() if k not in ("name", "base")}
    if base_path.parent == PRESETS / "planets":
        merged.setdefault("like", base_path.stem)
    return _laid_over(merged, {key: value for key, value in data.items() if key != "base"})


def _laid_over(below: Mapping[str, Any], data: Mapping[str, Any]) -> dict[str, Any]:
    """Tables over those of a base: knob by knob; what a knob excludes goes."""
    merged = dict(below)
    names = {cls.__name__: table for table, cls in KINDS.items()}
    for key, value in data.items():
        table = names.get(key, key)
        if table in KINDS:
            rules = rules_of(KINDS[table])
            gone = {other for k in value for other in rules[k].knob.excludes}
            under = merged.pop(table, merged.pop(KINDS[table].__name__, {}))
            merged[table] = {k: v for k, v in under.items() if k not in gone} | value
        else:
            merged[key] = value
    return merged
