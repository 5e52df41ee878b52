"""Scripted flights as pictures: numbered PNGs, a contact sheet and a video, without a display."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .._version import __version__
from ..camera.arguments import check_scene
from ..camera.flights import ScenePath, path
from ..errors import SettingError
from ..systems.capture import NumberedFrames, VideoError, contact_sheet, write_gif, write_png, write_video
from ..systems.capture.sheet import even_selection
from ..systems.capture.video import check_video_size, ffmpeg
from .shot import camera_settings, made_of

if TYPE_CHECKING:
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
    progress: Callable[[int, int], None] | None = None,
) -> Recording:
    """Render a scripted flight as frame_0000.png ..., contact_sheet.png and flight.mp4 in `folder` (made when missing);
    with `gif` as flight.gif too.

    Frames that are there already, of the same scene, flight and settings down to every key and knob, are kept: an
    interrupted recording goes on, and ends with the very frames that it would have had without. Frames of other ones
    are refused (CaptureError) unless `force`. progress(done, count) follows the frames.

    frames: the numbers of those to make, for several machines that share a folder or put theirs together; whoever
    finds all frames there makes the sheet and the film.

    A recording has time, and its camera is often so fast that no frame before shows the same clouds: they have a ray
    for each pixel in each frame, whatever the quality, unless `overrides` says otherwise (EVERY_RAY).
    """
    check_scene(scene, "record")
    _check_fps(fps, gif)
    flight = path(flight, scene) if isinstance(flight, str) else flight
    settings = {
        "planetfall": __version__, "scene": scene.name, "path": flight.name, "size": list(size), "quality": quality,
        "overrides": {**EVERY_RAY, **(overrides or {})}, "made_of": made_of(scene, path=flight.keys),
    }  # fmt: skip
    kept = NumberedFrames(Path(folder), count, settings=settings, force=force)
    wanted = range(count) if frames is None else frames
    if video:
        try:
            ffmpeg()
            check_video_size(size)
        except VideoError as error:
            log.warning("no video will be made: %s", error)
            video = False
    missing = sorted(set(kept.missing()) & set(wanted))
    if missing:
        _render(scene, flight, kept, missing, len(wanted), settings, progress)
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


def _render(
    scene: Scene,
    flight: ScenePath,
    frames: NumberedFrames,
    missing: list[int],
    count: int,
    settings: Mapping[str, Any],
    progress: Callable[[int, int], None] | None,
) -> None:
    from ..render.renderer import Renderer

    times = flight.times_s(frames.count)
    step_s = times[1] - times[0] if len(times) > 1 else 1.0
    width, height = settings["size"]
    kept = count - len(missing)
    with Renderer(scene, (width, height), settings["quality"], settings["overrides"]) as renderer:
        for index, wanted in frames_to_render(missing):
            camera, time_s = flight.camera_at(times[index]), times[index]
            if wanted is None:
                renderer.settle(camera, time_s, sun=flight.sun)
                continue
            color = renderer.render(camera, time_s, sun=flight.sun, dt_s=step_s)["color"]
            if not wanted:
                continue
            frames.write(index, color, {"time_s": time_s, "camera": camera_settings(camera), **settings})
            kept += 1
            if progress is not None:
                progress(kept, count)


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
