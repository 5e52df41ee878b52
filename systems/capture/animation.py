"""Animated GIFs, for pages that show no videos."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .files import CaptureError, written_beside
from .sheet import even_selection

if TYPE_CHECKING:
    from PIL import Image

_PALETTE_FRAMES = 12
_PALETTE_WIDTH = 160


def write_gif(
    path: Path | str, frames: Sequence[Path | NDArray[np.uint8]], *, fps: float = 15.0, width: int | None = None
) -> Path:
    """Write u8 (H, W, 3) frames, files or pixels, as a GIF that repeats for ever.

    One palette of 256 colours for all frames, taken from some of them, so that nothing flickers. width: make it
    smaller. fps: GIFs count in hundredths of a second and viewers slow down below two of them: 50 at most. Raises
    CaptureError.
    """
    from PIL import Image

    path = Path(path)
    if path.suffix.lower() != ".gif":
        raise CaptureError(f"{path}: a GIF's name ends in .gif, found {path.suffix or 'no suffix'!r}")
    if not frames:
        raise CaptureError(f"{path}: a GIF needs at least one frame, found none")
    if not 0.1 <= fps <= 50.0:
        raise CaptureError(f"{path}: fps: expected 0.1 to 50 for a GIF, found {fps!r}")
    palette = _palette([_image(frame, _PALETTE_WIDTH) for frame in even_selection(frames, _PALETTE_FRAMES)])

    def pictures() -> Iterator[Image.Image]:
        for frame in frames:
            yield _image(frame, width).quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG)

    made = pictures()
    with written_beside(path) as beside:
        next(made).save(
            beside, format="GIF", save_all=True, append_images=made, duration=round(100.0 / fps) * 10, loop=0,
            optimize=False, disposal=1,
        )  # fmt: skip
    return path


def _palette(images: list[Image.Image]) -> Image.Image:
    """The 256 colours that serve all of these."""
    from PIL import Image

    strip = np.concatenate([np.asarray(image) for image in images], axis=0)
    return Image.fromarray(strip).quantize(256, method=Image.Quantize.MEDIANCUT)


def _image(frame: Path | NDArray[np.uint8] | Any, width: int | None) -> Image.Image:
    from PIL import Image

    if isinstance(frame, np.ndarray):
        image = Image.fromarray(frame)
    else:
        try:
            with Image.open(frame) as file:
                image = file.convert("RGB")
        except OSError as error:
            raise CaptureError(f"{frame} cannot be read as a picture: {error}") from error
    if width is None or width == image.width:
        return image
    return image.resize((width, max(1, round(image.height * width / image.width))), Image.Resampling.LANCZOS)


__all__ = ["write_gif"]
