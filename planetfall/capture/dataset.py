"""Data sets: many pictures of seeded cameras, suns, weathers and planets, with exact labels and poses beside them."""

from __future__ import annotations

import hashlib
import json
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, nullcontext
from functools import partial
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._version import __version__
from ..engine.processor import processor_name
from ..engine.space import CameraState, local_axes
from ..systems.capture import CaptureError, require_writable
from ..systems.capture.files import remove_unfinished, written_beside
from .captures import save_capture
from .carried import packed, require_sendable, unpacked
from .dataset_plan import DatasetPlan, Drawn, checked_frames, read_plan
from .dataset_stage import Stage, Staged
from .farm import Farm, kept, land

if TYPE_CHECKING:
    from ..render.renderer import Renderer
    from ..scene.scene import Scene

__all__ = ["dataset"]

_FRAMES, _PLAN = "frames", "plan.json"
_LINES, _MANIFEST, _TRANSFORMS = "frames.jsonl", "manifest.json", "transforms.json"
_MODELS = {"pinhole": ("OPENCV", ()), "brown": ("OPENCV", ("k1", "k2", "p1", "p2", "k3")),
           "fisheye": ("OPENCV_FISHEYE", ("k1", "k2", "k3", "k4"))}  # fmt: skip
"""Lenses that transforms.json has a name for, and those of their coefficients."""
_BEND = np.diag([1.0, -1.0, -1.0])
"""From OpenCV's axes of a camera (right, down, forward) to OpenGL's (right, up, back)."""


def dataset(
    plan: str | PathLike[str] | DatasetPlan,
    folder: str | PathLike[str],
    *,
    frames: Sequence[int] | None = None,
    scheduler: str | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Render the frames of a plan into a folder, those alone that are not there yet; returns the folder.

    plan: a TOML file, see docs/data-sets.md. frames: their numbers; all by default. A frame is the same, to the bit,
    in whatever order and on whichever worker of one kind (processor and driver, both in the manifest) it is made.
    scheduler: the address of a Dask scheduler, such as tcp://10.0.0.5:8786, whose workers make the frames; the folder
    is written here all the same. Before anything is made SettingError when it can't be reached, SceneError for scenes
    with masks or tiles, which can't be sent.
    Files: frames/000000.png and so on, frames.jsonl (a line a frame: pose, lens, exposure, what was drawn),
    transforms.json for radiance fields, manifest.json with checksums. CaptureError for a folder of another plan.
    """
    plan = plan if isinstance(plan, DatasetPlan) else read_plan(plan)
    wanted = checked_frames(frames, plan.count)
    shown = {n: plan.scene_of(n) for n in wanted}
    for name in plan.scenes:
        with plan.scene(name) as scene:
            Stage(plan, scene).check(n for n in wanted if shown[n] == name)
            if scheduler is not None:
                require_sendable(scene)
    with nullcontext() if scheduler is None else Farm(scheduler) as farm:
        root = require_writable(Path(folder), make_folder=True)
        _claim(root, plan)
        remove_unfinished(require_writable(root / _FRAMES, make_folder=True))
        missing = [n for n in wanted if not _is_whole(root, n)]
        # A scene at a time: a frame hangs on none before it.
        parts = {name: [n for n in missing if shown[n] == name] for name in plan.scenes}
        make = _make_here(plan, root, parts) if farm is None else _make_there(plan, root, farm, parts)
        for done, _ in enumerate(make, 1 + len(wanted) - len(missing)):
            if progress is not None:
                progress(done, len(wanted))
    _summarise(root, plan)
    return root


def _make_here(plan: DatasetPlan, root: Path, parts: Mapping[str, Sequence[int]]) -> Iterator[None]:
    for name, numbers in parts.items():
        if numbers:
            with ExitStack() as stack:
                made = _Set(plan, partial(plan.scene, name), stack)
                for number in numbers:
                    made.render(root, number)
                    yield


def _make_there(plan: DatasetPlan, root: Path, farm: Farm, parts: Mapping[str, Sequence[int]]) -> Iterator[None]:
    scenes: dict[str, bytes] = {}
    for name, numbers in parts.items():
        if numbers:
            with plan.scene(name) as scene:
                scenes[name] = packed(scene)
    for files in farm.results(_on_a_worker, (plan, scenes), [n for numbers in parts.values() for n in numbers]):
        land(root, files)
        yield


def _on_a_worker(common: tuple[DatasetPlan, Mapping[str, bytes]], number: int) -> dict[str, bytes]:
    plan, scenes = common
    name = plan.frame(number).scene
    made = kept(("dataset", plan.content, name), lambda stack: _Set(plan, partial(unpacked, scenes[name]), stack))
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        (root / _FRAMES).mkdir()
        return {file: (root / file).read_bytes() for file in made.render(root, number)}


def _claim(root: Path, plan: DatasetPlan) -> None:
    file, own = root / _PLAN, {"planetfall": __version__, "plan": plan.content}
    if file.exists():
        try:
            found = json.loads(file.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            found = None
        if not isinstance(found, dict) or any(found.get(key) != value for key, value in own.items()):
            raise CaptureError(f"{root} holds frames of another plan or version; name another folder")
    elif any((root / _FRAMES).glob("*")):
        raise CaptureError(f"{root} holds frames of unknown origin; name another folder")
    _write(file, json.dumps({**own, "made_of": plan.told}, indent=1))


def _write(path: Path, text: str) -> None:
    with written_beside(path) as beside:
        beside.write_text(text, encoding="utf-8")


def _files(root: Path, number: int) -> Path:
    return root / _FRAMES / f"{number:06d}"


def _is_whole(root: Path, number: int) -> bool:
    """Whether its line, which is written last, is there, and the files that it names have their sizes."""
    try:
        told = json.loads(_files(root, number).with_suffix(".json").read_text(encoding="utf-8"))
        return all((root / name).stat().st_size == file["bytes"] for name, file in told["files"].items())
    except (OSError, ValueError, KeyError):
        return False


class _Set:
    """A scene of a plan with its renderer; `stack` gets what is to be released."""

    def __init__(self, plan: DatasetPlan, scene: Callable[[], Scene], stack: ExitStack) -> None:
        self._plan, self._scene = plan, scene
        self._open = stack.enter_context(ExitStack())
        self._made: tuple[Stage, Renderer] | None = None

    def _staged(self, drawn: Drawn) -> tuple[Renderer, Staged]:
        """The renderer, and what is to be rendered with it."""
        from ..render.renderer import Renderer

        plan = self._plan
        if self._made is not None and not plan.varied:
            return self._made[1], self._made[0].frame(drawn)
        # A scene that changes keeps its rivers and air until others are made in the background: each frame a new one.
        self._open.close()
        stage = Stage(plan, self._open.enter_context(self._scene()))
        frame = stage.frame(drawn)
        renderer = self._open.enter_context(Renderer(stage.scene, plan.size, plan.quality, dict(plan.overrides)))
        self._made = stage, renderer
        return renderer, frame

    def render(self, root: Path, number: int) -> list[str]:
        """Makes the files of a frame; their names, that of its line last."""
        plan, drawn = self._plan, self._plan.frame(number)
        renderer, frame = self._staged(drawn)
        renderer.settle(frame.camera, frame.time_s, sun=frame.sun)
        arrays = renderer.render(frame.camera, frame.time_s, sun=frame.sun, outputs=plan.outputs)
        state = renderer.camera_state(frame.camera)
        told: dict[str, Any] = {
            "frame": number, "scene": drawn.scene, "drawn": dict(drawn.values), "time_s": frame.time_s,
            "camera": _pose(state),
            "lens": _lens(plan, state), "exposure_ev100": renderer.exposure,
            "wavelengths_nm": list(renderer.wavelengths_nm), "quality": plan.quality,
            "overrides": dict(plan.overrides), "planetfall": __version__,
            "machine": [processor_name(), renderer.gpu.caps.renderer, renderer.gpu.caps.version],
        }  # fmt: skip
        if "material" in arrays:
            told["materials"] = renderer.materials
        base, parts = _files(root, number), {}
        if plan.format == "png":
            if "color" in arrays:
                parts[".png"] = {"color": arrays.pop("color")}
            if arrays:
                parts[".npz"] = arrays
        else:
            parts[f".{plan.format}"] = arrays
        told["files"] = {}
        for ending, some in parts.items():
            path = save_capture(base.with_suffix(ending), some)
            content = path.read_bytes()
            told["files"][path.relative_to(root).as_posix()] = {
                "bytes": len(content), "sha256": hashlib.sha256(content).hexdigest(), "outputs": sorted(some),
            }  # fmt: skip
        _write(base.with_suffix(".json"), json.dumps(told))
        return [*told["files"], base.with_suffix(".json").relative_to(root).as_posix()]


def _pose(state: CameraState) -> dict[str, Any]:
    """position_m: from the planet's centre, planet axes (z: north pole). camera_to_planet: rows of the rotation matrix
    that takes OpenCV's camera axes (x right, y down, z forward) to those."""
    turn = np.stack([state.right, -np.asarray(state.up), state.forward], axis=1)
    return {"position_m": np.asarray(state.position_m).tolist(), "camera_to_planet": turn.tolist()}


def _lens(plan: DatasetPlan, state: CameraState) -> dict[str, Any]:
    """OpenCV's: pixel centres are whole numbers."""
    if (own := plan.intrinsics) is not None:
        return {"model": own.model, "size": [own.width, own.height], "fx": own.fx, "fy": own.fy, "cx": own.cx,
                "cy": own.cy, "distortion": list(own.distortion)}  # fmt: skip
    width, height = plan.size
    fx, fy = width / (state.tan_right - state.tan_left), height / (state.tan_top - state.tan_bottom)
    return {"model": "pinhole", "size": [width, height], "fx": fx, "fy": fy, "cx": -fx * state.tan_left - 0.5,
            "cy": fy * state.tan_top - 0.5, "distortion": []}  # fmt: skip


def _summarise(root: Path, plan: DatasetPlan) -> None:
    """The files that tell of all frames, from what each tells."""
    told = [json.loads(_files(root, n).with_suffix(".json").read_text(encoding="utf-8"))
            for n in range(plan.count) if _is_whole(root, n)]  # fmt: skip
    _write(root / _LINES, "".join(f"{json.dumps(each)}\n" for each in told))
    known = told and told[0]["lens"]["model"] in _MODELS
    if known and "color" in plan.outputs and plan.format == "png" and len(plan.scenes) == 1:
        _write(root / _TRANSFORMS, json.dumps(_transforms(told), indent=1))
    files = {name: file["sha256"] for each in told for name, file in each["files"].items()}
    lines = [_files(root, each["frame"]).with_suffix(".json") for each in told]
    whole = [path for path in (root / _PLAN, root / _LINES, root / _TRANSFORMS) if path.is_file()]
    files |= {path.relative_to(root).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
              for path in (*lines, *whole)}  # fmt: skip
    machines = sorted({tuple(each["machine"]) for each in told})
    manifest = {"planetfall": __version__, "plan": plan.content, "count": plan.count, "frames": len(told),
                "machines": machines, "files": files}  # fmt: skip
    _write(root / _MANIFEST, json.dumps(manifest, indent=1))


def _transforms(told: list[dict[str, Any]]) -> dict[str, Any]:
    """For radiance fields: OpenGL's camera axes, in metres from the first camera, where x is east, y north and z
    up."""
    first = np.array(told[0]["camera"]["position_m"])
    up = first / np.linalg.norm(first)
    north, east = local_axes(up)
    axes, origin = np.stack([east, north, up]), first
    lens, poses = told[0]["lens"], []
    model, names = _MODELS[lens["model"]]
    for each in told:
        matrix = np.eye(4)
        matrix[:3, :3] = axes @ np.array(each["camera"]["camera_to_planet"]) @ _BEND
        matrix[:3, 3] = axes @ (np.array(each["camera"]["position_m"]) - origin)
        image = next(name for name in each["files"] if name.endswith(".png"))
        poses.append({"file_path": image, "transform_matrix": matrix.tolist()})
    return {"w": lens["size"][0], "h": lens["size"][1], "fl_x": lens["fx"], "fl_y": lens["fy"],
            "cx": lens["cx"] + 0.5, "cy": lens["cy"] + 0.5, "camera_model": model,
            **dict(zip(names, lens["distortion"], strict=False)), "origin_m": origin.tolist(), "axes": axes.tolist(),
            "frames": poses}  # fmt: skip
