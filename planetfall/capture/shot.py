"""Everything that a picture was made of, as plain data inside its file, and back from there."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .._version import __version__
from ..camera.camera import Camera
from ..camera.intrinsics import Intrinsics
from ..engine.settings import PresetError, build_components, plain_table
from ..engine.space import CameraState
from ..engine.wavelengths import wavelengths_of
from ..quality import resolve_quality
from ..scene.file import described_companions
from ..scene.kinds import KINDS, PROP_KINDS
from ..scene.saving import companion_table, prop_tables
from ..scene.scene import Scene, scene_of
from ..systems.capture import CaptureError
from ..systems.capture.png import json_plain
from .captures import read_settings

if TYPE_CHECKING:
    from ..components import Sun

__all__ = ["Shot", "camera_settings", "load_shot", "made_of", "scene_settings", "shot_settings"]


@dataclass(frozen=True)
class Shot:
    """What a picture's file tells: `scene` is made anew, the rest goes into Renderer and render, or `pf.photo`."""

    scene: Scene
    camera: Camera
    time_s: float
    size: tuple[int, int]
    quality: str
    overrides: Mapping[str, Any]
    supersample: int
    ev100: float | None
    mode: str


def shot_settings(
    scene: Scene,
    camera: Camera | CameraState,
    time_s: float,
    size: tuple[int, int],
    *,
    quality: str,
    overrides: Mapping[str, Any] | None = None,
    sun: Sun | None = None,
    supersample: int = 1,
    ev100: float | None = None,
    mode: str = "ship",
    over: str = "",
    intrinsics: Intrinsics | None = None,
) -> dict[str, Any]:
    """All that is needed to make a picture again. camera: a CameraState, or a Camera without a ground to stand on.

    sun: the one that shines, where it isn't the scene's. over: the companion in whose axes the camera is. ev100:
    the exposure that the picture has. intrinsics: its lens, beside a CameraState. "wavelengths_nm" says where its
    radiance is.
    """
    told = scene_settings(scene)
    if sun is not None:
        told["components"]["sun"] = plain_table(sun)
    return {
        "planetfall": __version__,
        **told,
        "over": over,
        "camera": camera_settings(camera) | ({} if intrinsics is None else {"intrinsics": asdict(intrinsics)}),
        "time_s": float(time_s),
        "size": [int(n) for n in size],
        "quality": quality,
        "overrides": dict(overrides or {}),
        "supersample": supersample,
        "exposure": ev100,
        "wavelengths_nm": list(wavelengths_of(resolve_quality(quality, overrides))),
        "mode": mode,
    }


def scene_settings(scene: Scene) -> dict[str, Any]:
    """All of a scene as plain data: components, objects and companions."""
    tables = {kind: table for table, kind in KINDS.items()}
    parts = (*scene.planet.components(), *scene.environment.components())
    return {
        "scene": scene.name,
        "like": scene.preset,
        "components": {tables[type(part)]: plain_table(part) for part in parts if type(part) in tables},
        "props": prop_tables(scene),
        "companions": [companion_table(companion) for companion in scene.companions.values()],
    }


def made_of(scene: Scene, **more: object) -> str:
    """A hash of all of the scene's values and of `more`: names stay when files are edited."""
    told = json.dumps({**scene_settings(scene), **more}, default=json_plain, sort_keys=True)
    return hashlib.sha256(told.encode()).hexdigest()


def camera_settings(camera: Camera | CameraState) -> dict[str, Any]:
    """A Camera (or a CameraState) as plain data for the files."""
    names = ("position_m", "forward", "up", "fov_y_deg", "tan_left", "tan_right", "tan_bottom", "tan_top", "near_m")
    found = {name: getattr(camera, name) for name in names if getattr(camera, name, None) is not None}
    lens = camera.intrinsics if isinstance(camera, Camera) else None
    return found if lens is None else {**found, "intrinsics": asdict(lens)}


def load_shot(path: str | PathLike[str]) -> Shot:
    """What a PNG, EXR or npz of ours was made of. CaptureError for another file; PresetError for settings that can't
    be."""
    path = Path(path)
    data = read_settings(path)
    try:
        found = data["camera"]
        if "components" not in data:
            raise KeyError("components")
        components = build_components(data["components"], KINDS, path)
        scene = Scene(str(data["scene"]), components, preset=data.get("like"))
        for number, entry in enumerate(data.get("props", [])):
            made = build_components(entry, PROP_KINDS, f"{path}: props[{number}]", also=("name",))
            scene.add(*made.values(), name=str(entry.get("name", "")))
        for told, orbit in described_companions(data.get("companions", []), path):
            scene.companions.add(scene_of(told), orbit)
        size = data["size"]
        if not (isinstance(size, list) and len(size) == 2 and all(isinstance(n, int) for n in size)):
            raise ValueError(f"size: expected [width, height] in pixels, found {size!r}")
        width, height = size
        exposure = data.get("exposure")
        return Shot(
            scene, _camera(found, data.get("over") or None), float(data["time_s"] or 0.0), (width, height),
            str(data["quality"]), dict(data.get("overrides", {})), int(data.get("supersample", 1)),
            None if exposure is None else float(exposure), str(data.get("mode", "ship")),
        )  # fmt: skip
    except KeyError as error:
        raise CaptureError(
            f"{path}: its settings lack {error}: it was written by an older version, and can't be made again from them"
        ) from error
    except (TypeError, AttributeError) as error:
        raise PresetError(f"{path}: its settings are damaged: {error}") from error
    except ValueError as error:
        raise PresetError(f"{path}: {error}") from error


def _camera(found: Mapping[str, Any], planet: str | None) -> Camera:
    place = (found["position_m"], found["forward"], found["up"])
    if "intrinsics" in found:
        return Camera(*place, planet=planet, intrinsics=Intrinsics(**found["intrinsics"]))
    if "tan_top" not in found:
        return Camera(*place, float(found["fov_y_deg"]), planet)
    left, right, bottom, top = (float(found[f"tan_{side}"]) for side in ("left", "right", "bottom", "top"))
    if left == -right and bottom == -top:
        return Camera(*place, 2.0 * math.degrees(math.atan(top)), planet)
    angles = [math.degrees(math.atan(t)) for t in (left, right, bottom, top)]
    return Camera(*place, planet=planet, frustum_deg=angles)
