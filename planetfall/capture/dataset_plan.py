"""What a data set is made of: a TOML file of numbers and of distributions that each frame draws from."""

from __future__ import annotations

import hashlib
import json
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from ..camera.camera import Camera
from ..camera.intrinsics import Intrinsics
from ..components import Sun
from ..engine.settings import PresetError, did_you_mean, read_toml
from ..errors import SettingError
from ..scene.scene import Scene, load_scene

__all__ = ["DatasetPlan", "Drawn", "parse_range", "read_plan"]

FORMATS = ("png", "npz", "exr")
_KEYS: Mapping[str, type | tuple[type, ...]] = {
    "seed": int, "count": int, "size": list, "quality": str, "scene": (str, list), "outputs": list, "format": str,
    "overrides": dict, "camera": dict, "sun": dict, "time_s": (int, float, dict), "intrinsics": str,
}  # fmt: skip
_CAMERA = {"latitude_deg": {"area": [-70.0, 70.0]}, "longitude_deg": {"uniform": [-180.0, 180.0]}, "altitude_m": 500.0,
           "heading_deg": {"uniform": [0.0, 360.0]}, "pitch_deg": -20.0, "fov_y_deg": 60.0}  # fmt: skip
_SUN = {"elevation_deg": 40.0, "azimuth_deg": {"uniform": [0.0, 360.0]}}
_OUTPUTS = ("color", "depth", "normal", "material")


def _log_uniform(random: np.random.Generator, a: float, b: float) -> float:
    return float(np.exp(random.uniform(np.log(a), np.log(b))))


def _by_area(random: np.random.Generator, a: float, b: float) -> float:
    """Latitudes of places that are spread evenly over the sphere."""
    low, high = np.sin(np.radians([a, b]))
    return float(np.degrees(np.arcsin(random.uniform(low, high))))


_DRAW: Mapping[str, Callable[[np.random.Generator, float, float], float]] = {
    "uniform": lambda random, a, b: float(random.uniform(a, b)),
    "log": _log_uniform,
    "normal": lambda random, a, b: float(random.normal(a, b)),
    "area": _by_area,
}


@dataclass(frozen=True)
class Drawn:
    """One frame."""

    scene: str
    camera: Camera
    sun: Sun
    time_s: float
    values: Mapping[str, float]
    """What was drawn, by key"""


@dataclass(frozen=True)
class DatasetPlan:
    """A plan that was read and checked. `frame(n)` is the same whichever others were asked for before."""

    path: Path
    seed: int
    count: int
    size: tuple[int, int]
    quality: str
    scenes: tuple[str, ...]
    outputs: tuple[str, ...]
    format: str
    overrides: Mapping[str, Any]
    values: Mapping[str, Any]
    """Numbers and distributions, by key"""
    intrinsics: Intrinsics | None
    content: str
    """Checksum of all that decides what is drawn"""

    def frame(self, number: int) -> Drawn:
        """What frame number (0 .. count - 1) shows."""

        def random(key: str) -> np.random.Generator:
            # One of its own for each key: another key in the plan leaves the others' numbers as they are.
            return np.random.default_rng([self.seed, number, zlib.crc32(key.encode())])

        drawn = {key: _value(value, random(key)) for key, value in self.values.items()}
        at = {key.partition(".")[2]: v for key, v in drawn.items() if key.startswith("camera.")}
        if not -90.0 <= at["latitude_deg"] <= 90.0 or not -90.0 <= at["pitch_deg"] <= 90.0:
            at |= {key: float(np.clip(at[key], -90.0, 90.0)) for key in ("latitude_deg", "pitch_deg")}
        camera = Camera.at(
            at["latitude_deg"], at["longitude_deg"], at["altitude_m"], at["heading_deg"], at["pitch_deg"],
            at["fov_y_deg"], "ground", intrinsics=self.intrinsics,
        )  # fmt: skip
        sun = Sun(elevation_deg=float(np.clip(drawn["sun.elevation_deg"], -90.0, 90.0)),
                  azimuth_deg=drawn["sun.azimuth_deg"] % 360.0,
                  latitude_deg=at["latitude_deg"], longitude_deg=at["longitude_deg"])  # fmt: skip
        scene = self.scenes[int(random("scene").integers(len(self.scenes)))]
        return Drawn(scene, camera, sun, drawn["time_s"], drawn)

    def scene(self, name: str) -> Scene:
        """One of `scenes`, which are files beside the plan or presets."""
        beside = self.path.parent / name
        return load_scene(beside if beside.is_file() else name)


def read_plan(path: str | PathLike[str]) -> DatasetPlan:
    """Read and check a plan. PresetError, naming file, key, expected and found."""
    path = Path(path)
    data = read_toml(path)
    for key, value in data.items():
        if key not in _KEYS:
            raise PresetError(f"{path}: {key}: no such key; {did_you_mean(key, _KEYS, 'keys')}")
        if not isinstance(value, _KEYS[key]) or isinstance(value, bool):
            raise PresetError(f"{path}: {key}: found {value!r}; see docs/data-sets.md for what it takes")
    values: dict[str, Any] = {"time_s": data.get("time_s", 0.0)}
    for table, known in (("camera", _CAMERA), ("sun", _SUN)):
        own = data.get(table, {})
        for key in own:
            if key not in known:
                raise PresetError(f"{path}: {table}.{key}: no such key; {did_you_mean(key, known, 'keys')}")
        values |= {f"{table}.{key}": own.get(key, default) for key, default in known.items()}
    for key, value in values.items():
        _check(f"{path}: {key}", value)
    scenes, size = data.get("scene", "earth"), data.get("size", [320, 180])
    scenes = [scenes] if isinstance(scenes, str) else scenes
    if not scenes or not all(isinstance(name, str) for name in scenes):
        raise PresetError(f"{path}: scene: expected names or files of scenes, found {scenes!r}")
    if len(size) != 2 or not all(isinstance(n, int) and 0 < n <= 16384 for n in size):
        raise PresetError(f"{path}: size: expected [width, height] in pixels, found {size!r}")
    count, format = data.get("count", 100), data.get("format", "png")
    if count < 1:
        raise PresetError(f"{path}: count: expected at least 1 frame, found {count}")
    if data.get("seed", 0) < 0:
        raise PresetError(f"{path}: seed: expected a whole number from 0 on, found {data['seed']}")
    if format not in FORMATS:
        raise PresetError(f"{path}: format: {format!r}; {did_you_mean(format, FORMATS, 'formats')}")
    outputs = tuple(data.get("outputs", _OUTPUTS))
    if not outputs or "flow" in outputs:
        raise PresetError(f"{path}: outputs: frames stand for themselves; expected outputs other than flow")
    lens = data.get("intrinsics")
    intrinsics = None if lens is None else Intrinsics.load(path.parent / lens)
    told = {**data, "values": values, "lens": None if intrinsics is None else repr(intrinsics)}
    content = hashlib.sha256(json.dumps(told, sort_keys=True, default=str).encode()).hexdigest()
    return DatasetPlan(
        path, data.get("seed", 0), count, (size[0], size[1]), data.get("quality", "medium"), tuple(scenes), outputs,
        format, data.get("overrides", {}), values, intrinsics, content,
    )  # fmt: skip


def _value(value: Any, random: np.random.Generator) -> float:
    if isinstance(value, Mapping):
        ((kind, numbers),) = value.items()
        return float(random.choice(numbers)) if kind == "choice" else _DRAW[kind](random, *numbers)
    return float(value)


def _check(where: str, value: Any) -> None:
    if isinstance(value, int | float) and not isinstance(value, bool) and np.isfinite(value):
        return
    kinds = (*_DRAW, "choice")
    if not isinstance(value, Mapping) or len(value) != 1 or next(iter(value)) not in kinds:
        raise PresetError(f"{where}: expected a number, or one of {{ {' | '.join(kinds)} = [...] }}, found {value!r}")
    ((kind, numbers),) = value.items()
    fits = isinstance(numbers, list) and numbers and all(isinstance(n, int | float) and np.isfinite(n) for n in numbers)
    if not fits or (kind != "choice" and len(numbers) != 2):
        wanted = "numbers" if kind == "choice" else "two numbers"
        raise PresetError(f"{where}: {kind}: expected {wanted}, found {numbers!r}")
    if kind not in ("choice", "normal") and not numbers[0] <= numbers[1]:
        raise PresetError(f"{where}: {kind}: expected the lower number first, found {numbers!r}")
    if (kind == "log" and numbers[0] <= 0.0) or (kind == "normal" and numbers[1] < 0.0):
        raise PresetError(f"{where}: {kind}: expected numbers above 0, found {numbers!r}")


def parse_range(text: str, count: int) -> range:
    """ "A:B", as Python slices have it, of count frames. SettingError for anything else."""
    first, colon, last = text.partition(":")
    try:
        found = range(count)[slice(int(first) if first else None, int(last) if last else None)] if colon else None
    except ValueError:
        found = None
    if not found:
        raise SettingError(f"frames: expected A:B of 0:{count}, such as 0:{max(count // 2, 1)}, found {text!r}")
    return found
