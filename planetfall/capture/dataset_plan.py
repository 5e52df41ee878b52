"""What a data set is made of: a TOML file of numbers and of distributions that each frame draws from."""

from __future__ import annotations

import hashlib
import json
import operator
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from os import PathLike
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from ..camera.camera import Camera
from ..camera.flights import told_of
from ..camera.intrinsics import Intrinsics
from ..components import Sun
from ..engine.settings import PresetError, did_you_mean, read_toml
from ..errors import SettingError
from ..render.outputs import OUTPUTS
from ..scene.saving import scene_tables
from ..scene.scene import Scene, load_scene
from ..systems.flight import PATHS_FILE, Path, find_path
from .dataset_knobs import Bounds, check_distribution, drawn_knob, drawn_value, split_overrides

__all__ = ["DatasetPlan", "Drawn", "checked_frames", "parse_range", "read_plan"]

FORMATS = ("png", "npz", "exr")
_KEYS: Mapping[str, type | tuple[type, ...]] = {
    "seed": int, "count": int, "size": list, "quality": str, "scene": (str, list), "outputs": list, "format": str,
    "overrides": dict, "camera": dict, "sun": dict, "time_s": (int, float, dict), "intrinsics": str,
    "path": str, "paths": str,
}  # fmt: skip
_CAMERA = {"latitude_deg": {"area": [-70.0, 70.0]}, "longitude_deg": {"uniform": [-180.0, 180.0]}, "altitude_m": 500.0,
           "heading_deg": {"uniform": [0.0, 360.0]}, "pitch_deg": -20.0, "fov_y_deg": 60.0}  # fmt: skip
_LENS = "fov_y_deg"
"""Of a camera without intrinsics"""
_SUN = {"elevation_deg": 40.0, "azimuth_deg": {"uniform": [0.0, 360.0]}}
_BOUNDS = {"camera.latitude_deg": Bounds(-90.0, 90.0), "camera.altitude_m": Bounds(0.0, 1e10),
           "camera.pitch_deg": Bounds(-90.0, 90.0), "camera.fov_y_deg": Bounds(0.001, 179.0),
           "sun.elevation_deg": Bounds(-90.0, 90.0)}  # fmt: skip
_OUTPUTS = ("color", "depth", "normal", "material")


@dataclass(frozen=True)
class Drawn:
    """One frame. With a flight, what it brings is None: its camera, and its sun and time unless the plan has others."""

    number: int
    scene: str
    camera: Camera | None
    sun: Sun | None
    time_s: float | None
    values: Mapping[str, Any]
    """What was drawn, by key"""
    knobs: Mapping[str, Any]
    """Those of `values` that are knobs of components"""


@dataclass(frozen=True)
class DatasetPlan:
    """A plan that was read and checked. `frame(n)` is the same whichever others were asked for before."""

    path: FilePath
    seed: int
    count: int
    size: tuple[int, int]
    quality: str
    scenes: tuple[str, ...]
    outputs: tuple[str, ...]
    format: str
    overrides: Mapping[str, Any]
    varied: Mapping[str, Any]
    """Distributions of knobs of components, by key"""
    flight: Path | None
    values: Mapping[str, Any]
    """Numbers and distributions of all else, by key"""
    intrinsics: Intrinsics | None
    told: Mapping[str, Any] = field(default_factory=dict)
    """All that decides what is drawn, as plain data"""
    content: str = ""
    """Checksum of `told`"""

    def frame(self, number: int) -> Drawn:
        """What frame number (0 .. count - 1) shows."""

        random = partial(self._random, number)
        drawn = {
            key: drawn_value(value, _bounds(key), random(key)) if isinstance(value, Mapping) else float(value)
            for key, value in self.values.items()
        }
        knobs = {key: drawn_knob(key, value, random(key)) for key, value in self.varied.items()}
        camera, latitude, longitude = None, 0.0, 0.0
        if self.flight is None:
            at: dict[str, Any] = {key.partition(".")[2]: v for key, v in drawn.items() if key.startswith("camera.")}
            latitude, longitude = at["latitude_deg"], at["longitude_deg"]
            camera = Camera.at(**at, above="ground", intrinsics=self.intrinsics)
        sun = None
        if "sun.elevation_deg" in drawn:
            sun = Sun(elevation_deg=drawn["sun.elevation_deg"], azimuth_deg=drawn["sun.azimuth_deg"] % 360.0,
                      latitude_deg=latitude, longitude_deg=longitude % 360.0)  # fmt: skip
        return Drawn(number, self.scene_of(number), camera, sun, drawn.get("time_s"), {**drawn, **knobs}, knobs)

    def scene_of(self, number: int) -> str:
        """Which of `scenes` frame number shows."""
        whole = len(self.scenes)
        return self.scenes[0 if whole == 1 else int(self._random(number, "scene").integers(whole))]

    def _random(self, number: int, key: str) -> np.random.Generator:
        # One of its own for each key: another key in the plan leaves the others' numbers as they are.
        return np.random.default_rng([self.seed, number, zlib.crc32(key.encode())])

    def scene(self, name: str) -> Scene:
        """One of `scenes`, which are files beside the plan or presets."""
        beside = self.path.parent / name
        return load_scene(beside if beside.is_file() else name)


def read_plan(path: str | PathLike[str]) -> DatasetPlan:
    """Read and check a plan. PresetError, naming file, key, expected and found."""
    path = FilePath(path)
    data = read_toml(path)
    for key, value in data.items():
        if key not in _KEYS:
            raise PresetError(f"{path}: {key}: no such key; {did_you_mean(key, _KEYS, 'keys')}")
        if not isinstance(value, _KEYS[key]) or isinstance(value, bool):
            raise PresetError(f"{path}: {key}: found {value!r}; see docs/data-sets.md for what it takes")
    flight, values = _flight(path, data), _values(path, data)
    scenes, size = data.get("scene", "earth"), data.get("size", [320, 180])
    scenes = [scenes] if isinstance(scenes, str) else scenes
    if not scenes or not all(isinstance(name, str) for name in scenes):
        raise PresetError(f"{path}: scene: expected names or files of scenes, found {scenes!r}")
    if len(size) != 2 or not all(type(n) is int and 0 < n <= 16384 for n in size):
        raise PresetError(f"{path}: size: expected [width, height] in pixels, from 1 to 16384, found {size!r}")
    count, format = data.get("count", 100), data.get("format", "png")
    if count < 1:
        raise PresetError(f"{path}: count: expected at least 1 frame, found {count}")
    if data.get("seed", 0) < 0:
        raise PresetError(f"{path}: seed: expected a whole number from 0 on, found {data['seed']}")
    if format not in FORMATS:
        raise PresetError(f"{path}: format: {format!r}; {did_you_mean(format, FORMATS, 'formats')}")
    outputs = _outputs(path, data.get("outputs", _OUTPUTS), format)
    quality = data.get("quality", "medium")
    fixed, varied = split_overrides(str(path), quality, data.get("overrides", {}))
    lens = data.get("intrinsics")
    intrinsics = None if lens is None else Intrinsics.load(path.parent / lens)
    if intrinsics is not None:
        if "size" in data and tuple(size) != intrinsics.size:
            raise PresetError(f"{path}: size: the lens {lens} is for {list(intrinsics.size)} pixels, found {size!r}")
        size = intrinsics.size
    plan = DatasetPlan(
        path, data.get("seed", 0), count, (size[0], size[1]), quality, tuple(scenes), outputs, format, fixed, varied,
        flight, values, intrinsics,
    )  # fmt: skip
    told = {**data, "values": values, "lens": None if intrinsics is None else asdict(intrinsics),
            "flight": None if flight is None else told_of(flight)}  # fmt: skip
    for name in scenes:
        try:
            with plan.scene(name) as scene:
                told[f"scene {name}"] = scene_tables(scene)
        except SettingError as error:
            raise PresetError(f"{path}: scene: {error}") from error
    text = json.dumps(told, sort_keys=True, default=str)
    return replace(plan, told=json.loads(text), content=hashlib.sha256(text.encode()).hexdigest())


def _flight(path: FilePath, data: Mapping[str, Any]) -> Path | None:
    if "path" not in data:
        if "paths" in data:
            raise PresetError(f'{path}: paths: a file of flights; name the one to take as well: path = "..."')
        return None
    if "camera" in data:
        raise PresetError(f"{path}: camera: a flight (path) brings its cameras; leave one of them out")
    file = path.parent / data["paths"] if "paths" in data else PATHS_FILE
    try:
        return find_path(data["path"], file)
    except PresetError as error:
        raise PresetError(f"{path}: path: {error}") from error


def _values(path: FilePath, data: Mapping[str, Any]) -> dict[str, Any]:
    """Numbers and distributions of camera, sun and time; of a flight only those that the plan has."""
    whole = "path" not in data
    values: dict[str, Any] = {"time_s": data.get("time_s", 0.0)} if whole or "time_s" in data else {}
    if "intrinsics" in data and _LENS in data.get("camera", {}):
        raise PresetError(f"{path}: camera.{_LENS}: the lens of intrinsics has its own; leave one of them out")
    camera = {key: default for key, default in _CAMERA.items() if key != _LENS or "intrinsics" not in data}
    for table, known in (("camera", camera), ("sun", _SUN)):
        own = data.get(table, {})
        for key in own:
            if key not in known:
                raise PresetError(f"{path}: {table}.{key}: no such key; {did_you_mean(key, known, 'keys')}")
        if whole or table in data:
            values |= {f"{table}.{key}": own.get(key, default) for key, default in known.items()}
    for key, value in values.items():
        check_distribution(f"{path}: {key}", value, _bounds(key))
    return values


def _bounds(key: str) -> Bounds:
    return _BOUNDS.get(key) or Bounds()


def _outputs(path: FilePath, outputs: Any, format: str) -> tuple[str, ...]:
    known = [name for name in OUTPUTS if name != "flow"]
    if not outputs:
        raise PresetError(f"{path}: outputs: expected at least one of {', '.join(known)}, found none")
    for name in outputs:
        if name == "flow":
            raise PresetError(
                f"{path}: outputs: flow leads to the frame before, and here frames stand for themselves; leave it out"
            )
        if name not in known:
            raise PresetError(f"{path}: outputs: no output {name!r}; {did_you_mean(name, known, 'outputs')}")
    if format == "exr" and "instance" in outputs:
        raise PresetError(f"{path}: outputs: instance: an EXR's floats can't hold its numbers; use format = \"npz\"")
    return tuple(outputs)


def checked_frames(frames: Sequence[int] | None, count: int) -> Sequence[int]:
    """Numbers of frames, each once; all of `count` for None. SettingError for those that are none of them."""
    _check_count(count)
    if frames is None:
        return range(count)
    try:
        wanted = list(dict.fromkeys(operator.index(n) for n in frames))
    except TypeError:
        raise SettingError(f"frames: expected whole numbers such as range(0, {count}), found {frames!r}") from None
    wrong = [n for n in wanted if not 0 <= n < count]
    if wrong:
        raise SettingError(f"frames: expected numbers from 0 to {count - 1}, found {wrong[0]}")
    return wanted


def parse_range(text: str, count: int) -> range:
    """ "A:B", as Python slices have it, of count frames. SettingError for anything else."""
    _check_count(count)
    first, colon, last = text.partition(":")
    try:
        found = range(count)[slice(int(first) if first else None, int(last) if last else None)] if colon else None
    except ValueError:
        found = None
    if not found:
        raise SettingError(f"frames: expected A:B of 0:{count}, such as 0:{max(count // 2, 1)}, found {text!r}")
    return found


def _check_count(count: Any) -> None:
    if not hasattr(count, "__index__") or count < 1:
        raise SettingError(f"count: expected a whole number of frames, at least 1, found {count!r}")
