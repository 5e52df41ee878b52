"""Scripted flights as pictures: numbered PNGs, a contact sheet and a video, without a display."""

from __future__ import annotations

import logging
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, nullcontext
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .._version import __version__
from ..camera.arguments import check_scene, check_size
from ..camera.flights import ScenePath, path
from ..errors import SettingError
from ..quality import resolve_quality
from ..systems.capture import NumberedFrames, VideoError, contact_sheet, write_gif, write_png, write_video
from ..systems.capture.sheet import even_selection
from ..systems.capture.video import check_video_size, ffmpeg
from .carried import packed, require_sendable, unpacked
from .dataset_plan import checked_frames
from .farm import Farm, kept, land
from .shot import camera_settings, made_of

if TYPE_CHECKING:
    from ..camera.camera import Camera
    from ..components import Sun
    from ..render.renderer import Renderer
    from ..scene.scene import Scene

__all__ = ["Recording", "record"]

log = logging.getLogger(__name__)

PART, RUN_UP = 96, 16
"""Frames. Twelve frames of a run-up leave less than a third of what temporal smoothing remembers, and exposure, which
takes a second or less, less than that."""

EVERY_RAY: Mapping[str, Any] = {"clouds.stride": 1}
"""What a recording asks of clouds."""


@dataclass(frozen=True)
class Recording:
    """What `record` wrote. video is None when none was asked for, or when the extra for videos is missing, gif when
    none was asked for; they and sheet are None while other frames are still to be made."""

    folder: Path
    frames: list[Path]
    sheet: Path | None
    video: Path | None
    gif: Path | None = None


def record(
    scene: Scene,
    flight: str | ScenePath = "descent",
    folder: str | PathLike[str] = "flight",
    *,
    count: int = 240,
    size: tuple[int, int] = (640, 360),
    quality: str = "medium",
    overrides: Mapping[str, Any] | None = None,
    fps: float = 24.0,
    video: bool = True,
    gif: bool = False,
    force: bool = False,
    frames: Sequence[int] | None = None,
    scheduler: str | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Recording:
    """Render a scripted flight as frame_0000.png ..., contact_sheet.png and flight.mp4 in `folder` (made when missing);
    with `gif` as flight.gif too.

    Frames that are there already, of the same scene, flight and settings down to every key and knob, are kept: an
    interrupted recording goes on, and ends with the very frames that it would have had without. Frames of other ones
    are refused (CaptureError) unless `force`. progress(done, count) follows the frames.

    frames: the numbers of those to make, for several machines that share a folder or put theirs together; whoever
    finds all frames there makes the sheet and the film. scheduler: the address of a Dask scheduler, such as
    tcp://10.0.0.5:8786, whose workers make them, PART at a time, and send them here; SettingError, before anything is
    made, when it can't be reached, and SceneError for a scene with masks or tiles, which can't be sent.

    A recording has time, and its camera is often so fast that no frame before shows the same clouds: they have a ray
    for each pixel in each frame, whatever the quality, unless `overrides` says otherwise (EVERY_RAY).
    """
    check_scene(scene, "record")
    _check_fps(fps, gif)
    wanted = checked_frames(frames, count)
    check_size(size, None)
    overrides = {**EVERY_RAY, **(overrides or {})}
    scene.validate(resolve_quality(quality, overrides))  # before the folder belongs to these settings
    if scheduler is not None:
        require_sendable(scene)
    flight = path(flight, scene) if isinstance(flight, str) else flight
    settings = {
        "planetfall": __version__, "scene": scene.name, "path": flight.name, "size": list(size), "quality": quality,
        "overrides": overrides, "made_of": made_of(scene, path=flight.keys),
    }  # fmt: skip
    if video:
        try:
            ffmpeg()
            check_video_size(size)
        except VideoError as error:
            log.warning("no video will be made: %s", error)
            video = False
    with nullcontext() if scheduler is None else Farm(scheduler) as farm:
        kept = NumberedFrames(Path(folder), count, settings=settings, force=force)
        missing = sorted(set(kept.missing()) & set(wanted))
        steps = _steps(flight, count, missing)
        make = (
            _make_here(scene, kept, settings, steps)
            if farm is None
            else _make_there(scene, kept, farm, settings, steps)
        )
        done = len(wanted) - len(missing)
        for made in make:
            done += made
            if progress is not None:
                progress(done, len(wanted))
    if next(kept.missing(), None) is not None:
        return Recording(kept.folder, [kept.path(n) for n in wanted], None, None)
    sheet = write_png(kept.folder / "contact_sheet.png", _sheet(flight, kept), settings)
    film = write_video(kept.folder / "flight.mp4", kept.paths, fps=fps) if video else None
    moving = write_gif(kept.folder / "flight.gif", kept.paths, fps=min(fps, 50.0)) if gif else None
    return Recording(kept.folder, kept.paths, sheet, film, moving)


def _check_fps(fps: Any, gif: bool) -> None:
    """A rate that no video can have, said before hours of rendering. GIFs pause at most 10 s for a frame."""
    least = 0.1 if gif else 0.001
    if not isinstance(fps, int | float) or not least <= fps <= 1000.0:  # nan is neither
        raise SettingError(f"record: fps: expected {least:g} to 1000 frames a second, found {fps!r}")


@dataclass(frozen=True)
class _Step:
    """What is rendered next; keep as in frames_to_render."""

    index: int
    keep: bool | None
    camera: Camera
    time_s: float


@dataclass(frozen=True)
class _Steps:
    """What is rendered one after another, from a picture on that hangs on none before it."""

    steps: Sequence[_Step]
    sun: Sun | None
    step_s: float


def _steps(flight: ScenePath, count: int, missing: Sequence[int]) -> list[_Steps]:
    """The parts to make."""
    times = flight.times_s(count)
    step_s = times[1] - times[0] if len(times) > 1 else 1.0
    parts: list[list[_Step]] = []
    for index, keep in frames_to_render(missing):
        if keep is None:
            parts.append([])
        parts[-1].append(_Step(index, keep, flight.camera_at(times[index]), times[index]))
    return [_Steps(part, flight.sun, step_s) for part in parts]


def _renderer(scene: Scene, settings: Mapping[str, Any]) -> Renderer:
    from ..render.renderer import Renderer

    width, height = settings["size"]
    return Renderer(scene, (width, height), settings["quality"], settings["overrides"])


def _make_here(
    scene: Scene, frames: NumberedFrames, settings: Mapping[str, Any], parts: Sequence[_Steps]
) -> Iterator[int]:
    """Makes the frames, and says 1 after each."""
    if not parts:
        return
    with _renderer(scene, settings) as renderer:
        for part in parts:
            for step, color in _rendered(renderer, part):
                frames.write(step.index, color, _told(step, settings))
                yield 1


def _make_there(
    scene: Scene, frames: NumberedFrames, farm: Farm, settings: Mapping[str, Any], parts: Sequence[_Steps]
) -> Iterator[int]:
    """Has the frames made, and says how many have come."""
    names = {step.index: frames.path(step.index).name for part in parts for step in part.steps}
    for files in farm.results(_on_a_worker, (packed(scene), settings, names), parts):
        land(frames.folder, files)
        yield len(files)


def _on_a_worker(common: tuple[bytes, Mapping[str, Any], Mapping[int, str]], part: _Steps) -> dict[str, bytes]:
    content, settings, names = common

    def make(stack: ExitStack) -> Renderer:
        return stack.enter_context(_renderer(stack.enter_context(unpacked(content)), settings))

    renderer = kept(("record", *map(str, settings.values())), make)
    with tempfile.TemporaryDirectory() as folder:
        made = [write_png(Path(folder) / names[step.index], color, _told(step, settings))
                for step, color in _rendered(renderer, part)]  # fmt: skip
        return {path.name: path.read_bytes() for path in made}


def _rendered(renderer: Renderer, part: _Steps) -> Iterator[tuple[_Step, Any]]:
    """The frames to keep, (H, W, 3) u8 each."""
    for step in part.steps:
        if step.keep is None:
            renderer.settle(step.camera, step.time_s, sun=part.sun)
            continue
        color = renderer.render(step.camera, step.time_s, sun=part.sun, dt_s=part.step_s)["color"]
        if step.keep:
            yield step, color


def _told(step: _Step, settings: Mapping[str, Any]) -> dict[str, Any]:
    return {"time_s": step.time_s, "camera": camera_settings(step.camera), **settings}


def frames_to_render(missing: Sequence[int]) -> Iterator[tuple[int, bool | None]]:
    """What is rendered to make the missing frames, in order: (frame, True) to keep, (frame, False) to throw away,
    (frame, None) to settle at.

    A frame looks back: exposure adapts, and smoothing gathers over the frames before. So a recording is made of parts;
    each settles a little before its first frame and runs up to it. That is the same whether the recording was
    interrupted or not.
    """
    wanted = set(missing)
    for part in sorted({index // PART for index in wanted}):
        first = part * PART
        last = max(index for index in wanted if index // PART == part)
        start = max(first - RUN_UP, 0)
        yield start, None
        for index in range(start, last + 1):
            yield index, index in wanted and index >= first


def _sheet(flight: ScenePath, frames: NumberedFrames) -> Any:
    times = flight.times_s(frames.count)
    chosen = even_selection(range(frames.count), 20)
    pictures = [(f"{index:04d}  {times[index]:.1f} s", frames.path(index)) for index in chosen]
    return contact_sheet(pictures, columns=5 if len(chosen) > 9 else None, thumb_width=256, title=flight.name)
