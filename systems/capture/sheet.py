"""Contact sheets: many small pictures with labels on one page."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from .files import CaptureError

if TYPE_CHECKING:
    from PIL import Image

Picture = Path | str | NDArray[np.uint8]

BACKGROUND = (18, 18, 22)
INK = (225, 225, 230)


def contact_sheet(
    pictures: Iterable[tuple[str, Picture]],
    *,
    columns: int | None = None,
    thumb_width: int = 320,
    gap: int = 6,
    title: str = "",
) -> NDArray[np.uint8]:
    """One u8 (H, W, 3) page of (label, picture) pairs; a picture is a file or u8 pixels. Pictures keep their shape; the
    rows are as high as the first one. ``columns`` None: about as wide as high. Raises CaptureError without pictures."""
    from PIL import Image, ImageDraw, ImageFont

    cells = [(label, _thumbnail(picture, thumb_width)) for label, picture in pictures]
    if not cells:
        raise CaptureError("a contact sheet needs at least one picture, found none")
    columns = columns or max(1, min(len(cells), round(math.sqrt(len(cells) * cells[0][1].height / thumb_width * 1.6))))
    rows = math.ceil(len(cells) / columns)
    font: Any = ImageFont.load_default(size=max(11, thumb_width // 22))
    label_height = int(font.size * 1.5)
    title_height = int(font.size * 2.0) if title else 0
    row_height = max(image.height for _, image in cells) + label_height + gap
    page = Image.new("RGB", (columns * (thumb_width + gap) + gap, rows * row_height + gap + title_height), BACKGROUND)
    draw = ImageDraw.Draw(page)
    if title:
        draw.text((gap, gap), title, fill=INK, font=font)
    for index, (label, image) in enumerate(cells):
        x = gap + (index % columns) * (thumb_width + gap)
        y = gap + title_height + (index // columns) * row_height
        page.paste(image, (x, y))
        draw.text((x + 2, y + image.height + 1), label, fill=INK, font=font)
    return np.asarray(page, dtype=np.uint8).copy()


def _thumbnail(picture: Picture, width: int) -> Image.Image:
    from PIL import Image

    if isinstance(picture, np.ndarray):
        image = Image.fromarray(picture).convert("RGB")
    else:
        try:
            with Image.open(picture) as file:
                image = file.convert("RGB")
        except OSError as error:
            raise CaptureError(
                f"contact sheet: {picture} cannot be read as a picture: {error}; delete it to have it made again"
            ) from error
    height = max(1, round(image.height * width / image.width))
    return image if image.width == width else image.resize((width, height), Image.Resampling.LANCZOS)


T = TypeVar("T")


def even_selection(items: Sequence[T], count: int) -> list[T]:
    """At most ``count`` items spread evenly, first and last included."""
    if len(items) <= count:
        return list(items)
    return [items[round(i)] for i in np.linspace(0, len(items) - 1, count)]
