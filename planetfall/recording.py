"""Scripted flights as pictures: numbered PNGs, a contact sheet and a video, without a display."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ._version import __version__
from .flights import ScenePath, path
from .shot import camera_settings
from .systems.capture import NumberedFrames, VideoError, contact_sheet, write_png, write_video
from .systems.capture.sheet import even_selection
from .systems.capture.video import ffmpeg

if TYPE_CHECKING:
    from .scene import Scene

__all__ = ["Recording", "record"]

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Recording:
    """What `record` wrote. video is None when none was asked for, or when the extra for videos is missing."""

    folder: Path
    frames: list[Path]
    sheet: Path
    video: Path | None


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
    force: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Recording:
    """Render a scripted flight as frame_0000.png ..., contact_sheet.png and flight.mp4 in `folder` (made when missing).

    Frames that are there already, of the same flight and settings, are kept: an interrupted recording goes on. Frames
    of other settings are refused (CaptureError) unless `force`. progress(done, count) follows the frames.
    """
    flight = path(flight, scene) if isinstance(flight, str) else flight
    settings = {
        "planetfall": __version__, "scene": scene.name, "path": flight.name, "size": list(size), "quality": quality,
        "overrides": dict(overrides or {}),
    }  # fmt: skip
    frames = NumberedFrames(Path(folder), count, settings=settings, force=force)
    if video:
        try:
            ffmpeg()
        except VideoError as error:
            log.warning("no video will be made: %s", error)
            video = False
    missing = list(frames.missing())
    if missing:
        _render(scene, flight, frames, missing, settings, progress)
    sheet = write_png(frames.folder / "contact_sheet.png", _sheet(flight, frames), settings)
    film = write_video(frames.folder / "flight.mp4", frames.paths, fps=fps) if video else None
    return Recording(frames.folder, frames.paths, sheet, film)


def _render(
    scene: Scene,
    flight: ScenePath,
    frames: NumberedFrames,
    missing: list[int],
    settings: Mapping[str, Any],
    progress: Callable[[int, int], None] | None,
) -> None:
    from .renderer import Renderer

    times = flight.times_s(frames.count)
    step_s = times[1] - times[0] if len(times) > 1 else 1.0
    width, height = settings["size"]
    with Renderer(scene, (width, height), settings["quality"], settings["overrides"]) as renderer:
        before = -2
        for index in missing:
            camera = flight.camera_at(times[index])
            if index != before + 1:  # a start, or a gap: exposure must not remember another place
                renderer.settle(camera, times[index], sun=flight.sun)
            color = renderer.render(camera, times[index], sun=flight.sun, dt_s=step_s)["color"]
            shot = {"time_s": times[index], "camera": camera_settings(camera), **settings}
            frames.write(index, color, shot)
            before = index
            if progress is not None:
                progress(index + 1, frames.count)


def _sheet(flight: ScenePath, frames: NumberedFrames) -> Any:
    times = flight.times_s(frames.count)
    chosen = even_selection(range(frames.count), 20)
    pictures = [(f"{index:04d}  {times[index]:.1f} s", frames.path(index)) for index in chosen]
    return contact_sheet(pictures, columns=5 if len(chosen) > 9 else None, thumb_width=256, title=flight.name)
