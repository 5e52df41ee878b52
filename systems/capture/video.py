"""Videos, through imageio-ffmpeg (an extra: it brings its own ffmpeg, so that none has to be installed)."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .files import CaptureError, written_beside

SUFFIXES = (".mp4", ".mkv", ".mov")


class VideoError(CaptureError):
    """No video can be written; the message says why and what to do."""


def ffmpeg() -> ModuleType:
    """The imageio_ffmpeg module, or a VideoError that says how to get it. Call it before rendering."""
    try:
        import imageio_ffmpeg
    except ImportError as error:
        raise VideoError("videos need the extra 'video': pip install 'planetfall[video]'") from error
    try:
        imageio_ffmpeg.get_ffmpeg_exe()
    except RuntimeError as error:
        raise VideoError(f"imageio-ffmpeg is installed but finds no ffmpeg ({error}); reinstall it") from error
    return imageio_ffmpeg


def write_video(
    path: Path | str, frames: Iterable[Path | str | NDArray[np.uint8]], *, fps: float = 24.0, quality: float = 8.0
) -> Path:
    """Write an H.264 video of u8 (H, W, 3) frames: files or pixels, all of one size. Odd sizes lose a row or a
    column, as H.264 needs even ones. ``quality`` is 0..10. Raises VideoError."""
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise VideoError(f"{path}: a video's name ends in {', '.join(SUFFIXES)}, found {path.suffix or 'no suffix'!r}")
    module = ffmpeg()
    with written_beside(path) as beside:
        writer: Any = None
        size = (0, 0)
        try:
            for index, frame in enumerate(frames):
                pixels = _pixels(frame)
                if writer is None:
                    size = (pixels.shape[1], pixels.shape[0])
                    writer = module.write_frames(
                        str(beside), size, fps=fps, quality=quality, macro_block_size=2, ffmpeg_log_level="error"
                    )
                    writer.send(None)
                elif (pixels.shape[1], pixels.shape[0]) != size:
                    found = f"{pixels.shape[1]}x{pixels.shape[0]}"
                    raise VideoError(f"{path}: frame {index} is {found}, expected {size[0]}x{size[1]}")
                writer.send(pixels)
            if writer is None:
                raise VideoError(f"{path}: a video needs at least one frame, found none")
        except OSError as error:
            raise VideoError(f"{path}: ffmpeg stopped: {error}") from error
        finally:
            if writer is not None:
                writer.close()
    return path


def check_video_size(size: tuple[int, int]) -> None:
    """VideoError for pictures that leave nothing once they are cut to even sizes. Call it before rendering."""
    if min(size) < 2:
        raise VideoError(f"pictures of {size[0]}x{size[1]} make no video: H.264 needs 2x2 pixels or more")


def _pixels(frame: Path | str | NDArray[np.uint8]) -> NDArray[np.uint8]:
    if isinstance(frame, np.ndarray):
        pixels = frame
    else:
        from PIL import Image

        try:
            with Image.open(frame) as image:
                pixels = np.asarray(image.convert("RGB"), dtype=np.uint8)
        except OSError as error:
            raise VideoError(f"{frame} cannot be read as a picture: {error}") from error
    check_video_size((pixels.shape[1], pixels.shape[0]))
    height, width = pixels.shape[0] & ~1, pixels.shape[1] & ~1
    return np.ascontiguousarray(pixels[:height, :width, :3])
